/** @file
 * Where light from far away comes in: densities against closed forms, and which photons get in.
 */
#include <tuple>

#include "transport/direct/lightPortals.h"
#include "transport/forward/shoot.h"
#include "transport/forward/shootSettings.h"
#include "transport/roomWithHole.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

LightPortals portalsOf(const Scene& scene) {
  LightPortals portals;
  TransportCounts counts;
  portals.learn(scene, 1, counts);
  return portals;
}

bool entersHole(const LeSample& sample, const Vec3f& center) {
  return crossesHole(sample.origin, sample.direction, center);
}

/** A ray of a light in one direction, over the whole scene's disc. */
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

TEST(LightPortals, PhotonsFindAHoleWithoutAPane) {
  const auto scene = sceneFrom(roomWithHole(16));
  ASSERT_TRUE(scene);
  const LightPortals portals = portalsOf(*scene);
  ASSERT_TRUE(portals.active());
  const SceneBounds& bounds = scene->bounds();
  const Vec3f direction = glm::normalize(Vec3f(0.3f, -1, 0.2f));
  Sampler sampler(3, 0, 0);
  constexpr int N = 200000;
  int inside = 0, stronger = 0;
  double sum = 0;
  for (int i = 0; i < N; ++i) {
    const Vec2f disc(sampler.next1D(), sampler.next1D()), u(sampler.next1D(), sampler.next1D());
    LeSample sample = overDisc(bounds, direction, disc);
    portals.redirect(sample, sampler.next1D(), u);
    EXPECT_NEAR(bounds.pdfDisc() / portals.pdf(sample.origin, direction), sample.flux.r,
                1e-3f * sample.flux.r);
    if (!entersHole(sample, bounds.center)) continue;
    ++inside;
    sum += double(sample.flux.r) / N;
    stronger += sample.flux.r > 0.1f;
  }
  // The mean flux through the hole is its part of the disc; by chance alone so many photons find it.
  const double part = double(square(2 * HOLE_HALF_WIDTH) * -direction.y * bounds.pdfDisc());
  EXPECT_NEAR(sum / part, 1, 0.03);
  EXPECT_GT(inside, 20 * part * N);
  // Hardly any of them is far stronger than the others.
  EXPECT_LT(stronger, inside / 100);
}

TEST(LightPortals, ARoomWithAHoleIsAsBrightAsByPaths) {
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

TEST(LightPortals, ASkyBesideAFarSunIsFoundToo) {
  // The sun is a ball of forty times the sky's power, so that it takes nearly all photons while it is not
  // aimed.
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

TEST(LightPortals, ASkyWithASunComesInAsItDoesWithoutBoxes) {
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
  const LightPortals portals = portalsOf(*scene);
  ASSERT_TRUE(portals.active());
  const auto powerOnTheFloor = [&](const LightPortals* through) {
    ShootSettings settings;
    settings.photons = 400000;
    settings.emission.portals = through;
    double sum = 0;
    for (const Photon& p : shootPhotons(*scene, PathClasses(), Pass(), settings, ForwardControl()).stored)
      if (p.position.y - scene->bounds().center.y < -0.5f) sum += double(p.power.r);
    return sum;
  };
  EXPECT_NEAR(powerOnTheFloor(&portals) / powerOnTheFloor(nullptr), 1, 0.03);
}

TEST(LightPortals, ASmallBallOfMilkOnAWideGroundGetsItsPhotons) {
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
    if (SANITIZED) continue; // so few samples give neither mean
    EXPECT_NEAR(photons.mean() / path.mean(), 1, 0.08 + 3 * path.standardError() / path.mean()) << seed;
  }
}

TEST(StrongPhotons, AreUnbiasedWhereLightComesOffAWideGround) {
  // What a wall sees of the sunny ground through its window reaches far: photons start there sparsely.
  const std::string room = view(16, "3.5 1.5 3.5  -3 1 -1  0 1 0", 70) + R"(
LightSource "infinite" "rgb L" [.5 .6 .8]
LightSource "distant" "point3 from" [-3 3 1] "rgb L" [8 7 6]
Material "diffuse" "rgb reflectance" [.6 .6 .6]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-150 -.1 -150 -150 -.1 150 150 -.1 150 150 -.1 -150]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3  4 5 6 4 6 7  0 1 5 0 5 4  2 3 7 2 7 6  1 2 6 1 6 5]
  "point3 P" [-4 0 -4  4 0 -4  4 0 4  -4 0 4  -4 3 -4  4 3 -4  4 3 4  -4 3 4]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3  4 5 6 4 6 7  8 9 10 8 10 11  12 13 14 12 14 15]
  "point3 P" [-4 0 -4 -4 0 4 -4 1 4 -4 1 -4  -4 2.4 -4 -4 2.4 4 -4 3 4 -4 3 -4
              -4 1 -4 -4 1 -2 -4 2.4 -2 -4 2.4 -4  -4 1 2 -4 1 4 -4 2.4 4 -4 2.4 2]
)";
  constexpr int COUNT = SANITIZED ? 2 : 32;
  const Rendered path = renderText(room, "path", "", 16 * COUNT);
  const Rendered photons = renderText(room, "photonmap", "", COUNT);
  const double error = std::hypot(path.standardError(), photons.standardError());
  if (SANITIZED) return; // the noise of so few samples hides light that is counted twice
  EXPECT_NEAR(photons.mean() / path.mean(), 1, 0.01 + 3 * error / path.mean());
  EXPECT_LT(error / path.mean(), 0.03) << photons.mean() << " " << path.mean() << " " << error;
}

