/** @file
 * Mixtures of emission: fluxes against closed forms before and after learning, selection of lights, caustics.
 */
#include "transport/emission/emissionMixture.h"
#include "transport/rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** A ball on a small floor. */
std::string ballOnFloor(int size, const std::string& lights) {
  return view(size, "0 -3 2  0 0 .2  0 0 1", 40) + "AttributeBegin\n" + lights + R"(
AttributeEnd
Material "diffuse" "rgb reflectance" [ .5 .5 .5 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 -2 0  2 -2 0  2 2 0  -2 2 0 ]
Material "dielectric"
Translate 0 0 .6
Shape "sphere" "float radius" .5
)";
}

/** Sixty units from the ball. */
const std::string FAR_AWAY = "Translate 20 -30 48\n";
const std::string FAR_LAMPS[] = {
    FAR_AWAY + "LightSource \"point\" \"rgb I\" [ 9 8 7 ]",
    FAR_AWAY + "LightSource \"spot\" \"rgb I\" [ 9 8 7 ] \"point3 to\" [ -20 30 -47 ] \"float coneangle\" 40",
    FAR_AWAY + "AreaLightSource \"diffuse\" \"rgb L\" [ 9 8 7 ] Shape \"sphere\" \"float radius\" 2",
    FAR_AWAY + "AreaLightSource \"diffuse\" \"rgb L\" [ 9 8 7 ] \"float exponent\" 2 Shape \"sphere\" "
               "\"float radius\" 2",
    FAR_AWAY + "AreaLightSource \"diffuse\" \"rgb L\" [ 9 8 7 ] \"bool twosided\" true Shape \"disk\" "
               "\"float radius\" 2"};

EmissionMixture mixtureOf(const Scene& scene) {
  TransportCounts counts;
  return EmissionMixture(scene, 1, counts);
}

std::optional<LeSample> emitted(const EmissionMixture& mixture, const Light& light, uint32_t i) {
  Sampler sampler(7, 0, i);
  LeRandom start;
  start.pick = sampler.next1D();
  start.position = sampler.next2D();
  start.direction = sampler.next2D();
  std::optional<LeSample> sample = light.sampleLe(start);
  const float pick = sampler.next1D();
  if (sample) mixture.redirect(0, *sample, pick, sampler.next2D());
  return sample;
}

const Vec3f BALL(0, 0, 0.6f);

bool hitsBall(const LeRay& ray) {
  const Vec3f way = BALL - ray.origin;
  const float along = glm::dot(way, ray.direction);
  return along > 0 && lengthSquared(way) - square(along) < square(0.5f);
}

/** Flux of a light towards the ball by shadow rays from its centre; for a distant light it is irradiance
 * times cross section. */
Mean fluxByShadowRays(const Light& light) {
  std::vector<double> arriving(1000);
  for (uint32_t i = 0; i < arriving.size(); ++i) {
    Sampler sampler(8, 0, i);
    const float pick = sampler.next1D();
    const auto li = light.sampleLi(BALL, pick, sampler.next2D());
    if (li) arriving[i] = double(li->radiance.r / li->pdf) * M_PI * 0.25;
  }
  return Mean(arriving);
}

/** Flux of many samples in all, and flux that reaches the ball. */
struct Emission {
  static constexpr uint32_t N = 100000;
  std::vector<double> all = std::vector<double>(N), toBall = std::vector<double>(N);
  double secondMoment = 0; ///< second moment of the flux to the ball
  int met = 0, otherwise = 0;

  Emission(const EmissionMixture& mixture, const Light& light, EmissionMixture::Moments& moments) {
    for (uint32_t i = 0; i < N; ++i) {
      const auto sample = emitted(mixture, light, i);
      if (!sample || isBlack(sample->flux)) continue;
      otherwise += std::abs(mixture.pdfLe(0, *sample).direction / sample->pdfDirection - 1) > 1e-3f;
      all[i] = double(sample->flux.r);
      if (!hitsBall(*sample)) continue;
      toBall[i] = all[i];
      secondMoment += square(all[i]);
      moments.add(0, *sample, square(all[i]));
      ++met;
    }
  }
};

} // namespace

