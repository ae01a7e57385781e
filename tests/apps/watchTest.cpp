/** @file
 * `recurse render --watch`: a change of the scene's files makes a new picture.
 */
#include "program.h"

#include "recurse/core/image.h"

using namespace programTesting;
using recurse::readImage;

namespace {

class Watch : public Program {
 protected:
  /** Waits for a line that says so, for the `count`th time. */
  bool said(const std::string& words, size_t count) const {
    for (int i = 0; i < 3000; ++i) {
      const std::string text = contents(file(".stderr"));
      size_t found = 0;
      for (size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++found;
      if (found >= count) return true;
      sleepSeconds(0.02);
    }
    return false;
  }
  static constexpr const char* WAITING = "waiting for a change";
};

} // namespace

TEST_F(Watch, RendersAgainAfterChangesAndErrors) {
  write("more.pbrt", "Material \"diffuse\"\n");
  const std::string with = scene("", "Include \"more.pbrt\"\nShape \"sphere\" \"float radius\" .2\n");
  write("scene.pbrt", with);
  const Outcome o =
      run({"render", "scene.pbrt", "--watch", "-o", "w.exr", "--integrator", "path"}, [&](pid_t child) {
        EXPECT_TRUE(said(WAITING, 1));
        EXPECT_EQ(readImage(file("w.exr")).width, 24);
        const std::vector<float> before = readImage(file("w.exr")).pixels;
        write("more.pbrt", "Material \"diffuse\" \"rgb reflectance\" [ 0 .9 0 ]\n"); // an included file
        EXPECT_TRUE(said(WAITING, 2));
        EXPECT_FALSE(readImage(file("w.exr")).pixels == before);
        write("scene.pbrt", with + "Shape \"nonsense\"\n");
        EXPECT_TRUE(said("unknown Shape", 1) && said(WAITING, 3));
        write("scene.pbrt", with);
        EXPECT_TRUE(said(WAITING, 4));
        ::kill(child, SIGINT);
      });
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(has(o.err, "\n6x4 pixels") || o.err.starts_with("6x4 pixels")) << o.err;
  EXPECT_TRUE(has(o.err, "\n24x16 pixels")) << o.err;
  EXPECT_EQ(leftBehind(), 0u);
}

TEST_F(Watch, EndsARenderThatIsUnderWay) {
  const Outcome o =
      run({"render", "scene.pbrt", "--watch", "-o", "w.exr", "--integrator", "path", "--spp", "100000000"},
          [&](pid_t child) {
            sleepSeconds(1);
            write("scene.pbrt", scene() + "Shape \"nonsense\"\n");
            EXPECT_TRUE(said("unknown Shape", 1));
            ::kill(child, SIGINT);
          });
  EXPECT_EQ(o.status, 0) << o.err;
}

TEST_F(Watch, RefusesWhatMakesNoSense) {
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--check"}, {"--live"}, {"--checkpoint", "c.rck"}}) {
    std::vector<std::string> words = {"render", "scene.pbrt", "--watch", "-o", "w.exr"};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(run(words).status, 2) << more[0];
  }
  EXPECT_EQ(run({"render", "scene.pbrt", "--send-scene"}).status, 2);
}
