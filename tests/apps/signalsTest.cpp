/** @file
 * Signals that end a render: the picture up to then is written.
 */
#include "program.h"

#include <nlohmann/json.hpp>

#include "recurse/core/image/image.h"

using namespace programTesting;
using recurse::readImage;

namespace {

class Signals : public Program {
 protected:
  /** Exit status of a shell command in the folder. */
  int shell(const std::string& line) const {
    return WEXITSTATUS(
        std::system(("cd '" + folder + "' && R='" + RECURSE_PROGRAM + "' && " + line).c_str()));
  }
};

} // namespace

TEST_F(Signals, AReaderOfMessagesThatGoesCostsNoPicture) {
  shell("timeout -s KILL 60 \"$R\" render scene.pbrt --integrator path --spp 1000000000 -o a.exr "
        "--progress json --stats s.json 2>&1 | head -1 >first.txt");
  EXPECT_TRUE(has(contents(file("first.txt")), "phase"));
  ASSERT_TRUE(exists("a.exr"));
  EXPECT_GT(readImage(file("a.exr")).rgb(12, 14).g, 0.01f);
  EXPECT_EQ(nlohmann::json::parse(contents(file("s.json")))["stop_reason"], "interrupted");
  EXPECT_EQ(leftBehind(), 0u);
}

TEST_F(Signals, ALimitOfProcessorTimeLeavesAPicture) {
  const auto twice = [this](pid_t child) { // as the system does, once a second
    onceUnderWay(SIGXCPU)(child);
    ::kill(child, SIGXCPU);
  };
  const Outcome o = run({"render", "scene.pbrt", "--integrator", "path", "--spp", "1000000000", "-o", "a.exr",
                         "--progress", "json"},
                        twice);
  EXPECT_EQ(o.status, 130) << o.err;
  ASSERT_TRUE(exists("a.exr"));
  EXPECT_GT(readImage(file("a.exr")).rgb(12, 14).g, 0.01f);
}

TEST_F(Signals, ALimitOfFilesSizesCostsTheLargeFilesOnly) {
  EXPECT_EQ(
      shell("(ulimit -f 40; \"$R\" render scene.pbrt --resolution 60x60 --integrator path --spp 1 -q -o "
            "small.png -o large.pfm --checkpoint c.rck) >log 2>&1"),
      1);
  EXPECT_TRUE(exists("small.png"));
  EXPECT_FALSE(exists("large.pfm"));
  EXPECT_TRUE(has(contents(file("log")), "large.pfm: cannot be written: File too large"))
      << contents(file("log"));
  EXPECT_EQ(leftBehind(), 0u);
}
