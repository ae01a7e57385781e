/** @file
 * First picture of `recurse render`, before an integrator has learned or shot photons.
 */
#include "program.h"

#include "recurse/core/image/image.h"

using namespace programTesting;
using recurse::readImage;

namespace {

class FirstPicture : public Program {
 protected:
  /** Picture of the scene with one sample of each pixel by path tracing; a single lamp leaves nothing to
   * learn. */
  std::vector<float> onePathSample() const {
    const Outcome o =
        run({"render", "scene.pbrt", "-q", "--integrator", "path", "--spp", "1", "-o", "path.exr"});
    EXPECT_EQ(o.status, 0) << o.err;
    return readImage(file("path.exr")).pixels;
  }
  /** Enough photons to exceed every timeout on any machine. */
  const std::vector<std::string> slow = {"render",    "scene.pbrt", "--integrator", "photonmap",
                                         "--photons", "2G",         "-o",           "out.exr"};
};

std::vector<std::string> with(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

} // namespace

TEST_F(FirstPicture, IsShownBeforePhotonsAreShot) {
  std::vector<float> shown;
  const Outcome o = run(with(slow, {"--preview", "look.exr"}), [&](pid_t child) {
    if (appears("look.exr")) shown = readImage(file("look.exr")).pixels;
    ::kill(child, SIGINT);
  });
  EXPECT_EQ(o.status, 130) << o.err;
  EXPECT_EQ(shown, onePathSample());
  EXPECT_TRUE(has(o.err, "interrupted before photonmap had one sample of every pixel")) << o.err;
  EXPECT_EQ(readImage(file("out.exr")).pixels, shown);
}

TEST_F(FirstPicture, TakesThePlaceOfOneThatIsNotReadyInTime) {
  // The limit includes loading, which may take longer: then there is no picture.
  Outcome o;
  for (int milliseconds = 10; milliseconds < 60000; milliseconds *= 4) {
    o = run(with(slow, {"--time-limit", std::to_string(milliseconds) + "ms", "--stats", "s.json"}));
    if (!has(o.err, "before the scene was loaded")) break;
  }
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(has(o.err, "warning: time limit reached before photonmap had one sample of every pixel"))
      << o.err;
  EXPECT_TRUE(has(contents(file("s.json")), "\"stop_reason\": \"time\"")) << contents(file("s.json"));
  EXPECT_EQ(readImage(file("out.exr")).pixels, onePathSample());
}

TEST_F(FirstPicture, IsNoPartOfTheResult) {
  for (const std::string integrator : {"photonmap", "path", "bdpt"}) {
    for (const std::string name : {"without.exr", "with.exr"}) {
      std::vector<std::string> words = {"render", "scene.pbrt", "-q", "--integrator", integrator, "--spp",
                                        "1",      "-o",         name};
      if (name == "with.exr") words.insert(words.end(), {"--preview", "look.exr"});
      const Outcome o = run(words);
      EXPECT_EQ(o.status, 0) << o.err;
    }
    EXPECT_EQ(readImage(file("with.exr")).pixels, readImage(file("without.exr")).pixels) << integrator;
  }
}

TEST_F(FirstPicture, IsSeenWherePixelsHaveNoSampleYet) {
  write("scene.pbrt",
        scene("Integrator \"path\" \"integer lightsamples\" 1000\n", "LightSource \"infinite\"\n"));
  bool isFull = true;
  int looks = 0;
  run({"render", "scene.pbrt", "--spp", "1000", "--preview", "look.exr", "--every", "0.01s", "--resolution",
       "96x64", "-o", "out.exr"},
      [&](pid_t child) {
        for (; looks < 40 && appears("look.exr"); ++looks) {
          for (const float value : readImage(file("look.exr")).pixels) isFull = isFull && value > 0;
          sleepSeconds(0.02);
        }
        ::kill(child, SIGINT);
      });
  EXPECT_TRUE(isFull);
  EXPECT_EQ(looks, 40);
}
