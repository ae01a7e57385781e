/** @file
 * Where light from far away comes in: densities against closed forms, and which photons get in.
 */
#include "recurse/transport/lightPortals.h"
#include "transport/rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

constexpr float HALF = 0.2f; ///< of the hole in the roof

/** A closed room with a hole in its roof, and light from all around. */
std::string roomWithHole(const std::string& pane = "") {
  return view(16, "-1.6 1.3 -1.8  1 .5 1  0 1 0", 60) + R"(
LightSource "infinite" "rgb L" [1 1 1]
Material "diffuse" "rgb reflectance" [.7 .7 .7]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3 4 5 1 4 1 0 5 6 2 5 2 1 6 7 3 6 3 2 7 4 0 7 0 3]
  "point3 P" [-2 0 -2  2 0 -2  2 0 2  -2 0 2  -2 2.5 -2  2 2.5 -2  2 2.5 2  -2 2.5 2]
Shape "trianglemesh" "integer indices" [0 1 5 0 5 4 1 2 6 1 6 5 2 3 7 2 7 6 3 0 4 3 4 7]
  "point3 P" [-2 2.5 -2  2 2.5 -2  2 2.5 2  -2 2.5 2  -.2 2.5 -.2  .2 2.5 -.2  .2 2.5 .2  -.2 2.5 .2]
)" + pane;
}

LightPortals portalsOf(const Scene& scene) {
  LightPortals portals;
  TransportCounts counts;
  portals.learn(scene, 1, counts);
  return portals;
}

/** Whether a ray comes in by the hole; the room's middle is at `center`. */
bool entersHole(const LeSample& sample, const Vec3f& center) {
  const float t = (center.y + 1.25f - sample.origin.y) / sample.direction.y;
  const Vec3f at = sample.origin + sample.direction * t - center;
  return std::abs(at.x) < HALF && std::abs(at.z) < HALF;
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
  const auto scene = sceneFrom(roomWithHole());
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
  const double part = double(square(2 * HALF) * -direction.y * bounds.pdfDisc());
  EXPECT_NEAR(sum / part, 1, 0.03);
  EXPECT_GT(inside, 20 * part * N);
  // Hardly any of them is far stronger than the others.
  EXPECT_LT(stronger, inside / 100);
}

TEST(LightPortals, ARoomWithAHoleIsAsBrightAsByPaths) {
  const int count = samples(32);
  for (const std::string pane : {"", "Material \"thindielectric\" Shape \"bilinearmesh\" \"point3 P\" "
                                     "[-.25 2.55 -.25 .25 2.55 -.25 -.25 2.55 .25 .25 2.55 .25]"}) {
    const Rendered path = renderText(roomWithHole(pane), "path", "", 4 * count);
    const Rendered photons = renderText(roomWithHole(pane), "photonmap", "", count);
    const double error = std::hypot(path.standardError(), photons.standardError());
    EXPECT_NEAR(photons.mean() / path.mean(), 1, 0.02 + 3 * error / path.mean()) << pane;
    EXPECT_GT(photons.statistics.photonsStored, photons.statistics.photonsEmitted / 20);
  }
}
