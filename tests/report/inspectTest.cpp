/** @file
 * The triangles of the page of light in a scene.
 */
#include <gtest/gtest.h>

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

TEST(SceneMesh, CurvesAreBoxes) {
  const auto scene =
      sceneFrom(view(4, 4, "0 0 -5  0 0 0  0 1 0", perspective(40)) +
                "Shape \"curve\" \"point3 P\" [ 0 0 0  1 0 0  2 1 0  3 1 0 ] \"float width\" .1\n");
  const SceneMesh mesh = meshOf(*scene, 1000);
  EXPECT_EQ(mesh.triangles(), 0u);
  ASSERT_EQ(mesh.boxes.size(), 1u);
  EXPECT_GT(mesh.boxes[0].diagonal().x, 2.9f);
}

} // namespace
} // namespace recurse
