/** @file
 * Triangles and reference points of the inspect page.
 */
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "recurse/pathclasses/pathExpression.h"
#include "recurse/report/inspect/inspect.h"
#include "report/inspect/sceneMesh.h"
#include "sceneRendering.h"

namespace recurse {
namespace {

using namespace recurse::testing;

Bounds3f boundsOf(const SceneMesh& mesh) {
  Bounds3f bounds;
  for (size_t i = 0; i < mesh.positions.size(); i += 3)
    bounds.add(Vec3f(mesh.positions[i], mesh.positions[i + 1], mesh.positions[i + 2]));
  return bounds;
}

/** A triangle in the plane z = 0, and two of its instances, 10 along x and 20 along y. */
std::string instancedTriangles() {
  return view(4, 4, "0 0 -5  0 0 0  0 1 0", perspective(40)) + R"(
ObjectBegin "leaf"
Shape "trianglemesh" "integer indices" [ 0 1 2 ] "point3 P" [ 0 0 0  1 0 0  0 1 0 ]
ObjectEnd
ObjectInstance "leaf"
Translate 10 0 0
ObjectInstance "leaf"
Translate 0 20 0
ObjectInstance "leaf"
)";
}

TEST(SceneMesh, InstancesStandWhereTheyAre) {
  const auto scene = sceneFrom(instancedTriangles());
  const SceneMesh mesh = meshOf(*scene, 1000);
  EXPECT_EQ(mesh.triangles(), 3u);
  EXPECT_EQ(mesh.names.size(), 3u);
  const Bounds3f bounds = boundsOf(mesh);
  EXPECT_NEAR(bounds.diagonal().x, 11, 1e-4f);
  EXPECT_NEAR(bounds.diagonal().y, 21, 1e-4f);
}

TEST(SceneMesh, ShapesWithoutTrianglesAreDiced) {
  const auto scene = sceneFrom(view(4, 4, "0 0 -5  0 0 0  0 1 0", perspective(40)) +
                               "Shape \"sphere\" \"float radius\" 2\n");
  const SceneMesh mesh = meshOf(*scene, 100000);
  EXPECT_GT(mesh.triangles(), 500u);
  EXPECT_EQ(mesh.before, mesh.triangles());
  EXPECT_EQ(mesh.colours.size(), 3 * mesh.triangles());
  EXPECT_EQ(mesh.positions.size(), 9 * mesh.triangles());
  for (size_t i = 0; i < mesh.positions.size(); i += 3)
    EXPECT_NEAR(glm::length(Vec3f(mesh.positions[i], mesh.positions[i + 1], mesh.positions[i + 2])), 2,
                1e-4f);
}

TEST(SceneMesh, IsSimplifiedToTheLimit) {
  const auto scene = sceneFrom(view(4, 4, "0 0 -5  0 0 0  0 1 0", perspective(40)) +
                               "Shape \"sphere\" \"float radius\" 2\n");
  const SceneMesh mesh = meshOf(*scene, 200);
  EXPECT_LE(mesh.triangles(), 200u);
  EXPECT_GT(mesh.triangles(), 50u);
  EXPECT_GT(mesh.before, 500u);
  EXPECT_EQ(mesh.colours.size(), 3 * mesh.triangles());
  EXPECT_GT(boundsOf(mesh).diagonal().x, 3);
}

TEST(SceneMesh, CurvesAreTubesAroundTheirAxes) {
  const auto scene =
      sceneFrom(view(4, 4, "0 0 -5  0 0 0  0 1 0", perspective(40)) +
                "Shape \"curve\" \"point3 P\" [ 0 1 0  1 1 0  2 1 0  3 1 0 ] \"float width\" .2\n");
  const SceneMesh mesh = meshOf(*scene, 1000);
  EXPECT_EQ(mesh.curves, 1u);
  EXPECT_EQ(mesh.shownCurves, 1u);
  ASSERT_GT(mesh.triangles(), 20u);
  const Vec3d origin = scene->origin();
  for (size_t i = 0; i < mesh.positions.size(); i += 3) {
    const Vec3d p = Vec3d(mesh.positions[i], mesh.positions[i + 1], mesh.positions[i + 2]) + origin;
    EXPECT_NEAR(std::hypot(p.y - 1, p.z), 0.1, 1e-4);
  }
  EXPECT_NEAR(boundsOf(mesh).diagonal().x, 3, 1e-4f);
}

TEST(SceneMesh, OfManyCurvesSomeAreShownWider) {
  std::string text = view(4, 4, "0 0 -5  0 0 0  0 1 0", perspective(40));
  for (int i = 0; i < 1000; ++i)
    text += "Shape \"curve\" \"point3 P\" [ 0 0 " + number(i) + "  0 1 " + number(i) + "  0 2 " + number(i) +
            "  0 3 " + number(i) + " ] \"float width\" .1\n";
  const SceneMesh mesh = meshOf(*sceneFrom(text), 1000);
  EXPECT_EQ(mesh.curves, 1000u);
  EXPECT_LE(mesh.triangles(), 1000u);
  EXPECT_GT(mesh.shownCurves, 150u);
  EXPECT_LT(mesh.shownCurves, 350u);
}

/** Largest distance of corners from a surface given by a signed distance, and the area of the mesh. */
template <class Distance>
std::pair<double, double> errorAndArea(const Scene& scene, const SceneMesh& mesh, const Distance& distance) {
  double worst = 0, area = 0;
  for (size_t t = 0; t < mesh.triangles(); ++t) {
    std::array<Vec3d, 3> p;
    for (size_t k = 0; k < 3; ++k)
      for (int c = 0; c < 3; ++c)
        p[k][c] = double(mesh.positions[9 * t + 3 * k + size_t(c)]) + scene.origin()[c];
    for (const Vec3d& corner : p) worst = std::max(worst, std::abs(distance(corner)));
    area += 0.5 * glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
  }
  return {worst, area};
}

TEST(SceneMesh, AnImplicitSphereHasTheAreaOfASphere) {
  const auto scene = sceneFrom(view(4, 4, "0 0 -5  0 0 0  0 1 0", perspective(40)) +
                               "Shape \"implicit\" \"string function\" \"x^2 + y^2 + z^2 - 4\" "
                               "\"point3 p1\" [ -3 -3 -3 ] \"point3 p2\" [ 3 3 3 ]\n");
  const SceneMesh mesh = meshOf(*scene, 200000);
  EXPECT_EQ(mesh.sampledShapes, 1u);
  const auto [worst, area] = errorAndArea(*scene, mesh, [](const Vec3d& p) { return glm::length(p) - 2; });
  EXPECT_LT(worst, 0.01);
  EXPECT_NEAR(area, 4 * M_PI * 4, 0.01 * 4 * M_PI * 4);
}

TEST(SceneMesh, ABlockWithABoreHasSharpEdges) {
  const auto scene = sceneFrom(view(4, 4, "0 0 -5  0 0 0  0 1 0", perspective(40)) + R"(
ObjectBegin "block"
Shape "box" "point3 p1" [ -1 -1 -1 ] "point3 p2" [ 1 1 1 ]
ObjectEnd
ObjectBegin "bore"
Shape "box" "point3 p1" [ -.5 -.5 -2 ] "point3 p2" [ .5 .5 2 ]
ObjectEnd
Shape "csg" "string operation" "difference" "string operands" [ "block" "bore" ]
)");
  const SceneMesh mesh = meshOf(*scene, 200000);
  EXPECT_EQ(mesh.sampledShapes, 1u);
  const auto box = [](const Vec3d& p, const Vec3d& half) {
    const Vec3d q = magnitude(p) - half;
    return glm::length(glm::max(q, Vec3d(0))) + std::min(0.0, std::max({q.x, q.y, q.z}));
  };
  const auto [worst, area] = errorAndArea(
      *scene, mesh, [&](const Vec3d& p) { return std::max(box(p, Vec3d(1)), -box(p, Vec3d(0.5, 0.5, 2))); });
  EXPECT_LT(worst, 0.01); // half a cell would be 0.02 at the edges without sharp ones
  const double exact = 4 * 4 + 2 * 3 + 4 * 2;
  EXPECT_NEAR(area, exact, 0.02 * exact);
}

TEST(SceneMesh, SimplificationKeepsWhatTheCameraSees) {
  // A ball of 4 m before a camera on a plate of 100 km, both of more triangles than are allowed.
  const auto scene = sceneFrom(
      view(4, 4, "0 0 -20  0 0 0  0 1 0", perspective(40)) +
      "Shape \"sphere\" \"float radius\" 2\nTranslate 0 -50003 0\nShape \"sphere\" \"float radius\" 50000\n");
  const SceneMesh mesh = meshOf(*scene, 1000);
  EXPECT_LE(mesh.triangles(), 1000u);
  EXPECT_GT(mesh.triangles(), 500u);
  size_t ofBall = 0;
  for (size_t t = 0; t < mesh.triangles(); ++t) {
    Vec3d p;
    for (int c = 0; c < 3; ++c) p[c] = double(mesh.positions[9 * t + size_t(c)]) + scene->origin()[c];
    ofBall += glm::length(p) < 2.5;
  }
  EXPECT_GT(ofBall, 200u);
}

constexpr double REFERENCE_FLUX = 3,
                 REFERENCE_ANGLE = 0.6; // irradiance perpendicular to the light, angle to the floor's normal

/** A floor of one material, lit by a distant light at an angle. */
std::string litFloor(const std::string& material) {
  return view(8, 8, "0 0 5  0 0 0  0 1 0", perspective(40)) + "LightSource \"distant\" \"rgb L\" [ " +
         number(REFERENCE_FLUX) + " 0 " + number(REFERENCE_FLUX) + " ] \"point3 from\" [ " +
         number(std::sin(REFERENCE_ANGLE)) + " 0 " + number(std::cos(REFERENCE_ANGLE)) +
         " ] \"point3 to\" [ 0 0 0 ]\nMaterial " + material + "\n" +
         "Shape \"trianglemesh\" \"integer indices\" [ 0 1 2  0 2 3 ] \"point3 P\" [ -2 -2 0  2 -2 0  2 2 0  "
         "-2 2 0 ]\n";
}

std::vector<ReferencePoint> referencesOf(const Scene& scene, const std::string& expression,
                                         int64_t samples = 64, uint64_t seed = 1) {
  const auto path = integratorFrom("path", "");
  const PathClasses classes({{"light", expression}});
  path->prepare(scene, classes);
  std::vector<RecordedPixel> pixels;
  pixels.push_back({4, 3, {}});
  const std::atomic<bool> stop{false};
  return referencePoints(scene, *path, classes, pixels, samples, seed, stop);
}

TEST(ReferencePoints, IrradianceOfADistantLightIsItsFluxTimesTheCosine) {
  const auto scene = sceneFrom(litFloor("\"diffuse\" \"rgb reflectance\" [ .2 .5 .8 ]"));
  const std::vector<ReferencePoint> found = referencesOf(*scene, "L(S|D)*E");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].x, 4);
  EXPECT_EQ(found[0].y, 3);
  EXPECT_EQ(found[0].samples, 64);
  const double expected = REFERENCE_FLUX * std::cos(REFERENCE_ANGLE);
  EXPECT_NEAR(double(found[0].irradiance.r), expected, 1e-4 * expected);
  EXPECT_EQ(found[0].irradiance.g, 0);
  EXPECT_NEAR(double(found[0].irradiance.b), expected, 1e-4 * expected);
  EXPECT_NEAR(found[0].standardError, 0, 1e-3);
  EXPECT_NEAR(found[0].normal.z, 1, 1e-6f);
}