TEST(EmissionMixture, KeepsTheFluxOfALampWhateverIsLearned) {
  for (const std::string& lamp : FAR_LAMPS) {
    const auto scene = sceneFrom(ballOnFloor(16, lamp));
    ASSERT_TRUE(scene);
    EmissionMixture mixture = mixtureOf(*scene);
    ASSERT_TRUE(mixture.active()) << lamp;
    EXPECT_TRUE(mixture.isFar(0)) << lamp;
    const Light& light = scene->lights()[0];
    const Mean expected = fluxByShadowRays(light);
    const auto power = double(light.power().r);
    double before = 0;
    for (int round = 0; round < 3; ++round) {
      EmissionMixture::Moments moments(mixture);
      const Emission e(mixture, light, moments);
      EXPECT_LT(e.otherwise, int(Emission::N) / 5000) << lamp; // on the edge of a cone, up to rounding
      const Mean flux(e.all), toBall(e.toBall);
      EXPECT_NEAR(flux.value / power, 1, 4 * flux.error / power) << lamp;
      EXPECT_NEAR(toBall.value, expected.value, 4 * (toBall.error + expected.error) + 2e-3 * expected.value)
          << lamp;
      EXPECT_GT(e.met, int(Emission::N) / 100) << lamp;
      if (round == 0) before = e.secondMoment;
      if (round == 2) {
        EXPECT_LT(e.secondMoment, before / 1.5) << lamp;
      }
      mixture.adapt(moments);
    }
  }
}

TEST(EmissionMixture, APortalIsPartOfTheDensityOfReplacedOrigins) {
  // The portal is above a part of the floor only.
  const auto scene =
      sceneFrom(ballOnFloor(16, "LightSource \"infinite\" \"rgb L\" [ 1 1 1 ] \"point3 portal\" "
                                "[ -1 -1 2  0 -1 2  0 1 2  -1 1 2 ]"));
  ASSERT_TRUE(scene);
  const EmissionMixture mixture = mixtureOf(*scene);
  ASSERT_TRUE(mixture.active());
  const Light& light = scene->lights()[0];
  std::vector<double> fluxes;
  for (uint32_t i = 0; i < 20000; ++i) {
    const auto sample = emitted(mixture, light, i);
    fluxes.push_back(sample && hitsBall(*sample) ? double(sample->flux.r) : 0);
    if (!sample || isBlack(sample->flux)) continue;
    EXPECT_NEAR(mixture.pdfLe(0, *sample).position / sample->pdfPosition, 1, 1e-3);
    EXPECT_NEAR(sample->radiance.r / (sample->pdfPosition * sample->pdfDirection) / sample->flux.r, 1, 1e-3);
  }
  // A sky of radiance 1 all around.
  const Mean flux(fluxes);
  EXPECT_NEAR(flux.value, M_PI * 4 * M_PI * 0.25, 4 * flux.error);
  EXPECT_LT(flux.error, 0.03 * flux.value);
}

TEST(EmissionMixture, ALampInARoomIsNotFar) {
  const auto scene = sceneFrom(litCorner(16));
  ASSERT_TRUE(scene);
  EXPECT_FALSE(mixtureOf(*scene).isFar(0));
}

TEST(EmissionMixture, ChoosesLightsByWhatTheyBring) {
  const auto scene = sceneFrom(ballOnFloor(16, "LightSource \"point\" \"rgb I\" [ 1000 1000 1000 ] "
                                               "Translate 0 0 3 LightSource \"point\" \"rgb I\" [ 1 1 1 ]"));
  ASSERT_TRUE(scene);
  EmissionMixture mixture = mixtureOf(*scene);
  ASSERT_TRUE(mixture.active());
  // Half of the photons select their light by power, half uniformly.
  EXPECT_NEAR(mixture.lights().probability(1), 0.25f + 0.5f / 1001, 1e-4f);
  EmissionMixture::Moments moments(mixture);
  LeRay down;
  down.direction = Vec3f(0, 0, -1);
  down.origin = Vec3f(0, 0, 3);
  moments.add(1, down, 1);
  mixture.adapt(moments);
  // Only the second light has contributed; a fifth of the probabilities is not learned.
  EXPECT_NEAR(mixture.lights().probability(1), 0.8f + 0.2f * (0.25f + 0.5f / 1001), 1e-4f);
  EXPECT_NEAR(mixture.lights().probability(0) + mixture.lights().probability(1), 1, 1e-5f);
  mixture.adapt(EmissionMixture::Moments(mixture)); // moments without samples change nothing
  EXPECT_GT(mixture.lights().probability(1), 0.8f);
}

TEST(EmissionMixture, AFarSunHasTheCausticOfADistantLight) {
  // The ball has the same irradiance as in the light of a distant lamp; a sphere of small radius r at
  // distance d has L π r²/d².
  const auto render = [&](const std::string& light) {
    const std::string text = ballOnFloor(24, light);
    return renderText(text, "photonmap", "", samples(32));
  };
  const Rendered sun =
      render("Translate 400 -600 960 AreaLightSource \"diffuse\" \"rgb L\" [ 72000 72000 72000 ] "
             "Shape \"sphere\" \"float radius\" 4");
  const double irradiance = 72000 * M_PI * 16 / (400.0 * 400 + 600.0 * 600 + 960.0 * 960);
  const std::string e = std::to_string(irradiance);
  const Rendered distant = render("LightSource \"distant\" \"point3 from\" [ 400 -600 960 ] \"rgb L\" [ " +
                                  e + " " + e + " " + e + " ]");
  EXPECT_GT(sun.statistics.photonsStored, sun.statistics.photonsEmitted / 16);
  const double error = std::hypot(sun.standardError(), distant.standardError());
  EXPECT_NEAR(sun.mean() / distant.mean(), 1, 0.01 + 3 * error / distant.mean());
}

