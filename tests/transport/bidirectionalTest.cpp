/** @file
 * Estimators from both ends: each technique alone agrees with `path` on the paths that it can sample, all
 * together find all light, and pictures have the same bits for any number of threads.
 */
#include "classRendering.h"

#include "integrators/bidirectional/bidirectional.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Number of standard errors that means may differ by. */
constexpr double ERRORS_APART = 4.5;

/** A corner with a mirror, a glass ball and a wide lamp, so that `path` finds all light quickly. */
std::string corner(int size, const std::string& more = {}) {
  return view(size, "0 -3.2 1.4  0 0 .5  0 0 1", 45) + R"(
Material "diffuse" "rgb reflectance" [ .7 .6 .5 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 -2 0  2 -2 0  2 2 0  -2 2 0 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 1 0  2 1 0  2 1 2  -2 1 2 ]
AttributeBegin
Material "conductor" "rgb reflectance" [ .9 .8 .9 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1.5 0 0  -1 .8 0  -1 .8 1.2  -1.5 0 1.2 ]
AttributeEnd
AttributeBegin
Translate .6 -.1 .4
Material "dielectric" "float eta" 1.5
Shape "sphere" "float radius" .4
AttributeEnd
AttributeBegin
Translate 0 -.8 1.8
AreaLightSource "diffuse" "rgb L" [ 3 4 5 ]
Material "diffuse" "rgb reflectance" [ .2 .2 .2 ]
Shape "sphere" "float radius" .35
AttributeEnd
)" + more;
}
const std::string SKY = "LightSource \"infinite\" \"rgb L\" [ .3 .4 .5 ]\n";

/** Means of classes over pictures with the seeds 1, 2, … */
BatchMeans meansOf(const Scene& scene, const BidirectionalSettings& techniques, const PathClasses& classes,
                   int samplesPerPixel, int seeds) {
  BatchMeans means;
  for (int seed = 1; seed <= seeds; ++seed) {
    Bidirectional integrator(techniques);
    const Rendered out = renderScene(scene, integrator, classes, samplesPerPixel, uint64_t(seed));
    EXPECT_EQ(out.statistics.counts.nonFinite, 0u);
    means.add(out.layerMeans());
  }
  return means;
}

void expectEqual(const BatchMeans& means, const BatchMeans& truth, const PathClasses& classes, double bias,
                 const std::string& what) {
  for (size_t i = 0; i < 3 * classes.layerCount(); ++i) {
    const double error = std::hypot(means.standardError(i), truth.standardError(i));
    EXPECT_NEAR(means.mean(i), truth.mean(i), ERRORS_APART * error + bias * truth.mean(i))
        << what << ": " << classes.classes()[i / 3].expression << ", errors " << means.standardError(i)
        << " and " << truth.standardError(i);
    EXPECT_GT(truth.mean(i), 0);
    EXPECT_LT(error, (SANITIZED ? 0.4 : 0.1) * truth.mean(i))
        << what << ": " << classes.classes()[i / 3].expression << " too vague to tell";
  }
}

/** A closed box that emits 1 and reflects one half. */
std::string furnace() {
  return R"(
Material "diffuse" "rgb reflectance" [ .5 .5 .5 ]
AreaLightSource "diffuse" "rgb L" [ 1 1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1 ]
Shape "trianglemesh" "integer indices" [ 0 2 1  0 3 2 ] "point3 P" [ -1 -1 1  1 -1 1  1 1 1  -1 1 1 ]
Shape "trianglemesh" "integer indices" [ 0 2 1  0 3 2 ] "point3 P" [ -1 -1 -1  1 -1 -1  1 -1 1  -1 -1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 1 -1  1 1 -1  1 1 1  -1 1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  -1 1 -1  -1 1 1  -1 -1 1 ]
Shape "trianglemesh" "integer indices" [ 0 2 1  0 3 2 ] "point3 P" [ 1 -1 -1  1 1 -1  1 1 1  1 -1 1 ]
)";
}

