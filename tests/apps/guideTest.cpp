/** @file
 * Scenes of doc-files/guide: each is rendered at a small size, and the statements of its page about the
 * picture hold. Commands in the pages use existing options.
 */
#include "program.h"

#include <cmath>
#include <map>
#include <regex>

#include "recurse/core/image/image.h"

using namespace programTesting;
using recurse::Image;
using recurse::readImage;

namespace {

const std::string ROOT = RECURSE_SOURCE_DIR;

std::string scenePath(const std::string& name) { return ROOT + "/doc-files/examples/" + name + ".pbrt"; }

class Guide : public Program {
 protected:
  /** Renders an example as its page does, at a smaller size. */
  Image render(const std::string& name, const std::string& resolution, const std::string& spp,
               const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {
        "render", scenePath(name), "-q", "--resolution", resolution, "--spp", spp, "-o", "p.exr"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome o = run(words);
    EXPECT_EQ(o.status, 0) << name << "\n" << o.err;
    return o.status == 0 ? readImage(file("p.exr")) : Image(1, 1, {"R", "G", "B"});
  }
  static double mean(const Image& image, int channel = 1) {
    double sum = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) sum += double(image.at(x, y)[channel]);
    return sum / (image.width * image.height);
  }
  /** Column of the centre of mass of the green channel [pixels]. */
  static double centreOfMass(const Image& image) {
    double sum = 0, moment = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        sum += double(image.at(x, y)[1]);
        moment += (x + 0.5) * double(image.at(x, y)[1]);
      }
    return moment / sum;
  }
};

} // namespace

TEST_F(Guide, FirstSceneHasACausticInTheShadowOfItsBall) {
  const Image direct = render("first-scene", "40x40", "4", {"--paths", "LDE"}),
              caustic = render("first-scene", "40x40", "4", {"--paths", "LS+DE", "--photons", "20k"});
  // The converged caustic is .37 here and .04 in the row above. The floor without the ball is .07.
  EXPECT_EQ(direct.rgb(20, 29).g, 0) << "the shadow";
  EXPECT_GT(caustic.rgb(20, 29).g, 2 * direct.rgb(2, 35).g) << "brighter than the floor without the ball";
  EXPECT_LT(caustic.rgb(2, 35).g, 0.05 * direct.rgb(2, 35).g) << "only light that the ball reflects";
}

TEST_F(Guide, CausticsAreTheSameByPhotonsAndByBidirectionalPaths) {
  const double photons = mean(render("caustics", "48x36", "16",
                                     {"--paths", "LS+DE", "--integrator", "photonmap", "--photons", "50k"})),
               paths = mean(render("caustics", "48x36", "128", {"--paths", "LS+DE", "--integrator", "bdpt"}));
  EXPECT_GT(paths, 0.001);
  EXPECT_NEAR(photons / paths, 1, 0.1) << "both have a standard error of 1 to 2 %";
}

TEST_F(Guide, FogDimsTheLampByBeersLawAndShowsTheBeam) {
  // The lamp is at a distance of 20, behind 2 mean free paths of fog. The crop is inside of the lamp.
  const Image lamp =
      render("fog", "600x400", "256",
             {"--integrator", "path", "--paths", "LE", "--cropwindow", "0.49,0.51,0.485,0.515"});
  EXPECT_NEAR(mean(lamp), 2 * std::exp(-2.0), 0.02);
  const auto scattered = [&](const char* crop) {
    return mean(render("fog", "60x40", "16", {"--paths", "LVE", "--photons", "20k", "--cropwindow", crop}));
  };
  EXPECT_GT(scattered("0.1,0.35,0.1,0.4"), 3 * scattered("0.65,0.9,0.1,0.4")) << "the beam is on the left";
}

TEST_F(Guide, ImageLightIsSeenInTheMirrorBallAndLightsTheMattOne) {
  const Image mirror = render("image-light", "48x32", "4", {"--integrator", "path", "--paths", "LSE"});
  EXPECT_GT(mirror.rgb(34, 11).b, 0.05) << "the sky in the silver ball";
  EXPECT_EQ(mirror.rgb(14, 16).g, 0) << "the other ball";
  const double path = mean(render("image-light", "48x32", "64", {"--integrator", "path"})),
               both = mean(render("image-light", "48x32", "64", {"--integrator", "bdpt"}));
  EXPECT_NEAR(path / both, 1, 0.02);
}

TEST_F(Guide, ModelsHaveTheMaterialsOfTheirFile) {
  const Outcome check = run({"render", scenePath("models"), "--check"});
  EXPECT_EQ(check.status, 0) << check.err;
  EXPECT_TRUE(has(check.out + check.err, "mesh: 2 meshes, 14 triangles, 2 materials"))
      << check.out << check.err;
  EXPECT_TRUE(has(check.out + check.err, "2 instances"));
  const Image albedo = render("models", "48x32", "1", {"--integrator", "path", "--layers", "albedo"});
  const int red = albedo.channel("albedo.R");
  ASSERT_GE(red, 0);
  EXPECT_NEAR(albedo.at(12, 14)[red], 0.6, 0.02) << "a roof";
  EXPECT_NEAR(albedo.at(12, 14)[albedo.channel("albedo.G")], 0.15, 0.02);
  EXPECT_NEAR(albedo.at(12, 20)[red], 0.7, 0.02) << "a wall";
}

