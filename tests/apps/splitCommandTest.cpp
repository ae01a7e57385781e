/** @file
 * `recurse split`: its scripts run only the intended commands.
 */
#include "program.h"

using namespace programTesting;

namespace {
class SplitCommand : public Program {};
} // namespace

TEST_F(SplitCommand, NamesOfFoldersRunNoCommands) {
  const std::string name = "-it's \"$(touch pwned)\" `touch pwned` $HOME; touch pwned # %a \\";
  std::filesystem::create_directories(file(name));
  std::filesystem::rename(file("scene.pbrt"), file(name + "/" + name + ".pbrt"));
  const Outcome o = runIn(file(name), {"split", "./" + name + ".pbrt", "--parts", "1", "--spp", "1", "-o",
                                       "./" + name, "--integrator", "path"});
  ASSERT_EQ(o.status, 0) << o.err;
  const std::string job = name + "/" + name;
  // A copy of the folder uses its own files.
  std::filesystem::copy(file(job), file("copied"));
  EXPECT_EQ(
      std::system(
          ("cd '" + folder + "/copied' && RECURSE='" RECURSE_PROGRAM "' sh local.sh >log 2>&1").c_str()),
      0)
      << contents(file("copied/log"));
  EXPECT_TRUE(exists("copied/picture.exr")) << contents(file("copied/log"));
  EXPECT_FALSE(exists(job + "/picture.exr"));
  for (const std::string& where : {std::string(), name + "/", job + "/", std::string("copied/")})
    EXPECT_FALSE(exists(where + "pwned")) << where;
  // sbatch parses these lines by its own rules.
  EXPECT_NE(contents(file(job + "/slurm.sh")).find("#SBATCH --output=/dev/null\n"), std::string::npos);
}

TEST_F(SplitCommand, NamesWithControlCharactersAreRefused) {
  for (const std::string& name :
       {std::string("a\ntouch pwned\nb"), std::string("a\rb"), std::string("a\x1b[2J")}) {
    const Outcome o =
        run({"split", "scene.pbrt", "--parts", "2", "--spp", "2", "-o", name, "--integrator", "path"});
    EXPECT_EQ(o.status, 2) << o.err;
    EXPECT_FALSE(exists(name));
    std::filesystem::copy_file(file("scene.pbrt"), file(name + ".pbrt"));
    EXPECT_EQ(run({"split", name + ".pbrt", "--parts", "2", "--spp", "2", "-o", "job"}).status, 2);
  }
  EXPECT_FALSE(exists("job"));
}