/** Water with pebbles and weeds on the ground, below a wide lamp. */
std::string tank() {
  std::string text = view(24, "0 1.4 -3  0 .3 0  0 1 0", 22) + R"(
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 12 12 11 ]
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
Shape "trianglemesh" "point3 P" [ -1.5 3 -1.5  1.5 3 -1.5  1.5 3 1.5  -1.5 3 1.5 ] "integer indices" [ 0 1 2 0 2 3 ]
AttributeEnd
Material "dielectric" "float eta" 1.33
Shape "trianglemesh" "point3 P" [ -1 0 -.6  1 0 -.6  -1 .9 -.6  1 .9 -.6  -1 0 .6  1 0 .6  -1 .9 .6  1 .9 .6 ]
"integer indices" [ 0 2 1 1 2 3  4 5 6 5 7 6  0 1 4 1 5 4  2 6 3 3 6 7  0 4 2 2 4 6  1 3 5 3 7 5 ]
Material "diffuse" "rgb reflectance" [ .6 .5 .4 ]
Shape "bilinearmesh" "point3 P" [ -.98 .02 -.58  .98 .02 -.58  -.98 .02 .58  .98 .02 .58 ]
)";
  Sampler random(1, 0, 0);
  const auto at = [&](double low, double high) { return low + (high - low) * double(random.next1D()); };
  text += "Material \"diffuse\" \"rgb reflectance\" [ .5 .45 .4 ]\n";
  for (int i = 0; i < 150; ++i) {
    const double radius = at(.02, .06), x = at(-.9, .9), z = at(-.5, .5);
    text += "AttributeBegin\nTranslate " + number(x) + " " + number(.02 + .4 * radius) + " " + number(z) +
            "\nScale 1 .6 1\nShape \"sphere\" \"float radius\" " + number(radius) + "\nAttributeEnd\n";
  }
  text += "Material \"diffusetransmission\" \"rgb reflectance\" [ .15 .3 .1 ]"
          " \"rgb transmittance\" [ .1 .25 .05 ]\n";
  for (int i = 0; i < 60; ++i) {
    const double x = at(-.9, .9), z = at(-.5, .5), width = at(.01, .03), height = at(.2, .6);
    const auto corner = [&](double side, double y) {
      return number(x + side * width / 2 + .2 * y) + " " + number(y) + " " + number(z) + "  ";
    };
    text += "AttributeBegin\nTranslate " + number(x) + " 0 " + number(z) + "\nRotate " + number(at(0, 360)) +
            " 0 1 0\nTranslate " + number(-x) + " 0 " + number(-z) +
            "\nShape \"bilinearmesh\" \"point3 P\" [ " + corner(-1, .02) + corner(1, .02) +
            corner(-1, height) + corner(1, height) + "]\nAttributeEnd\n";
  }
  return text;
}

PathClasses classOf(const std::string& expression) {
  return PathClasses(std::vector<PathClass>{{"one", expression}});
}

} // namespace

// Light starts on the lamp's own surface, and rounding leaves no distance between the two.
TEST(BidirectionalEnds, ALampMayBeSmallerThanRounding) {
  const std::string scene = view(4, "0 -.27 -.04  .6 -.07 -.04  0 0 1", 40) + R"(
AttributeBegin
Translate -0.908439248 -0.069043653 0.839460564
Scale 1e-07 1e-07 1e-07
AreaLightSource "diffuse" "float power" 10 "bool twosided" true
Shape "sphere"
AttributeEnd
Material "diffuse"
ReverseOrientation
Shape "box" "point3 p1" [ -3 -3 -3 ] "point3 p2" [ 3 3 3 ]
)";
  for (const auto& [integrator, parameters] :
       {std::pair("lightpath", "\"integer lightpaths\" 4000"),
        std::pair("bdpt", "\"integer lightpaths\" 4000"), std::pair("vcm", "\"integer photons\" 4000")})
    renderText(scene, integrator, std::string(parameters) + " \"integer maxdepth\" 8", 2);
}

