/** @file
 * `recurse figure` and the options of `recurse inspect`.
 */
#include "program.h"

#include "recurse/core/image/image.h"

using namespace programTesting;
using recurse::Image;
using recurse::readImage;

namespace {

using FigureProgram = Program;

/** Options that a kind requires, or that shorten its render. */
std::vector<std::string> optionsOf(const std::string& kind) {
  if (kind == "guide") return {"--pixel", "12,12", "--pixel", "3,14", "--stages", "2"};
  if (kind == "estimate") return {"--photons", "20k"};
  return {};
}

/** Number of pixels that are not white paper. */
size_t inkOf(const Image& image) {
  size_t count = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) count += image.at(x, y)[1] < 0.99f;
  return count;
}

} // namespace

TEST_F(FigureProgram, EachKindIsAPicture) {
  for (const std::string kind :
       {"pyramid", "mis", "samplings", "estimate", "acne", "patches", "guide", "cost"}) {
    std::vector<std::string> words = {"figure", kind, "scene.pbrt", "-o", kind + ".png", "--spp", "2", "-q"};
    for (const std::string& word : optionsOf(kind)) words.push_back(word);
    const Outcome o = run(words);
    ASSERT_EQ(o.status, 0) << kind << o.err;
    EXPECT_GT(inkOf(readImage(file(kind + ".png"))), 2u * 24 * 16) << kind;
  }
}

TEST_F(FigureProgram, InspectSaysWarningsOnce) {
  const Outcome o = run({"inspect", "scene.pbrt", "-o", "look.html", "--integrator", "mlt", "--spp", "1",
                         "--path-samples", "1", "--reference-samples", "0"});
  ASSERT_EQ(o.status, 0) << o.err;
  const size_t first = o.err.find("is rendered by \"path\"");
  ASSERT_NE(first, std::string::npos) << o.err;
  EXPECT_EQ(o.err.find("is rendered by \"path\"", first + 1), std::string::npos) << o.err;
}

TEST_F(FigureProgram, WritesSvg) {
  const Outcome o = run({"figure", "samplings", "scene.pbrt", "-o", "s.svg", "--spp", "2", "-q"});
  ASSERT_EQ(o.status, 0) << o.err;
  const std::string svg = contents(file("s.svg"));
  EXPECT_TRUE(svg.starts_with("<svg "));
  EXPECT_TRUE(has(svg, ">samplings of direct light</text>"));
  size_t pictures = 0;
  for (size_t at = svg.find("<image "); at != std::string::npos; at = svg.find("<image ", at + 1)) ++pictures;
  EXPECT_EQ(pictures, 5u);
}

TEST_F(FigureProgram, TheGuideHasAnEntryForEachPixel) {
  const Outcome o = run({"figure", "guide", "scene.pbrt", "-o", "g.svg", "--pixel", "12,12", "--pixel",
                         "3,14", "--stages", "1", "--spp", "1", "-q"});
  ASSERT_EQ(o.status, 0) << o.err;
  const std::string svg = contents(file("g.svg"));
  for (const char* text : {"directions of light", "guide: ", ">12,12: all light, E = ",
                           ">3,14: all light, E = ", ">left to rays, ", "per sr, logarithmic"})
    EXPECT_TRUE(has(svg, text)) << text;
}

TEST_F(FigureProgram, TheGuideNeedsASurface) {
  const Outcome o = run({"figure", "guide", "scene.pbrt", "-o", "g.png", "--pixel", "0,0", "--spp", "1"});
  EXPECT_EQ(o.status, 1);
  EXPECT_TRUE(has(o.err, "pixel 0,0 sees no surface with a non-delta lobe")) << o.err;
}

TEST_F(FigureProgram, OptionsOfAKindChangeItsFigure) {
  const auto sheetOf = [&](const std::string& kind, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"figure", kind, "scene.pbrt", "-o", "o.exr", "--spp", "2", "-q"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome o = run(words);
    EXPECT_EQ(o.status, 0) << kind << o.err;
    return readImage(file("o.exr"));
  };
  EXPECT_NE(sheetOf("estimate", {"--photons", "2000", "--maps", "2"}).pixels,
            sheetOf("estimate", {"--photons", "2000", "--maps", "3"}).pixels);
  EXPECT_NE(sheetOf("estimate", {"--photons", "2000", "--maps", "2"}).pixels,
            sheetOf("estimate", {"--photons", "2000", "--maps", "2", "--gather-photons", "5"}).pixels);
  EXPECT_LT(sheetOf("acne", {"--offsets", "0"}).height, sheetOf("acne", {"--offsets", "0,1,2,3,4"}).height);
  EXPECT_NE(sheetOf("patches", {"--set", "patchsize=.3"}).pixels, sheetOf("patches", {}).pixels);
}

