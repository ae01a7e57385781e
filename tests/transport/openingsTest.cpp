/** @file
 * Openings for light of infinite lights: densities against closed forms, and the photons that enter.
 */
#include "transport/emission/emissionMixture.h"
#include "transport/forward/shoot.h"
#include "transport/forward/shootSettings.h"
#include "transport/roomWithHole.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

EmissionMixture mixtureOf(const Scene& scene) {
  TransportCounts counts;
  return EmissionMixture(scene, 1, counts);
}

bool entersHole(const LeSample& sample, const Vec3f& center) {
  return crossesHole(sample.origin, sample.direction, center);
}

/** Ray of a directional light, uniform over the disc of the scene. */
LeSample overDisc(const SceneBounds& bounds, const Vec3f& direction, const Vec2f& u) {
  const Vec3f across = glm::normalize(glm::cross(direction, Vec3f(1, 0, 0)));
  const float r = bounds.radius * std::sqrt(u.x), phi = 2 * PI * u.y;
  LeSample sample;
  sample.direction = direction;
  sample.origin = bounds.center - direction * bounds.radius +
                  (across * std::cos(phi) + glm::cross(direction, across) * std::sin(phi)) * r;
  sample.pdfPosition = bounds.pdfDisc();
  sample.flux = Rgb(1);
  return sample;
}

} // namespace

TEST(Openings, PhotonsFindAHoleWithoutAPane) {
  const auto scene = sceneFrom(roomWithHole(16));
  ASSERT_TRUE(scene);
  EmissionMixture mixture = mixtureOf(*scene);
  ASSERT_TRUE(mixture.active());
  const SceneBounds& bounds = scene->bounds();
  const Vec3f direction = glm::normalize(Vec3f(0.3f, -1, 0.2f));
  for (uint32_t round = 0; round < 3; ++round) { // learns which photons enter
    EmissionMixture::Moments moments(mixture);
    Sampler sampler(4, round, 0);
    for (int i = 0; i < 30000; ++i) {
      const Vec2f disc(sampler.next1D(), sampler.next1D()), u(sampler.next1D(), sampler.next1D());
      LeSample sample = overDisc(bounds, direction, disc);
      mixture.redirect(0, sample, sampler.next1D(), u);
      if (entersHole(sample, bounds.center)) moments.add(0, sample, square(double(sample.flux.r)));
    }
    mixture.adapt(moments);
  }
  Sampler sampler(3, 0, 0);
  constexpr int N = 200000;
  int inside = 0, stronger = 0;
  double sum = 0;
  for (int i = 0; i < N; ++i) {
    const Vec2f disc(sampler.next1D(), sampler.next1D()), u(sampler.next1D(), sampler.next1D());
    LeSample sample = overDisc(bounds, direction, disc);
    mixture.redirect(0, sample, sampler.next1D(), u);
    EXPECT_NEAR(bounds.pdfDisc() / mixture.pdfLe(0, sample).position, sample.flux.r, 1e-3f * sample.flux.r);
    if (!entersHole(sample, bounds.center)) continue;
    ++inside;
    sum += double(sample.flux.r) / N;
    stronger += sample.flux.r > 0.1f;
  }
  // The mean flux through the hole is the hole's fraction of the disc; uniform sampling would find a
  // twentieth of the photons.
  const double part = double(square(2 * HOLE_HALF_WIDTH) * -direction.y * bounds.pdfDisc());
  EXPECT_NEAR(sum / part, 1, 0.03);
  EXPECT_GT(inside, 20 * part * N);
  // Very few of them have a much larger flux.
  EXPECT_LT(stronger, inside / 100);
}

TEST(Openings, ARoomWithAHoleIsAsBrightAsByPaths) {
  const int count = samples(32);
  for (const std::string pane : {"", "Material \"thindielectric\" Shape \"bilinearmesh\" \"point3 P\" "
                                     "[-.25 2.55 -.25 .25 2.55 -.25 -.25 2.55 .25 .25 2.55 .25]"}) {
    const Rendered path = renderText(roomWithHole(16, pane), "path", "", 4 * count);
    const Rendered photons = renderText(roomWithHole(16, pane), "photonmap", "", count);
    const double error = std::hypot(path.standardError(), photons.standardError());
    EXPECT_NEAR(photons.mean() / path.mean(), 1, 0.02 + 3 * error / path.mean()) << pane;
    EXPECT_GT(photons.statistics.photonsStored, photons.statistics.photonsEmitted / 20);
  }
}

