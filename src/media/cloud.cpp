/** @file
 * Procedural cloud, after pbrt-v4: dense at the bottom of its box, and torn further up.
 */
#include "media/grid/gridMedium.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/model/texture/noise.h"

namespace recurse {

namespace {

constexpr double FINER = 1.99; ///< frequency ratio of successive octaves
constexpr int TURNS = 2, OCTAVES = 5;
constexpr double STEEPNESS = 4.5;

class Cloud final : public Medium {
 public:
  Cloud(const Parameters& p, const MediumContext& context)
      : whole(readMediumPoint(p)), box(p, context), density(p.real("density")),
        wispiness(p.real("wispiness")), frequency(p.real("frequency")) {
    const Vec3d p0 = p.vector3("p0"), p1 = p.vector3("p1");
    lower = glm::min(p0, p1);
    extent = glm::max(p0, p1) - lower;
    constexpr int SLICES = 32;
    std::vector<float> bounds;
    for (int i = 0; i < SLICES; ++i)
      bounds.push_back(static_cast<float>(boundBetween(lower.y + extent.y * (i - 1e-3) / SLICES,
                                                       lower.y + extent.y * (i + 1 + 1e-3) / SLICES)));
    majorants = MajorantGrid({1, SLICES, 1}, std::move(bounds));
    box.checkSteps(p, "", majorants, whole.extinction());
  }

  MediumPoint at(const Vec3f& position) const override {
    const Vec3d unit(box.point(position));
    if (glm::any(glm::lessThan(unit, Vec3d(0))) || glm::any(glm::greaterThan(unit, Vec3d(1)))) return {};
    const auto d = static_cast<float>(densityAt(lower + extent * unit));
    return {whole.absorption * d, whole.scattering * d, whole.emission * d};
  }
  MajorantSegments segments(const Ray& ray, float end) const override {
    return box.segments(majorants, whole.extinction(), ray, end);
  }
  bool isEmissive() const override { return !isBlack(whole.emission); }
  Bounds3f bounds() const override { return box.bounds(); }

 private:
  /** Gradient of the noise, by finite differences with the step of pbrt-v4. */
  static Vec3d slope(const Vec3d& p) {
    constexpr double STEP = 0.01;
    const double n = perlinNoise(p);
    return (Vec3d(perlinNoise(p + Vec3d(STEP, 0, 0)), perlinNoise(p + Vec3d(0, STEP, 0)),
                  perlinNoise(p + Vec3d(0, 0, STEP))) -
            n) /
           STEP;
  }
  double densityAt(const Vec3d& p) const {
    Vec3d q = p * frequency;
    double height = 0.05 * wispiness, fineness = 10;
    for (int i = 0; i < TURNS && wispiness > 0; ++i, height *= 0.5, fineness *= FINER)
      q += slope(q * fineness) * height;
    double sum = 0;
    height = 0.5;
    fineness = 1;
    for (int i = 0; i < OCTAVES; ++i, height *= 0.5, fineness *= FINER)
      sum += height * perlinNoise(q * fineness);
    const double torn = std::clamp((1 - p.y) * STEEPNESS * density * sum, 0.0, 1.0);
    return std::clamp(torn + 2 * std::max(0.0, 0.5 - p.y), 0.0, 1.0);
  }
  /** Upper bound of the density between two heights. */
  double boundBetween(double y0, double y1) const {
    constexpr double HIGHEST = 1.04; // bound of |noise|, and of its sum of octaves
    const double torn = std::max(std::abs(1 - y0), std::abs(1 - y1)) * STEEPNESS * density * HIGHEST;
    return std::min(1.0, std::min(1.0, torn) + 2 * std::max(0.0, 0.5 - y0));
  }

  MediumPoint whole;
  GridBox box;
  double density, wispiness, frequency;
  Vec3d lower{0}, extent{1};
  MajorantGrid majorants;
};

} // namespace

void registerCloud(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters = mediumParameters("1", "1");
  for (const ParameterSpec& s : gridBoxParameters()) parameters.push_back(s);
  parameters.push_back(
      realParameter("density", "1", "factor on the noise: larger values give more cloud").range(0, 1e6));
  parameters.push_back(
      realParameter("wispiness", "1", "strength of the distortion of the noise").range(0, 1e3));
  parameters.push_back(realParameter("frequency", "5", "frequency of the noise [1/length]").range(0, 1e6));
  plugIns.media.add(
      {{.name = "cloud",
        .summary = std::string("A procedural cloud in a box, from noise: dense at its bottom, up to y = 0.5, "
                               "and ragged above.") +
                   DENSITY_LIMIT,
        .parameters = parameters,
        .examples = {"", "\"float density\" 2 \"float wispiness\" 0 \"point3 p0\" [-1 0 -1]"}},
       [](const Parameters& p, const MediumContext& c) { return std::make_unique<Cloud>(p, c); }});
}

} // namespace recurse