TEST(StrongPhotons, AreSplitWithoutLossWhereTheyAreSeen) {
  const auto scene = sceneFrom(litCorner(16));
  ASSERT_TRUE(scene);
  VisibleRegion everywhere;
  everywhere.add(scene->bounds().center, 2 * scene->bounds().radius);
  ShootSettings settings;
  settings.photons = 20000;
  settings.direct = false;
  settings.region = &everywhere;
  struct Shot {
    std::vector<double> fluxes; ///< by pass
    size_t count = 0;
    float strongest = 0;
  };
  const auto shoot = [&] {
    Shot shot;
    for (uint64_t pass = 0; pass < 16; ++pass) {
      Pass p;
      p.seed = pass + 1;
      double flux = 0;
      for (const Photon& photon : shootPhotons(*scene, PathClasses(), p, settings, ForwardControl()).stored) {
        flux += double(photon.power.g);
        shot.strongest = std::max(shot.strongest, maxComponent(photon.power));
        ++shot.count;
      }
      shot.fluxes.push_back(flux);
    }
    return shot;
  };
  const Shot whole = shoot();
  settings.splitPower = whole.strongest / 4;
  const Shot split = shoot();
  const Mean a(whole.fluxes), b(split.fluxes);
  EXPECT_NEAR(b.value / a.value, 1, 4 * std::hypot(a.error, b.error) / a.value);
  EXPECT_GT(split.count, 2 * whole.count);
  EXPECT_LT(split.strongest, 0.6f * whole.strongest);
}

TEST(StrongPhotons, FollowAMirrorOnlyOnceWhereTheyAreSplit) {
  // What a coat mirrors has one direction, and all copies of a photon would come to one point.
  const auto scene = sceneFrom(view(16, "0 -3 2  0 0 .2  0 0 1", 40) + R"(
LightSource "spot" "point3 from" [ 0 -1 1 ] "point3 to" [ 0 0 0 ] "rgb I" [ 9 9 9 ]
Material "coateddiffuse" "float roughness" 0 "rgb reflectance" [ .5 .5 .5 ]
Shape "bilinearmesh" "point3 P" [ -2 -2 0  2 -2 0  -2 2 0  2 2 0 ]
Material "diffuse"
Shape "bilinearmesh" "point3 P" [ -2 2 0  2 2 0  -2 2 4  2 2 4 ]
)");
  VisibleRegion everywhere;
  everywhere.add(scene->bounds().center, 2 * scene->bounds().radius);
  ShootSettings settings;
  settings.photons = 4000;
  settings.direct = false;
  settings.region = &everywhere;
  struct Shot {
    double flux = 0, squares = 0; ///< of all photons, and sum of their squares
    size_t coincident = 0;
    float strongest = 0;
  };
  const auto shoot = [&] {
    Shot shot;
    std::vector<Photon> photons =
        shootPhotons(*scene, PathClasses(), Pass(), settings, ForwardControl()).stored;
    std::sort(photons.begin(), photons.end(), [](const Photon& a, const Photon& b) {
      return std::tie(a.position.x, a.position.y, a.position.z) <
             std::tie(b.position.x, b.position.y, b.position.z);
    });
    for (size_t i = 0; i < photons.size(); ++i) {
      const float power = maxComponent(photons[i].power);
      shot.flux += double(power);
      shot.squares += square(double(power));
      shot.strongest = std::max(shot.strongest, power);
      if (i > 0 && photons[i].position == photons[i - 1].position) ++shot.coincident;
    }
    return shot;
  };
  const Shot whole = shoot();
  EXPECT_EQ(whole.coincident, 0u);
  settings.splitPower = whole.strongest / 16;
  const Shot split = shoot();
  EXPECT_EQ(split.coincident, 0u);
  EXPECT_NEAR(split.flux / whole.flux, 1, 4 * std::sqrt(whole.squares + split.squares) / whole.flux);
}
