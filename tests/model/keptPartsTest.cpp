/** @file
 * Scenes that reuse parts of the previous frame are equal to scenes built from scratch.
 */
#include <gtest/gtest.h>

#include "recurse/core/sampling/sampler.h"
#include "recurse/model/scene/keptParts.h"
#include "recurse/model/scene/scene.h"
#include "recurse/scene/directives/loader.h"

using namespace recurse;

namespace {

std::unique_ptr<Scene> frameScene(const std::string& text, KeptParts* kept, const std::string& camera = "") {
  Diagnostics diagnostics;
  const SceneDescription description =
      parseScene(camera + "\nWorldBegin\n" + text, "kept.pbrt", "", diagnostics);
  std::unique_ptr<Scene> scene = buildScene(description, {}, diagnostics, kept);
  EXPECT_TRUE(scene) << diagnostics.format();
  return scene;
}

/** Expects the same hits of rays from all directions, with the same scattering and emission. */
void expectTheSame(const Scene& a, const Scene& b) {
  int hits = 0;
  for (uint32_t i = 0; i < 2000; ++i) {
    const auto number = [i](uint32_t k) { return unitFloat(static_cast<uint32_t>(hashCombine(i, k) >> 32)); };
    const Vec3f from = Vec3f(number(0), number(1), number(2)) * 12.0f - 6.0f;
    const Vec3f to = Vec3f(number(3), number(4), number(5)) * 4.0f - 2.0f;
    Ray ray;
    ray.origin = from;
    ray.direction = glm::normalize(to - from);
    Hit x, y;
    const bool hit = a.intersect(ray, x);
    ASSERT_EQ(hit, b.intersect(ray, y));
    EXPECT_EQ(a.occluded(ray), b.occluded(ray));
    if (!hit) continue;
    ++hits;
    EXPECT_EQ(x.t, y.t);
    EXPECT_EQ(x.point.position, y.point.position);
    EXPECT_EQ(x.point.geometricNormal, y.point.geometricNormal);
    EXPECT_EQ(x.lightIndex, y.lightIndex);
    EXPECT_EQ(x.shape, y.shape);
    EXPECT_EQ(a.materialName(x.material), b.materialName(y.material));
    EXPECT_EQ(!x.areaLight, !y.areaLight);
  }
  EXPECT_GT(hits, 200);
}

std::string world(double x, const std::string& material = "diffuse", double height = 1) {
  return "ObjectBegin \"tree\" Material \"" + material +
         "\" Shape \"loopsubdiv\" \"integer levels\" 2 \"point3 P\" [ 1 0 0  -1 0 0  0 1 0  0 -1 0  0 0 1  0 "
         "0 -1 ] "
         "\"integer indices\" [ 0 2 4  2 1 4  1 3 4  3 0 4  2 0 5  1 2 5  3 1 5  0 3 5 ] "
         "Shape \"cylinder\" \"float zmax\" " +
         std::to_string(height) +
         " ObjectEnd Material \"\" Material \"conductor\" Shape \"box\" \"point3 p1\" [ -2 -2 -2 ] \"point3 "
         "p2\" [ 2 2 -1.5 ] "
         "AttributeBegin Translate " +
         std::to_string(x) +
         " 0 0 ObjectInstance \"tree\" Translate 2 0 0 ObjectInstance \"tree\" "
         "AreaLightSource \"diffuse\" Shape \"sphere\" \"float radius\" .4 AttributeEnd";
}

} // namespace

TEST(KeptParts, WhatDoesNotMoveIsNotBuiltAgain) {
  KeptParts kept;
  const std::unique_ptr<Scene> first = frameScene(world(0), &kept);
  EXPECT_EQ(kept.shapes.kept, 0u);
  EXPECT_EQ(kept.shapes.made, 4u);
  EXPECT_EQ(kept.trees.made, 1u);
  const std::unique_ptr<Scene> second = frameScene(world(.5), &kept);
  EXPECT_EQ(kept.shapes.kept, 3u);
  EXPECT_EQ(kept.shapes.made, 1u); // the lamp, whose transform is applied to its geometry
  EXPECT_EQ(kept.trees.kept, 1u);
  expectTheSame(*second, *frameScene(world(.5), nullptr));
}

