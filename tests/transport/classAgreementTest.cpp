/** @file
 * Rendered path classes: integrators agree on each class, the classes of a disjoint cover add up to all
 * light, and a class rendered alone is equal to the same class rendered with others, with less work.
 */
#include "classRendering.h"

#include <filesystem>

using namespace recurse;
using namespace recurse::testing;

namespace {

/** The Cornell box with a mirror sphere and a glass sphere; the lamp is large enough for `path` to find
 * caustics. */
const char* const MIRROR_BALL = R"(Material "conductor" "rgb reflectance" [ .9 .9 .9 ])";
const char* const GLASS_BALL = R"(Material "dielectric" "float eta" 1.5)";
std::string glassBox(int size, const std::string& left = MIRROR_BALL, const std::string& right = GLASS_BALL) {
  return view(size, "0 0 3.9  0 0 0  0 1 0", 39.3) + R"(
Material "diffuse" "rgb reflectance" [ .7 .7 .7 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  1 -1 -1  1 -1 1  -1 -1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 1 -1  -1 1 1  1 1 1  1 1 -1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  -1 1 -1  1 1 -1  1 -1 -1 ]
Material "diffuse" "rgb reflectance" [ .6 .1 .1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  -1 -1 1  -1 1 1  -1 1 -1 ]
Material "diffuse" "rgb reflectance" [ .1 .5 .2 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ 1 -1 -1  1 1 -1  1 1 1  1 -1 1 ]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 8 7 6 ]
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ]
  "point3 P" [ -.4 .98 -.4  .4 .98 -.4  .4 .98 .4  -.4 .98 .4 ]
AttributeEnd
AttributeBegin
)" + left +
         R"(
Translate -.42 -.58 -.35
Shape "sphere" "float radius" .4
AttributeEnd
AttributeBegin
)" + right +
         R"(
Translate .42 -.58 .25
Shape "sphere" "float radius" .4
AttributeEnd
)";
}

constexpr double SIGMAS = 5;
/** Bias from blur over edges and shadow borders, for a search radius of a pixel of a small film. */
constexpr double PHOTON_BIAS = 0.03;

/** The classes, and a last layer of all paths. */
PathClasses withTotal(std::vector<PathClass> classes) {
  classes.push_back({"total", "all"});
  return PathClasses(classes);
}

/** Magnitude that rounding errors of a colour are relative to: wavelengths have colours of both signs, which
 * cancel. */
double magnitude(const Rgb& value, int colour, bool dispersive) {
  return dispersive ? std::max({std::abs(value.r), std::abs(value.g), std::abs(value.b)})
                    : std::abs(value[colour]);
}

/** Expects that in every pixel all layers before the last add up to the last. */
void expectSums(const Film& film, bool dispersive, const std::string& what) {
  const size_t total = film.layerCount() - 1;
  for (size_t p = 0; p < film.bounds().area(); ++p)
    for (int c = 0; c < 3; ++c) {
      double sum = 0, scale = 0;
      for (size_t layer = 0; layer < total; ++layer) {
        sum += double(film.value(p, layer)[c]);
        scale += magnitude(film.value(p, layer), c, dispersive);
      }
      ASSERT_NEAR(sum, double(film.value(p, total)[c]), 1e-5 * scale)
          << what << " pixel " << p << " colour " << c;
    }
}

std::unique_ptr<Scene> smallScene(const std::filesystem::path& file) {
  Diagnostics diagnostics;
  const SceneDescription description = loadScene(file.string(), diagnostics);
  SceneOverrides overrides;
  overrides.width = overrides.height = 8;
  return diagnostics.hasErrors() ? nullptr : buildScene(description, overrides, diagnostics);
}

/** Expects that the means of all classes agree with `truth`, within the noise of both and the bias of a
 * map. */
