/** @file
 * Light leaks of photon maps through thin objects, against path tracing: the outside of a lamp's shade, the
 * dark side of a wall without thickness, the floor under a table, and the underside of the table.
 */
#include "rendering.h"
#include "transport/paths/walk.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** A room with a wall that has a door, and with a lamp in a shade above a table. */
const std::string ROOM = R"(
Material "diffuse" "rgb reflectance" [ .7 .7 .7 ]
Shape "box" "point3 p1" [ -2 0 -2 ] "point3 p2" [ 2 2.6 2 ]
Shape "bilinearmesh" "point3 P" [ -2 0 .5  1 0 .5  -2 2.6 .5  1 2.6 .5 ]
Material "diffuse" "rgb reflectance" [ .5 .5 .5 ]
Shape "box" "point3 p1" [ -1.6 .7 -1.8 ] "point3 p2" [ -.2 .73 -.6 ]
Translate -.8 2 -1
Rotate -90 1 0 0
Shape "sphere" "float radius" .2 "float zmin" 0
AreaLightSource "diffuse" "rgb L" [ 90 90 90 ]
Shape "sphere" "float radius" .05
)";

struct Mask {
  std::string name, lookAt;
  double fov;
  int pathSamples;
};

} // namespace

class Leaks : public ::testing::TestWithParam<Mask> {};

TEST_P(Leaks, AreNone) {
  constexpr double SURE = 0.02; // standard error relative to the mean
  constexpr double KNOWN = 0.1; // bound below the leaks through shades of earlier estimators
  const auto scene = sceneFrom(view(48, GetParam().lookAt, GetParam().fov) + ROOM);
  const Rendered truth = renderScene(*scene, "path", "", samples(GetParam().pathSamples));
  std::vector<double> means;
  for (uint64_t seed = 1; seed <= 8; ++seed)
    means.push_back(
        renderScene(*scene, "photonmap", "\"integer photons\" 40000", SANITIZED ? 2 : 8, seed).mean());
  const Mean found(means);
  const double error = std::hypot(found.error, truth.standardError());
  EXPECT_NEAR(found.value, truth.mean(), SURE * truth.mean() + 4 * error);
  if (SANITIZED) return; // too few samples for a reference
  EXPECT_LT(4 * error, KNOWN * truth.mean());
}

INSTANTIATE_TEST_SUITE_P(All, Leaks,
                         ::testing::Values(Mask{"shade", "-.8 2.5 -.6  -.8 2.17 -.9  0 1 0", 10, 256},
                                           Mask{"wall", "0 1.3 1.8  -1 1.2 .5  0 1 0", 25, 512},
                                           Mask{"floor", "0 .3 -1.2  -.9 0 -1.2  0 1 0", 14, 128},
                                           Mask{"table", "0 .3 -1.2  -.9 .7 -1.2  0 1 0", 14, 128}),
                         [](const auto& info) { return info.param.name; });

/** A uniformly lit lid over lamps in the same thin box, whose light leaves through the bottom. */
const std::string LID = view(48, "0 2.2 0  0 1.2 0  0 0 1", 26) + R"(
Material "diffuse" "rgb reflectance" [ .5 .5 .5 ]
Shape "bilinearmesh" "point3 P" [ -2 0 -2  2 0 -2  -2 0 2  2 0 2 ]
Shape "bilinearmesh" "point3 P" [ -2 3 -2  2 3 -2  -2 3 2  2 3 2 ]
Material "diffuse" "rgb reflectance" [ .3 .3 .3 ]
Shape "box" "point3 p1" [ -.5 1.22 -.3 ] "point3 p2" [ .5 1.23 .3 ]
Material "diffusetransmission" "rgb reflectance" [ .4 .4 .4 ] "rgb transmittance" [ .5 .5 .5 ]
Shape "bilinearmesh" "point3 P" [ -.5 1.2 -.3  .5 1.2 -.3  -.5 1.2 .3  .5 1.2 .3 ]
AreaLightSource "diffuse" "rgb L" [ 60 60 60 ]
Shape "bilinearmesh" "point3 P" [ -.45 1.219 -.2  .45 1.219 -.2  -.45 1.219 -.19  .45 1.219 -.19 ]
Shape "bilinearmesh" "point3 P" [ -.45 1.219 .2  .45 1.219 .2  -.45 1.219 .21  .45 1.219 .21 ]
)";

