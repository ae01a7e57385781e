/** @file
 * Every registered light, from its own examples and on several shapes: densities, power, and agreement of
 * both passes.
 */
#include <gtest/gtest.h>

#include "recurse/core/sampling/sampling.h"
#include "recurse/model/scene/plugIns.h"

using namespace recurse;

namespace {

/** Light with the objects that it refers to. */
struct LightUse {
  std::string text;
  std::unique_ptr<Shape> shape; ///< shape of an area light
  std::unique_ptr<Light> light;
  const Light* operator->() const { return light.get(); }
};

constexpr SceneBounds BOUNDS{{0.5f, 0.25f, -0.5f}, 2.5f};

void makeEveryLight(std::vector<LightUse>& uses) {
  Diagnostics diagnostics;
  Mat4d placed(1); // a rotation and a translation
  placed[0] = {0.6, 0, -0.8, 0};
  placed[1] = {-0.48, 0.8, -0.36, 0};
  placed[2] = {0.64, 0.6, 0.48, 0};
  placed[3] = {0.25, -0.5, 0.75, 1};
  Mat4d stretched = placed;
  stretched[0] *= 1.5;
  stretched[1] *= 0.75;
  const auto add = [&](std::string text, std::unique_ptr<Shape> shape, std::unique_ptr<Light> light) {
    ASSERT_TRUE(light) << text << "\n" << diagnostics.format();
    light->prepare(BOUNDS);
    uses.push_back({std::move(text), std::move(shape), std::move(light)});
  };
  for (const auto& entry : plugIns().lights.entries())
    for (const std::string& example : entry.examples)
      add(entry.name + " " + example, nullptr,
          plugIns().lights.make(parseParameterText(entry.name, example), LightContext{placed}, diagnostics));
  const std::tuple<const char*, const char*, Mat4d> shapes[] = {
      {"sphere", "\"float radius\" .3", placed},
      {"sphere", "\"float radius\" .3", stretched},
      {"disk", "\"float radius\" .4", placed},
      {"trianglemesh", "\"integer indices\" [0 1 2 2 1 3] \"point3 P\" [0 0 0  1 0 0  0 .7 0  1 1 .3]",
       placed},
      {"bilinearmesh", "\"point3 P\" [0 0 0  1 0 .3  0 1 .4  1.2 1.1 -.2]", placed},
  };
  for (const auto& entry : plugIns().areaLights.entries())
    for (const std::string& example : entry.examples)
      for (const auto& [name, parameters, place] : shapes) {
        auto shape =
            plugIns().shapes.make(parseParameterText(name, parameters), ShapeContext{place}, diagnostics);
        ASSERT_TRUE(shape);
        auto light =
            plugIns().areaLights.make(parseParameterText(entry.name, example), {*shape}, diagnostics);
        add(entry.name + " " + example + " on " + name, std::move(shape), std::move(light));
      }
}

const std::vector<LightUse>& everyLight() {
  static const std::vector<LightUse> ALL = [] {
    std::vector<LightUse> uses;
    makeEveryLight(uses);
    return uses;
  }();
  return ALL;
}

LeRandom leRandom(uint32_t index) {
  Sampler sampler(1, 2, index);
  const float pick = sampler.next1D();
  const Vec2f position = sampler.next2D();
  return {pick, position, sampler.next2D()};
}

/** Mean of the added values, with its standard error. */
class Mean {
 public:
  void add(double x) {
    ++count;
    const double d = x - mean;
    mean += d / count;
    squares += d * (x - mean);
  }
  double value() const { return mean; }
  double error() const { return std::sqrt(squares) / count; }

 private:
  double count = 0, mean = 0, squares = 0;
};

} // namespace