void expectAgreement(const Scene& scene, const Way& way, const PathClasses& classes,
                     const BatchMeans& truth) {
  const BatchMeans means = classMeans(scene, way, classes, 1, 16);
  for (size_t i = 0; i < classes.layerCount(); ++i) {
    const PathClass& c = classes.classes()[i];
    for (size_t k = 3 * i; k < 3 * i + 3; ++k) {
      const double error = std::hypot(truth.standardError(k), means.standardError(k));
      EXPECT_NEAR(means.mean(k), truth.mean(k), SIGMAS * error + PHOTON_BIAS * truth.mean(k))
          << way.parameters << " " << c.name << " errors " << truth.standardError(k) << " and "
          << means.standardError(k);
      EXPECT_GT(truth.mean(k), 0) << c.name;
      EXPECT_LT(error, (SANITIZED ? 0.25 : 0.08) * truth.mean(k)) << c.name << ": too vague to tell";
    }
  }
}

} // namespace

TEST(ClassAgreement, PhotonMapConnectionsAndPathAgreeOnStills) {
  const ThreadPool pool;
  const auto scene = sceneFrom(glassBox(SANITIZED ? 44 : 64));
  const PathClasses classes(defaultStillClasses());
  const BatchMeans truth = classMeans(*scene, {"path", ""}, classes, samples(12), 16);
  const std::string photons =
      "\"integer passes\" 1 \"integer photons\" " + std::to_string(samples(50000)) + " \"float radius\" .03";
  for (const char* direct : {"shadowrays", "photons"})
    expectAgreement(*scene, {"photonmap", photons + " \"string direct\" \"" + direct + "\""}, classes, truth);
  for (const Way& way : allWays("1"))
    if (integratorFrom(way.integrator, way.parameters)->splats())
      expectAgreement(*scene, way, classes, truth); // bdpt, vcm
}

/** Rough lobes are D and read the map, or are followed by rays, or both; near the threshold with weights
 * between 0 and 1. */
TEST(ClassAgreement, RoughLobesAgreeWhoeverTakesThem) {
  const ThreadPool pool;
  const auto scene =
      sceneFrom(glassBox(32, R"(Material "conductor" "rgb reflectance" [ .9 .9 .9 ] "float roughness" .04)",
                         R"(Material "dielectric" "float roughness" .04)"));
  const PathClasses classes({{"direct", "LDE"}, {"two", "LDDE"}, {"three", "LDDDE"}, {"more", "LDDDD+E"}});
  const BatchMeans truth = classMeans(*scene, {"path", ""}, classes, samples(16), 16);
  const std::string photons =
      "\"integer passes\" 1 \"integer photons\" " + std::to_string(samples(25000)) + " \"float radius\" .03";
  std::vector<Way> ways;
  for (const char* direct : {"shadowrays", "photons"})
    for (const char* follow : {"0", ".2", "1"})
      ways.push_back({"photonmap", photons + " \"float followroughness\" " + follow +
                                       " \"string direct\" \"" + direct + "\""});
  for (const Way& way : dealt(ways, 1)) expectAgreement(*scene, way, classes, truth);
}

namespace {

/** A lamp above a floor before an upright plate. `material`: directives before the shape of the plate, which
 * may move it; `parameters`: of the shape. */
std::string floorAndPlate(const std::string& material, const std::string& parameters) {
  return view(16, "0 1.6 -5  0 .9 0  0 1 0", 42) + R"(
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 9 8 7 ]
Translate 0 3 -1.5
Shape "sphere" "float radius" .5
AttributeEnd
Material "diffuse" "rgb reflectance" [ .6 .6 .6 ]
Shape "bilinearmesh" "point3 P" [ -2 0 -2  2 0 -2  -2 0 2  2 0 2 ]
)" + material +
         R"(
Shape "bilinearmesh" "point3 P" [ -1.5 .2 0  1.5 .2 0  -1.5 2 0  1.5 2 0 ] )" +
         parameters;
}

/** Photons agree with paths on LDDE, most of which the floor reflects to the plate. */
void expectPhotonsOnThePlate(const std::string& material, const std::string& parameters = {}) {
  const auto scene = sceneFrom(floorAndPlate(material, parameters));
  const PathClasses classes(std::vector<PathClass>{{"indirect", "LDDE"}});
  const BatchMeans paths = classMeans(*scene, {"path", ""}, classes, samples(256), 4);
  for (const Way& way : {Way{"photonmap", ""}, {"photonmap", "\"string direct\" \"photons\""}, {"vcm", ""}}) {
    const BatchMeans photons = classMeans(*scene, way, classes, samples(24), 4);
    EXPECT_NEAR(photons.mean(0), paths.mean(0),
                SIGMAS * std::hypot(photons.standardError(0), paths.standardError(0)) +
                    PHOTON_BIAS * paths.mean(0))
        << way.integrator << " " << way.parameters;
  }
}