TEST(ThinLayers, AreNotMixed) {
  const auto scene = sceneFrom(LID);
  const Rendered truth = renderScene(*scene, "bdpt", "", samples(64));
  std::vector<double> means, pixels(truth.pixels());
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    const Rendered found = renderScene(*scene, "photonmap", "", SANITIZED ? 2 : 8, seed);
    means.push_back(found.mean());
    for (size_t i = 0; i < pixels.size(); ++i) pixels[i] += found.luminanceAt(i) / 4;
  }
  const Mean found(means);
  EXPECT_NEAR(found.value, truth.mean(), 4 * std::hypot(found.error, truth.standardError()));
  if (SANITIZED) return; // single pixels are too noisy with few samples
  const auto [darkest, brightest] = std::minmax_element(pixels.begin(), pixels.end());
  EXPECT_GT(*darkest, 0.8 * found.value);
  EXPECT_LT(*brightest, 1.25 * found.value);
}

TEST(ThinLayers, BothSidesOfASheetShowTheShadowsOnIt) {
  // The lamp is behind the sheet, in glass: only photons carry its light. Between the shadows of bars,
  // columns 24 to 38 are lit.
  const auto scene = sceneFrom(view(48, "0 .5 -2  0 .5 0  0 1 0", 26) + R"(
Material "diffuse" "rgb reflectance" [ .5 .5 .5 ]
Shape "bilinearmesh" "point3 P" [ -2 -1 -2.5  2 -1 -2.5  -2 -1 2.5  2 -1 2.5 ]
Shape "bilinearmesh" "point3 P" [ -2 -1 2.5  2 -1 2.5  -2 2 2.5  2 2 2.5 ]
Material "diffusetransmission" "rgb reflectance" [ .4 .4 .4 ] "rgb transmittance" [ .4 .4 .4 ]
Shape "bilinearmesh" "point3 P" [ -.5 0 0  .5 0 0  -.5 1 0  .5 1 0 ]
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
Shape "bilinearmesh" "point3 P" [ -.25 0 .1  0 0 .1  -.25 1 .1  0 1 .1 ]
Shape "bilinearmesh" "point3 P" [ .25 0 .1  .5 0 .1  .25 1 .1  .5 1 .1 ]
Translate 0 .5 .8
AttributeBegin
Material "dielectric"
Shape "sphere" "float radius" .05
AttributeEnd
AreaLightSource "diffuse" "rgb L" [ 300 300 300 ]
Shape "sphere" "float radius" .02
)");
  const auto columns = [](const Rendered& picture, size_t first, size_t end) {
    double sum = 0;
    for (size_t y = 0; y < 48; ++y)
      for (size_t x = first; x < end; ++x) sum += picture.luminanceAt(y * 48 + x) / 48 / double(end - first);
    return sum;
  };
  const Rendered truth = renderScene(*scene, "bdpt", "", 64); // 8 samples have an error of 4.5 %
  const Rendered found = renderScene(*scene, "photonmap", "", SANITIZED ? 1 : 4);
  const double lit = columns(truth, 26, 34);
  EXPECT_NEAR(columns(found, 26, 34), lit, 0.05 * lit);
  EXPECT_NEAR(columns(found, 14, 19), columns(truth, 14, 19), 0.05 * lit);
}

TEST(DiffuseTransmission, WhatWouldAddLightIsScaledDownWithAWarning) {
  const std::string text =
      view(2, "0 0 -3  0 0 1  0 1 0", 1) +
      "LightSource \"infinite\" \"rgb L\" [1 1 1]\nMaterial \"diffusetransmission\" \"rgb "
      "reflectance\" [.9 .9 .9] \"rgb transmittance\" [.6 .6 .6]\nShape \"disk\"\n";
  Diagnostics diagnostics;
  buildScene(parseScene(text, "test.pbrt", ".", diagnostics), {}, diagnostics);
  EXPECT_FALSE(diagnostics.hasErrors()) << diagnostics.format();
  EXPECT_NE(diagnostics.format().find("add up to 1.5"), std::string::npos) << diagnostics.format();
  const Rendered r = renderText(text, "path", "", samples(1024));
  EXPECT_NEAR(r.mean(), 1, 4.5 * r.standardError());
}

