/** @file
 * Every registered material, made from its own examples: sampling against density, energy, reciprocity, and
 * the forward pass against the backward pass. A new material is covered without a change here.
 */
#include <gtest/gtest.h>

#include <random>

#include "recurse/model/plugIns.h"
#include "recurse/model/scatteringPoint.h"

using namespace recurse;

namespace {

class NoTextures final : public TextureLookup {
 public:
  TexturedRgb rgb(const Parameters& p, const std::string& n) const override {
    return {Rgb(p.spectrum(n)), nullptr};
  }
  TexturedRgb real(const Parameters& p, const std::string& n) const override {
    return {Rgb(static_cast<float>(p.real(n))), nullptr};
  }
};

std::unique_ptr<Material> make(const std::string& name, const std::string& parameters,
                               const MaterialContext& context) {
  Diagnostics diagnostics;
  auto material = plugIns().materials.make(parseParameterText(name, parameters), context, diagnostics);
  EXPECT_TRUE(material) << name << " " << parameters << "\n" << diagnostics.format();
  return material;
}

SurfacePoint flatPoint() {
  SurfacePoint p{};
  p.geometricNormal = p.shadingNormal = {0, 0, 1};
  p.dpdu = {1, 0, 0};
  return p;
}

/** Calls test(label, bsdf) for each example of each material, and for mixes of unlike materials. */
template <class F> void forEachBsdf(const F& test) {
  const NoTextures textures;
  const MaterialContext plain{textures, {}};
  const auto red = make("diffuse", "\"rgb reflectance\" [.9 .3 .1]", plain);
  const auto gold = make("conductor", "\"rgb reflectance\" [.9 .8 .4]", plain);
  const auto glass = make("dielectric", "\"float eta\" 1.5", plain);
  const MaterialContext context{
      textures, [&](const Parameters&, const std::string&, const std::string& name) -> const Material* {
        return name == "red" ? red.get() : name == "gold" ? gold.get() : glass.get();
      }};
  std::vector<std::pair<std::string, std::string>> uses = {
      {"mix", "\"string materials\" [\"red\" \"gold\"] \"float amount\" .3"},
      {"mix", "\"string materials\" [\"glass\" \"red\"] \"float amount\" .6"},
      {"mix", "\"string materials\" [\"glass\" \"gold\"]"}};
  for (const auto& entry : plugIns().materials.entries())
    for (const std::string& example : entry.examples) uses.emplace_back(entry.name, example);
  for (const auto& [name, parameters] : uses) {
    SCOPED_TRACE(name + " " + parameters);
    const auto material = make(name, parameters, context);
    BsdfArena arena;
    const Bsdf* bsdf = material->bsdfAt(flatPoint(), arena);
    if (!bsdf) {
      EXPECT_EQ(material->lobes(), NO_LOBE);
      continue;
    }
    EXPECT_EQ(bsdf->lobes() & ~material->lobes(), 0) << "a lobe that the material does not announce";
    test(*bsdf);
  }
}

std::vector<Vec3f> incidentDirections() {
  std::vector<Vec3f> out;
  for (const double degrees : {0.0, 30.0, 60.0, 85.0, 89.9})
    for (const float side : {1.0f, -1.0f}) {
      const double a = glm::radians(degrees);
      out.push_back(glm::normalize(
          Vec3f(float(std::sin(a) * 0.8), float(std::sin(a) * 0.6), side * float(std::cos(a)))));
    }
  return out;
}

} // namespace