TEST(Bidirectional, EachTechniqueAloneFindsItsPaths) {
  const ThreadPool pool;
  struct Technique {
    bool BidirectionalSettings::*used;
    const char* name;
    const char* paths;
    double bias;
  };
  for (const std::string& more : {std::string(), SKY}) {
    const auto scene = sceneFrom(corner(16, more));
    for (const Technique& t :
         {Technique{&BidirectionalSettings::hits, "hits", "L(S|D)*E", 0},
          Technique{&BidirectionalSettings::shadowRays, "shadow rays", "LD(S|D)*E", 0},
          Technique{&BidirectionalSettings::connections, "connections", "L(S|D)*DD(S|D)*E", 0},
          Technique{&BidirectionalSettings::splats, "splats", "L(S|D)*DE", 0},
          Technique{&BidirectionalSettings::merges, "photons", "L(S|D)+D(S|D)*E", 0.03}}) {
      BidirectionalSettings alone;
      alone.hits = alone.shadowRays = alone.connections = alone.splats = alone.merges = false;
      alone.*t.used = true;
      const PathClasses classes = classOf(t.paths);
      const BatchMeans truth = classMeans(*scene, {"path", ""}, classes, samples(64), 8);
      expectEqual(meansOf(*scene, alone, classes, samples(64), 8), truth, classes, t.bias,
                  t.name + (more.empty() ? std::string() : " under a sky"));
    }
  }
}

TEST(Bidirectional, AllTechniquesTogetherFindEveryClassOnce) {
  const ThreadPool pool;
  const PathClasses classes({{"seen", "LS*E"},
                             {"direct", "LDE"},
                             {"mirrored", "LDS+E"},
                             {"caustics", "LS+DE"},
                             {"two", "LDDE"},
                             {"all", "all"}});
  const std::string lights = R"(
AttributeBegin
Translate -1 -1 2.5
LightSource "point" "rgb I" [ 2 1 1 ]
AttributeEnd
LightSource "distant" "point3 from" [ 1 -1 2 ] "point3 to" [ 0 0 0 ] "rgb L" [ .3 .5 .4 ]
)";
  for (const std::string& more : {std::string(), SKY}) {
    const auto scene = sceneFrom(corner(16, more));
    const BatchMeans truth = classMeans(*scene, {"path", ""}, classes, samples(128), 8);
    for (const Way& way : {Way{"bdpt", ""}, Way{"vcm", ""}, Way{"vcm", "\"bool correlated\" false"}})
      expectEqual(classMeans(*scene, way, classes, samples(32), 8), truth, classes,
                  way.integrator == "vcm" ? 0.02 : 0, way.integrator + way.parameters + more);
  }
  // Lights that no ray hits: only light paths find their light through glass.
  const auto scene = sceneFrom(corner(16, lights));
  const PathClasses found({{"direct", "LDE"}, {"two", "LDDE"}});
  const BatchMeans truth = classMeans(*scene, {"path", ""}, found, samples(64), 8);
  for (const char* name : {"bdpt", "vcm"})
    expectEqual(classMeans(*scene, {name, ""}, found, samples(32), 8), truth, found, 0.01, name);
  const PathClasses caustics = classOf("LS+DE");
  const BatchMeans traced = classMeans(*scene, {"lightpath", ""}, caustics, samples(64), 8);
  for (const char* name : {"bdpt", "vcm"})
    expectEqual(classMeans(*scene, {name, ""}, caustics, samples(32), 8), traced, caustics, 0.02, name);
}