TEST(EmissionMixture, DensitiesOfEachLightIntegrateToOneWhateverIsLearned) {
  const std::string near = "Translate .4 -.5 1.6\n";
  for (const std::string& lamp :
       {near + "LightSource \"point\" \"rgb I\" [ 9 8 7 ]",
        near +
            "LightSource \"spot\" \"rgb I\" [ 9 8 7 ] \"point3 to\" [ -.4 .5 -1.6 ] \"float coneangle\" 60",
        near + "AreaLightSource \"diffuse\" \"rgb L\" [ 9 8 7 ] Shape \"sphere\" \"float radius\" .2",
        near + "AreaLightSource \"diffuse\" \"rgb L\" [ 9 8 7 ] \"bool twosided\" true Shape \"disk\" "
               "\"float radius\" .2",
        std::string("LightSource \"distant\" \"point3 from\" [ 1 -1 3 ] \"point3 to\" [ 0 0 0 ]"),
        std::string("LightSource \"infinite\" \"rgb L\" [ 3 4 5 ]")}) {
    SCOPED_TRACE(lamp);
    const auto scene = sceneFrom(ballOnFloor(16, lamp));
    ASSERT_TRUE(scene);
    EmissionMixture mixture = mixtureOf(*scene);
    ASSERT_TRUE(mixture.active());
    const Light& light = scene->lights()[0];
    const bool twoSided = lamp.find("twosided") != std::string::npos;
    const SceneBounds& bounds = scene->bounds();
    const float widest = 1.8f * bounds.radius; // corners of boxes may be outside of the bounding sphere
    for (int round = 0; round < 3; ++round) {
      constexpr uint32_t N = SANITIZED ? 20000 : 200000, STARTS = 4;
      for (uint32_t start = 0; start < STARTS; ++start) {
        const std::optional<LeSample> sample = emitted(mixture, light, start);
        ASSERT_TRUE(sample);
        std::vector<double> values(N);
        for (uint32_t i = 0; i < N; ++i) {
          Sampler sampler(9, start, i);
          LeRay ray = *sample;
          if (light.isInfinite()) { // all parallel rays of a direction that may hit the scene
            const Frame across(ray.direction);
            const Vec2f disc = uniformDisk(sampler.next2D()) * widest;
            ray.origin = bounds.center + across.toWorld({disc.x, disc.y, -widest});
            double density = double(mixture.pdfLe(0, ray).position);
            // The light's own sampling covers only the lines through the disc, with constant density;
            // subtracts it outside.
            if (glm::length(disc) > bounds.radius)
              density -= (1 - mixture.boxPart()) * double(bounds.pdfDisc());
            values[i] = density * M_PI * square(double(widest));
          } else {
            ray.direction = uniformSphere(sampler.next2D());
            const bool back = ray.normal != Vec3f(0) && glm::dot(ray.direction, ray.normal) <= 0;
            if (!back || twoSided) values[i] = double(mixture.pdfLe(0, ray).direction) * 4 * M_PI;
          }
        }
        // Cones around boxes may include directions behind an emitting surface, where samples have no flux.
        std::vector<double> behind(N);
        if (!light.isInfinite() && sample->normal != Vec3f(0))
          for (uint32_t i = 0; i < N; ++i) {
            Sampler sampler(11, start, i);
            LeSample redirected = *sample;
            if (twoSided && i % 2 == 0) redirected.normal = -redirected.normal;
            redirected.direction = redirected.normal; // as by the light's own sampling, in front
            mixture.redirect(0, redirected, sampler.next1D(), sampler.next2D());
            behind[i] = glm::dot(redirected.direction, redirected.normal) <= 0;
          }
        const Mean integral(values), lost(behind);
        EXPECT_NEAR(integral.value + lost.value, 1, 4 * (integral.error + lost.error))
            << "start " << start << ", round " << round;
        EXPECT_LT(integral.error, SANITIZED ? 0.1 : 0.03);
      }
      EmissionMixture::Moments moments(mixture);
      Sampler random(10, 0, static_cast<uint32_t>(round));
      for (uint32_t i = 0; i < 2000; ++i)
        if (const std::optional<LeSample> sample = emitted(mixture, light, i))
          moments.add(0, *sample, std::pow(10, 6 * double(random.next1D())));
      mixture.adapt(moments);
    }
  }
}