TEST(Bsdf, SamplesFollowTheDensity) {
  // Chi-square over cells of the sphere; the density is integrated numerically in each cell.
  constexpr int COS = 10, PHI = 12, N = 40000, FINE = 12;
  forEachBsdf([&](const Bsdf& bsdf) {
    if (!(bsdf.lobes() & DIFFUSE_LOBES)) return;
    for (const Vec3f& wi : incidentDirections()) {
      std::mt19937 random(7);
      std::uniform_real_distribution<float> uniform(0, ONE_MINUS_EPSILON);
      std::vector<double> found(COS * PHI, 0), expected(COS * PHI, 0);
      int made = 0;
      for (int i = 0; i < N; ++i) {
        const auto wo = bsdf.sample(wi, {uniform(random), uniform(random)}, uniform(random));
        if (!wo) continue;
        ++made;
        ASSERT_NEAR(glm::length(*wo), 1, 1e-4);
        const int c = std::clamp(int((wo->z + 1) / 2 * COS), 0, COS - 1);
        const int p = std::clamp(int((std::atan2(wo->y, wo->x) / (2 * PI) + 0.5f) * PHI), 0, PHI - 1);
        found[size_t(c * PHI + p)] += 1;
      }
      double total = 0;
      for (int c = 0; c < COS * FINE; ++c)
        for (int p = 0; p < PHI * FINE; ++p) {
          const float z = 2 * (float(c) + 0.5f) / (COS * FINE) - 1,
                      phi = 2 * PI * ((float(p) + 0.5f) / (PHI * FINE) - 0.5f);
          const float r = std::sqrt(1 - z * z);
          const double mass = double(bsdf.pdf(wi, {r * std::cos(phi), r * std::sin(phi), z})) * 4 * M_PI /
                              (COS * FINE * PHI * FINE);
          expected[size_t(c / FINE * PHI + p / FINE)] += mass;
          total += mass;
        }
      EXPECT_NEAR(total, double(made) / N, 0.01) << "the density's integral is the chance of a sample";
      double chi2 = 0;
      int cells = 0;
      for (size_t i = 0; i < found.size(); ++i) {
        const double e = expected[i] * N;
        if (e < 5) continue;
        chi2 += (found[i] - e) * (found[i] - e) / e;
        ++cells;
      }
      // The mean of chi-square is the number of cells, its standard deviation the root of twice that.
      EXPECT_LT(chi2, cells + 6 * std::sqrt(2.0 * cells) + 5);
    }
  });
}

TEST(Bsdf, EnergyAndAlbedo) {
  forEachBsdf([&](const Bsdf& bsdf) {
    for (const Vec3f& wi : incidentDirections()) {
      std::mt19937 random(3);
      std::uniform_real_distribution<float> uniform(0, ONE_MINUS_EPSILON);
      Rgbd scattered(0);
      constexpr int N = 4000;
      if (bsdf.lobes() & DIFFUSE_LOBES)
        for (int i = 0; i < N; ++i) {
          const auto wo = bsdf.sample(wi, {uniform(random), uniform(random)}, uniform(random));
          if (!wo || !(bsdf.pdf(wi, *wo) > 0)) continue;
          scattered += Rgbd(bsdf.value(wi, *wo) * std::abs(wo->z) / bsdf.pdf(wi, *wo)) / double(N);
        }
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(scattered[k], double(bsdf.albedo(wi)[k]), 0.03) << "albedo() of the non-delta part";
      DeltaScatters deltas;
      bsdf.deltas(wi, deltas);
      EXPECT_EQ(deltas.count > 0, (bsdf.lobes() & DELTA_LOBES) != 0);
      for (const DeltaScatter& d : deltas) {
        scattered += Rgbd(d.weight);
        EXPECT_NEAR(glm::length(d.wo), 1, 1e-5);
        EXPECT_EQ(d.lobe == MIRROR, d.wo.z * wi.z > 0);
        for (int k = 0; k < 3; ++k) EXPECT_GE(d.weight[k], 0);
      }
      for (int k = 0; k < 3; ++k) EXPECT_LE(scattered[k], 1 + 1e-4);
    }
  });
}

TEST(Bsdf, Reciprocity) {
  forEachBsdf([&](const Bsdf& bsdf) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> uniform(-1, 1);
    for (int i = 0; i < 2000; ++i) {
      const Vec3f a = glm::normalize(Vec3f(uniform(random), uniform(random), uniform(random)));
      const Vec3f b = glm::normalize(Vec3f(uniform(random), uniform(random), uniform(random)));
      const Rgb ab = bsdf.value(a, b), ba = bsdf.value(b, a);
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(ab[k], ba[k], 1e-5f * (1 + ab[k]));
    }
    // Delta lobes: the way back has the same weight, and undoes the bending.
    for (const Vec3f& wi : incidentDirections()) {
      DeltaScatters there;
      bsdf.deltas(wi, there);
      for (const DeltaScatter& d : there) {
        DeltaScatters back;
        bsdf.deltas(d.wo, back);
        double best = INFINITY;
        for (const DeltaScatter& e : back)
          if (glm::length(e.wo - wi) < 2e-3f)
            best = std::min(best, double(maxComponent(glm::abs(e.weight - d.weight))));
        EXPECT_LT(best, 2e-2) << "angle " << wi.z;
      }
    }
  });
}