/** In a closed shell that emits E and reflects ρ everywhere, the radiance is E / (1 - ρ). */
TEST(Bidirectional, ClosedFurnaceIsEvenlyBright) {
  const ThreadPool pool;
  const auto scene = sceneFrom(view(8, "0 0 0  1 .5 .2  0 0 1", 70) + furnace());
  const PathClasses classes = classOf("all");
  for (const char* name : {"bdpt", "vcm"}) {
    const BatchMeans means = classMeans(*scene, {name, ""}, classes, samples(64), 12);
    EXPECT_NEAR(means.mean(0), 2, ERRORS_APART * means.standardError(0) + (name[0] == 'v' ? 0.01 : 0))
        << name;
    EXPECT_LT(means.standardError(0), 0.02) << name;
  }
}

/** Light of two and more reflections in a closed shell that emits E and reflects ρ everywhere is ρ²E / (1 -
 * ρ), by photons alone: edges and corners are as bright as the middle. */
TEST(Bidirectional, PhotonsAreAsManyAtEdges) {
  const ThreadPool pool;
  const auto scene = sceneFrom(view(12, "0 0 0  1 .7 .6  0 0 1", 100) + furnace());
  BidirectionalSettings photons;
  photons.hits = photons.shadowRays = photons.connections = photons.splats = false;
  photons.merges = true;
  photons.radius = .3f;
  photons.lightPaths = 4000;
  const PathClasses classes = classOf("L(S|D)+D(S|D)*E");
  const BatchMeans means = meansOf(*scene, photons, classes, samples(16), 8);
  EXPECT_NEAR(means.mean(0), 0.5, 0.0025 + ERRORS_APART * means.standardError(0));
  EXPECT_LT(means.standardError(0), SANITIZED ? 6e-3 : 2e-3);
}

/** Photons of one layer do not count on the layer behind it: light that passes both is counted once. */
TEST(Bidirectional, PhotonsOfLayersBehindEachOtherAreKeptApart) {
  const ThreadPool pool;
  const auto scene = sceneFrom(view(16, "0 0 -5  0 0 0  0 1 0", 24) + R"(
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 10 10 10 ]
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
Shape "trianglemesh" "point3 P" [ -1 -1 1  1 -1 1  1 1 1  -1 1 1 ] "integer indices" [ 0 2 1 0 3 2 ]
AttributeEnd
Material "diffusetransmission" "rgb reflectance" [ .3 .25 .2 ] "rgb transmittance" [ .3 .25 .2 ]
Shape "bilinearmesh" "point3 P" [ -1 -1 .5  1 -1 .5  -1 1 .5  1 1 .5 ]
Shape "bilinearmesh" "point3 P" [ -1 -1 .504  1 -1 .504  -1 1 .504  1 1 .504 ]
)");
  const PathClasses classes = classOf("all");
  const BatchMeans truth = classMeans(*scene, {"path", ""}, classes, samples(128), 8);
  expectEqual(classMeans(*scene, {"vcm", ""}, classes, samples(32), 8), truth, classes, 0.005, "two layers");
}

/** Pebbles and narrow two-sided weeds in a tank of water, whose light connections do not find. */
TEST(Bidirectional, SmallThingsUnderWaterAreAsBrightAsByPathTracing) {
  const ThreadPool pool;
  const auto scene = sceneFrom(tank());
  const PathClasses classes = classOf("LS+D(S|D)*S+E");
  const BatchMeans truth = classMeans(*scene, {"path", ""}, classes, samples(256), 6);
  expectEqual(classMeans(*scene, {"vcm", ""}, classes, samples(32), 6), truth, classes, 0.02, "tank");
}

/** A sky of radiance 1 around surfaces without absorption: the radiance is 1 everywhere. */
TEST(Bidirectional, NothingDarkensAnEvenSky) {
  const ThreadPool pool;
  const PathClasses classes = classOf("all");
  for (const char* material :
       {"Material \"diffuse\" \"rgb reflectance\" [ 1 1 1 ]", "Material \"dielectric\" \"float eta\" 1.5"}) {
    const auto scene =
        sceneFrom(view(8, "0 -4 0  0 0 0  0 0 1", 40) + "LightSource \"infinite\" \"rgb L\" [ 1 1 1 ]\n" +
                  material + "\nShape \"sphere\" \"float radius\" 1\n");
    for (const char* name : {"bdpt", "vcm"}) {
      const BatchMeans means = classMeans(*scene, {name, ""}, classes, samples(64), 8);
      EXPECT_NEAR(means.mean(0), 1, ERRORS_APART * means.standardError(0) + 1e-4) << name << " " << material;
      EXPECT_LT(means.standardError(0), 0.01) << name;
    }
  }
}

