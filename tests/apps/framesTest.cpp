/** @file
 * `recurse render --frames`: pictures of an animation.
 */
#include "program.h"

#include "gltfFile.h"
#include "recurse/core/image/image.h"

using namespace programTesting;
using recurse::readImage;

namespace {

class Frames : public Program {
 protected:
  static std::string animated(const std::string& x, const std::string& glow) {
    return scene("", "AttributeBegin Material \"diffuse\" \"rgb reflectance\" [ " + glow +
                         " .2 .2 ]\nTranslate " + x +
                         " .5 0\nShape \"sphere\" \"float radius\" .3\nAttributeEnd\n"
                         "ObjectBegin \"post\" Shape \"cylinder\" \"float radius\" .1 ObjectEnd\n"
                         "AttributeBegin Translate .8 0 " +
                         x + " ObjectInstance \"post\" AttributeEnd\n");
  }
  void SetUp() override {
    Program::SetUp();
    write("film.pbrt", "Animate \"x\" \"float times\" [ 0 2 ] \"float values\" [ -.5 .5 ]\n"
                       "Animate \"glow\" \"float times\" [ 0 4 ] \"float values\" [ 0 1 ]\n" +
                           animated("$x", "$glow"));
  }
  /** Expects that each frame of a scene with `$n` from 0 to 2 is equal to the scene of shapes(n) with the
   * number as text, and that no two frames are equal. */
  void expectFrames(const std::function<std::string(const std::string& n)>& shapes) const {
    write("played.pbrt",
          "Animate \"n\" \"float times\" [ 0 2 ] \"float values\" [ 0 2 ]\n" + scene("", shapes("$n")));
    const Outcome o =
        run({"render", "played.pbrt", "--frames", "0:2", "-o", "p.exr", "--integrator", "path"});
    ASSERT_EQ(o.status, 0) << o.err;
    std::vector<recurse::Image> frames;
    for (const std::string n : {"0", "1", "2"}) {
      write("alone.pbrt", scene("", shapes(n)));
      const Outcome alone = run({"render", "alone.pbrt", "-o", "alone.exr", "--integrator", "path"});
      ASSERT_EQ(alone.status, 0) << alone.err;
      frames.push_back(readImage(file("p-000" + n + ".exr")));
      EXPECT_TRUE(frames.back().pixels == readImage(file("alone.exr")).pixels) << n;
    }
    EXPECT_FALSE(frames[0].pixels == frames[1].pixels);
    EXPECT_FALSE(frames[1].pixels == frames[2].pixels);
    EXPECT_FALSE(frames[0].pixels == frames[2].pixels);
  }
};

} // namespace

