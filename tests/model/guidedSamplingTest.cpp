/** @file
 * Sampling of BSDFs mixed with a guide: unbiased for any guide, for every registered material.
 */
#include "bsdfTesting.h"
#include "sanitized.h"

using namespace recurse;

namespace {

/** Guide without knowledge of the scene: half of it is a narrow cone around a direction, which may be below
 * the surface. */
class WrongGuide final : public DirectionGuide {
 public:
  explicit WrongGuide(const Vec3f& axis) : frame(axis) {}
  float bsdfProbability() const override { return 0.5f; }
  float pdf(const Vec3f& direction) const override {
    const bool inCone = glm::dot(direction, frame.z) > 1 - OPENING;
    return 0.5f / (4 * PI) + (inCone ? 0.5f / (2 * PI * OPENING) : 0);
  }
  Vec3f sample(Vec2f u, float& density) const override {
    const bool isCone = u.x < 0.5f;
    const Vec2f left(isCone ? 2 * u.x : 2 * u.x - 1, u.y);
    const Vec3f direction = isCone ? frame.toWorld(uniformCone(left, OPENING)) : uniformSphere(left);
    density = pdf(direction);
    return direction;
  }

 private:
  static constexpr float OPENING = 0.05f;
  Frame frame;
};

struct Moments {
  double sum = 0, squares = 0, count = 0;
  void add(double x) {
    sum += x;
    squares += x * x;
    ++count;
  }
  double mean() const { return sum / count; }
  double variance() const { return (squares / count - mean() * mean()) / count; }
};

} // namespace

TEST(GuidedSampling, HasTheMeanOfBsdfSamplingWhateverTheGuide) {
  const int count = recurse::testing::samples(20000);
  int guided = 0;
  for (const MaterialUse& use : everyUse()) {
    SCOPED_TRACE(use.text);
    BsdfArena arena;
    const Bsdf* bsdf = use.material->bsdfAt(flatPoint(), arena);
    if (!bsdf) continue;
    const Vec3f wi = glm::normalize(Vec3f(0.3f, -0.2f, 0.8f));
    for (const Vec3f& axis : {Vec3f(0.6f, 0, 0.8f), Vec3f(0, 0.6f, -0.8f)}) {
      const WrongGuide guide(axis);
      ScatteringPoint plain(*bsdf, flatPoint()), mixed(*bsdf, flatPoint());
      mixed.follow(&guide);
      if (!plain.isGuidable()) continue;
      ++guided;
      // Reflected light of a sky that is brighter on one side.
      const auto bring = [&](const ScatteringPoint& point, Sampler sampler) {
        const auto s = point.scatter(wi, Transport::RADIANCE, sampler);
        return s ? double(luminance(s->weight)) * double(1.2f + s->direction.x) : 0;
      };
      Moments a, b;
      for (int i = 0; i < count; ++i) {
        a.add(bring(plain, Sampler(1, 2, uint32_t(i))));
        b.add(bring(mixed, Sampler(1, 3, uint32_t(i))));
      }
      EXPECT_NEAR(a.mean(), b.mean(), 5 * std::sqrt(a.variance() + b.variance()) + 1e-5);
    }
  }
  EXPECT_GT(guided, 10);
}

TEST(GuidedSampling, TheDensityOfAStepIsThatOfItsDirection) {
  for (const MaterialUse& use : everyUse()) {
    SCOPED_TRACE(use.text);
    BsdfArena arena;
    const Bsdf* bsdf = use.material->bsdfAt(flatPoint(), arena);
    if (!bsdf) continue;
    const WrongGuide guide(Vec3f(0.6f, 0, 0.8f));
    ScatteringPoint point(*bsdf, flatPoint());
    point.follow(&guide);
    if (!point.isGuidable()) continue;
    const Vec3f wi = glm::normalize(Vec3f(0.3f, -0.2f, 0.8f));
    for (uint32_t i = 0; i < 200; ++i) {
      Sampler sampler(4, 5, i);
      const auto s = point.scatter(wi, Transport::RADIANCE, sampler);
      if (s && !s->specular()) {
        EXPECT_NEAR(point.pdf(wi, s->direction) / s->pdf, 1, 1e-4f);
      }
    }
  }
}