TEST(ReferencePoints, AnyPointOfTheFloorHasTheSameIrradiance) {
  const auto scene = sceneFrom(litFloor("\"diffuse\" \"rgb reflectance\" [ .5 .6 .7 ]"));
  const auto path = integratorFrom("simplepath", "");
  const PathClasses classes(std::vector<PathClass>{{"light", "all"}});
  const std::atomic<bool> stop{false};
  const Vec3f point = Vec3f(1.7f, -1.9f, 0) - Vec3f(scene->origin()); // outside of the picture
  const auto found = referenceAt(*scene, *path, classes, point, {0, 0, 1}, 16, 1, stop);
  ASSERT_TRUE(found);
  EXPECT_NEAR(glm::length(found->position - point), 0, 1e-5f);
  EXPECT_EQ(found->samples, 16);
  const double expected = REFERENCE_FLUX * std::cos(REFERENCE_ANGLE);
  EXPECT_NEAR(double(found->irradiance.r), expected, 1e-3 * expected);
  // The back of the floor is dark; a mirror has no irradiance.
  const auto below = referenceAt(*scene, *path, classes, point, {0, 0, -1}, 16, 1, stop);
  ASSERT_TRUE(below);
  EXPECT_EQ(below->irradiance.r, 0);
  const auto mirror = sceneFrom(litFloor("\"conductor\""));
  EXPECT_FALSE(referenceAt(*mirror, *path, classes, point, {0, 0, 1}, 16, 1, stop));
}