TEST_F(FigureProgram, MoreEdgesAreMoreRows) {
  const auto heightOf = [&](const std::string& edges) {
    EXPECT_EQ(
        run({"figure", "pyramid", "scene.pbrt", "-o", "p.png", "--spp", "1", "-q", "--edges", edges}).status,
        0);
    return readImage(file("p.png")).height;
  };
  const int two = heightOf("2"), three = heightOf("3");
  EXPECT_GE(three, two + 2 * 16); // a row in both pyramids
}

TEST_F(FigureProgram, WrongUsageIsRefused) {
  const auto refused = [&](std::vector<std::string> more, const std::string& part) {
    std::vector<std::string> words = {"figure", "pyramid", "scene.pbrt", "-o", "p.png"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome o = runAMinute(words);
    EXPECT_EQ(o.status, 2) << part;
    EXPECT_TRUE(has(o.err, part)) << o.err;
  };
  refused({"--edges", "1"}, "--edges");
  refused({"--edges", "13"}, "--edges");
  refused({"--edges", "many"}, "--edges");
  refused({"--time-limit", "5s"}, "--spp");
  refused({"--error-target", ".1"}, "--spp");
  refused({"--adaptive"}, "--adaptive");
  refused({"--stats", "s.json"}, "--stats");
  refused({"--integrator", "path"}, "--integrator");
  refused({"--photons", "1000"}, "--photons");
  refused({"--set", "alpha=.5"}, "--set");
  const auto refusedOf = [&](const std::string& kind, const std::vector<std::string>& more,
                             const std::string& part) {
    std::vector<std::string> words = {"figure", kind, "scene.pbrt", "-o", "p.png"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome o = runAMinute(words);
    EXPECT_EQ(o.status, 2) << kind << part;
    EXPECT_TRUE(has(o.err, part)) << o.err;
  };
  for (const std::string kind : {"samplings", "acne"}) {
    refusedOf(kind, {"--photons", "1000"}, "--photons: 'figure " + kind + "' has no integrator");
    refusedOf(kind, {"--set", "alpha=.5"}, "--set: 'figure " + kind + "' has no integrator");
    refusedOf(kind, {"--integrator", "path"}, "--integrator");
    refusedOf(kind, {"--maps", "3"}, "--maps");
  }
  refusedOf("estimate", {"--maps", "1"}, "--maps");
  refusedOf("estimate", {"--spp", "1"}, "--spp");
  refusedOf("estimate", {"--direct", "shadowrays"}, "--direct");
  refusedOf("estimate", {"--set", "passes=3"}, "--set passes");
  refusedOf("estimate", {"--offsets", "1"}, "--offsets");
  refusedOf("acne", {"--offsets", "-1"}, "--offsets");
  refusedOf("acne", {"--offsets", "0,a"}, "--offsets");
  refusedOf("patches", {"--photons", "1000"}, "--photons");
  refusedOf("guide", {}, "--pixel X,Y");
  refusedOf("guide", {"--pixel", "24,0"}, "--pixel: 24,0 is outside of the picture of 0,0 to 23,15");
  refusedOf("guide", {"--pixel", "3"}, "--pixel: 3 is not X,Y");
  refusedOf("guide", {"--pixel", "3,4", "--stages", "0"}, "--stages");
  refusedOf("guide", {"--pixel", "3,4", "--set", "guided=false"}, "--set guided");
  refusedOf("guide", {"--pixel", "3,4", "--integrator", "bdpt"}, "--integrator");
  refusedOf("cost", {"--pixel", "3,4"}, "--pixel: 'figure cost' has no such option");
  EXPECT_EQ(run({"figure", "mis", "scene.pbrt", "-o", "p.png", "--integrator", "bdpt"}).status, 2);
  EXPECT_EQ(run({"figure", "mis", "scene.pbrt", "-o", "p.png", "--edges", "3"}).status, 2);
  EXPECT_EQ(run({"figure", "cost", "scene.pbrt", "-o", "p.png", "--edges", "3"}).status, 2);
  EXPECT_EQ(run({"figure", "square", "scene.pbrt", "-o", "p.png"}).status, 2);
  EXPECT_EQ(run({"figure", "mis", "scene.pbrt", "-o", "p.doc"}).status, 2);
  EXPECT_EQ(run({"figure", "mis", "scene.pbrt"}).status, 2);
  EXPECT_FALSE(std::filesystem::exists(file("p.png")));
}

TEST_F(FigureProgram, MaximumDepthHolds) {
  const auto inkOfBoth = [&](const std::string& header, const std::vector<std::string>& more) {
    write("depth.pbrt", scene(header));
    std::vector<std::string> words = {"figure", "mis", "depth.pbrt", "-o", "p.exr", "--spp", "1", "-q"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome o = run(words);
    EXPECT_EQ(o.status, 0) << o.err;
    return readImage(file("p.exr")).pixels;
  };
  const auto all = inkOfBoth("", {}), direct = inkOfBoth("", {"--maxdepth", "0"});
  EXPECT_NE(all, direct);
  EXPECT_EQ(inkOfBoth("Integrator \"path\" \"integer maxdepth\" 0\n", {}), direct);
}

TEST_F(FigureProgram, TooManyPicturesForTheMemoryAreAnError) {
  const Outcome o = runAMinute({"figure", "pyramid", "scene.pbrt", "-o", "p.png", "--spp", "1", "--edges",
                                "12", "--resolution", "1920x1080", "--memory", "4G"});
  EXPECT_EQ(o.status, 1);
  EXPECT_TRUE(has(o.err, "a figure of 176 pictures of 1920x1080 pixels")) << o.err;
}

TEST_F(FigureProgram, TheTitleOfCostsHasTheSamplesThatWereTaken) {
  const auto sheet = [&](const std::string& samples) {
    const Outcome o = run({"figure", "cost", "scene.pbrt", "-o", "c.exr", "--integrator", "photonmap",
                           "--photons", "1000", "--set", "passes=16", "--spp", samples, "-q"});
    EXPECT_EQ(o.status, 0) << o.err;
    Image image = readImage(file("c.exr"));
    const size_t title = size_t(image.width) * 40 * image.channels.size(); // top of the sheet
    image.pixels.resize(title);
    return image.pixels;
  };
  const auto four = sheet("4");
  EXPECT_EQ(four, sheet("16"));
  EXPECT_NE(four, sheet("17"));
}

TEST_F(FigureProgram, FogIsRefusedByNameOfTheIntegrator) {
  write("fog.pbrt",
        scene("MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\nMediumInterface \"\" \"fog\"\n"));
  const Outcome o = run({"figure", "pyramid", "fog.pbrt", "-o", "p.png", "--spp", "1"});
  EXPECT_EQ(o.status, 1);
  EXPECT_TRUE(has(o.err, "bdpt, which cannot render media")) << o.err;
}

TEST_F(FigureProgram, FogIsRefusedByFiguresOfSurfaces) {
  write("fog.pbrt",
        scene("MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\nMediumInterface \"\" \"fog\"\n"));
  for (const std::string kind : {"samplings", "estimate", "acne"}) {
    const Outcome o = run({"figure", kind, "fog.pbrt", "-o", "p.png", "--spp", "2"});
    EXPECT_EQ(o.status, 1) << kind;
    EXPECT_TRUE(has(o.err, "cannot draw media")) << o.err;
  }
  const Outcome o = run({"figure", "patches", "fog.pbrt", "-o", "p.png", "--spp", "2"});
  EXPECT_EQ(o.status, 1);
  EXPECT_TRUE(has(o.err, "radiosity, which cannot render media")) << o.err;
}

TEST_F(FigureProgram, InspectRefusesWrongNumbers) {
  for (const std::string option : {"--shown-light-paths", "--reference-samples"})
    for (const std::string value : {"-1", "some", "1e30"}) {
      const Outcome o = run({"inspect", "scene.pbrt", "-o", "p.html", option + "=" + value});
      EXPECT_EQ(o.status, 2) << option << value;
      EXPECT_TRUE(has(o.err, option)) << o.err;
    }
  const Outcome o = run({"inspect", "scene.pbrt", "-o", "p.html", "--reference-samples", "1"});
  EXPECT_EQ(o.status, 2); // no standard error
  EXPECT_TRUE(has(o.err, "--reference-samples")) << o.err;
}