/** Two materials, one with bumps: each hit on a mix chooses one of them. */
const std::string MIRROR_AND_WHITE = R"(
Texture "flat" "float" "constant" "float value" 0
MakeNamedMaterial "mirror" "string type" "conductor" "rgb reflectance" [ .8 .8 .8 ] "texture displacement" "flat"
MakeNamedMaterial "white" "string type" "diffuse"
)";

} // namespace

TEST(ClassAgreement, PhotonsOfAMovingPlateAreWhereItIs) {
  expectPhotonsOnThePlate(R"(
ActiveTransform EndTime
Translate 0 0 1
ActiveTransform All)");
}

TEST(ClassAgreement, PhotonsOfAMaterialChosenAtRandomCountForTheWholeSurface) {
  expectPhotonsOnThePlate(MIRROR_AND_WHITE +
                          R"(Material "mix" "string materials" [ "mirror" "white" ] "float amount" .4)");
}

TEST(ClassAgreement, PhotonsOfChoicesWithinAChoiceCountForTheWholeSurface) {
  expectPhotonsOnThePlate(MIRROR_AND_WHITE + R"(
MakeNamedMaterial "half" "string type" "mix" "string materials" [ "mirror" "white" ]
Material "mix" "string materials" [ "half" "mirror" ] "float amount" .4)");
}

TEST(ClassAgreement, PhotonsOnAnAlphaSheetCountForTheWholeSheet) {
  expectPhotonsOnThePlate("Material \"diffuse\"", "\"float alpha\" .4");
}

TEST(ClassAgreement, LayersOfACoverAddUp) {
  namespace fs = std::filesystem;
  const ThreadPool pool;
  std::vector<std::pair<std::string, std::unique_ptr<Scene>>> scenes;
  scenes.emplace_back("glass box", sceneFrom(glassBox(8)));
  for (const auto& file : fs::directory_iterator(fs::path(RECURSE_SOURCE_DIR) / "scenes"))
    if (file.path().extension() == ".pbrt")
      scenes.emplace_back(file.path().filename().string(), smallScene(file.path()));
  const char* environment = std::getenv("RECURSE_SHARED");
  const fs::path shared =
      environment ? fs::path(environment) : fs::path(RECURSE_SOURCE_DIR) / ".." / "shared";
  for (const char* name : {"cornell.pbrt", "cornell-glass.pbrt", "hexroom-grey.pbrt", "sds.pbrt"})
    if (fs::exists(shared / "reference" / name))
      scenes.emplace_back(name, smallScene(shared / "reference" / name));

  const PathClasses few = withTotal({{"lens", "L.*SE"}, {"none", "LE"}, {"rest", "all - (L.*SE | LE)"}});
  const std::vector<Way> differing = waysThatShareOutDifferently(), all = everyWay();
  std::vector<Way> many = differing; // in addition every fifth way, which covers almost all pairs of options
  for (size_t i = 0; i < all.size(); i += 5) many.push_back(all[i]);
  // Each scene renders every eighth way, and each way is rendered for an eighth of the scenes. Sums are
  // exact, and sanitizers, which look for other errors, render an eighth of that.
  constexpr size_t STRIDE = SANITIZED ? 64 : 8;
  for (size_t i = 0; i < scenes.size(); ++i) {
    const auto& [name, scene] = scenes[i];
    ASSERT_TRUE(scene) << name;
    const PathClasses stills = withTotal(defaultStillClasses(scene->hasMedia()));
    const bool dispersive = (scene->contents().lobes & DISPERSIVE) != 0;
    const std::vector<Way>& choice = i > 0 ? differing : many;
    const size_t step = i > 0 || SANITIZED ? STRIDE : 1;
    std::vector<Way> ways;
    for (size_t k = i % step; k < choice.size(); k += step) ways.push_back(choice[k]);
    for (const Way& way : ways) {
      // The patch that shoots next has the largest sum over classes, which rounding may change.
      if (way.integrator == "radiosity") continue;
      if (!unsupportedPart(*integratorFrom(way.integrator, way.parameters), *scene).empty()) continue;
      const Way small = withPhotons(way, samples(4000));
      const std::string what = name + " " + way.integrator + way.parameters;
      const Rendered apart = renderClasses(*scene, small, stills, 2, 5);
      expectSums(apart.film, dispersive, what);
      if (HasFatalFailure()) return;
      expectSums(renderClasses(*scene, small, few, 1, 6).film, dispersive, what);
      // Separating classes changes no path: the total is equal to the picture without classes.
      const Rendered plain = renderClasses(*scene, small, PathClasses(), 2, 5);
      EXPECT_EQ(plain.statistics.counts.rays, apart.statistics.counts.rays) << what;
      const size_t total = stills.layerCount() - 1, pixels = plain.pixels();
      const double splatUnit = 1e-9 * plain.mean(); // each layer rounds splats up or down at random
      for (size_t p = 0; p < pixels; ++p)
        for (int c = 0; c < 3; ++c) {
          const Rgb expected = plain.film.value(p, 0);
          ASSERT_NEAR(double(apart.film.value(p, total)[c]), double(expected[c]),
                      1e-5 * magnitude(expected, c, dispersive) + splatUnit)
              << what;
        }
    }
  }
}