TEST(ReferencePoints, APointOffTheSurfaceHasTheIrradianceOfTheSurface) {
  // A chord of 5° of a sphere of radius 5 is up to 0.1 below it; a plate is some distance above it.
  const auto scene =
      sceneFrom(litFloor("\"diffuse\"") + "Translate 0 0 10\nShape \"sphere\" \"float radius\" 5\n");
  const auto path = integratorFrom("simplepath", "");
  const PathClasses classes(std::vector<PathClass>{{"light", "all"}});
  const std::atomic<bool> stop{false};
  const Vec3f normal(std::sin(REFERENCE_ANGLE), 0, std::cos(REFERENCE_ANGLE)); // towards the light
  const Vec3f surface = Vec3f(0, 0, 10) + 5.0f * normal - Vec3f(scene->origin());
  const float reach = 0.02f * scene->bounds().radius;
  for (const float height : {-0.9f, -0.5f, -0.01f, 0.0f, 0.01f, 0.9f}) {
    const Vec3f point = surface + normal * (height * reach);
    const auto found = referenceAt(*scene, *path, classes, point, normal, 16, 1, stop);
    ASSERT_TRUE(found) << height;
    EXPECT_NEAR(glm::length(found->position - surface), 0, 1e-4f) << height;
    EXPECT_NEAR(double(found->irradiance.r), REFERENCE_FLUX, 1e-3 * REFERENCE_FLUX) << height;
    // The inside is dark.
    const auto inside = referenceAt(*scene, *path, classes, point, -normal, 16, 1, stop);
    ASSERT_TRUE(inside) << height;
    EXPECT_EQ(inside->irradiance, BLACK) << height;
  }
  for (const float height : {-1.1f, 1.1f})
    EXPECT_FALSE(
        referenceAt(*scene, *path, classes, surface + normal * (height * reach), normal, 16, 1, stop));
}

