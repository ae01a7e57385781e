/** @file
 * Form factors against closed forms, and the figure of patches.
 */
#include <gtest/gtest.h>

#include "recurse/report/figures/figures.h"
#include "recurse/report/inspect/formFactors.h"
#include "sceneRendering.h"

namespace recurse {
namespace {

using namespace recurse::testing;

constexpr uint32_t FACTOR_RAYS = 4096;

/** Patches of a scene, and their form factors. */
struct PatchSystem {
  std::unique_ptr<Scene> scene;
  std::unique_ptr<Integrator> radiosity;
  std::vector<RadiosityPatch> patches;
  std::vector<FormFactors> factors;

  /** The lit side is towards the origin. */
  explicit PatchSystem(const std::string& text) : scene(sceneFrom(text)) {
    radiosity = integratorFrom("radiosity", "\"float patchsize\" .25 \"integer rays\" 1000");
    radiosity->prepare(*scene, PathClasses());
    radiosity->forward(*scene, PathClasses(), {}, {});
    radiosity->visitPatches([&](const RadiosityPatch& patch) { patches.push_back(patch); });
    for (RadiosityPatch& p : patches) p.received[glm::dot(p.normal, -centroid(p)) > 0 ? 0 : 1] = Rgb(1);
    const std::atomic<bool> stop{false};
    factors = formFactors(*scene, *radiosity, patches, FACTOR_RAYS, 1, stop);
  }

