/** @file
 * Photons as records of the guide: their flux against a closed form, and the selection of photons whose light
 * rays can find.
 */
#include <gtest/gtest.h>

#include "sceneRendering.h"
#include "transport/learning/guideTraining.h"
#include "transport/learning/lightLearning.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

std::vector<GuideRecord> recordsOf(const Scene& scene, uint64_t photons) {
  LightSampler lights;
  learnLights(scene, lights);
  ShootSettings shoot;
  shoot.photons = photons;
  shoot.shadowRays = &lights;
  Pass pass;
  pass.seed = 3;
  TransportCounts counts;
  return photonRecords(scene, pass, shoot, {}, counts);
}

const char* const FLOOR = R"(
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
Shape "bilinearmesh" "point3 P" [ -4 0 -4  4 0 -4  -4 0 4  4 0 4 ]
)";

/** A square lamp of radiance 5 and side 1 at height 1, facing down. */
const char* const LAMP = R"(
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 5 5 5 ] "bool twosided" true
Shape "bilinearmesh" "point3 P" [ -.5 1 -.5  .5 1 -.5  -.5 1 .5  .5 1 .5 ]
AttributeEnd
)";

} // namespace

TEST(PhotonRecords, TheirFluxIsTheIntegralOfRadianceTimesCosine) {
  const auto scene = sceneFrom(view(8, 8, "0 3 0  0 0 0  0 0 1", perspective(60)) + FLOOR + LAMP);
  // The flux from the half of the lamp with x > 0 onto the square |x|, |z| < .5 of the floor, by the midpoint
  // rule.
  constexpr int N = 24;
  double right = 0, left = 0;
  const auto middle = [](int i) { return (i + 0.5) / N - 0.5; };
  for (int a = 0; a < N; ++a)
    for (int b = 0; b < N; ++b)
      for (int c = 0; c < N; ++c)
        for (int d = 0; d < N; ++d) {
          const double dx = middle(a) - middle(c), dz = middle(b) - middle(d), r2 = dx * dx + dz * dz + 1;
          // Unit squares; both cosines are 1 / r.
          (middle(a) > 0 ? right : left) += 5 / square(r2) / (double(N) * N * N * N);
        }
  const Vec3f middleOfFloor(-scene->origin());
  double foundRight = 0, foundLeft = 0;
  for (const GuideRecord& r : recordsOf(*scene, 1 << 19)) {
    EXPECT_TRUE(r.fromPhoton);
    const Vec3f p = r.position - middleOfFloor;
    if (std::abs(p.y) > 1e-3f || std::abs(p.x) > 0.5f || std::abs(p.z) > 0.5f) continue;
    EXPECT_GT(r.direction.y, 0);
    (p.x + r.direction.x / r.direction.y > 0 ? foundRight : foundLeft) += double(r.value);
  }
  EXPECT_NEAR(foundRight / right, 1, 0.03);
  EXPECT_NEAR(foundLeft / left, 1, 0.03);
}

TEST(PhotonRecords, LightThatNoRayCanHitTeachesNothing) {
  const std::string mirror = R"(
Material "conductor" "rgb reflectance" [ .9 .9 .9 ] "float roughness" 0
Shape "bilinearmesh" "point3 P" [ 2 0 -4  2 4 -4  2 0 4  2 4 4 ]
)";
  const std::string sun = "LightSource \"distant\" \"point3 from\" [ -1 1 0 ] \"point3 to\" [ 0 0 0 ]\n";
  const std::string camera = view(8, 8, "0 3 0  0 0 0  0 0 1", perspective(60));
  // The floor is black: all of its photons are caustics of the mirror, or direct light.
  const auto bySun = sceneFrom(camera + FLOOR + mirror + sun),
             byLamp = sceneFrom(camera + FLOOR + mirror + LAMP);
  EXPECT_TRUE(recordsOf(*bySun, 20000).empty());
  EXPECT_FALSE(recordsOf(*byLamp, 20000).empty());
}