TEST(ReferencePoints, TheFrontOfAThinSphereIsNotItsBack) {
  // The position is nearer to the back of the sphere than to its front.
  const auto scene =
      sceneFrom(litFloor("\"diffuse\"") + "Translate 0 0 3\nShape \"sphere\" \"float radius\" .01\n");
  const auto path = integratorFrom("simplepath", "");
  const PathClasses classes(std::vector<PathClass>{{"light", "all"}});
  const std::atomic<bool> stop{false};
  const Vec3f normal(std::sin(REFERENCE_ANGLE), 0, std::cos(REFERENCE_ANGLE));
  const Vec3f centre = Vec3f(0, 0, 3) - Vec3f(scene->origin());
  const auto found = referenceAt(*scene, *path, classes, centre - normal * 0.003f, normal, 16, 1, stop);
  ASSERT_TRUE(found);
  EXPECT_NEAR(glm::length(found->position - (centre + normal * 0.01f)), 0, 1e-4f);
  EXPECT_NEAR(double(found->irradiance.r), REFERENCE_FLUX, 1e-3 * REFERENCE_FLUX);
}

TEST(ReferencePoints, OnlyTheLightOfTheClassCounts) {
  const auto scene = sceneFrom(litFloor("\"diffuse\""));
  const std::vector<ReferencePoint> found = referencesOf(*scene, "L(S|D)+DE");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].irradiance, BLACK);
}