// A ray that leaves a block through its lower face would start below a floor in the same plane.
TEST(TouchingSurfaces, FloorsAreClosedUnderBlocksThatStandOnThem) {
  const auto meanOf = [](const std::string& floor, const std::string& block, double below,
                         const char* integrator) {
    const std::string scene = view(16, "0 -9 5  0 0 0  0 0 1", 25) +
                              "MakeNamedMedium \"thin\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ "
                              "1e-6 1e-6 1e-6 ] \"rgb sigma_s\" "
                              "[ 0 0 0 ]\nLightSource \"infinite\" \"rgb L\" [ 1 1 1 ]\n"
                              "Material \"diffuse\" \"rgb reflectance\" [ .5 .5 .5 ]\n" +
                              floor + block + "Shape \"box\" \"point3 p1\" [ -2 -2 " +
                              std::to_string(-below) + " ] \"point3 p2\" [ 2 2 1 ]\n";
    return renderText(scene, integrator, "", SANITIZED ? 4 : 32).mean();
  };
  const std::string bilinear =
                        "Shape \"bilinearmesh\" \"point3 P\" [ -30 -30 0  30 -30 0  -30 30 0  30 30 0 ]\n",
                    disk = "Shape \"disk\" \"float radius\" 40\n",
                    glass = "Material \"dielectric\" \"float eta\" 1.33\n",
                    fog = "Material \"interface\" MediumInterface \"thin\" \"\"\n";
  for (const std::string& floor : {bilinear, disk})
    for (const char* integrator : {"path", "photonmap", "bdpt"}) {
      const double tolerance = SANITIZED ? .1 : .01;
      if (integrator != std::string("bdpt")) { // which does not render media
        EXPECT_NEAR(meanOf(floor, fog, 0, integrator), .5, tolerance * .5) << floor << integrator;
      }
      const double sunk = meanOf(floor, glass, .01, integrator);
      EXPECT_NEAR(meanOf(floor, glass, 0, integrator), sunk, tolerance * sunk) << floor << integrator;
    }
}

// Positions on triangles may be exact, but the distances of hits are rounded.
TEST(TouchingSurfaces, FloorsHideMeshesThatStandOnThem) {
  for (const char* height : {"0", ".7"}) {
    const auto scene = sceneFrom(std::string("WorldBegin\nTranslate 0 0 ") + height + R"(
Shape "trianglemesh" "point3 P" [ -4 -8 0  4 -8 0  4 4 0  -4 4 0 ] "integer indices" [ 0 1 2 0 2 3 ]
Material "dielectric"
Shape "trianglemesh" "point3 P" [ -1 -1 0  1 -1 0  1 1 0  -1 1 0  -1 -1 2  1 -1 2  1 1 2  -1 1 2 ]
  "integer indices" [ 0 2 1 0 3 2 4 5 6 4 6 7 0 1 5 0 5 4 1 2 6 1 6 5 2 3 7 2 7 6 3 0 4 3 4 7 ]
)");
    ASSERT_TRUE(scene);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(-1, 1);
    int through = 0;
    for (int i = 0; i < 10000; ++i) {
      const Vec3f to(.9f * unit(random), .9f * unit(random), std::stof(height)),
          from = to + Vec3f(.9f * unit(random), .9f * unit(random), i % 2 ? 1.5f : -1.5f);
      Hit hit;
      Ray ray{from, glm::normalize(to - from), INFINITE, 0};
      while (scene->intersectPosition(ray, hit) && std::abs(hit.point.position.z - to.z) > .1f)
        ray = rayBehind(ray, hit);
      through += !isOpaque(hit.material);
    }
    EXPECT_EQ(through, 0) << height;
  }
}