TEST(Lights, EmittedRaysHaveTheDensitiesThatAreToldOfThem) {
  for (const LightUse& light : everyLight()) {
    int sampled = 0;
    for (uint32_t i = 0; i < 2000; ++i) {
      const auto s = light->sampleLe(leRandom(i));
      if (!s) continue;
      ++sampled;
      const LePdf told = light->pdfLe(*s);
      ASSERT_EQ(told.deltaPosition, light->kind() == LightKind::POINT) << light.text;
      ASSERT_EQ(told.deltaDirection, light->kind() == LightKind::DISTANT) << light.text;
      if (told.deltaPosition) {
        ASSERT_EQ(told.position, 0) << light.text;
        ASSERT_EQ(s->pdfPosition, 1) << light.text;
      } else {
        ASSERT_NEAR(told.position / s->pdfPosition, 1, 1e-3) << light.text;
      }
      if (told.deltaDirection) {
        ASSERT_EQ(told.direction, 0) << light.text;
        ASSERT_EQ(s->pdfDirection, 1) << light.text;
      } else {
        ASSERT_NEAR(told.direction, s->pdfDirection, 1e-3f * s->pdfDirection + 1e-5f) << light.text;
      }
      ASSERT_NEAR(glm::length(s->direction), 1, 1e-5) << light.text;
      const bool surface = light->kind() == LightKind::AREA;
      ASSERT_NEAR(glm::length(s->normal), surface ? 1 : 0, 1e-5) << light.text;
      const float cosine = surface ? absDot(s->normal, s->direction) : 1;
      const Rgb product = s->flux * (s->pdfPosition * s->pdfDirection), expected = s->radiance * cosine;
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(product[c], expected[c], 1e-4f * (expected[c] + s->flux[c] * s->pdfPosition))
            << light.text;
    }
    EXPECT_GT(sampled, 1000) << light.text;
  }
}

TEST(Lights, NumbersAtTheEndsOfTheirRangeStartNoRayOfDensityZero) {
  const float ends[] = {0, 0.25f, 0.5f, 0.75f, ONE_MINUS_EPSILON};
  for (const LightUse& light : everyLight())
    for (const float pick : ends)
      for (const float x : ends)
        for (const float y : ends)
          for (const float u : ends)
            for (const float v : ends) {
              const auto s = light->sampleLe({pick, {x, y}, {u, v}});
              if (!s || isBlack(s->flux)) continue;
              const auto numbers = [&] {
                return light.text + " by " + std::to_string(pick) + ", " + std::to_string(x) + " " +
                       std::to_string(y) + ", " + std::to_string(u) + " " + std::to_string(v);
              };
              ASSERT_TRUE(isFinite(s->flux)) << numbers();
              ASSERT_GT(s->pdfPosition, 0) << numbers();
              ASSERT_GT(s->pdfDirection, 0) << numbers();
            }
}

/** Radiance of an area light in a second direction from the position of a sample. */
static Rgb elsewhere(const LightUse& light, const LeSample& sample, const Vec3f& direction) {
  const auto& area = dynamic_cast<const AreaLight&>(*light.light);
  SurfacePoint point;
  point.position = sample.origin;
  point.geometricNormal = point.shadingNormal = sample.normal;
  point.uv = {.5f, .5f}; // any point of a picture
  return sample.radiance *
         (luminance(area.radiance(point, direction)) / luminance(area.radiance(point, sample.direction)));
}

TEST(Lights, RadianceIsToldForOtherDirections) {
  for (const LightUse& light : everyLight()) {
    if (light.light->isInfinite()) continue;
    int compared = 0;
    for (uint32_t i = 0; i < 1000; ++i) {
      LeRandom numbers = leRandom(i);
      const auto one = light->sampleLe(numbers);
      numbers.direction = leRandom(i + 1000).direction;
      const auto other = light->sampleLe(numbers);
      if (!one || !other) continue;
      // For a sphere the position depends on the direction as well; for area lights the directions are
      // compared at the same point.
      const bool isSurface = light->kind() == LightKind::AREA;
      if (isSurface ? glm::dot(one->normal, other->direction) <= 0
                    : glm::distance(one->normal, other->normal) > 1e-3f)
        continue;
      ++compared;
      const Rgb told = light->radianceTowards(*one, other->direction);
      const Rgb expected = isSurface ? elsewhere(light, *one, other->direction) : other->radiance;
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(told[c], expected[c], 2e-3f * maxComponent(expected)) << light.text;
    }
    EXPECT_GT(compared, 300) << light.text;
  }
}

