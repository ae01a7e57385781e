/** @file
 * `recurse develop`, and the developed outputs of `recurse render`.
 */
#include "program.h"

#include <cmath>
#include <cstdlib>

#include "recurse/core/image/image.h"
#include "recurse/model/scene/plugIns.h"
#include "report/page/bitmapFont.h"

using namespace programTesting;
using recurse::Image;
using recurse::readImage;

namespace {

class DevelopProgram : public Program {
 protected:
  /** A ramp with a lamp in it, too dark to be visible without exposure. */
  void makePicture() const {
    Image image(64, 32, {"R", "G", "B"});
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 64; ++x)
        for (int c = 0; c < 3; ++c) image.at(x, y)[c] = x > 60 ? 100.0f : 1e-4f * std::exp2(float(x) / 10);
    recurse::writeImage(file("dark.exr"), image);
  }
  double meanOf(const std::string& name) const { // Mean of the values in the file.
    const Image image = readImage(file(name));
    double sum = 0;
    for (float v : image.pixels) sum += double(recurse::srgbFromLinear(v)) / double(image.pixels.size());
    return sum;
  }
};

} // namespace

TEST_F(DevelopProgram, ShowsADarkPictureByItself) {
  makePicture();
  const Outcome o = run({"develop", "dark.exr", "-o", "a.png", "-o", "a.jpg"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(has(o.err, "exposure +")) << o.err;
  EXPECT_TRUE(has(o.err, "tone operator filmic")) << o.err;
  EXPECT_GT(meanOf("a.png"), 0.35);
  EXPECT_LT(meanOf("a.png"), 0.65);
  EXPECT_NEAR(meanOf("a.png"), meanOf("a.jpg"), 0.02);
  ASSERT_EQ(run({"develop", "dark.exr", "-q", "-o", "more.png", "--exposure", "auto+1"}).status, 0);
  EXPECT_GT(meanOf("more.png"), meanOf("a.png") + 0.05);
  ASSERT_EQ(
      run({"develop", "dark.exr", "-q", "-o", "plain.png", "--exposure", "0", "--tonemap", "none"}).status,
      0);
  EXPECT_LT(meanOf("plain.png"), 0.1);
  // The stored settings give the same picture.
  const std::string settings = readImage(file("a.png")).metadata.at("recurse:developed");
  EXPECT_TRUE(has(settings, "--tonemap filmic --display srgb")) << settings;
}

TEST_F(DevelopProgram, MakesASheetOfAllOperators) {
  makePicture();
  ASSERT_EQ(run({"develop", "dark.exr", "-q", "-o", "sheet.png", "--sheet"}).status, 0);
  const Image sheet = readImage(file("sheet.png"));
  EXPECT_GT(sheet.width, 3 * 64);
  EXPECT_GT(sheet.height, 2 * 32);
}

TEST_F(DevelopProgram, NamesInASheetOfSmallPicturesDoNotOverlap) {
  recurse::writeImage(file("small.exr"), Image(5, 3, {"R", "G", "B"}));
  ASSERT_EQ(run({"develop", "small.exr", "-q", "-o", "sheet.png", "--sheet"}).status, 0);
  const auto dots = [](const Image& image) {
    int count = 0;
    for (size_t i = 0; i < image.pixels.size(); i += 3) count += image.pixels[i] > 0.5f;
    return count;
  };
  int expected = 0;
  for (const std::string& name : recurse::plugIns().toneMaps.names()) {
    Image alone(400, 40, {"R", "G", "B"});
    recurse::drawText(alone, 0, 0, name, recurse::Rgb(1), 2);
    expected += dots(alone);
  }
  EXPECT_EQ(dots(readImage(file("sheet.png"))), expected);
}

TEST_F(DevelopProgram, BloomSpreadsALamp) {
  makePicture();
  const std::vector<std::string> plain = {"--exposure", "0", "--tonemap", "none", "-q"};
  const auto develop = [&](const std::string& name, std::vector<std::string> more) {
    std::vector<std::string> arguments = {"develop", "dark.exr", "-o", name};
    arguments.insert(arguments.end(), plain.begin(), plain.end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome o = run(arguments);
    EXPECT_EQ(o.status, 0) << o.err;
    return readImage(file(name)).rgb(56, 16).g;
  };
  EXPECT_GT(develop("bloom.png", {"--bloom", "0.5"}), 10 * develop("sharp.png", {}));
}

TEST_F(DevelopProgram, RefusesWhatMakesNoSense) {
  makePicture();
  const auto refused = [&](std::vector<std::string> more, const std::string& words) {
    std::vector<std::string> arguments = {"develop", "dark.exr", "-o", "x.png"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome o = run(arguments);
    EXPECT_EQ(o.status, 2) << o.err;
    EXPECT_TRUE(has(o.err, words)) << o.err;
    EXPECT_FALSE(exists("x.png"));
  };
  refused({"--tonemap", "filmc"}, "did you mean filmic");
  refused({"--tonemap", "drago \"float bais\" 0.7"}, "bias");
  refused({"--tonemap", "drago \"float bias\" 7"}, "0.6");
  refused({"--exposure", "automatic"}, "auto, a percentile");
  refused({"--exposure", "p101"}, "at most 100");
  refused({"--exposure", "bright"}, "not a number");
  refused({"--white-balance", "100"}, "1667 to 25000");
  refused({"--display", "gamma"}, "gamma2.2");
  refused({"--bloom", "2"}, "from 0 to 1");
  refused({"--bloom-angle", "20"}, "needs --bloom");
  refused({"-o", "y.exr"}, "not a picture format for displays");
  const Outcome missing = run({"develop", "none.exr", "-o", "x.png"});
  EXPECT_EQ(missing.status, 1);
  EXPECT_TRUE(has(missing.err, "none.exr: cannot be read")) << missing.err;
}

TEST_F(DevelopProgram, OcioDisplayComesFromTheConfiguration) {
  makePicture();
  // A configuration whose only display applies the square root.
  write("config.ocio", "ocio_profile_version: 1\n"
                       "roles:\n  default: raw\n  scene_linear: lin\n"
                       "displays:\n  screen:\n    - !<View> {name: root, colorspace: shown}\n"
                       "active_displays: []\nactive_views: []\n"
                       "colorspaces:\n"
                       "  - !<ColorSpace>\n    name: raw\n    isdata: true\n"
                       "  - !<ColorSpace>\n    name: lin\n"
                       "  - !<ColorSpace>\n    name: shown\n"
                       "    to_reference: !<ExponentTransform> {value: [2, 2, 2, 1]}\n");
  // The program reads the variables of its environment at the start.
  const auto developed = [&](const std::string& variable, const std::string& display) {
    const std::string command = variable + " '" RECURSE_PROGRAM "' develop '" + file("dark.exr") +
                                "' -q -o '" + file("o.png") + "' --exposure 0 --tonemap none --display " +
                                display + " 2>'" + file("said.txt") + "'";
    const int status = std::system(command.c_str());
    return std::pair(status, contents(file("said.txt")));
  };
  EXPECT_TRUE(has(developed("OCIO=", "ocio").second, "needs the environment variable OCIO"));
  const std::string variable = "OCIO='" + file("config.ocio") + "'";
  const auto [status, said] = developed(variable, "ocio");
  ASSERT_EQ(status, 0) << said;
  const Image shown = readImage(file("o.png"));
  for (int x : {5, 30, 59})
    EXPECT_NEAR(recurse::srgbFromLinear(shown.rgb(x, 3).g), std::sqrt(1e-4f * std::exp2(float(x) / 10)),
                0.003f);
  EXPECT_TRUE(has(developed(variable, "ocio:cinema").second, "it has: screen"));
  EXPECT_TRUE(has(developed("OCIO=nowhere.ocio", "ocio").second, "not an OpenColorIO configuration"));
}

TEST_F(DevelopProgram, RenderSaysHowItExposed) {
  const std::vector<std::string> arguments = {"render", "scene.pbrt", "--integrator", "path", "--spp",
                                              "4",      "-o",         "a.png",        "-o",   "a.exr"};
  const Outcome o = run(arguments);
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(has(o.err, "exposure ")) << o.err;
  EXPECT_TRUE(has(o.err, "for linear values: --exposure 0 --tonemap none")) << o.err;
  std::vector<std::string> plain = arguments;
  plain.insert(plain.end(), {"--exposure", "0", "--tonemap", "none"});
  ASSERT_EQ(run(plain).status, 0);
  const Image png = readImage(file("a.png")), exr = readImage(file("a.exr"));
  for (int y = 0; y < 16; ++y) // clipped to the range of the display, otherwise as computed
    for (int x = 0; x < 24; ++x) EXPECT_NEAR(png.rgb(x, y).g, std::min(exr.rgb(x, y).g, 1.0f), 0.01f);
}

TEST_F(DevelopProgram, PreviewIsKeptUpToDateAndChangesNothing) {
  const std::vector<std::string> arguments = {
      "render", "scene.pbrt", "--integrator", "path",    "--spp", "1000000000", "-o",
      "a.exr",  "--preview",  "p.png",        "--every", "200ms", "--progress", "off"};
  int seen = 0;
  const Outcome o = run(arguments, [&](pid_t child) {
    std::filesystem::file_time_type last{};
    comesTo([&] {
      std::error_code none;
      const auto time = std::filesystem::last_write_time(file("p.png"), none);
      if (none || time == last) return false;
      last = time;
      EXPECT_EQ(readImage(file("p.png")).width, 24); // every version is a complete picture
      return ++seen == 3;
    });
    ::kill(child, SIGINT);
  });
  ASSERT_EQ(o.status, 130) << o.err;
  EXPECT_EQ(seen, 3);
  EXPECT_TRUE(has(o.err, "p.png")) << o.err;
  EXPECT_EQ(leftBehind(), 0u);
  // Previews do not change the picture, at whatever time they are made.
  const auto picture = [&](const std::string& name, std::vector<std::string> more) {
    std::vector<std::string> all = {"render", "scene.pbrt", "-q", "--integrator", "path", "--spp",
                                    "200",    "-o",         name};
    all.insert(all.end(), more.begin(), more.end());
    EXPECT_EQ(run(all).status, 0);
    return readImage(file(name)).pixels;
  };
  EXPECT_EQ(picture("plain.exr", {}), picture("watched.exr", {"--preview", "p.png", "--every", "1ms"}));
  EXPECT_EQ(run({"render", "scene.pbrt", "--every", "3s"}).status, 2);
  EXPECT_EQ(run({"render", "scene.pbrt", "-o", "a.png", "--preview", "a.png"}).status, 2);
  EXPECT_EQ(run({"render", "scene.pbrt", "--preview", "nowhere/a.png"}).status, 1);
}

TEST_F(DevelopProgram, LayersGoIntoTheExr) {
  ASSERT_EQ(run({"render", "scene.pbrt", "-q", "--integrator", "path", "-o", "a.exr", "-o", "a.png",
                 "--layers", "albedo,normal,depth"})
                .status,
            0);
  const Image image = readImage(file("a.exr"));
  EXPECT_EQ(image.channels.size(), 10u);
  const float* floor = image.at(12, 14);
  EXPECT_NEAR(floor[image.channel("albedo.G")], 0.5f, 1e-4f);
  EXPECT_NEAR(floor[image.channel("normal.Y")], 1, 1e-4f);
  EXPECT_GT(floor[image.channel("depth.Z")], 1);
  for (const auto& [layers, words] :
       {std::pair{"albedo,colour", "there are: albedo"}, {"depth,depth", "twice"}}) {
    const Outcome o = run({"render", "scene.pbrt", "-o", "b.exr", "--layers", layers});
    EXPECT_EQ(o.status, 2);
    EXPECT_TRUE(has(o.err, words)) << o.err;
  }
  EXPECT_EQ(run({"render", "scene.pbrt", "-o", "b.png", "--layers", "depth"}).status, 2);
  EXPECT_EQ(run({"render", "scene.pbrt", "-o", "b.exr", "--layers-through"}).status, 2);
  EXPECT_EQ(run({"render", "scene.pbrt", "-o", "b.exr", "--layers", "depth", "--class", "depth=LDE"}).status,
            2);
}
