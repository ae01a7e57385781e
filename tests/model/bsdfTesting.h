/** @file
 * BSDFs for tests: every registered material from its own examples, and from the corners of its declared
 * parameters, so that new materials are covered without a change of the tests.
 */
#pragma once

#include <gtest/gtest.h>

#include <random>

#include "recurse/core/sampling/sampling.h"
#include "recurse/model/bsdf/scatteringPoint.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

class NoTextures final : public TextureLookup {
 public:
  TexturedRgb rgb(const Parameters& p, const std::string& n) const override {
    return {Rgb(p.spectrum(n)), nullptr};
  }
  TexturedRgb real(const Parameters& p, const std::string& n) const override {
    return {Rgb(static_cast<float>(p.real(n))), nullptr};
  }
};

inline std::unique_ptr<Material> makeMaterial(const std::string& name, const std::string& parameters,
                                              const MaterialContext& context) {
  Diagnostics diagnostics;
  auto material = plugIns().materials.make(parseParameterText(name, parameters), context, diagnostics);
  EXPECT_TRUE(material) << name << " " << parameters << "\n" << diagnostics.format();
  return material;
}

/** Named materials for use as components: a diffuse one, a mirror, glass, and rough versions of the last
 * two. */
class NamedMaterials {
 public:
  NamedMaterials() {
    const MaterialContext plain{textures, {}};
    const auto add = [&](const char* name, const char* type, const char* parameters) {
      materials.emplace_back(name, makeMaterial(type, parameters, plain));
    };
    add("red", "diffuse", "\"rgb reflectance\" [.9 .3 .1]");
    add("gold", "conductor", "\"rgb reflectance\" [.9 .8 .4]");
    add("glass", "dielectric", "\"float eta\" 1.5");
    add("brushed", "conductor", "\"rgb reflectance\" [.9 .8 .4] \"float roughness\" .1");
    add("frosted", "dielectric", "\"float eta\" 1.5 \"float roughness\" .1");
  }
  MaterialContext context() const {
    return {textures, [this](const Parameters& p, const std::string& parameter, const std::string& name) {
              for (const auto& [known, material] : materials)
                if (known == name) return static_cast<const Material*>(material.get());
              p.fail(parameter, "no such material");
            }};
  }

 private:
  NoTextures textures;
  std::vector<std::pair<std::string, std::unique_ptr<Material>>> materials;
};

inline SurfacePoint flatPoint() {
  SurfacePoint p{};
  p.geometricNormal = p.shadingNormal = {0, 0, 1};
  p.dpdu = {1, 0, 0};
  p.uv = {.3f, .3f}; // position across hair
  return p;
}

/** Material from one of its own examples. */
struct MaterialUse {
  std::string text;
  std::unique_ptr<Material> material;
};
/** All examples of all materials, made once because tables take time. */
inline const std::vector<MaterialUse>& everyUse() {
  static const NamedMaterials named;
  static const std::vector<MaterialUse> uses = [] {
    std::vector<MaterialUse> out;
    for (const auto& entry : plugIns().materials.entries())
      for (const std::string& example : entry.examples)
        out.push_back({entry.name + " " + example, makeMaterial(entry.name, example, named.context())});
    return out;
  }();
  return uses;
}

/** Calls test(bsdf) for each use. */
template <class F> void forEachBsdf(const F& test) {
  for (const MaterialUse& use : everyUse()) {
    SCOPED_TRACE(use.text);
    ASSERT_TRUE(use.material);
    BsdfArena arena;
    const Bsdf* bsdf = use.material->bsdfAt(flatPoint(), arena);
    if (!bsdf) {
      EXPECT_EQ(use.material->lobes(), NO_LOBE);
      continue;
    }
    EXPECT_EQ(bsdf->lobes() & ~use.material->lobes() & ALL_LOBES, 0)
        << "a lobe that the material does not announce";
    test(*bsdf);
  }
}

/** Both sides, from the normal to grazing, in several azimuths. */
inline std::vector<Vec3f> incidentDirections() {
  std::vector<Vec3f> out;
  double azimuth = 0.3;
  for (const double degrees : {0.0, 20.0, 45.0, 70.0, 84.0, 89.0, 89.9})
    for (const double side : {1.0, -1.0}) {
      const double a = glm::radians(degrees);
      azimuth += 2.4;
      out.emplace_back(glm::normalize(
          Vec3d(std::sin(a) * std::cos(azimuth), std::sin(a) * std::sin(azimuth), side * std::cos(a))));
    }
  return out;
}

/** Random numbers of a test, the same in every run. */
class TestRandom {
 public:
  explicit TestRandom(uint32_t seed) : engine(seed) {}
  float next() { return unitFloat(engine()); }
  Vec2f next2() {
    const float x = next();
    return {x, next()};
  }
  Vec3f direction() { return uniformSphere(next2()); }
  uint32_t below(size_t n) { return static_cast<uint32_t>(engine() % n); }

 private:
  std::mt19937 engine;
};

} // namespace recurse