TEST(ReferencePoints, OtherSurfacesAreLeftOut) {
  for (const char* material :
       {"\"conductor\"", "\"coateddiffuse\"", "\"diffuse\" \"rgb reflectance\" [ .5 0 .5 ]"})
    EXPECT_TRUE(referencesOf(*sceneFrom(litFloor(material)), "L(S|D)*E").empty()) << material;
}

TEST(ReferencePoints, StandardErrorIsTheSpreadOverSeeds) {
  constexpr int SEEDS = 200;
  const auto scene =
      sceneFrom(litFloor("\"diffuse\"") +
                "AreaLightSource \"diffuse\" \"rgb L\" [ 9 9 9 ]\n"
                "Shape \"bilinearmesh\" \"point3 P\" [ -3 1 .5  -3 -1 .5  -3 1 3  -3 -1 3 ]\n");
  for (const int64_t samples : {2, 16}) {
    SCOPED_TRACE(samples);
    double sum = 0, squares = 0, stated = 0;
    for (uint64_t seed = 0; seed < SEEDS; ++seed) {
      const std::vector<ReferencePoint> found = referencesOf(*scene, "L(S|D)*E", samples, seed);
      ASSERT_EQ(found.size(), 1u);
      const double y = double(luminance(found[0].irradiance));
      sum += y / SEEDS;
      squares += y * y / SEEDS;
      stated += square(double(found[0].standardError)) / SEEDS;
    }
    const double variance = (squares - sum * sum) * SEEDS / (SEEDS - 1);
    EXPECT_GT(variance, 1e-8 * sum * sum);
    EXPECT_NEAR(std::sqrt(stated), std::sqrt(variance), 0.2 * std::sqrt(variance));
  }
}

TEST(ReferencePoints, ThereAreNoneWhereTheirLightIsNotThatOfThePhotons) {
  const std::string floor = litFloor("\"diffuse\"");
  const auto countIn = [](const std::string& text) {
    return referencesOf(*sceneFrom(text), "L(S|D)*E").size();
  };
  const std::string shape = "Shape \"sphere\" \"float radius\" .1\n";
  EXPECT_EQ(countIn(floor + "Translate 1.5 1.5 1\n" + shape), 1u);
  EXPECT_EQ(countIn(floor + "Translate 1.5 1.5 1\nMaterial \"thindielectric\"\n" + shape), 0u);
  EXPECT_EQ(countIn(floor + "ActiveTransform EndTime\nTranslate 0 0 1\nActiveTransform All\n" + shape), 0u);
  EXPECT_EQ(countIn(floor +
                    "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\n"
                    "MediumInterface \"fog\" \"\"\nMaterial \"interface\"\n"
                    "Translate 1.5 1.5 1\n" +
                    shape),
            0u);
}