// Which of two surfaces a ray hits first depends on rounding, where both are in the same plane.
// Of a ceiling hundreds of times wider than its lamp, the errors still block some shadow rays.
TEST(TouchingSurfaces, LampsHideTheCeilingThatTheyAreIn) {
  const std::string wall = "Material \"diffuse\"\nShape \"trianglemesh\" \"point3 P\" [ -40 -40 0  40 -40 0 "
                           "40 40 0  -40 40 0 ] \"integer indices\" [ 0 1 2 0 2 3 ]\n",
                    emits = "AttributeBegin\nAreaLightSource \"diffuse\" \"bool twosided\" true\n",
                    bilinear = "Shape \"bilinearmesh\" \"point3 P\" [ -1 -1 0  1 -1 0  -1 1 0  1 1 0 ]\n",
                    mesh = "Shape \"trianglemesh\" \"point3 P\" [ -1 -1 0  1 -1 0  1 1 0  -1 1 0 ] \"integer "
                           "indices\" [ 0 1 3 1 2 3 ]\n",
                    instance = "ObjectBegin \"wall\"\n" + wall +
                               "ObjectEnd\nAttributeBegin\nIdentity\nObjectInstance \"wall\"\nAttributeEnd\n";
  for (const std::string& lamp : {bilinear, mesh})
    for (const std::string& of : {wall, instance})
      for (const bool isFirst : {false, true}) {
        const std::string light = emits + lamp + "AttributeEnd\n";
        const auto scene = sceneFrom("WorldBegin\nRotate 37 1 2 3\nTranslate 0 0 .7\n" +
                                     (isFirst ? light + of : of + light));
        ASSERT_TRUE(scene);
        const glm::mat4 turn = glm::rotate(glm::mat4(1), glm::radians(37.0f), glm::normalize(Vec3f(1, 2, 3)));
        const auto place = [&](float x, float y, float z) { return Vec3f(turn * glm::vec4(x, y, z, 1)); };
        std::mt19937 random(5);
        std::uniform_real_distribution<float> unit(-1, 1);
        std::vector<Ray> rays;
        for (int i = 0; i < 4096; ++i) {
          const Vec3f from = place(unit(random), unit(random), 2),
                      to = place(.9f * unit(random), .9f * unit(random), .7f);
          rays.push_back({from, glm::normalize(to - from), INFINITE, 0});
        }
        std::vector<Hit> hits(rays.size());
        scene->intersectBatch(rays, Scene::Coherence::NONE, hits);
        size_t lit = 0, litAlone = 0, blocked = 0;
        for (size_t i = 0; i < rays.size(); ++i) {
          Hit hit;
          litAlone += scene->intersect(rays[i], hit) && hit.areaLight;
          lit += hits[i].areaLight != nullptr;
          const std::optional<LiSample> sample = scene->lights()[0].sampleLi(
              rays[i].origin, .5f, {.5f + .5f * unit(random), .5f + .5f * unit(random)});
          ASSERT_TRUE(sample);
          SurfacePoint from{};
          from.position = rays[i].origin;
          blocked += scene->occluded(shadowRay(from, *sample));
        }
        EXPECT_EQ(lit, rays.size()) << lamp << of << isFirst;
        EXPECT_EQ(litAlone, rays.size()) << lamp << of << isFirst;
        EXPECT_EQ(blocked, 0u) << lamp << of << isFirst;
      }
}

TEST(TouchingSurfaces, AWarningNamesWhatIsHiddenByThem) {
  const auto messages = [](const std::string& sheet) {
    Diagnostics diagnostics;
    buildScene(
        parseScene("WorldBegin\nShape \"disk\" \"float radius\" 9\n" + sheet, "test.pbrt", ".", diagnostics),
        {}, diagnostics);
    return diagnostics.format();
  };
  const std::string sheet = "Material \"diffusetransmission\"\nShape \"disk\"\n";
  EXPECT_NE(messages(sheet).find("not seen"), std::string::npos);
  EXPECT_EQ(messages("Translate 0 0 .001\n" + sheet), "");
  EXPECT_EQ(messages("Material \"dielectric\"\nShape \"box\" \"point3 p1\" [ -1 -1 0 ]\n"), "");
}
