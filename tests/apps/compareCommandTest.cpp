/** @file
 * `recurse compare` and `recurse info` on pictures.
 */
#include "program.h"

#include <limits>

#include <nlohmann/json.hpp>

#include "recurse/core/image/image.h"

using namespace programTesting;
using recurse::Image;

namespace {

Image constant(float value, int width = 8, int height = 4) {
  Image image(width, height, {"R", "G", "B"});
  std::fill(image.pixels.begin(), image.pixels.end(), value);
  return image;
}

class CompareProgram : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    writeImage(file("x.exr"), constant(1.5f));
    writeImage(file("r.exr"), constant(1));
    writeImage(file("a.exr"), constant(0.9f));
    writeImage(file("b.exr"), constant(1.1f));
  }
};

} // namespace

TEST_F(CompareProgram, TableAndJson) {
  const Outcome text = run({"compare", "x.exr", "r.exr"});
  EXPECT_EQ(text.status, 0) << text.err;
  for (const char* part : {"relMSE", "ε 0.01", "reference²+ε", "MAPE", "PSNR", "worst pixels"})
    EXPECT_TRUE(has(text.out, part)) << text.out;
  const Outcome json = run({"compare", "x.exr", "r.exr", "--json"});
  EXPECT_EQ(json.status, 0) << json.err;
  const nlohmann::json j = nlohmann::json::parse(json.out);
  EXPECT_DOUBLE_EQ(j["mse"], 0.25);
  EXPECT_NEAR(j["relmse"], 0.25 / 1.01, 1e-12);
  EXPECT_DOUBLE_EQ(j["mean_ratio"], 1.5);
  EXPECT_DOUBLE_EQ(j["max"], 0.5);
  for (const char* key : {"relmse_trimmed", "mape", "smape", "flip", "hdrflip", "psnr", "mean_ratio_rgb"})
    EXPECT_TRUE(j.contains(key)) << key;
}

TEST_F(CompareProgram, TwoReferences) {
  const auto json = [&](const std::vector<std::string>& arguments) {
    const Outcome o = run(arguments);
    EXPECT_EQ(o.status, 0) << o.err;
    return nlohmann::json::parse(o.out);
  };
  EXPECT_NEAR(json({"compare", "--json", "x.exr", "a.exr", "b.exr"})["mse_noise_free"], 0.6 * 0.4, 1e-6);
  const nlohmann::json j = json({"compare", "--json", "x.exr", "r.exr", "--noise-free", "a.exr", "b.exr"});
  EXPECT_NEAR(j["relmse_noise_free"], 0.24 / 1.01, 1e-6);
  EXPECT_NEAR(j["relmse"], 0.25 / 1.01, 1e-6);
}

TEST_F(CompareProgram, StatusForScripts) {
  EXPECT_EQ(run({"compare", "x.exr", "r.exr", "--fail-above", "mse=0.26", "--fail-above", "max=0.51"}).status,
            0);
  const Outcome o = run({"compare", "x.exr", "r.exr", "--fail-above", "mse=0.26", "--fail-above", "mape=0.1",
                         "--fail-below", "psnr=40"});
  EXPECT_EQ(o.status, 1);
  EXPECT_TRUE(has(o.err, "mape is ")) << o.err;
  EXPECT_TRUE(has(o.err, "psnr is ")) << o.err;
  EXPECT_FALSE(has(o.err, "mse is ")) << o.err;
  EXPECT_EQ(run({"compare", "r.exr", "r.exr", "--fail-above", "flip=0", "--fail-above", "hdrflip=0"}).status,
            0);
  EXPECT_TRUE(has(run({"compare", "x.exr", "r.exr", "--fail-above", "hdrflip=0.01"}).err, "hdrflip is "));
  EXPECT_TRUE(has(o.out, "relMSE"));

  Image broken = constant(1);
  broken.pixels[5] = std::numeric_limits<float>::quiet_NaN();
  writeImage(file("nan.exr"), broken);
  const Outcome nan = run({"compare", "nan.exr", "r.exr", "--json"});
  EXPECT_EQ(nan.status, 1);
  EXPECT_EQ(nlohmann::json::parse(nan.out)["non_finite"], 1);
  EXPECT_EQ(run({"compare", "r.exr", "nan.exr"}).status, 0);
}

TEST_F(CompareProgram, ErrorsAreClear) {
  writeImage(file("small.exr"), constant(1, 3, 2));
  const Outcome size = run({"compare", "x.exr", "small.exr"});
  EXPECT_EQ(size.status, 1);
  EXPECT_TRUE(has(size.err, "8x4") && has(size.err, "3x2")) << size.err;
  const Outcome missing = run({"compare", "x.exr", "missing.exr"});
  EXPECT_EQ(missing.status, 1);
  EXPECT_TRUE(has(missing.err, "missing.exr: cannot be read: No such file")) << missing.err;
  EXPECT_EQ(run({"compare", "x.exr", "scene.pbrt"}).status, 1);
}