TEST(RenderPause, RecordsTheSamplesOfTheRenderAndLeavesTheFilmAlone) {
  const auto scene = sceneFrom(glassAndMirrorBox(24, 1.2));
  for (const auto& [name, parameters] :
       {std::pair("path", ""), {"photonmap", "\"integer photons\" 2000 \"integer passes\" 4"}}) {
    SCOPED_TRACE(name);
    RenderSettings settings;
    settings.samplesPerPixel = 8;
    const std::atomic<bool> stop{false};
    Film plain(scene->film().crop, 1), asked(scene->film().crop, 1);
    render(*scene, *integratorFrom(name, parameters), PathClasses(), settings, plain, stop, nullptr, nullptr);
    std::vector<RecordedPixel> truth(1);
    truth[0].x = 7;
    truth[0].y = 15;
    recordPixels(*scene, *integratorFrom(name, parameters), PathClasses(), settings, 8, truth, stop);
    int answers = 0;
    bool seenPhotons = false;
    settings.isAsked = [] { return true; };
    settings.answer = [&](const RenderPause& pause) {
      ++answers;
      PathRecorder record;
      pause.record(7, 15, 3, record);
      ASSERT_GE(record.samples().size(), 1u);
      ASSERT_LE(record.samples().size(), 3u);
      for (const RecordedSample& s : record.samples())
        EXPECT_EQ(s.total, truth[0].record.samples()[s.index].total) << s.index;
      pause.integrator().visitPhotons([&](const StoredPhoton&) { seenPhotons = true; });
    };
    render(*scene, *integratorFrom(name, parameters), PathClasses(), settings, asked, stop, nullptr, nullptr);
    EXPECT_GE(answers, 4);
    EXPECT_EQ(seenPhotons, std::string(name) == "photonmap");
    for (size_t p = 0; p < plain.bounds().area(); ++p) ASSERT_EQ(plain.value(p, 0), asked.value(p, 0));
  }
}

TEST(PhotonExpression, IsTheUnionOfTheClassesOfThePhotons) {
  const PathClasses classes({{"direct", "LDE"}, {"caustic", "LS+DE"}, {"other", "L(S|D)*D(S|D)*DE"}});
  const auto photonAfter = [&](const std::string& events) {
    StoredPhoton photon{Vec3f(0), Vec3f(0), Vec3f(0), BLACK, classes.lightStart(), false};
    for (const char e : events)
      photon.state = classes.step(photon.state, e == 'S' ? PathEvent::S : PathEvent::D);
    return photon;
  };
  EXPECT_EQ(photonExpression(classes, {photonAfter("S"), photonAfter("SS")}, "all"), "((LS+DE)) & (all)");
  EXPECT_EQ(photonExpression(classes, {photonAfter("DS"), photonAfter("")}, "all - LE"),
            "((LDE) | (L(S|D)*D(S|D)*DE)) & (all - LE)");
  EXPECT_EQ(photonExpression(PathClasses({{"direct", "LDE"}, {"mirrored", "L(S|D)*SE"}}), {photonAfter("D")},
                             "all"),
            "");
}

TEST(PhotonExpression, HasTheLightOfTheMapAlone) {
  const auto scene = sceneFrom(glassAndMirrorBox(8, 1.2));
  const PathClasses classes({{"caustic", "LS+DE"}, {"rest", "all - LS+DE"}});
  const auto accepted = [&](const char* parameters) {
    const auto integrator = integratorFrom("photonmap", parameters);
    integrator->prepare(*scene, classes);
    integrator->forward(*scene, classes, {.seed = 1}, {});
    size_t inMap = 0;
    const auto photons = photonsOf(*integrator, 100000, inMap);
    const PathAutomaton light =
        PathAutomaton::compile(photonExpression(classes, photons, integrator->photonPaths()));
    std::string words;
    for (const char* word : {"LDE", "LSDE", "LDDE", "LSDDE"})
      if (light.accepts(word)) words += std::string(word) + " ";
    return words;
  };
  EXPECT_EQ(accepted("\"integer photons\" 2000"), "LSDE LDDE LSDDE ");
  EXPECT_EQ(accepted("\"integer photons\" 2000 \"string direct\" \"photons\""), "LDE LSDE LDDE LSDDE ");
  EXPECT_EQ(accepted("\"integer photons\" 2000 \"bool causticsonly\" true"), "LSDE ");
}

} // namespace
} // namespace recurse
