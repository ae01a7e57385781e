/** @file
 * Sampling of light along rays through media: densities against sampled distances, and the light of lamps
 * against its integral along the ray.
 */
#include "transport/direct/lightAlongRay.h"
#include "transport/rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Expects that the density is that of the samples `sampleAt(i)`, by their fractions in equal parts of [0,
 * end]. */
template <class Distance, class SampleAt>
void expectDensityOfSamples(const Distance& distance, float end, SampleAt&& sampleAt,
                            const std::string& what) {
  constexpr int N = 20000, PARTS = 16;
  constexpr int STEPS = 200000;
  std::array<double, PARTS> sampled{}, expected{};
  for (int i = 0; i < N; ++i) {
    const float t = sampleAt(i);
    ASSERT_TRUE(t >= 0 && t <= end) << what << " " << t;
    sampled[std::min(PARTS - 1, int(t / end * PARTS))] += 1.0 / N;
  }
  for (int i = 0; i < STEPS; ++i)
    expected[size_t(i) * PARTS / STEPS] += double(distance.pdf(float((i + 0.5) / STEPS) * end) * end) / STEPS;
  double sum = 0;
  for (int p = 0; p < PARTS; ++p) {
    EXPECT_NEAR(sampled[p], expected[p], 5 * std::sqrt(expected[p] / N) + 1e-4) << what << " part " << p;
    sum += expected[p];
  }
  EXPECT_NEAR(sum, 1, 1e-3) << what;
}

/** A room of fog, seen along its middle, with the lamp. */
std::string fogWith(const std::string& lamp) {
  return "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [.1 .05 .02] "
         "\"rgb sigma_s\" [.1 .15 .2] \"float g\" .6\nMediumInterface \"\" \"fog\"\n" +
         view(1, "0 0 0  0 0 1  0 1 0", 1) + "MediumInterface \"fog\" \"fog\"\n" + lamp;
}

} // namespace

TEST(LightAlongRay, DistancesFollowTheirDensities) {
  Sampler sampler(1, 2, 0);
  for (const float end : {0.5f, 10.0f}) {
    const TransmittanceDistance open({0.3f, 0, 2}, end);
    expectDensityOfSamples(
        open, end, [&](int) { return open.sample(sampler.next1D(), sampler.next1D()); }, "transmittance");
    // Lamps before the start of the ray, beside it, and behind its end.
    for (const Vec3f& lamp : {Vec3f(0.1f, 0, -0.3f), Vec3f(0, 0.05f, 0.25f), Vec3f(1, 1, 12)}) {
      const EquiangularDistance near({Vec3f(0), Vec3f(0, 0, 1)}, end, lamp);
      ASSERT_TRUE(near.usable());
      expectDensityOfSamples(
          near, end, [&](int) { return std::min(near.sample(sampler.next1D()), end); }, "equiangular");
    }
  }
  EXPECT_FALSE(EquiangularDistance({Vec3f(0), Vec3f(0, 0, 1)}, 4, {0, 0, 2}).usable());
  const TransmittanceDistance endless({1, 1, 1}, INFINITE);
  EXPECT_NEAR(endless.pdf(2), std::exp(-2), 1e-6);
}

