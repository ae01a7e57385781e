/** @file
 * Help, exit statuses and error messages of the program.
 */
#include "program.h"

using namespace programTesting;

namespace {
class ProgramUsage : public Program {};
} // namespace

TEST_F(ProgramUsage, HelpOfEverySubcommandHasExamples) {
  for (const char* name : {"render", "compare", "info", "classes", "explain", "reference"}) {
    const Outcome o = run({name, "--help"});
    EXPECT_EQ(o.status, 0) << name;
    EXPECT_TRUE(has(o.out, "Usage: recurse ")) << o.out;
    EXPECT_TRUE(has(o.out, "Examples:\n  recurse " + std::string(name))) << o.out;
    std::istringstream lines(o.out);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 110u) << line;
  }
  const Outcome all = run({"--help"});
  EXPECT_EQ(all.status, 0);
  EXPECT_TRUE(has(all.out, "Exit status"));
  const Outcome version = run({"--version"});
  EXPECT_EQ(version.status, 0);
  EXPECT_TRUE(has(version.out, "Recurse 0.")) << version.out;
}

TEST_F(ProgramUsage, BadUsageIsStatus2AndSaysWhatWouldDo) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{}, "subcommand is required"},
      {{"rendre", "scene.pbrt"}, "--help"},
      {{"render"}, "required"},
      {{"render", "scene.pbrt", "--spp"}, "--spp"},
      {{"render", "scene.pbrt", "--spp", "0"}, "whole number from 1"},
      {{"render", "scene.pbrt", "--spp", "2.5"}, "whole number"},
      {{"render", "scene.pbrt", "--no-such-option"}, "--no-such-option"},
      {{"render", "scene.pbrt", "-o", "a.bmp2"}, ".exr .hdr .pfm .png"},
      {{"render", "scene.pbrt", "-o", "a.exr", "-o", "a.exr"}, "twice"},
      {{"render", "scene.pbrt", "--integrator", "phtonmap"}, "did you mean photonmap"},
      {{"render", "scene.pbrt", "--integrator", "path", "--photons", "10"}, "has no parameter 'photons'"},
      {{"render", "scene.pbrt", "--photons", "-5"}, "--photons"},
      {{"render", "scene.pbrt", "--radius", "0"}, "--radius"},
      {{"render", "scene.pbrt", "--direct", "somehow"}, "shadowrays"},
      {{"render", "scene.pbrt", "--photon-index", "octree"}, "kdtree"},
      {{"render", "scene.pbrt", "--set", "nonsense=1"}, "nonsense"},
      {{"render", "scene.pbrt", "--set", "nonsense"}, "NAME=VALUE"},
      {{"render", "scene.pbrt", "--time-limit", "soon"}, "1h30m"},
      {{"render", "scene.pbrt", "--resolution", "640"}, "640x480"},
      {{"render", "scene.pbrt", "--cropwindow", "0,1,1"}, "x0,x1,y0,y1"},
      {{"render", "scene.pbrt", "--seed", "-1"}, "--seed"},
      {{"render", "scene.pbrt", "--nthreads", "0"}, "--nthreads"},
      {{"render", "scene.pbrt", "--progress", "loud"}, "plain"},
      {{"render", "scene.pbrt", "--paths", "L("}, "column"},
      {{"render", "scene.pbrt", "-q", "-v"}, "excludes"},
      {{"compare", "a.exr"}, "required"},
      {{"compare", "a.exr", "b.exr", "--fail-above", "beauty=1"}, "relmse"},
      {{"compare", "a.exr", "b.exr", "--fail-above", "relmse"}, "METRIC=NUMBER"},
      {{"compare", "a.exr", "b.exr", "--fail-above", "relmse_noise_free=1"}, "two independent references"},
      {{"classes", "LX"}, "column 2"},
      {{"reference", "sphre"}, "sphere"},
      {{"explain", "--integrator", "nothing"}, "photonmap"},
  };
  for (const auto& [arguments, message] : cases) {
    const Outcome o = run(arguments);
    std::string line;
    for (const std::string& a : arguments) line += a + " ";
    EXPECT_EQ(o.status, 2) << line << o.err;
    EXPECT_TRUE(has(o.err, message)) << line << "\n" << o.err;
    EXPECT_TRUE(o.out.empty()) << line << o.out;
  }
}