TEST(Lights, DensitiesOfEmissionIntegrateToOne) {
  for (const LightUse& light : everyLight()) {
    const int n = light.shape ? 256 : 512; // strata along the axis and around it
    const auto start = light->sampleLe(leRandom(7));
    ASSERT_TRUE(start) << light.text;
    double directions = 0;
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < n; ++k) {
        LeRay ray = *start;
        ray.direction = uniformSphere((Vec2f(i, k) + 0.5f) / float(n));
        directions += double(light->pdfLe(ray).direction) * 4 * M_PI / (double(n) * n);
      }
    if (light->kind() != LightKind::DISTANT) {
      EXPECT_NEAR(directions, 1, 5e-3) << light.text;
    }
    if (light->kind() == LightKind::POINT) continue;
    // The area is the mean of 1 / density over sampled points.
    Mean area;
    for (uint32_t i = 0; i < 20000; ++i)
      if (const auto s = light->sampleLe(leRandom(i))) area.add(1 / double(s->pdfPosition));
    const double expected =
        light.light->isInfinite() ? M_PI * square(double(BOUNDS.radius)) : double(light.shape->area());
    EXPECT_NEAR(area.value(), expected, 4 * area.error() + 1e-4 * expected) << light.text;
  }
}

TEST(Lights, MeanFluxOfPhotonsIsThePower) {
  for (const LightUse& light : everyLight()) {
    Mean flux[3];
    for (uint32_t i = 0; i < 20000; ++i) {
      const auto s = light->sampleLe(leRandom(i));
      for (int c = 0; c < 3; ++c) flux[c].add(s ? double(s->flux[c]) : 0);
    }
    const Rgb power = light->power();
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(flux[c].value(), double(power[c]), 4 * flux[c].error() + 1e-4 * double(power[c]))
          << light.text;
  }
}

TEST(Lights, DirectionsTowardsLightsHaveTheDensitiesThatAreToldOfThem) {
  const Vec3f from(0.75f, 0.5f, -1);
  for (const LightUse& light : everyLight())
    for (uint32_t i = 0; i < 1000; ++i) {
      const LeRandom u = leRandom(i);
      const auto s = light->sampleLi(from, u.pick, u.position);
      if (!s) continue;
      ASSERT_NEAR(glm::length(s->direction), 1, 1e-5) << light.text;
      ASSERT_EQ(s->unhittable, light->isDelta()) << light.text;
      ASSERT_EQ(s->distance == INFINITE, light.light->isInfinite()) << light.text;
      if (!light.light->isInfinite()) {
        ASSERT_NEAR(glm::distance(from + s->direction * s->distance, s->target), 0, 1e-4) << light.text;
      }
      if (light.light->isInfinite()) { // a ray of the light through the point
        const LePdf told = light->pdfLe(s->emitted()),
                    expected = light->pdfLe({from + s->direction, -s->direction});
        ASSERT_NEAR(told.position, expected.position, 1e-3f * expected.position) << light.text;
        ASSERT_EQ(told.direction, expected.direction) << light.text;
      }
      if (const auto* area = dynamic_cast<const AreaLight*>(light.light.get())) {
        SurfacePoint point;
        point.position = s->target;
        point.geometricNormal = s->normal;
        ASSERT_NEAR(area->pdfLi(from, s->primitive, point) / s->pdf, 1, 1e-2) << light.text;
      } else if (const auto* sky = dynamic_cast<const EnvironmentLight*>(light.light.get())) {
        ASSERT_NEAR(sky->pdfLi(from, s->direction) / s->pdf, 1, 1e-3) << light.text;
        for (int c = 0; c < 3; ++c)
          ASSERT_NEAR(sky->radiance(s->direction)[c], s->radiance[c], 1e-3f * (1 + s->radiance[c]))
              << light.text;
      } else {
        ASSERT_EQ(s->pdf, 1) << light.text;
      }
    }
}