TEST_F(CompareProgram, ErrorMap) {
  ASSERT_EQ(run({"compare", "x.exr", "r.exr", "-o", "map.png"}).status, 0);
  ASSERT_EQ(run({"compare", "x.exr", "r.exr", "-o", "signed.png", "--map", "signed"}).status, 0);
  EXPECT_EQ(recurse::readImage(file("map.png")).width, 8);
  ASSERT_EQ(run({"compare", "x.exr", "r.exr", "-o", "seen.png", "--map", "hdrflip"}).status, 0);
  EXPECT_EQ(recurse::readImage(file("seen.png")).width, 8);
  const recurse::Rgb red = recurse::readImage(file("signed.png")).rgb(2, 2);
  EXPECT_GT(red.r, red.b);
}

TEST_F(CompareProgram, MarksAnExerciseByItsClasses) {
  const Outcome stills =
      run({"stills", "scene.pbrt", "-o", "stills", "--spp", "32", "-q", "--integrator", "path"});
  ASSERT_EQ(stills.status, 0) << stills.err;
  ASSERT_EQ(run({"render", "scene.pbrt", "-o", "right.exr", "--spp", "16", "--seed", "2", "-q",
                 "--integrator", "path"})
                .status,
            0);
  ASSERT_EQ(run({"render", "scene.pbrt", "-o", "wrong.exr", "--spp", "16", "--seed", "2", "-q",
                 "--integrator", "path", "--paths", "LE"})
                .status,
            0);
  const Outcome right = run({"compare", "right.exr", "stills", "--classes"});
  EXPECT_EQ(right.status, 0) << right.err;
  EXPECT_TRUE(has(right.out, "No errors were found")) << right.out;
  const Outcome wrong = run({"compare", "wrong.exr", "stills", "--classes", "-o", "marks.html"});
  EXPECT_EQ(wrong.status, 0) << wrong.err;
  EXPECT_TRUE(has(wrong.out, "LDE (direct-diffuse) is missing")) << wrong.out;
  EXPECT_TRUE(has(contents(file("marks.html")), "LDE (direct-diffuse) is missing"));
  const nlohmann::json json =
      nlohmann::json::parse(run({"compare", "wrong.exr", "stills/stills.exr", "--classes", "--json"}).out);
  EXPECT_EQ(json["classes"][1]["state"], "missing");
  const Outcome picture = run({"compare", "right.exr", "stills", "--classes", "-o", "marks.png"});
  EXPECT_EQ(picture.status, 2);
  EXPECT_TRUE(has(picture.err, "marks.html")) << picture.err;
  EXPECT_EQ(run({"compare", "right.exr", "stills", "right.exr", "--classes"}).status, 2);
  const Outcome plain = run({"compare", "right.exr", "wrong.exr", "--classes"});
  EXPECT_EQ(plain.status, 1);
  EXPECT_TRUE(has(plain.err, "recurse stills")) << plain.err;
}

TEST_F(CompareProgram, AFloatPictureMayBeWhite) {
  write("white.pbrt", scene() + "LightSource \"infinite\" \"rgb L\" [ 1 1 1 ]\n");
  const std::vector<std::string> options = {"--resolution", "24x16", "--integrator", "path", "-q",
                                            "--spp",        "16"};
  std::vector<std::string> stills = {"stills", "white.pbrt", "-o", "stills"},
                           picture = {"render", "white.pbrt", "-o", "white.exr", "--seed", "2"};
  stills.insert(stills.end(), options.begin(), options.end());
  picture.insert(picture.end(), options.begin(), options.end());
  ASSERT_EQ(run(stills).status, 0);
  ASSERT_EQ(run(picture).status, 0);
  const Outcome marks = run({"compare", "white.exr", "stills", "--classes"});
  EXPECT_EQ(marks.status, 0) << marks.err;
  EXPECT_FALSE(has(marks.out, "clipped")) << marks.out;
}

TEST_F(CompareProgram, Info) {
  Image broken = constant(2);
  broken.pixels[4] = std::numeric_limits<float>::infinity();
  broken.metadata["recurse:seed"] = "12";
  writeImage(file("i.exr"), broken);
  const Outcome o = run({"info", "i.exr"});
  EXPECT_EQ(o.status, 0);
  for (const char* part :
       {"8x4 pixels, 3 channels", "mean 2", "1 not finite", "0 not finite", "recurse:seed"})
    EXPECT_TRUE(has(o.out, part)) << part << "\n" << o.out;
  EXPECT_EQ(run({"info", "none.exr"}).status, 1);
  EXPECT_EQ(run({"info", "none.pbrt"}).status, 1);
}