TEST(LightAlongRay, IsTheLightOfLampsWithLittleVariance) {
  struct Case {
    std::string lamp;
    double variance; ///< upper bound of the relative variance of one sample
  };
  // With sampling by transmittance alone, lamps near the ray have a relative variance of 30 and more.
  const std::vector<Case> cases = {
      {"LightSource \"point\" \"point3 from\" [.05 0 3]", 0.05},
      {"LightSource \"spot\" \"point3 from\" [1 0 8] \"point3 to\" [0 0 4] \"float coneangle\" 10", 0.05},
      {"LightSource \"distant\" \"point3 from\" [1 1 0]", 0.1},
      {"LightSource \"point\" \"point3 from\" [.05 0 3] LightSource \"point\" \"point3 from\" [0 2 7]", 2},
  };
  const float end = 10;
  for (const Case& c : cases) {
    const auto scene = sceneFrom(fogWith(c.lamp));
    const Medium& medium = *scene->medium(scene->cameraMedium());
    const Ray ray{Vec3f(0), Vec3f(0, 0, 1)};
    const Rgb extinction = medium.at(ray.origin).extinction();
    const auto brought = [&](float t, const LiSample& light) {
      return double(luminance(light.radiance * flight::transmittance(extinction, t)) *
                    medium.phase->value(glm::dot(light.direction, ray.direction)));
    };
    double truth = 0;
    constexpr int STEPS = 100000;
    for (int i = 0; i < STEPS; ++i) {
      const float t = (float(i) + 0.5f) / STEPS * end;
      for (size_t l = 0; l < scene->lights().size(); ++l)
        if (const auto light = scene->lights()[l].sampleLiAt(0, pointInMedium(ray, t).position, 0.5f, {}))
          truth += brought(t, *light) / double(light->pdf) * double(end) / STEPS;
    }
    LightSampler guide;
    std::vector<double> values;
    for (uint32_t i = 0; i < 40000; ++i) {
      Sampler sampler(7, i, 0);
      const auto s = sampleLightAlong(*scene, guide, medium, ray, end, {}, 0, sampler);
      values.push_back(s ? brought(s->t, s->light) * double(s->reciprocalPdf) : 0);
    }
    const Mean mean(values);
    EXPECT_NEAR(mean.value, truth, 4.5 * mean.error) << c.lamp;
    EXPECT_LT(square(mean.error / truth) * double(values.size()), c.variance) << c.lamp;
  }
}

TEST(LightAlongRay, SeveralRaysFindTheSameLightOfAShaftWithLessVariance) {
  // The lamps light a tenth of the ray. The panel always gets one ray, whatever the number for the delta
  // lights.
  const std::string panel = "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [.5 .5 .5]\nTranslate 0 3 "
                            "4\nShape \"sphere\" \"float radius\" .5\nAttributeEnd\n";
  const std::string sun = "LightSource \"distant\" \"point3 from\" [1 1 0]\n";
  const std::string spot = "LightSource \"spot\" \"point3 from\" [1 0 8] \"point3 to\" [0 0 4]\n";
  const float end = 10, shaftBegin = 4, shaftEnd = 5;
  struct Case {
    std::string lamps;
    double gain; ///< lower bound of the ratio of variances, one ray over four rays
  };
  // Independent rays would gain a factor of four.
  for (const Case& c : {Case{sun, 4.5}, Case{spot, 3}, Case{sun + panel, 1}, Case{panel, 0.8}}) {
    const auto scene = sceneFrom(fogWith(c.lamps));
    const Medium& medium = *scene->medium(scene->cameraMedium());
    const Ray ray{Vec3f(0), Vec3f(0, 0, 1)};
    const Rgb extinction = medium.at(ray.origin).extinction();
    const LightSampler guide;
    const auto found = [&](const RaysToLights& rays, uint64_t seed) {
      std::vector<double> values;
      for (uint32_t i = 0; i < 20000; ++i) {
        Sampler sampler(seed, i, 0);
        values.push_back(0);
        for (int which = 0; which < rays.others; ++which) {
          const auto s = sampleLightAlong(*scene, guide, medium, ray, end, rays, which, sampler);
          if (s && s->t > shaftBegin && s->t < shaftEnd)
            values.back() +=
                double(luminance(s->light.radiance * flight::transmittance(extinction, s->t)) *
                       medium.phase->value(glm::dot(s->light.direction, ray.direction)) * s->reciprocalPdf);
        }
      }
      return Mean(values);
    };
    const Mean one = found({1, 1}, 7), four = found({1, 4}, 8);
    EXPECT_NEAR(four.value, one.value, 4.5 * std::hypot(one.error, four.error)) << c.lamps;
    EXPECT_GT(square(one.error / four.error), c.gain) << c.lamps;
  }
}