TEST(ClassAgreement, AClassAloneIsTheSameAsInCompany) {
  const ThreadPool pool;
  const auto scene = sceneFrom(glassBox(32));
  const std::vector<PathClass> all = {{"caustic", "LS+DE"},
                                      {"second", "LDDE"},
                                      {"mirrored", "L(S|D)*DS+E"},
                                      {"lamps", "LS*E"},
                                      {"caustics mirrored", "LS+DS+E"},
                                      {"direct", "LDE"}};
  const std::string photons = "\"integer passes\" 1 \"integer photons\" " + std::to_string(samples(20000));
  for (const Way& way : {Way{"path", ""}, Way{"photonmap", photons},
                         Way{"photonmap", photons + " \"string direct\" \"photons\""}}) {
    // Both renders use the same search radius, because a search chosen by error would be wider for a class
    // with fewer photons.
    Way fixed = way;
    if (way.integrator != "path") fixed.parameters += " \"float radius\" .05";
    const BatchMeans together = classMeans(*scene, fixed, PathClasses(all), 2, 8);
    for (size_t i = 0; i < all.size(); ++i) {
      const BatchMeans alone = classMeans(*scene, fixed, PathClasses({all[i]}), 2, 8);
      for (size_t c = 0; c < 3; ++c) {
        const double error = std::hypot(together.standardError(3 * i + c), alone.standardError(c));
        EXPECT_GT(alone.mean(c), 0);
        // The standard error from eight values has an uncertainty of a quarter.
        EXPECT_NEAR(alone.mean(c), together.mean(3 * i + c), 1.5 * SIGMAS * error + 1e-9)
            << fixed.integrator << fixed.parameters << " " << all[i].expression;
      }
    }
  }
}

TEST(ClassAgreement, NarrowClassesTraceFewerRays) {
  const ThreadPool pool;
  const auto scene = sceneFrom(glassBox(32));
  const std::vector<Way> ways = waysThatShareOutDifferently();
  for (size_t i = 0; i < ways.size(); i += SANITIZED ? 4 : 1) {
    const Way& way = ways[i];
    const Way small = withPhotons(way, samples(10000));
    const auto rays = [&](const std::string& expression) {
      return double(
          renderClasses(*scene, small, PathClasses({{"one", expression}}), 2, 1).statistics.counts.rays);
    };
    const double all = rays("all");
    const std::string claims = integratorFrom(way.integrator, way.parameters)->claims();
    const auto isNearlyAll = [&](const std::string& narrow) { // except for light that the same rays hit
      return !claims.empty() &&
             PathAutomaton::compile(claims).subsetOf(PathAutomaton::compile(narrow + "|LE"));
    };
    for (const char* narrow : {"LS+DE", "LE", "LDE", "LSE", "LDDE"}) {
      if (isNearlyAll(narrow)) continue;
      EXPECT_LT(rays(narrow), 0.8 * all) << narrow << " " << way.integrator << way.parameters;
    }
  }
}
