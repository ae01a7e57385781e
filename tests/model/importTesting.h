/** @file
 * Base of tests of importers: a folder of their own, scenes that name files in it, and hits of rays.
 */
#pragma once

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

#include "recurse/model/bsdf/scatteringPoint.h"
#include "recurse/model/scene/importExpansion.h"
#include "recurse/model/scene/scene.h"
#include "recurse/model/scene/sceneImport.h"
#include "recurse/scene/directives/loader.h"

namespace recurse::testing {

class ImportTest : public ::testing::Test {
 protected:
  void SetUp() override {
    directory = ::testing::TempDir() + "importTest." + std::to_string(::getpid());
    std::filesystem::create_directory(directory);
  }
  void TearDown() override { std::filesystem::remove_all(directory); }

  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(directory + "/" + name, std::ios::binary) << bytes;
  }

  /** Scene including the objects of importers; `messages` has the warnings, and the errors if
   * `wantErrors`. */
  SceneDescription load(const std::string& world, bool wantErrors = false) {
    Diagnostics diagnostics;
    SceneDescription scene = parseScene("WorldBegin\n" + world, "test.pbrt", directory, diagnostics);
    expandImports(scene, diagnostics, false);
    messages = diagnostics.format();
    EXPECT_EQ(diagnostics.hasErrors(), wantErrors) << messages;
    return scene;
  }

  std::unique_ptr<Scene> build(const SceneDescription& scene) {
    Diagnostics diagnostics;
    std::unique_ptr<Scene> made = buildScene(scene, {}, diagnostics);
    EXPECT_TRUE(made) << diagnostics.format();
    return made;
  }

  /** First hit of a ray along -z at a point of the file's world. */
  static Hit hitAt(const Scene& scene, const Vec3d& place) {
    Hit hit;
    Ray ray;
    ray.origin = Vec3f(place + Vec3d(0, 0, 1) - scene.origin());
    ray.direction = {0, 0, -1};
    EXPECT_TRUE(scene.intersect(ray, hit));
    return hit;
  }
  static Rgb albedo(const Scene& scene, const Vec3d& place) {
    const Hit hit = hitAt(scene, place);
    if (!hit.material) return BLACK;
    BsdfArena arena;
    const Bsdf* bsdf = hit.material->bsdfAt(hit.point, arena);
    return bsdf ? bsdf->albedo({0, 0, 1}) : BLACK;
  }

  static double numberOf(const ParsedDirective& d, const std::string& name, size_t i = 0) {
    for (const ParsedParameter& p : d.parameters)
      if (p.name == name) return p.numbers.at(i);
    ADD_FAILURE() << d.type << " has no " << name;
    return 0;
  }

  std::string directory, messages;
};

} // namespace recurse::testing