TEST(Bidirectional, BrightPlacesInSmallPixelsAreNotTooBrightToSplat) {
  const ThreadPool pool;
  for (const std::string scale : {"1e-2", "1e-4", "1e-6"}) {
    const std::string half = "-" + scale + " " + scale + " ";
    const auto scene = sceneFrom("Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\n"
                                 "PixelFilter \"box\"\nLookAt 0 0 1  0 0 0  0 1 0\n"
                                 "Camera \"orthographic\" \"float screenwindow\" [ " +
                                 half + half +
                                 "]\nWorldBegin\nShape \"disk\"\n"
                                 "LightSource \"point\" \"point3 from\" [ 0 0 " +
                                 scale + " ]\n");
    const double truth = renderScene(*scene, "path", "", samples(64)).mean();
    // A sixth of the light reaches the visible region.
    constexpr int LIGHT_PATHS = SANITIZED ? 1000 : 40000;
    const double error = std::sqrt(6.0 / LIGHT_PATHS);
    for (const std::string integrator : {"lightpath", "bdpt", "vcm"}) {
      const std::string parameter = integrator == "vcm" ? "photons" : "lightpaths";
      const Rendered r =
          renderScene(*scene, integrator, "\"integer " + parameter + "\" " + std::to_string(LIGHT_PATHS), 1);
      EXPECT_NEAR(r.mean() / truth, 1, ERRORS_APART * error) << integrator << " at " << scale;
      EXPECT_EQ(r.statistics.splatsSaturated, 0u) << integrator << " at " << scale;
    }
  }
}

TEST(Bidirectional, NumberOfLightPathsChangesNoMean) {
  const ThreadPool pool;
  const auto scene = sceneFrom(corner(16, SKY));
  const PathClasses classes({{"direct", "LDE"}, {"caustics", "LS+DE"}, {"all", "all"}});
  const BatchMeans truth = classMeans(*scene, {"bdpt", ""}, classes, samples(64), 8);
  expectEqual(classMeans(*scene, {"bdpt", "\"integer lightpaths\" 1000"}, classes, samples(32), 8), truth,
              classes, 0, "more light paths");
  expectEqual(classMeans(*scene, {"vcm", "\"integer photons\" 60"}, classes, samples(64), 8), truth, classes,
              0.02, "few photons");
}

TEST(Bidirectional, SameBitsForAnyNumberOfThreads) {
  const auto scene = sceneFrom(corner(24, SKY));
  for (const char* name : {"bdpt", "vcm", "lightpath"}) {
    const Rendered one = renderScene(*scene, name, "", 3, 7, 1);
    for (const int threads : {2, 3}) {
      const Rendered more = renderScene(*scene, name, "", 3, 7, threads);
      for (size_t p = 0; p < one.pixels(); ++p) ASSERT_EQ(one.value(p), more.value(p)) << name << " " << p;
    }
    EXPECT_GT(one.mean(), 0);
  }
}

/** Light tracing stores a single light path at a time if its vertices are only splatted. */
TEST(Bidirectional, LightTracingHasNoNeedOfMemory) {
  const ThreadPool pool;
  const auto scene = sceneFrom(corner(8, ""));
  const Rendered r = renderScene(*scene, "lightpath", "\"integer lightpaths\" 20000", 1);
  EXPECT_GT(r.mean(), 0);
  EXPECT_GT(r.statistics.mapBytes, 0u);
  EXPECT_LT(r.statistics.mapBytes, 100000u);
}