TEST_F(Guide, FramesMoveTheBall) {
  const Outcome o = run({"render", scenePath("frames"), "-q", "--frames", "0:24", "--resolution", "32x16",
                         "--spp", "4", "--integrator", "path", "--paths", "LE", "-o", "f.exr"});
  ASSERT_EQ(o.status, 0) << o.err;
  // The ball is at x / (distance tan(15 degrees)) half heights from the middle.
  const double right = 8 * 2 / (std::hypot(8.0, 0.7) * std::tan(3.14159265 / 12));
  EXPECT_NEAR(centreOfMass(readImage(file("f-0000.exr"))), 16 - right, 0.3);
  EXPECT_NEAR(centreOfMass(readImage(file("f-0012.exr"))), 16, 0.1);
  EXPECT_NEAR(centreOfMass(readImage(file("f-0024.exr"))), 16 + right, 0.3);
}

TEST_F(Guide, ReedsSwayAndAreBackAfterTwoSeconds) {
  const Outcome check = run({"render", scenePath("reeds"), "--check"});
  EXPECT_EQ(check.status, 0) << check.err;
  const std::string said = "mesh: 3 meshes, 1040 triangles, 3 materials, animation \"sway\" at 0 s";
  EXPECT_TRUE(has(check.out + check.err, said)) << check.out << check.err;
  EXPECT_TRUE(has(contents(ROOT + "/doc-files/guide/animation.md"), said));
  const auto frame = [&](const std::string& number) {
    const Outcome o = run({"render", scenePath("reeds"), "-q", "--frames", number, "--resolution", "96x64",
                           "--spp", "4", "-o", "f.exr"});
    EXPECT_EQ(o.status, 0) << o.err;
    return readImage(file("f-00" + number + ".exr"));
  };
  const Image start = frame("00"), middle = frame("24"), end = frame("48");
  double inHalf = 0, inWhole = 0; // sums of squared differences to the first frame
  for (size_t i = 0; i < start.pixels.size(); ++i) {
    inHalf += std::pow(double(middle.pixels[i] - start.pixels[i]), 2);
    inWhole += std::pow(double(end.pixels[i] - start.pixels[i]), 2);
  }
  EXPECT_GT(inHalf, 1);
  EXPECT_LT(inWhole, 0.01 * inHalf);
}

TEST_F(Guide, LightInFlightArrivesFirstByTheShortestWay) {
  const Image film = render("light-in-flight", "80x60", "16",
                            {"--integrator", "path", "--paths", "LDE", "--time-of-flight", "5.5:9:70"});
  // Length of the first frame with light in these columns and rows.
  const auto first = [&](int x0, int x1, int y0, int y1) {
    for (int frame = 0; frame < 70; ++frame) {
      const int green = film.channel((frame < 10 ? "frame-000" : "frame-00") + std::to_string(frame) + ".G");
      if (green < 0) return double(INFINITY);
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x)
          if (film.at(x, y)[green] > 0) return 5.5 + 0.05 * frame;
    }
    return double(INFINITY);
  };
  // The shortest path by a plane is as long as the straight line from the mirror image of the lamp.
  EXPECT_NEAR(first(18, 62, 2, 20), std::hypot(1.3, 0.4, 1.6 + 5 + 2), 0.051) << "the wall at the back";
  EXPECT_LT(first(0, 80, 40, 60), 6) << "the floor";
}

TEST_F(Guide, StillsAddUpToThePicture) {
  const Outcome o = run({"stills", scenePath("stills"), "-q", "-o", "s", "--resolution", "24x24", "--spp",
                         "4", "--integrator", "path"});
  ASSERT_EQ(o.status, 0) << o.err;
  const Image all = readImage(file("s/stills.exr"));
  const int caustic = all.channel("caustic.R"), direct = all.channel("direct-diffuse.R");
  ASSERT_TRUE(caustic >= 0 && direct >= 0);
  for (int y = 0; y < all.height; ++y)
    for (int x = 0; x < all.width; ++x) {
      double sum = 0;
      for (size_t c = 0; c < all.channels.size(); ++c)
        if (all.channels[c].ends_with(".R")) sum += double(all.at(x, y)[c]);
      ASSERT_NEAR(sum, all.at(x, y)[0], 1e-5 + 1e-4 * all.at(x, y)[0]) << x << " " << y;
    }
  EXPECT_GT(mean(all, direct), 0);
}

TEST_F(Guide, FurnaceHasAKnownAnswerAndItsErrorFallsWithTheSamples) {
  std::vector<double> squares; // mean squared errors
  for (const std::string spp : {"4", "64"}) {
    const Image image = render("furnace", "32x32", spp, {"--integrator", "path"});
    double square = 0;
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x) square += std::pow(double(image.rgb(x, y).g) - 2, 2) / 1024;
    EXPECT_NEAR(mean(image), 2, 4 * std::sqrt(square / 1024)) << "no bias, " << spp << " samples";
    squares.push_back(square);
  }
  EXPECT_GT(squares[0] / squares[1], 12) << "1 / samples, or faster with points of low discrepancy";
}

