/** @file
 * Photons of large flux, which are split in the visible region.
 */
#include <tuple>

#include "transport/classRendering.h"
#include "transport/forward/shoot.h"
#include "transport/rendering.h"

using namespace recurse;
using namespace recurse::testing;

TEST(StrongPhotons, AreUnbiasedWhereLightComesOffAWideGround) {
  // The part of the sunlit ground that a wall sees through its window is large, so the density of emission
  // towards it is low.
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
  if (SANITIZED) return; // the noise of few samples hides light that is counted twice
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
    std::vector<double> fluxes; ///< flux of each pass
    size_t count = 0;
    float strongest = 0;
  };
  const auto shoot = [&] {
    Shot shot;
    for (uint64_t pass = 0; pass < 16; ++pass) {
      Pass p;
      p.seed = pass + 1;
      double flux = 0;
      for (const Photon& photon :
           shootPhotons(*scene, PathClasses(), p, settings, ForwardControl()).onSurfaces) {
        flux += double(photon.power.g);
        shot.strongest = std::max(shot.strongest, maxComponent(photon.power));
        ++shot.count;
      }
      shot.fluxes.push_back(flux);
    }
    return shot;
  };
  const Shot whole = shoot();
  settings.splitPower = whole.strongest / 4 * float(settings.photons);
  const Shot split = shoot();
  const Mean a(whole.fluxes), b(split.fluxes);
  EXPECT_NEAR(b.value / a.value, 1, 4 * std::hypot(a.error, b.error) / a.value);
  EXPECT_GT(split.count, 2 * whole.count);
  EXPECT_LT(split.strongest, 0.6f * whole.strongest);
}

TEST(StrongPhotons, AreSplitWithoutLossWhereFogScattersThem) {
  // Walls that absorb all light: every photon stored comes from the fog.
  const auto scene = sceneFrom(
      "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [.1 .1 .1] \"rgb sigma_a\" "
      "[0 0 0]\nMediumInterface \"\" \"fog\"\n" +
      view(16, "0 0 -.9  0 0 1  0 1 0", 80) +
      "MediumInterface \"fog\" \"fog\"\nLightSource \"point\"\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 "
      "0]\n"
      "ReverseOrientation\nShape \"box\" \"point3 p1\" [-1 -1 -1] \"point3 p2\" [1 1 1]\n");
  ASSERT_TRUE(scene);
  VisibleRegion region;
  region.addInMedium(Vec3f(0), 4, 1);
  ShootSettings settings;
  settings.photons = 1 << 15;
  settings.direct = false;
  settings.region = &region;
  const auto shoot = [&] {
    BatchMeans means; // of flux, strongest photon, and number of photons
    for (uint64_t pass = 1; pass <= 8; ++pass) {
      Pass p;
      p.seed = pass;
      const auto photons = shootPhotons(*scene, PathClasses(), p, settings, ForwardControl()).onSurfaces;
      double flux = 0, strongest = 0;
      for (const Photon& photon : photons) {
        flux += double(photon.power.g);
        strongest = std::max(strongest, double(photon.power.g));
      }
      means.add({flux, strongest, double(photons.size())});
    }
    return means;
  };
  const BatchMeans whole = shoot();
  settings.splitPower = static_cast<float>(whole.mean(1) * double(settings.photons) / 16);
  const BatchMeans split = shoot();
  EXPECT_NEAR(split.mean(0), whole.mean(0), 3 * std::hypot(split.standardError(0), whole.standardError(0)));
  EXPECT_LT(split.mean(1), whole.mean(1) / 10);
  EXPECT_GT(split.mean(2), whole.mean(2) * 10);
}

TEST(StrongPhotons, AreSplitIntoALimitedNumber) {
  const auto scene = sceneFrom(litCorner(16));
  VisibleRegion everywhere;
  everywhere.add(scene->bounds().center, 2 * scene->bounds().radius);
  ShootSettings settings;
  settings.photons = 20;
  settings.direct = false;
  settings.maxDepth = 8;
  settings.region = &everywhere;
  settings.splitPower = 1e-20f; // a lamp that no trial photon of the region came from
  const ShotPhotons shot = shootPhotons(*scene, PathClasses(), Pass(), settings, ForwardControl());
  EXPECT_LT(shot.onSurfaces.size(), settings.photons * uint64_t(256 * settings.maxDepth));
}

TEST(StrongPhotons, FollowAMirrorOnlyOnceWhereTheyAreSplit) {
  // The coat's mirror reflection has a single direction, so all copies of a photon would arrive at the same
  // point.
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
    double flux = 0, squares = 0; ///< flux of all photons, and sum of squares
    size_t coincident = 0;
    float strongest = 0;
  };
  const auto shoot = [&] {
    Shot shot;
    std::vector<Photon> photons =
        shootPhotons(*scene, PathClasses(), Pass(), settings, ForwardControl()).onSurfaces;
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
  settings.splitPower = whole.strongest / 16 * float(settings.photons);
  const Shot split = shoot();
  EXPECT_EQ(split.coincident, 0u);
  EXPECT_NEAR(split.flux / whole.flux, 1, 4 * std::sqrt(whole.squares + split.squares) / whole.flux);
}
