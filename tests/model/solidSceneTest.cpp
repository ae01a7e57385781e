/** @file
 * Solids and curves in whole scenes: materials of operands, instances, errors with their positions.
 */
#include "model/shapeTesting.h"
#include "recurse/model/scene/scene.h"
#include "recurse/scene/directives/loader.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

struct Loaded {
  std::unique_ptr<Scene> scene;
  std::string messages;
};

Loaded load(const std::string& world) {
  Diagnostics diagnostics;
  const auto d = parseScene("Camera \"perspective\"\nWorldBegin\n" + world, "test.pbrt", ".", diagnostics);
  Loaded loaded;
  loaded.scene = buildScene(d, {}, diagnostics);
  loaded.messages = diagnostics.format();
  return loaded;
}

std::string errorsOf(const std::string& world) {
  const Loaded l = load(world);
  EXPECT_FALSE(l.scene);
  return l.messages;
}

constexpr const char* OBJECTS = "ObjectBegin \"block\"\nMaterial \"diffuse\" \"rgb reflectance\" [.5 0 0]\n"
                                "Shape \"box\"\nObjectEnd\n"
                                "ObjectBegin \"ball\"\nMaterial \"dielectric\"\n"
                                "Shape \"sphere\" \"float radius\" 1.2\nObjectEnd\n";

/** Objects "c0", a sphere, to "c(levels)", each the union of two copies of the previous one; then an instance
 * of the last. */
std::string towerOfSolids(int levels, const std::string& other = {}) {
  std::string text = "ObjectBegin \"c0\"\nShape \"sphere\"\nObjectEnd\n";
  for (int i = 1; i <= levels; ++i) {
    const std::string below = "\"c" + std::to_string(i - 1) + "\"";
    text += "ObjectBegin \"c" + std::to_string(i) + "\"\nShape \"csg\" \"string operands\" [" + below + " " +
            (other.empty() ? below : other) + "]\nObjectEnd\n";
  }
  return text + "ObjectInstance \"c" + std::to_string(levels) + "\"\n";
}

Hit hitAlong(const Scene& scene, const Vec3f& origin, const Vec3f& direction) {
  Hit hit;
  EXPECT_TRUE(scene.intersect({origin, direction}, hit));
  return hit;
}

} // namespace

TEST(SolidScene, SurfacesKeepTheMaterialOfTheirOperand) {
  const std::string csg =
      "Shape \"csg\" \"string operation\" \"difference\" \"string operands\" [\"block\" \"ball\"]";
  for (const bool instanced : {false, true}) {
    const std::string use = instanced ? "ObjectBegin \"both\"\n" + csg +
                                            "\nObjectEnd\nTranslate 0 0 5\n"
                                            "Scale 2 2 2\nObjectInstance \"both\"\n"
                                      : "Translate 0 0 5\nScale 2 2 2\n" + csg + "\n";
    const Loaded l = load(OBJECTS + use);
    ASSERT_TRUE(l.scene) << l.messages;
    const Vec3f origin = -Vec3f(l.scene->origin());
    // Through the hole in the face from the front: the surface of the ball at the far side of the block.
    const Hit outside = hitAlong(*l.scene, origin + Vec3f(1.9f, 1.9f, 0), {0, 0, 1});
    EXPECT_NEAR(outside.t, 3, 1e-4);
    EXPECT_EQ(outside.material->lobes() & REFRACTION, 0);
    const Hit cut = hitAlong(*l.scene, origin + Vec3f(0, 0, 5), glm::normalize(Vec3f(1, 1, 1)));
    EXPECT_NEAR(cut.t, 2.4, 1e-4);
    EXPECT_NE(cut.material->lobes() & REFRACTION, 0);
    // The remaining solid is outside of the ball.
    EXPECT_LT(glm::dot(cut.point.geometricNormal, Vec3f(1)), 0);
  }
  const Loaded one =
      load(OBJECTS + std::string("Material \"conductor\"\n") + csg + " \"bool onematerial\" true\n");
  ASSERT_TRUE(one.scene) << one.messages;
  EXPECT_EQ(hitAlong(*one.scene, Vec3f(0), glm::normalize(Vec3f(1, 1, 1))).material->lobes() & REFRACTION, 0);
}