/** Flux onto a disc by the forward pass is equal to the flux by the backward pass. */
TEST(Lights, PhotonsBringWhatIsSampledTowardsTheLight) {
  constexpr float RADIUS = 0.6f;
  for (const LightUse& light : everyLight()) {
    Vec3f center(0.75f, 0.5f, -1);
    if (!light.light->isInfinite()) { // the light may be directional
      const auto s = light->sampleLe(leRandom(3));
      ASSERT_TRUE(s) << light.text;
      center = s->origin + s->direction * 1.25f;
    }
    const Frame frame(glm::normalize(Vec3f(0.4f, -0.5f, 1)));
    // A closed surface may occlude itself.
    const auto blocked = [&](const Vec3f& origin, const Vec3f& direction, float distance) {
      return light.shape && !light.shape->triangleMesh() &&
             light.shape->intersect(0, origin, direction, 0, distance);
    };
    // Compensated sampling of environments leaves the darker part to uniform sampling.
    const auto* sky = dynamic_cast<const EnvironmentLight*>(light.light.get());
    constexpr float UNIFORM = 1 / (4 * PI);
    Mean photons, sampled;
    for (uint32_t i = 0; i < 100000; ++i) {
      const LeRandom u = leRandom(i);
      const Vec2f on = uniformDisk(u.direction) * RADIUS;
      const Vec3f point = center + frame.x * on.x + frame.y * on.y;
      const auto l = light->sampleLi(point, u.pick, u.position);
      const bool sees = l && !blocked(l->target, -l->direction, l->distance);
      double brought = 0;
      if (sees)
        brought =
            double(luminance(l->radiance) * absDot(l->direction, frame.z) / (l->pdf + (sky ? UNIFORM : 0)));
      if (sky) {
        const Vec3f d = uniformSphere(leRandom(i + 1000000).direction);
        brought +=
            double(luminance(sky->radiance(d)) * absDot(d, frame.z) / (sky->pdfLi(point, d) + UNIFORM));
      }
      sampled.add(brought * M_PI * square(double(RADIUS)));
      const auto s = light->sampleLe(u);
      const float t = s ? glm::dot(center - s->origin, frame.z) / glm::dot(s->direction, frame.z) : -1;
      const bool arrives = t > 0 && glm::distance(s->origin + s->direction * t, center) < RADIUS &&
                           !blocked(s->origin, s->direction, t);
      photons.add(arrives ? double(luminance(s->flux)) : 0);
    }
    EXPECT_NEAR(photons.value(), sampled.value(),
                4 * std::hypot(photons.error(), sampled.error()) + 1e-4 * sampled.value())
        << light.text;
    EXPECT_LT(photons.error(), 0.1 * photons.value()) << light.text; // the disc receives light
  }
}

// The cosine of the half-angle of such cones is 1 in single precision.
TEST(Spot, RaysOfTheNarrowestConesArriveAtTheFullIntensity) {
  constexpr uint32_t COUNT = 4000;
  for (const double angle : {0.001, 0.02}) {
    Diagnostics diagnostics;
    const auto light = plugIns().lights.make(
        parseParameterText("spot",
                           "\"point3 from\" [.2 .3 .1] \"point3 to\" [-.5 1 .7] \"float coneangle\" " +
                               std::to_string(angle) + " \"float conedeltaangle\" 0"),
        LightContext{Mat4d(1)}, diagnostics);
    ASSERT_TRUE(light) << diagnostics.format();
    light->prepare(BOUNDS);
    const double opening = 2 * square(std::sin(glm::radians(angle) / 2));
    EXPECT_NEAR(light->power().r / (2 * M_PI * opening), 1, 1e-5) << angle;
    uint32_t lit = 0, dense = 0;
    for (uint32_t i = 0; i < COUNT; ++i) {
      const auto photon = light->sampleLe(leRandom(i));
      ASSERT_TRUE(photon) << angle;
      ASSERT_GT(photon->pdfDirection, 0) << angle;
      dense += light->pdfLe(*photon).direction == photon->pdfDirection;
      const auto arrives = light->sampleLi(photon->origin + photon->direction, 0, Vec2f(0.5f));
      lit += arrives && std::abs(arrives->radiance.r - 1) < 1e-4f;
    }
    // Rounding moves directions by a hundredth of the narrower cone.
    EXPECT_GT(lit, COUNT * 49 / 50) << angle;
    EXPECT_GT(dense, COUNT * 49 / 50) << angle;
    LeRandom edge;
    edge.direction = Vec2f(std::nextafter(1.0f, 0.0f), 0.3f);
    const auto photon = light->sampleLe(edge);
    ASSERT_TRUE(photon) << angle;
    EXPECT_GT(photon->pdfDirection, 0) << angle;
  }
}