TEST_F(ProgramUsage, BadScenesAreStatus3WithPlaceAndCount) {
  Outcome o = run({"render", "nothing.pbrt"});
  EXPECT_EQ(o.status, 3);
  EXPECT_TRUE(has(o.err, "nothing.pbrt")) << o.err;
  EXPECT_TRUE(has(o.err, "No such file")) << o.err;

  write("bad.pbrt", scene("", "Shape \"sphere\" \"float radus\" 1\nShape \"spheer\"\n"));
  for (const char* mode : {"--check", "--quiet"}) {
    o = run({"render", "bad.pbrt", mode});
    EXPECT_EQ(o.status, 3);
    EXPECT_TRUE(has(o.err, "bad.pbrt:14:")) << o.err;
    EXPECT_TRUE(has(o.err, "radius")) << o.err;
    EXPECT_TRUE(has(o.err, "bad.pbrt:15:")) << o.err;
    EXPECT_TRUE(has(o.err, "^\n")) << o.err;
    EXPECT_TRUE(has(o.err, "2 errors\n")) << o.err;
    EXPECT_FALSE(exists("film.exr"));
  }
  write("lenient.pbrt", scene("", "Shape \"sphere\" \"float radus\" 1\n"));
  o = run({"render", "lenient.pbrt", "--check", "--lenient"});
  EXPECT_EQ(o.status, 0);
  EXPECT_TRUE(has(o.err, "warning: ")) << o.err;

  write("integrator.pbrt", scene("Integrator \"magic\"\n"));
  o = run({"render", "integrator.pbrt"});
  EXPECT_EQ(o.status, 3);
  EXPECT_TRUE(has(o.err, "integrator.pbrt:5:")) << o.err;
}

TEST_F(ProgramUsage, UnwritableOutputsAreFoundBeforeRendering) {
  for (const std::vector<std::string>& output :
       std::vector<std::vector<std::string>>{{"-o", "nowhere/a.exr"},
                                             {"-o", "good.exr", "-o", "nowhere/a.png"},
                                             {"--stats", "nowhere/a.json"}}) {
    std::vector<std::string> arguments = {"render", "scene.pbrt", "--spp", "100000000"};
    arguments.insert(arguments.end(), output.begin(), output.end());
    const Outcome o = run(arguments);
    EXPECT_EQ(o.status, 1);
    EXPECT_TRUE(has(o.err, "nowhere/a.")) << o.err;
    EXPECT_TRUE(has(o.err, "no such folder")) << o.err;
    EXPECT_FALSE(exists("good.exr"));
  }
}

TEST_F(ProgramUsage, FullDiskIsTold) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP();
  const std::string command =
      std::string("cd '") + folder + "' && '" + RECURSE_PROGRAM + "' reference > /dev/full 2> full.txt";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_TRUE(has(contents(file("full.txt")), "No space left")) << contents(file("full.txt"));
}

TEST_F(ProgramUsage, ReferenceClassesAndExplain) {
  const Outcome markdown = run({"reference", "--markdown"});
  EXPECT_EQ(markdown.status, 0);
  for (const char* part : {"# Scene files", "## Shape", "sphere", "photonmap", "LookAt"})
    EXPECT_TRUE(has(markdown.out, part)) << part;
  const Outcome one = run({"reference", "sphere"});
  EXPECT_TRUE(has(one.out, "\"float radius\"")) << one.out;
  EXPECT_FALSE(has(one.out, "LookAt"));

  EXPECT_TRUE(has(run({"classes"}).out, "caustic"));
  EXPECT_TRUE(has(run({"classes", "LS+DE"}).out, "LSDE"));
  EXPECT_TRUE(has(run({"classes", "mine=LDE", "LD+E"}).out, "not disjoint"));

  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"explain", "scene.pbrt"},
                                             {"explain", "--integrator", "path"},
                                             {"explain", "--direct", "photons"}}) {
    const Outcome o = run(arguments);
    EXPECT_EQ(o.status, 0) << o.err << o.out;
    EXPECT_TRUE(has(o.out, "LS*E")) << o.out;
    EXPECT_TRUE(has(o.out, "Every path is estimated once")) << o.out;
  }
}