TEST(SolidScene, ErrorsNameThePlace) {
  const auto expect = [](const std::string& text, const char* place, const char* part) {
    EXPECT_NE(text.find(place), std::string::npos) << text;
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  expect(errorsOf("Shape \"csg\" \"string operands\" [\"a\" \"b\"]"),
         "test.pbrt:3:", "no object named \"a\"");
  expect(errorsOf("ObjectBegin \"a\"\nShape \"csg\" \"string operands\" [\"a\" \"a\"]\nObjectEnd\n"
                  "Shape \"csg\" \"string operands\" [\"a\" \"a\"]"),
         "test.pbrt:4:", "contains itself");
  expect(errorsOf("ObjectBegin \"a\"\nShape \"cylinder\"\nObjectEnd\n"
                  "Shape \"csg\" \"string operands\" [\"a\" \"a\"]"),
         "test.pbrt:4:7", "it is open");
  expect(errorsOf("ObjectBegin \"a\"\nShape \"sphere\" \"float alpha\" .5\nObjectEnd\n"
                  "Shape \"csg\" \"string operands\" [\"a\" \"a\"]"),
         "test.pbrt:4:7", "alpha");
  expect(errorsOf("ObjectBegin \"a\"\nAreaLightSource \"diffuse\"\nShape \"sphere\"\nObjectEnd\n"
                  "Shape \"csg\" \"string operands\" [\"a\" \"a\"]"),
         "test.pbrt:5:7", "cannot emit by itself");
  // Shapes that cannot be sampled cannot be lamps.
  expect(errorsOf("AreaLightSource \"diffuse\"\nShape \"metaballs\" \"point3 P\" [0 0 0]"), "test.pbrt:4:7",
         "cannot be a lamp");
  expect(errorsOf("AreaLightSource \"diffuse\"\nShape \"implicit\" \"string function\" \"x\""),
         "test.pbrt:4:7", "cannot be a lamp");
  expect(errorsOf("AreaLightSource \"diffuse\"\nShape \"curve\" \"point3 P\" [0 0 0 0 0 1 0 0 2 0 0 3]"),
         "test.pbrt:4:7", "cannot be a lamp");
}

TEST(SolidScene, CurvesAreAsWideAsTheySay) {
  // A straight curve along x, .2 wide at one end and .1 at the other, and parallel rays perpendicular to it.
  const auto width = [](const Scene& scene, float x, const Vec3f& towards, bool isRibbon = false) {
    const Vec3f across = glm::cross(Vec3f(1, 0, 0), towards);
    int met = 0;
    constexpr int RAYS = 2000;
    Hit hit;
    for (int i = 0; i < RAYS; ++i) {
      const float offset = (float(i) + .5f) / RAYS * .4f - .2f;
      const Vec3f origin = Vec3f(x, 0, 0) + across * offset - towards * 3.0f - Vec3f(scene.origin());
      if (!scene.intersect({origin, towards}, hit)) continue;
      ++met;
      const Vec3f p = origin + towards * hit.t;
      // The hit of an oblique ribbon is on the ribbon itself, not on its projection.
      EXPECT_LT(glm::length(hit.point.position - p), isRibbon ? .1f : 1e-3f);
      EXPECT_NEAR(hit.point.uv.x, x / 3, 1e-3);
      EXPECT_TRUE(scene.occluded({origin, towards}));
    }
    return met * .4 / RAYS;
  };
  const std::string controls =
      " \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"float width0\" .2 \"float width1\" .1";
  const Vec3f down(0, -1, 0), tilted = glm::normalize(Vec3f(0, -1, 1));
  for (const char* type : {"flat", "cylinder"}) {
    const Loaded l = load("Shape \"curve\" \"string type\" \"" + std::string(type) + "\"" + controls);
    ASSERT_TRUE(l.scene) << l.messages;
    for (const Vec3f& d : {down, tilted}) {
      EXPECT_NEAR(width(*l.scene, .75f, d), .175, 2e-3) << type;
      EXPECT_NEAR(width(*l.scene, 2.25f, d), .125, 2e-3) << type;
    }
  }
  // A flat ribbon is narrower from the side. Of its normals, only what is perpendicular to the curve counts.
  for (const char* normals : {"0 1 0 0 1 0", "1 1 0 -2 1 0"}) {
    const Loaded ribbon = load("Shape \"curve\" \"string type\" \"ribbon\" \"normal N\" [" +
                               std::string(normals) + "]" + controls);
    ASSERT_TRUE(ribbon.scene) << ribbon.messages;
    EXPECT_NEAR(width(*ribbon.scene, .75f, down), .175, 2e-3) << normals;
    EXPECT_NEAR(width(*ribbon.scene, .75f, tilted, true), .175 * std::sqrt(.5), 2e-3) << normals;
  }
}

TEST(SolidScene, TooManySolidsAreRefusedWithTheirPlace) {
  const std::string said = errorsOf(towerOfSolids(40));
  EXPECT_NE(said.find("test.pbrt:124:13: error: too many solids are combined: more than 1000000"),
            std::string::npos)
      << said;
  EXPECT_NE(said.find("^"), std::string::npos);
  EXPECT_TRUE(load(towerOfSolids(8)).scene);
}

TEST(SolidScene, TooManyLevelsOfSolidsAreRefusedWithTheirPlace) {
  const std::string said = errorsOf(OBJECTS + towerOfSolids(5000, "\"ball\""));
  EXPECT_NE(said.find("error: solids are nested more than 256 levels"), std::string::npos) << said;
  const Loaded deepest = load(OBJECTS + towerOfSolids(256, "\"ball\""));
  ASSERT_TRUE(deepest.scene) << deepest.messages;
  EXPECT_NEAR(hitAlong(*deepest.scene, {-3, 0, 0}, {1, 0, 0}).t, 1.8, 1e-4);
}

// Squares of their sizes are no normal numbers: rays would have directions that are not numbers.
TEST(SolidScene, TinyShapesAreRefusedWithTheirPlace) {
  const std::string said = errorsOf("Shape \"sphere\" \"float radius\" 1e-19");
  EXPECT_NE(said.find("test.pbrt:3:7: error: the shape is too small"), std::string::npos) << said;
  EXPECT_TRUE(load("Shape \"sphere\" \"float radius\" 1e-14").scene);
}
