/** @file
 * Progressive photon maps: schedule of radii, independence of passes, constant memory, and an error, bias
 * included, that decreases with the number of passes.
 */
#include "rendering.h"

#include "transport/density/radiusCache.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** A floor with free edges, a block on it and a lamp above: bias at every boundary of the photons. */
std::string blockOnFloor() {
  return view(16, "0 -3 2  0 0 .2  0 0 1", 40) + R"(
Material "diffuse" "rgb reflectance" [ .7 .6 .5 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 0  1 -1 0  1 1 0  -1 1 0 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ 0 .2 0  .5 .2 0  .5 .2 .5  0 .2 .5 ]
AreaLightSource "diffuse" "rgb L" [ 20 20 20 ]
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
Shape "trianglemesh" "integer indices" [ 0 2 1  0 3 2 ] "point3 P" [ -.7 -.3 1.2  -.5 -.3 1.2  -.5 -.1 1.2  -.7 -.1 1.2 ]
)";
}

constexpr const char* ALL_FROM_PHOTONS =
    "\"integer photons\" 20000 \"integer passes\" 0 \"string direct\" \"photons\"";

double squaredError(const Rendered& a, const Rendered& truth) {
  double sum = 0;
  for (size_t p = 0; p < a.pixels(); ++p)
    sum += double(square(luminance(a.value(p)) - luminance(truth.value(p))));
  return sum / double(a.pixels());
}

std::vector<Rgb> radiances(const Scene& scene, const Integrator& integrator) {
  const PathClasses classes;
  TransportCounts counts;
  PathRadiance radiance(classes, counts);
  std::vector<Rgb> out;
  for (uint32_t i = 0; i < 64; ++i) {
    Sampler sampler(3, 4, i);
    radiance.reset();
    integrator.backward(scene, *scene.camera().sampleRay({sampler.next2D() * 16.0f}), sampler, radiance);
    out.push_back(radiance.total());
  }
  return out;
}

} // namespace

TEST(Progressive, EmitsMorePhotonsWhereFewAreStored) {
  // In a closed ball about every second hit of a surface stores a photon; over a floor most photons escape
  // first.
  const std::string ball = view(4, "0 0 0  1 0 0  0 0 1", 60) +
                           "LightSource \"point\"\nMaterial \"diffuse\" "
                           "\"rgb reflectance\" [ .5 .5 .5 ]\nShape \"sphere\" \"float radius\" 1\n";
  constexpr uint64_t LEAST = 65536, SAMPLES = 2;
  const auto emitted = [](const std::string& text) {
    return renderText(text, "photonmap", "", SAMPLES).statistics.photonsEmitted / SAMPLES;
  };
  EXPECT_LT(double(emitted(ball)), 1.05 * double(LEAST));
  EXPECT_GT(emitted(blockOnFloor()), 2 * LEAST);
  EXPECT_LE(emitted(blockOnFloor()), 4 * LEAST);
}

TEST(Progressive, RadiusFollowsTheProduct) {
  for (const double alpha : {0.1, 2.0 / 3, 1.0}) {
    double product = 1;
    for (uint32_t i = 0; i < 1000; ++i) {
      EXPECT_NEAR(square(double(radiusScale(i, alpha))), product, 1e-5 * product) << alpha << " " << i;
      product *= (i + 1 + alpha) / (i + 2);
    }
  }
}

TEST(Progressive, APassDependsOnNoneButTheFirst) {
  const ThreadPool pool;
  const auto scene = sceneFrom(blockOnFloor());
  const PathClasses classes;
  const auto afterPasses = [&](std::initializer_list<uint32_t> passes) {
    const auto integrator = integratorFrom("photonmap", ALL_FROM_PHOTONS);
    for (const uint32_t pass : passes)
      integrator->forward(*scene, classes, {7, pass, PassSchedule::PER_SAMPLE}, {});
    return radiances(*scene, *integrator);
  };
  const auto jumped = afterPasses({0, 3});
  EXPECT_EQ(jumped, afterPasses({0, 1, 2, 3}));
  EXPECT_NE(jumped, afterPasses({0, 2}));
}

TEST(Progressive, MemoryDoesNotGrow) {
  const ThreadPool pool;
  const auto scene = sceneFrom(blockOnFloor());
  const PathClasses classes;
  const auto integrator = integratorFrom(
      "photonmap", "\"integer photons\" 4000 \"integer passes\" 0 \"string direct\" \"photons\"");
  size_t early = 0;
  for (uint32_t pass = 0; pass < (SANITIZED ? 100u : 1000u); ++pass) {
    const size_t bytes =
        integrator->forward(*scene, classes, {1, pass, PassSchedule::PER_SAMPLE}, {}).mapBytes;
    if (pass < 20)
      early = std::max(early, bytes);
    else
      ASSERT_LE(bytes, early + early / 4) << "pass " << pass;
  }
}

TEST(Progressive, ErrorFallsWithThePasses) {
  const auto scene = sceneFrom(blockOnFloor());
  const Rendered truth = renderScene(*scene, "path", "", samples(4096));
  // Bias and variance both decrease as n^(-2/3) for alpha = 2/3 and a kernel estimate in the plane; mean of
  // three renders, because the error of a single one is random.
  double few = 0, many = 0;
  constexpr int FEW = 4, MANY = SANITIZED ? 32 : 120;
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    few += squaredError(renderScene(*scene, "photonmap", ALL_FROM_PHOTONS, FEW, seed), truth);
    many += squaredError(renderScene(*scene, "photonmap", ALL_FROM_PHOTONS, MANY, seed), truth);
  }
  const double exponent = std::log(many / few) / std::log(double(MANY) / FEW);
  RecordProperty("exponent", std::to_string(exponent));
  EXPECT_LT(exponent, -0.6) << "squared errors " << few / 3 << " and " << many / 3;
}