TEST(LightAlongRay, RaysPastALampOrOntoItHaveLittleVariance) {
  // A square lamp of side .02, three units away along the ray, which grazes it or ends on it.
  constexpr double SIDE = 0.02, AWAY = 3, GAP = 1e-3;
  struct Case {
    std::string what, corners;
    Vec3d center, acrossX, acrossY, normal;
    float end;
  };
  const std::vector<Case> cases = {
      {"past it",
       "-.01 -.001 2.99  -.01 -.001 3.01  .01 -.001 3.01  .01 -.001 2.99",
       {0, -GAP, AWAY},
       {SIDE, 0, 0},
       {0, 0, SIDE},
       {0, 1, 0},
       10},
      {"onto it",
       "-.01 -.01 3  -.01 .01 3  .01 .01 3  .01 -.01 3",
       {0, 0, AWAY},
       {SIDE, 0, 0},
       {0, SIDE, 0},
       {0, 0, -1},
       static_cast<float>(AWAY)},
  };
  for (const Case& c : cases) {
    const auto scene = sceneFrom(fogWith(
        "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\nShape \"trianglemesh\" "
        "\"integer indices\" [0 1 2 0 2 3] \"point3 P\" [" +
        c.corners + "]\nAttributeEnd\nShape \"sphere\" \"float radius\" 20\n")); // the sphere keeps the
                                                                                 // scene's origin in place
    const Medium& medium = *scene->medium(scene->cameraMedium());
    const Ray ray{Vec3f(0), Vec3f(0, 0, 1)};
    const Rgb extinction = medium.at(ray.origin).extinction();
    // Reference by quadrature over points of the lamp, and over distances along the ray at equal angles from
    // each point.
    double truth = 0;
    constexpr int POINTS = 100, ANGLES = 200;
    for (int i = 0; i < POINTS * POINTS; ++i) {
      const Vec3d point = c.center + c.acrossX * ((i % POINTS + 0.5) / POINTS - 0.5) +
                          c.acrossY * ((i / POINTS + 0.5) / POINTS - 0.5);
      const double away = std::hypot(point.x, point.y), begin = std::atan2(-point.z, away),
                   angle = std::atan2(double(c.end) - point.z, away) - begin;
      for (int k = 0; k < ANGLES; ++k) {
        const double t = point.z + away * std::tan(begin + angle * (k + 0.5) / ANGLES);
        const Vec3d towards = point - Vec3d(0, 0, t);
        const double cosine = -glm::dot(towards, c.normal) / glm::length(towards);
        if (cosine > 0)
          truth += cosine * angle / away *
                   double(luminance(flight::transmittance(extinction, float(t))) *
                          medium.phase->value(float(towards.z / glm::length(towards))));
      }
    }
    truth *= SIDE * SIDE / (double(POINTS) * POINTS * ANGLES);
    std::vector<double> values;
    for (uint32_t i = 0; i < 40000; ++i) {
      Sampler sampler(7, i, 0);
      const auto s = sampleLightAlong(*scene, {}, medium, ray, c.end, {}, 0, sampler);
      values.push_back(s ? double(luminance(s->light.radiance * flight::transmittance(extinction, s->t)) *
                                  medium.phase->value(glm::dot(s->light.direction, ray.direction)) *
                                  s->reciprocalPdf)
                         : 0);
    }
    const Mean mean(values);
    EXPECT_NEAR(mean.value, truth, 4.5 * mean.error + 0.01 * truth) << c.what;
    EXPECT_LT(square(mean.error / truth) * double(values.size()), 5) << c.what;
    EXPECT_LT(*std::max_element(values.begin(), values.end()) / truth, 500) << c.what;
  }
}