TEST(Bsdf, ForwardAndBackwardPassAgree) {
  // The named operations are views of the same scattering; flux and radiance differ by 1/η² at refraction
  // only.
  forEachBsdf([&](const Bsdf& bsdf) {
    const SurfacePoint point = flatPoint();
    const ScatteringPoint s(bsdf, point);
    for (const Vec3f& wi : incidentDirections()) {
      std::array<Scatter, DeltaScatters::MOST> flux, radiance;
      const int n = s.deltaScatters(wi, Transport::FLUX, flux);
      ASSERT_EQ(n, s.deltaScatters(wi, Transport::RADIANCE, radiance));
      for (int i = 0; i < n; ++i) {
        const Rgb expected = flux[size_t(i)].weight / square(flux[size_t(i)].eta);
        for (int k = 0; k < 3; ++k)
          EXPECT_NEAR(radiance[size_t(i)].weight[k], expected[k], 1e-5f * (1 + expected[k]));
      }
      if (const auto mirror = s.specularReflectionBackwardScatter(wi)) {
        EXPECT_EQ(mirror->lobe, MIRROR);
      }
      if (const auto refracted = s.specularRefractionBackwardScatter(wi)) {
        EXPECT_EQ(refracted->lobe, REFRACTION);
      }
      Sampler sampler(1, 2, 3);
      if (const auto d = s.hasDiffuse() ? s.diffuseForwardScatter(wi, sampler) : std::nullopt) {
        const Rgb expected = s.evaluate(wi, d->direction) / d->pdf;
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(d->weight[k], expected[k], 1e-4f * (1 + expected[k]));
        EXPECT_NEAR(s.pdfDiffuse(wi, d->direction), d->pdf, 1e-4f * d->pdf);
      }
      // The mean of scatter's weight over lobes is what all lobes scatter together.
      Rgbd mean(0);
      constexpr int N = 20000;
      for (uint32_t i = 0; i < N; ++i) {
        Sampler each(9, 1, i);
        if (const auto step = s.scatter(wi, Transport::FLUX, each)) mean += Rgbd(step->weight) / double(N);
      }
      Rgbd all(bsdf.albedo({wi}));
      for (int i = 0; i < n; ++i) all += Rgbd(flux[size_t(i)].weight);
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(mean[k], all[k], 0.02);
    }
  });
}

TEST(PlugIns, EveryExampleCanBeMade) {
  const auto check = [](const auto& registry, const auto& context) {
    for (const auto& entry : registry.entries()) {
      EXPECT_FALSE(entry.summary.empty()) << entry.name;
      for (const ParameterSpec& p : entry.parameters)
        EXPECT_FALSE(p.description.empty()) << entry.name << " " << p.name;
      for (const std::string& example : entry.examples) {
        Diagnostics diagnostics;
        EXPECT_TRUE(registry.make(parseParameterText(entry.name, example), context, diagnostics))
            << registry.kind() << " " << entry.name << " " << example << "\n"
            << diagnostics.format();
      }
    }
  };
  const PlugIns& all = plugIns();
  CameraContext camera;
  camera.width = camera.height = 16;
  check(all.shapes, ShapeContext{});
  check(all.lights, LightContext{});
  check(all.cameras, camera);
  check(all.filters, NoContext{});
  check(all.films, NoContext{});
  check(all.samplers, NoContext{});
  check(all.accelerators, NoContext{});
  Diagnostics diagnostics;
  const auto sphere = all.shapes.make(parseParameterText("sphere", ""), {}, diagnostics);
  check(all.areaLights, AreaLightContext{*sphere});
}

TEST(Filters, SamplesHaveTheFiltersMoments) {
  // Weighted samples must have total weight 1, mean 0, and stay within the radius.
  for (const auto& entry : plugIns().filters.entries()) {
    Diagnostics diagnostics;
    const auto filter = plugIns().filters.make(parseParameterText(entry.name, ""), {}, diagnostics);
    double weight = 0, x = 0, y = 0;
    constexpr uint32_t N = 1 << 16;
    for (uint32_t i = 0; i < N; ++i) {
      Sampler sampler(1, 1, i);
      const Filter::Sample s = filter->sample(sampler.next2D());
      weight += double(s.weight) / N;
      x += double(s.weight * s.offset.x) / N;
      y += double(s.weight * s.offset.y) / N;
      ASSERT_LE(std::abs(s.offset.x), 2.0001f);
    }
    EXPECT_NEAR(weight, 1, 2e-3) << entry.name;
    EXPECT_NEAR(x, 0, 2e-3) << entry.name;
    EXPECT_NEAR(y, 0, 2e-3) << entry.name;
  }
}