TEST_F(Guide, PartsOfManyMachinesMergeToTheSameBits) {
  const std::vector<std::string> common = {"--integrator", "path", "--resolution", "16x16", "--spp", "6"};
  const Image whole = render("first-scene", "16x16", "6", {"--integrator", "path"});
  for (const auto& [range, kept] : {std::pair<std::string, std::string>{"0:3", "a.rck"}, {"3:6", "b.rck"}}) {
    std::vector<std::string> words = {"render", scenePath("first-scene"), "-q", "--sample-range",
                                      range,    "--checkpoint",           kept};
    words.insert(words.end(), common.begin(), common.end());
    const Outcome o = run(words);
    ASSERT_EQ(o.status, 0) << o.err;
  }
  const Outcome merged = run({"merge", "a.rck", "b.rck", "-o", "m.exr"});
  ASSERT_EQ(merged.status, 0) << merged.err;
  EXPECT_EQ(readImage(file("m.exr")).pixels, whole.pixels);
}

TEST_F(Guide, ExposureIsAFactorOfTheLinearValues) {
  const Image linear = render("exposure", "16x8", "4", {"--integrator", "path"});
  EXPECT_FLOAT_EQ(linear.rgb(3, 4).g, 4);
  EXPECT_FLOAT_EQ(linear.rgb(12, 4).g, 0.25f);
  const Outcome o = run({"develop", "p.exr", "-q", "--exposure", "+1", "--tonemap", "none", "-o", "d.png"});
  ASSERT_EQ(o.status, 0) << o.err;
  const Image shown = readImage(file("d.png"));
  EXPECT_FLOAT_EQ(shown.rgb(3, 4).g, 1) << "white";
  EXPECT_NEAR(shown.rgb(12, 4).g, 0.5, 0.01);
}

TEST_F(Guide, FilesOfPbrtAreTakenWithTheWarningsOfThePage) {
  const Outcome check = run({"render", scenePath("from-pbrt"), "--check"});
  EXPECT_EQ(check.status, 0) << check.err;
  const std::string said = check.out + check.err, page = contents(ROOT + "/doc-files/guide/pbrt.md");
  for (const char* part : {"warning: \"volpath\" is rendered by \"path\"",
                           "warning: the spectral response of \"canon_eos_5d\" is not available"}) {
    EXPECT_TRUE(has(said, part)) << said;
    EXPECT_TRUE(has(page, part)) << part;
  }
  EXPECT_EQ(render("from-pbrt", "20x15", "2").pixels,
            render("from-pbrt", "20x15", "2", {"--integrator", "path", "--maxdepth", "8"}).pixels);
}

TEST_F(Guide, CommandsOfThePagesHaveOptionsThatExist) {
  std::vector<std::string> pages = {
      ROOT + "/README.md", ROOT + "/CONTRIBUTING.md", ROOT + "/doc-files/first-plug-ins.md",
      ROOT + "/doc-files/first-estimator.md", ROOT + "/doc-files/course/README.md"};
  for (const auto& entry : std::filesystem::directory_iterator(ROOT + "/doc-files/guide"))
    if (entry.path().extension() == ".md") pages.push_back(entry.path().string());
  ASSERT_GE(pages.size(), 17u);
  const std::regex command(R"((?:^|[\n`] *)(?:recurse|build/release/recurse|scripts/render)( [^\n`#|&]*))"),
      option(R"( (--?[a-z][a-z-]*))");
  std::map<std::string, std::string> help;
  int count = 0;
  for (const std::string& page : pages) {
    std::string text = contents(page);
    text = std::regex_replace(text, std::regex(R"(\\\n)"), " ");     // commands may continue in the next line
    text = std::regex_replace(text, std::regex(R"("[^"\n]*")"), ""); // options of the quoted command
    for (std::sregex_iterator i(text.begin(), text.end(), command), end; i != end; ++i) {
      const std::string words = (*i)[1];
      const bool isScript = has((*i)[0], "scripts/render");
      std::string name;
      std::istringstream(words) >> name;
      if (isScript) name = "render";
      if (!std::regex_match(name, std::regex("[a-z]+"))) continue; // `recurse --help`, `recurse COMMAND`
      if (!help.contains(name)) {
        const Outcome o = run({name, "--help"});
        EXPECT_EQ(o.status, 0) << page << ": " << words;
        help[name] = o.out;
      }
      for (std::sregex_iterator j(words.begin(), words.end(), option), none; j != none; ++j) {
        ++count;
        EXPECT_TRUE(std::regex_search(help[name], std::regex("[ ,]" + (*j)[1].str() + "[ ,:\\n]")))
            << page << ": recurse " << name << " has no " << (*j)[1];
      }
    }
  }
  EXPECT_GT(count, 50);
}