  static Vec3f centroid(const RadiosityPatch& p) {
    return (p.corners[0] + p.corners[1] + p.corners[2]) / 3.0f;
  }
  double factor(size_t from, size_t to) const {
    for (const FormFactorHits& h : factors[from].hits)
      if (h.patch == to) return double(h.rays) / FACTOR_RAYS;
    return 0;
  }
  /** Form factor between groups of patches. */
  template <class From, class To> double between(const From& isFrom, const To& isTo) const {
    double sum = 0, area = 0;
    for (size_t i = 0; i < patches.size(); ++i) {
      if (!isFrom(centroid(patches[i]))) continue;
      area += double(patches[i].area);
      for (size_t j = 0; j < patches.size(); ++j)
        if (isTo(centroid(patches[j]))) sum += double(patches[i].area) * factor(i, j);
    }
    return sum / area;
  }
};

std::string squares(const std::string& second) {
  return view(4, 4, "0 0 3  0 0 0  0 1 0", perspective(40)) +
         "LightSource \"point\" \"point3 from\" [ 0 0 0 ]\nMaterial \"diffuse\" \"rgb reflectance\" [ .6 .5 "
         ".4 ]\n"
         "Shape \"bilinearmesh\" \"point3 P\" [ -.5 -.5 -.5  .5 -.5 -.5  -.5 -.5 .5  .5 -.5 .5 ]\n" +
         second;
}

const auto IS_FLOOR = [](const Vec3f& p) { return p.y < -0.499f; };
const auto IS_OTHER = [](const Vec3f& p) { return !(p.y < -0.499f); };

TEST(FormFactors, OfParallelSquares) {
  const PatchSystem system(
      squares("Shape \"bilinearmesh\" \"point3 P\" [ -.5 .5 -.5  .5 .5 -.5  -.5 .5 .5  .5 .5 .5 ]\n"));
  ASSERT_EQ(system.patches.size(), 64u);
  // Unit squares at distance 1 (Howell, A Catalog of Radiation Heat Transfer Configuration Factors, C-11).
  const double s2 = std::sqrt(2.0);
  const double expected =
      2 / PI_D * (std::log(std::sqrt(4.0 / 3)) + 2 * s2 * std::atan(1 / s2) - 2 * std::atan(1.0));
  EXPECT_NEAR(expected, 0.1998, 1e-4);
  EXPECT_NEAR(system.between(IS_FLOOR, IS_OTHER), expected, 0.004);
  EXPECT_NEAR(system.between(IS_OTHER, IS_FLOOR), expected, 0.004);
  EXPECT_EQ(system.between(IS_FLOOR, IS_FLOOR), 0);
}

TEST(FormFactors, OfPerpendicularSquares) {
  const PatchSystem system(
      squares("Shape \"bilinearmesh\" \"point3 P\" [ -.5 -.5 -.5  -.5 -.5 .5  -.5 .5 -.5  -.5 .5 .5 ]\n"));
  // With a common edge (Howell, C-14, all lengths 1).
  const double expected =
      (2 * std::atan(1.0) - std::sqrt(2.0) * std::atan(1 / std::sqrt(2.0)) + std::log(0.75) / 4) / PI_D;
  EXPECT_NEAR(expected, 0.2000, 1e-4);
  EXPECT_NEAR(system.between(IS_FLOOR, IS_OTHER), expected, 0.004);
  EXPECT_NEAR(system.between(IS_OTHER, IS_FLOOR), expected, 0.004);
}

/** Rectangle by three of its corners. */
std::string rectangle(const Vec3f& p, const Vec3f& q, const Vec3f& r) {
  std::string text = "Shape \"bilinearmesh\" \"point3 P\" [";
  for (const Vec3f& corner : {p, q, r, q + r - p})
    for (int c = 0; c < 3; ++c) text += " " + number(double(corner[c]));
  return text + " ]\n";
}

/** Closed box around the origin. */
std::string closedBox(const Vec3f& half) {
  std::string text =
      view(4, 4, "0 0 3  0 0 0  0 1 0", perspective(40)) + "LightSource \"point\"\nMaterial \"diffuse\"\n";
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      Vec3f p = -half, q = -half, r = -half;
      p[axis] = q[axis] = r[axis] = side * half[axis];
      q[(axis + 1) % 3] = half[(axis + 1) % 3];
      r[(axis + 2) % 3] = half[(axis + 2) % 3];
      text += rectangle(p, q, r);
    }
  return text;
}

TEST(FormFactors, AreReciprocalAndOneInAClosedBox) {
  // Edges of the patches are 1/4, 0.15 and 0.13 long.
  const PatchSystem system(closedBox({0.5f, 0.15f, 0.13f}));
  for (const FormFactors& factors : system.factors) {
    uint32_t rays = 0;
    for (const FormFactorHits& h : factors.hits) rays += h.rays;
    EXPECT_EQ(rays, FACTOR_RAYS);
  }
  size_t pairs = 0, unequal = 0;
  for (size_t i = 0; i < system.patches.size(); ++i)
    for (size_t j = 0; j < i; ++j) {
      const double ij = system.factor(i, j), ji = system.factor(j, i);
      if (std::max(ij, ji) < 0.03) continue;
      const double a = double(system.patches[i].area), b = double(system.patches[j].area);
      const double error = std::sqrt((square(a) * ij * (1 - ij) + square(b) * ji * (1 - ji)) / FACTOR_RAYS);
      EXPECT_NEAR(a * ij, b * ji, 5 * error) << i << " " << j;
      ++pairs;
      unequal += std::max(a, b) > 1.5 * std::min(a, b);
    }
  EXPECT_GT(pairs, 200u);
  EXPECT_GT(unequal, 20u);
}

TEST(FormFactors, AWallBetweenBlocksThem) {
  const std::string both =
      "Shape \"bilinearmesh\" \"point3 P\" [ -.5 .5 -.5  .5 .5 -.5  -.5 .5 .5  .5 .5 .5 ]\n";
  const std::string wall = "Shape \"bilinearmesh\" \"point3 P\" [ -5 .1 -5  5 .1 -5  -5 .1 5  5 .1 5 ]\n";
  const PatchSystem system(squares(both + "Material \"conductor\"\n" + wall));
  EXPECT_EQ(system.between(IS_FLOOR, [](const Vec3f& p) { return p.y > 0.4f; }), 0);
}

TEST(FormFactors, RaysOfAPageAreBounded) {
  EXPECT_EQ(formFactorRays(10), 16384u); // hits have 16 bits in the page
  EXPECT_EQ(formFactorRays(1000), 4000u);
  EXPECT_EQ(formFactorRays(MOST_FACTOR_PATCHES), 66u);
  EXPECT_EQ(formFactorRays(MOST_FACTOR_PATCHES + 1), 0u);
}

TEST(Patches, HaveTheRadiosityOfTheIntegrator) {
  // In a closed box that emits 1 and reflects 1/2, the irradiance of light reflected at least once before is
  // π (1/2) / (1 - 1/2).
  const std::string box = view(16, 16, "0 0 0  1 .3 .2  0 0 1", perspective(80)) +
                          "AreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ]\nMaterial \"diffuse\" \"rgb "
                          "reflectance\" [ .5 .5 .5 ]\n"
                          "ReverseOrientation\nShape \"box\"\n";
  const auto scene = sceneFrom(box);
  const auto radiosity = integratorFrom("radiosity", "\"float patchsize\" .5 \"integer rays\" 200000");
  const std::atomic<bool> stop{false};
  RenderSettings settings;
  settings.samplesPerPixel = 16;
  const std::vector<FigurePanel> panels = patchesPanels(*scene, *radiosity, settings, stop);
  double area = 0, sum = 0;
  radiosity->visitPatches([&](const RadiosityPatch& p) {
    area += double(p.area);
    sum += double(p.area * (p.received[0].g + p.received[1].g));
    EXPECT_NEAR(p.albedo[0].g, 0.5f, 1e-5f);
  });
  EXPECT_NEAR(area, 24, 1e-3);
  EXPECT_NEAR(sum / area, PI_D, 0.02 * PI_D);
  // Patches and their interpolation have the same mean, apart from the lines of the mesh.
  ASSERT_EQ(panels.size(), 3u);
  std::vector<double> values;
  for (size_t i = 0; i < panels[0].image.pixels.size(); i += 3)
    values.push_back(double(panels[0].image.pixels[i]));
  EXPECT_NEAR(quantileOf(values, 0.75), 0.5, 0.05);
  EXPECT_LT(quantileOf(values, 0.02), 0.3); // lines
  double interpolated = 0, all = 0;
  for (size_t i = 0; i < panels[1].image.pixels.size(); ++i) {
    interpolated += double(panels[1].image.pixels[i]) / double(panels[1].image.pixels.size());
    all += double(panels[2].image.pixels[i]) / double(panels[2].image.pixels.size());
  }
  EXPECT_NEAR(interpolated, 0.5, 0.02);
  EXPECT_NEAR(all, 2, 0.05);
}

TEST(Patches, AnInterruptedRenderHasNone) {
  const auto scene = sceneFrom(closedBox(Vec3f(1)));
  const auto radiosity = integratorFrom("radiosity", "");
  const std::atomic<bool> stop{true};
  RenderSettings settings;
  settings.samplesPerPixel = 1;
  EXPECT_TRUE(patchesPanels(*scene, *radiosity, settings, stop).empty());
  const auto prepared = integratorFrom("radiosity", "");
  prepared->prepare(*scene, PathClasses());
  prepared->visitPatches([](const RadiosityPatch&) { ADD_FAILURE(); });
}

TEST(Patches, ASceneWithoutDiffuseSurfacesIsAnErrorWithTheReason) {
  const auto scene = sceneFrom(view(4, 4, "0 0 3  0 0 0  0 1 0", perspective(40)) +
                               "LightSource \"infinite\"\nMaterial \"conductor\"\nShape \"sphere\"\n");
  const std::atomic<bool> stop{false};
  RenderSettings settings;
  settings.samplesPerPixel = 1;
  try {
    patchesPanels(*scene, *integratorFrom("radiosity", ""), settings, stop);
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("radiosity divides into patches"), std::string::npos);
  }
}

} // namespace
} // namespace recurse
