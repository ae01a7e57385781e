/** @file
 * Far lamps whose photons are aimed: densities, fluxes against closed forms, and caustics.
 */
#include "transport/emission/photonAim.h"
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

/** Sixty away from the ball. */
const std::string FAR_AWAY = "Translate 20 -30 48\n";
const std::string FAR_LAMPS[] = {
    FAR_AWAY + "LightSource \"point\" \"rgb I\" [ 9 8 7 ]",
    FAR_AWAY + "LightSource \"spot\" \"rgb I\" [ 9 8 7 ] \"point3 to\" [ -20 30 -47 ] \"float coneangle\" 40",
    FAR_AWAY + "AreaLightSource \"diffuse\" \"rgb L\" [ 9 8 7 ] Shape \"sphere\" \"float radius\" 2",
    FAR_AWAY + "AreaLightSource \"diffuse\" \"rgb L\" [ 9 8 7 ] \"float exponent\" 2 Shape \"sphere\" "
               "\"float radius\" 2",
    FAR_AWAY + "AreaLightSource \"diffuse\" \"rgb L\" [ 9 8 7 ] \"bool twosided\" true Shape \"disk\" "
               "\"float radius\" 2"};

PhotonAim aimAt(const Scene& scene) {
  PhotonAim aim;
  TransportCounts counts;
  aim.learn(scene, 1, counts);
  return aim;
}

std::optional<LeSample> aimed(const PhotonAim& aim, const Light& light, uint32_t i) {
  Sampler sampler(7, 0, i);
  LeRandom start;
  start.pick = sampler.next1D();
  start.position = sampler.next2D();
  start.direction = sampler.next2D();
  std::optional<LeSample> sample = light.sampleLe(start);
  const float pick = sampler.next1D();
  if (sample) aim.redirect(light, *sample, pick, sampler.next2D());
  return sample;
}

} // namespace

TEST(PhotonAim, KeepsTheFluxOfALamp) {
  constexpr uint32_t N = 200000;
  for (const std::string& lamp : FAR_LAMPS) {
    const auto scene = sceneFrom(ballOnFloor(16, lamp));
    ASSERT_TRUE(scene);
    const PhotonAim aim = aimAt(*scene);
    ASSERT_TRUE(aim.isAimed(0)) << lamp;
    const Light& light = scene->lights()[0];
    std::vector<double> all(N), toBall(N);
    int met = 0, otherwise = 0;
    const Vec3f ball(0, 0, 0.6f);
    for (uint32_t i = 0; i < N; ++i) {
      const auto sample = aimed(aim, light, i);
      if (!sample || isBlack(sample->flux)) continue;
      const float told = aim.pdfDirection(light, *sample, light.pdfLe(*sample).direction);
      otherwise += std::abs(told / sample->pdfDirection - 1) > 1e-3f;
      all[i] = double(sample->flux.r);
      const Vec3f way = ball - sample->origin;
      const float along = glm::dot(way, sample->direction);
      if (along > 0 && lengthSquared(way) - square(along) < square(0.5f)) {
        toBall[i] = all[i];
        ++met;
      }
    }
    EXPECT_LT(otherwise, int(N) / 10000) << lamp; // on the very edge of a cone
    const Mean flux(all), fluxToBall(toBall);
    const auto power = double(light.power().r);
    EXPECT_NEAR(flux.value / power, 1, 4 * flux.error / power) << lamp;
    EXPECT_GT(met, int(N) / 50) << lamp;
    // By shadow rays from the ball's middle: from so far away the flux is irradiance times silhouette.
    std::vector<double> arriving(1000);
    for (uint32_t i = 0; i < arriving.size(); ++i) {
      Sampler sampler(8, 0, i);
      const float pick = sampler.next1D();
      const auto li = light.sampleLi(ball, pick, sampler.next2D());
      if (li) arriving[i] = double(li->radiance.r / li->pdf) * M_PI * 0.25;
    }
    const Mean expected(arriving);
    EXPECT_NEAR(fluxToBall.value, expected.value,
                4 * (fluxToBall.error + expected.error) + 2e-3 * expected.value)
        << lamp;
  }
}

TEST(PhotonAim, LeavesLampsInARoomAlone) {
  const auto scene = sceneFrom(litCorner(16));
  ASSERT_TRUE(scene);
  EXPECT_FALSE(aimAt(*scene).active());
}

TEST(PhotonAim, AFarSunHasTheCausticOfADistantLight) {
  // A ball of irradiance, as of a light in one direction, by a lamp of small radius r at distance d: L π
  // r²/d².
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