TEST_F(Frames, AreTheScenesWithTheirNumbersWrittenOut) {
  for (const std::string integrator : {"photonmap", "path"}) {
    const Outcome o = run({"render", "film.pbrt", "--frames", "0:2", "-o", "f.exr", "-o", "g#.pfm",
                           "--integrator", integrator, "--stats", "s.json"});
    ASSERT_EQ(o.status, 0) << o.err;
    EXPECT_TRUE(has(o.err, "as before: 3 of 4 shapes, 1 of 1 objects' trees")) << o.err;
    const char* values[3][2] = {{"-.5", "0"}, {"0", ".25"}, {".5", ".5"}};
    for (int n = 0; n < 3; ++n) {
      write("alone.pbrt", animated(values[n][0], values[n][1]));
      const Outcome alone = run({"render", "alone.pbrt", "-o", "alone.exr", "--integrator", integrator});
      ASSERT_EQ(alone.status, 0) << alone.err;
      const std::string number = std::to_string(n);
      EXPECT_TRUE(readImage(file("f-000" + number + ".exr")).pixels == readImage(file("alone.exr")).pixels)
          << n;
      EXPECT_TRUE(exists("g" + number + ".pfm") && exists("s-000" + number + ".json"));
    }
    EXPECT_FALSE(readImage(file("f-0000.exr")).pixels == readImage(file("f-0001.exr")).pixels);
  }
  // Starts at any frame, with the file name of the scene.
  const Outcome o = run({"render", "film.pbrt", "--frames", "2", "--integrator", "path"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(readImage(file("film-0002.exr")).pixels == readImage(file("f-0002.exr")).pixels);
}

TEST_F(Frames, HaveAMeshFileEach) {
  for (int n = 0; n < 3; ++n) {
    const std::string height = std::to_string(0.3 + 0.3 * n);
    write("cloth000" + std::to_string(n) + ".ply",
          "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
          "element face 1\nproperty list uchar int vertex_indices\nend_header\n-1 0 0\n1 0 0\n0 " +
              height + " 0\n3 0 1 2\n");
  }
  const auto shapes = [](const char* shape) {
    return [shape](const std::string& n) {
      const std::string number = n == "$n" ? "$n%04d" : "000" + n;
      return "Shape \"" + std::string(shape) + "\" \"string filename\" \"cloth" + number + ".ply\"\n";
    };
  };
  expectFrames(shapes("plymesh"));
  expectFrames(shapes("mesh"));
  std::filesystem::remove(file("cloth0002.ply"));
  const Outcome missing = run({"render", "played.pbrt", "--frames", "0:2", "--check"});
  EXPECT_NE(missing.status, 0);
  EXPECT_TRUE(has(missing.err, "there is no file \"cloth0002.ply\"")) << missing.err;
}

TEST_F(Frames, PlayTheAnimationOfAModel) {
  recurse::testing::GltfFile model; // a falling triangle
  const int positions = model.floats("VEC3", {-1, 0, 0, 1, 0, 0, 0, 1, 0}),
            times = model.floats("SCALAR", {0, 2}),
            turns = model.floats("VEC4", {0, 0, 0, 1, -0.70710678f, 0, 0, 0.70710678f});
  write("m.gltf", model.text(R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{)"
                             R"("attributes":{"POSITION":)" +
                             std::to_string(positions) +
                             R"(}}]}],"animations":[{"channels":[{"sampler":0,"target":{"node":0,)"
                             R"("path":"rotation"}}],"samplers":[{"input":)" +
                             std::to_string(times) + R"(,"output":)" + std::to_string(turns) + "}]}]"));
  expectFrames([](const std::string& n) {
    return "Shape \"mesh\" \"string filename\" \"m.gltf\" \"float time\" " + n + "\n";
  });
  // Transforms of the animation without an animated model.
  const char* WITHOUT = "\nShape \"mesh\" \"string filename\" \"m.gltf\"\n";
  write("alone.pbrt", scene("", std::string("Rotate -45 1 0 0") + WITHOUT));
  const Outcome alone = run({"render", "alone.pbrt", "-o", "alone.exr", "--integrator", "path"});
  ASSERT_EQ(alone.status, 0) << alone.err;
  const recurse::Image turned = readImage(file("alone.exr")), frame = readImage(file("p-0001.exr"));
  for (size_t i = 0; i < turned.pixels.size(); ++i) EXPECT_NEAR(frame.pixels[i], turned.pixels[i], 1e-3) << i;
}

TEST_F(Frames, ShareOneExposure) {
  // The lamp becomes darker by six stops; the frame before it is lit is black.
  write("dim.pbrt",
        "Animate \"l\" \"float times\" [ 0 1 2 ] \"float values\" [ 0 16 .25 ]\n" +
            scene("", "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [ $l $l $l ] Translate 0 .4 0 "
                      "Shape \"sphere\" \"float radius\" .3 AttributeEnd\n"));
  std::string text = contents(file("dim.pbrt"));
  text.replace(text.find("[ 4 4 4 ]"), 9, "[ 0 0 0 ]");
  write("dim.pbrt", text);
  const Outcome o = run({"render", "dim.pbrt", "--frames", "0:2", "-o", "f#.png", "-o", "f#.exr",
                         "--integrator", "path", "--tonemap", "none"});
  ASSERT_EQ(o.status, 0) << o.err;
  const std::string chosen = readImage(file("f1.png")).metadata.at("recurse:developed");
  EXPECT_EQ(readImage(file("f2.png")).metadata.at("recurse:developed"), chosen);
  const Outcome alone = run({"develop", "f1.exr", "-o", "alone.png", "--tonemap", "none"});
  ASSERT_EQ(alone.status, 0) << alone.err;
  EXPECT_EQ(readImage(file("alone.png")).pixels, readImage(file("f1.png")).pixels);
}

TEST_F(Frames, AreCheckedWithoutRendering) {
  const Outcome good = run({"render", "film.pbrt", "--frames", "1:3", "--check"});
  EXPECT_EQ(good.status, 0) << good.err;
  EXPECT_TRUE(has(good.out, "animation   frame 1; keyframes from 0 to 4 of x, glow")) << good.out;
  EXPECT_TRUE(has(good.err, "frame 3: ")) << good.err;
  const Outcome first = run({"render", "film.pbrt", "--check"});
  EXPECT_TRUE(has(first.out, "animation   frame 0;")) << first.out;
  // An error that only a later frame has is reported.
  write("film.pbrt", "Animate \"x\" \"float times\" [ 0 2 ] \"float values\" [ 1 -1 ]\n" +
                         scene("", "Shape \"sphere\" \"float radius\" $x\n"));
  EXPECT_EQ(run({"render", "film.pbrt", "--frames", "0", "--check"}).status, 0);
  const Outcome bad = run({"render", "film.pbrt", "--frames", "0:2", "--check"});
  EXPECT_NE(bad.status, 0);
  EXPECT_TRUE(has(bad.err, "radius")) << bad.err;
}

TEST_F(Frames, ErrorsSayWhatToDo) {
  const auto fails = [&](std::vector<std::string> more, const std::string& words) {
    std::vector<std::string> all = {"render", "film.pbrt"};
    all.insert(all.end(), more.begin(), more.end());
    const Outcome o = run(all);
    EXPECT_NE(o.status, 0);
    EXPECT_TRUE(has(o.err, words)) << o.err;
  };
  fails({"--frames", "3:1"}, "from 3 to");
  fails({"--frames", "1:2:3"}, "FIRST:LAST");
  fails({"--frames", "a"}, "--frames: 'a'");
  fails({"--frames", "0:1", "--checkpoint", "c"}, "cannot be combined with --checkpoint");
  const Outcome still = run({"render", "scene.pbrt", "--frames", "0:1"});
  EXPECT_NE(still.status, 0);
  EXPECT_TRUE(has(still.err, "no Animate directive")) << still.err;
}