TEST(DiffuseLight, ExponentGivesAPowerOfTheCosine) {
  Diagnostics diagnostics;
  const auto disc = plugIns().shapes.make(parseParameterText("disk", "\"float radius\" 2"), {}, diagnostics);
  const auto make = [&](const std::string& parameters) {
    auto light = plugIns().areaLights.make(parseParameterText("diffuse", parameters), {*disc}, diagnostics);
    EXPECT_TRUE(light) << diagnostics.format();
    return light;
  };
  const SurfacePoint point = disc->sampleArea(.5f, {.3f, .6f}).point;
  for (const double n : {0.0, .5, 1.0, 7.0, 500.0, 1e4}) {
    const std::string exponent = " \"float exponent\" " + std::to_string(n);
    const auto one = make("\"rgb L\" [3 2 1]" + exponent),
               both = make("\"rgb L\" [3 2 1] \"bool twosided\" true" + exponent),
               scaled = make("\"float power\" 10" + exponent);
    const double integral = 2 * M_PI / (n + 2), area = 4 * M_PI;
    EXPECT_NEAR(double(one->power().r), 3 * integral * area, 1e-5 * 3 * integral * area) << n;
    EXPECT_NEAR(double(both->power().g), 2 * 2 * integral * area, 1e-5 * 4 * integral * area) << n;
    EXPECT_NEAR(double(luminance(scaled->power())), 10, 1e-4) << n;
    for (const double cosine : {.02, .3, .9, .9999, 1.0}) {
      const auto sine = static_cast<float>(std::sqrt(1 - cosine * cosine));
      const Vec3f up(sine, 0, static_cast<float>(cosine)), down(sine, 0, -up.z);
      const double expected = 3 * std::pow(double(up.z), n);
      EXPECT_NEAR(double(one->radiance(point, up).r), expected, 1e-3 * expected + 1e-30) << n;
      EXPECT_TRUE(isBlack(one->radiance(point, down))) << n;
      EXPECT_EQ(both->radiance(point, down), both->radiance(point, up)) << n;
      // The density of photons is proportional to radiance times cosine.
      const LeRay ray{point.position, up, point.geometricNormal};
      EXPECT_NEAR(double(one->pdfLe(ray).direction), expected / 3 * double(up.z) / integral,
                  1e-3 * expected / integral + 1e-30)
          << n;
      EXPECT_EQ(both->pdfLe(ray).direction, one->pdfLe(ray).direction / 2) << n;
    }
    for (uint32_t i = 0; i < 1000; ++i) {
      const auto s = one->sampleLe(leRandom(i));
      if (!s) continue;
      EXPECT_NEAR(double(s->flux.r), double(one->power().r), 1e-4 * double(one->power().r)) << n;
    }
  }
  // The exponent 0 has the same bits as no exponent.
  const auto plain = make("\"rgb L\" [3 2 1]"), zero = make("\"rgb L\" [3 2 1] \"float exponent\" 0");
  for (uint32_t i = 0; i < 1000; ++i) {
    const auto a = plain->sampleLe(leRandom(i)), b = zero->sampleLe(leRandom(i));
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->direction, b->direction);
    EXPECT_EQ(a->radiance, Rgb(3, 2, 1));
    EXPECT_EQ(a->pdfDirection, std::max(cosineHemisphere(leRandom(i).direction).z, 0.0f) * INV_PI);
    EXPECT_EQ(b->pdfDirection, a->pdfDirection);
    EXPECT_EQ(b->flux, a->flux);
  }
}

TEST(DiffuseLight, BadExponentsAreRefused) {
  Diagnostics diagnostics;
  const auto disc = plugIns().shapes.make(parseParameterText("disk", ""), {}, diagnostics);
  for (const char* exponent : {"-1", "1e5"})
    EXPECT_FALSE(plugIns().areaLights.make(
        parseParameterText("diffuse", "\"float exponent\" " + std::string(exponent)), {*disc}, diagnostics));
  EXPECT_NE(diagnostics.format().find("exponent"), std::string::npos) << diagnostics.format();
}

TEST(Lights, PowerOfAShapeWithoutAreaIsRefusedForThatReason) {
  Diagnostics diagnostics;
  const auto line = plugIns().shapes.make(
      parseParameterText("trianglemesh", "\"integer indices\" [0 1 2] \"point3 P\" [0 0 0  1 1 1  2 2 2]"),
      ShapeContext{Mat4d(1)}, diagnostics);
  ASSERT_TRUE(line) << diagnostics.format();
  const auto make = [&](const char* parameters) {
    return plugIns().areaLights.make(parseParameterText("diffuse", parameters), {*line}, diagnostics);
  };
  EXPECT_TRUE(make("\"rgb L\" [1 1 1]"));
  EXPECT_FALSE(make("\"float power\" 10"));
  EXPECT_NE(diagnostics.format().find("no area"), std::string::npos) << diagnostics.format();
}