TEST(KeptParts, MaterialsOfKeptTreesAreThoseOfTheFrame) {
  KeptParts kept;
  std::unique_ptr<Scene> before = frameScene(world(0), &kept);
  std::unique_ptr<Scene> next = frameScene(world(0, "conductor"), &kept);
  EXPECT_EQ(kept.trees.kept, 1u);
  before.reset();
  expectTheSame(*next, *frameScene(world(0, "conductor"), nullptr));
  // Rays that look for opaque surfaces do not see glass: a new tree.
  before = std::move(next);
  next = frameScene(world(0, "dielectric"), &kept);
  EXPECT_EQ(kept.trees.kept, 0u);
  expectTheSame(*next, *frameScene(world(0, "dielectric"), nullptr));
  // A surface that no longer scatters casts no shadow: shape and tree are removed.
  before = std::move(next);
  next = frameScene(world(0, ""), &kept);
  EXPECT_EQ(kept.trees.kept, 0u);
  expectTheSame(*next, *frameScene(world(0, ""), nullptr));
}

TEST(KeptParts, ShapesThatChangeAreMadeAnew) {
  KeptParts kept;
  const std::unique_ptr<Scene> first = frameScene(world(0), &kept);
  const std::unique_ptr<Scene> second = frameScene(world(0, "diffuse", 2), &kept);
  EXPECT_EQ(kept.shapes.kept, 3u);
  EXPECT_EQ(kept.trees.kept, 0u);
  expectTheSame(*second, *frameScene(world(0, "diffuse", 2), nullptr));
}

TEST(KeptParts, ShapesOfObjectsAndTexturesAreMadeAnew) {
  const auto text = [](double radius, double alpha) {
    return "Texture \"a\" \"float\" \"constant\" \"float value\" " + std::to_string(alpha) +
           " ObjectBegin \"ball\" Shape \"sphere\" \"float radius\" " + std::to_string(radius) +
           " ObjectEnd ObjectBegin \"box\" Shape \"box\" ObjectEnd "
           "Shape \"csg\" \"string operation\" \"union\" \"string operands\" [ \"ball\" \"box\" ] "
           "Translate 3 0 0 Shape \"sphere\" \"texture alpha\" \"a\"";
  };
  KeptParts kept;
  const std::unique_ptr<Scene> first = frameScene(text(1, 1), &kept);
  const std::unique_ptr<Scene> second = frameScene(text(1.3, 0), &kept);
  EXPECT_EQ(kept.shapes.kept, 0u);
  expectTheSame(*second, *frameScene(text(1.3, 0), nullptr));
}

TEST(KeptParts, DisplacedShapesAreDicedForTheCameraOfTheFrame) {
  const std::string mesh = "Shape \"trianglemesh\" \"point3 P\" [ -1 -1 0  1 -1 0  0 1 0 ] "
                           "\"integer indices\" [ 0 1 2 ] \"float displacement\" .1 ";
  const auto camera = [](int distance) {
    return "Film \"rgb\" \"integer xresolution\" 32 \"integer yresolution\" 32\nLookAt 0 0 " +
           std::to_string(distance) + " 0 0 0 0 1 0\nCamera \"perspective\"";
  };
  KeptParts kept;
  const std::unique_ptr<Scene> far = frameScene(mesh, &kept, camera(20));
  const std::unique_ptr<Scene> near = frameScene(mesh, &kept, camera(3));
  EXPECT_GT(near->contents().triangles, 2 * far->contents().triangles);
  EXPECT_EQ(near->contents().triangles, frameScene(mesh, nullptr, camera(3))->contents().triangles);
  // Edges of a given length do not depend on the camera.
  KeptParts fixed;
  const std::unique_ptr<Scene> first = frameScene(mesh + "\"float edgelength\" .2", &fixed, camera(20));
  const std::unique_ptr<Scene> second = frameScene(mesh + "\"float edgelength\" .2", &fixed, camera(3));
  EXPECT_EQ(fixed.shapes.kept, 1u);
}
