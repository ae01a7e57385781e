/** @file
 * Models on the command line: `recurse convert`, and `recurse render` of a model itself.
 */
#include "program.h"

#include "recurse/core/image.h"

using namespace programTesting;
using recurse::Image;
using recurse::readImage;

namespace {

class ProgramModel : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    std::filesystem::create_directories(file("models"));
    write("models/box.obj",
          "mtllib box.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
          "vt 0 0\nvt 1 0\nvt 1 1\nusemtl red\nf 5/1 6/2 7/3 8/1\nf 2/1 1/2 4/3 3/1\n"
          "f 1/1 5/2 8/3 4/1\nf 6/1 2/2 3/3 7/1\nf 8/1 7/2 3/3 4/1\nf 1/1 2/2 6/3 5/1\n");
    write("models/box.mtl", "newmtl red\nKd 1 1 1\nmap_Kd red.png\n");
    Image red(1, 1, {"R", "G", "B"});
    red.at(0, 0)[0] = 0.8f;
    writeImage(file("models/red.png"), red);
  }
};

/** The mean of a picture's middle. */
recurse::Rgb middle(const Image& image) {
  recurse::Rgb sum(0);
  for (int y = 9; y < 15; ++y)
    for (int x = 13; x < 19; ++x) sum += image.rgb(x, y);
  return sum / 36.0f;
}

} // namespace

TEST_F(ProgramModel, IsRenderedAsItIs) {
  const Outcome o = run({"render", "models/box.obj", "-o", "box.exr", "--resolution", "32x24", "--spp", "4",
                         "--integrator", "path"});
  ASSERT_EQ(o.status, 0) << o.err;
  const Image picture = readImage(file("box.exr"));
  EXPECT_GT(middle(picture).r, 0.2f);
  EXPECT_LT(middle(picture).g, 0.1f);
  EXPECT_NEAR(picture.rgb(0, 0).g, 0.5f, 0.01f); // the sky: all of the box is seen
  const Outcome check = run({"render", "models/box.obj", "--check"});
  EXPECT_TRUE(has(check.out, "1 mesh, 12 triangles, 1 material, 1 picture")) << check.out;
}

TEST_F(ProgramModel, IsConvertedToASceneThatStandsByItself) {
  Outcome o = run({"convert", "models/box.obj", "-o", "made.pbrt"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(std::filesystem::exists(file("made-files/red.png")));
  const std::vector<std::string> settings = {"--resolution", "32x24", "--spp", "4", "--integrator", "path"};
  const auto picture = [&](const std::string& scene, const std::string& output) {
    std::vector<std::string> arguments = {"render", scene, "-o", output};
    arguments.insert(arguments.end(), settings.begin(), settings.end());
    const Outcome rendered = run(arguments);
    EXPECT_EQ(rendered.status, 0) << rendered.err;
    return readImage(file(output)).pixels;
  };
  const std::vector<float> direct = picture("models/box.obj", "a.exr");
  std::filesystem::remove_all(file("models"));
  EXPECT_EQ(picture("made.pbrt", "b.exr"), direct);
}

TEST_F(ProgramModel, WrongUsageIsExplained) {
  EXPECT_EQ(run({"convert", "scene.pbrt", "-o", "made.pbrt"}).status, 2);
  EXPECT_EQ(run({"convert", "models/box.obj", "-o", "made.txt"}).status, 2);
  const Outcome o = run({"convert", "models/gone.obj", "-o", "made.pbrt"});
  EXPECT_EQ(o.status, 3);
  EXPECT_TRUE(has(o.err, "there is no file \"models/gone.obj\"")) << o.err;
  EXPECT_FALSE(std::filesystem::exists(file("made.pbrt")));
}