TEST(Openings, ASkyBesideAFarSunIsFoundToo) {
  // The sun is a ball with forty times the power of the sky, so that it gets nearly all photons before
  // learning.
  const int count = samples(32);
  const std::string sun =
      "AttributeBegin Translate 60 250 30 AreaLightSource \"diffuse\" \"rgb L\" [400 400 400] "
      "Material \"diffuse\" \"rgb reflectance\" [0 0 0] Shape \"sphere\" \"float radius\" 8 "
      "AttributeEnd";
  const Rendered path = renderText(roomWithHole(16, sun), "path", "", 8 * count);
  const Rendered photons = renderText(roomWithHole(16, sun), "photonmap", "", count);
  const double error = std::hypot(path.standardError(), photons.standardError());
  EXPECT_NEAR(photons.mean() / path.mean(), 1, 0.02 + 3 * error / path.mean());
  EXPECT_GT(photons.statistics.photonsStored, photons.statistics.photonsEmitted / 20);
}

TEST(Openings, ASkyWithASunComesInAsItDoesWithoutBoxes) {
  const std::string pool = view(16, "-3.5 2.6 -7.5  0 -.8 0  0 1 0", 8) + R"(
AttributeBegin
Rotate -90 1 0 0
LightSource "sky" "float turbidity" 3 "float elevation" 52 "float azimuth" 250 "float scale" .1
AttributeEnd
Material "diffuse" "rgb reflectance" [.6 .6 .6]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3  0 1 5 0 5 4  1 2 6 1 6 5  2 3 7 2 7 6  3 0 4 3 4 7]
  "point3 P" [-3 -1.6 -4  3 -1.6 -4  3 -1.6 4  -3 -1.6 4  -3 0 -4  3 0 -4  3 0 4  -3 0 4]
Shape "trianglemesh" "integer indices" [0 1 5 0 5 4  1 2 6 1 6 5  2 3 7 2 7 6  3 0 4 3 4 7]
  "point3 P" [-8 0 -8  8 0 -8  8 0 8  -8 0 8  -3 0 -4  3 0 -4  3 0 4  -3 0 4]
Material "dielectric" "float eta" 1.33
Shape "bilinearmesh" "point3 P" [-3 -.1 4  3 -.1 4  -3 -.1 -4  3 -.1 -4]
)";
  const auto scene = sceneFrom(pool);
  ASSERT_TRUE(scene);
  const EmissionMixture mixture = mixtureOf(*scene);
  ASSERT_TRUE(mixture.active());
  const auto powerOnTheFloor = [&](const EmissionMixture* through) {
    ShootSettings settings;
    settings.photons = 400000;
    settings.emission.mixture = through;
    double sum = 0;
    for (const Photon& p : shootPhotons(*scene, PathClasses(), Pass(), settings, ForwardControl()).onSurfaces)
      if (p.position.y - scene->bounds().center.y < -0.5f) sum += double(p.power.r);
    return sum;
  };
  EXPECT_NEAR(powerOnTheFloor(&mixture) / powerOnTheFloor(nullptr), 1, 0.03);
}

TEST(Openings, ASmallBallOfMilkOnAWideGroundGetsItsPhotons) {
  const std::string milk = view(16, "0 .3 2.2  0 .3 0  0 1 0", 14) + R"(
LightSource "infinite" "rgb L" [.6 .7 .9]
Material "diffuse" "rgb reflectance" [.4 .4 .4]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-40 0 -40  -40 0 40  40 0 40  40 0 -40]
MakeNamedMedium "milk" "string type" "homogeneous" "rgb sigma_s" [25 25 25] "rgb sigma_a" [.1 .1 .1]
  "float g" .7
MediumInterface "milk" ""
Material "dielectric" "float eta" 1.35
Translate 0 .3 0
Shape "sphere" "float radius" .3
)";
  const Rendered path = renderText(milk, "path", "", SANITIZED ? 8 : 256);
  for (uint64_t seed = 1; seed <= (SANITIZED ? 1 : 3); ++seed) {
    const Rendered photons = renderText(milk, "photonmap", "", samples(16), seed);
    if (SANITIZED) continue; // too few samples for either mean
    EXPECT_NEAR(photons.mean() / path.mean(), 1, 0.08 + 3 * path.standardError() / path.mean()) << seed;
  }
}
