/** @file
 * Schlick's phase function (Blasi, Le Saec and Schlick 1993, "A Rendering Algorithm for Discrete Volume
 * Density Objects"): (1 - k²) / (4π (1 - k cos)²).
 */
#include "recurse/model/medium/phaseFunction.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class Schlick final : public PhaseFunction {
 public:
  explicit Schlick(double k) : k(static_cast<float>(k)) {}
  float value(float cosine) const override {
    return 0.25f * INV_PI * (1 - k) * (1 + k) / square(1 - k * cosine);
  }
  float sampleCosine(float u) const override {
    // The distribution from -1 to x is (1 - k)(1 + x) / (2 (1 - kx)).
    const float v = 2 * (1 - u);
    return (v + k - 1) / (1 - k + k * v);
  }
  float meanCosine() const override {
    if (std::abs(k) < SERIES) return 2 * k / 3;
    const double x = double(k);
    return static_cast<float>(1 / x + (1 - x * x) / (2 * x * x) * std::log((1 - x) / (1 + x)));
  }

 private:
  /** |k| below which the next term of the series, k³, is below the rounding error of the closed form. */
  static constexpr float SERIES = 1e-3f;
  float k;
};

} // namespace

void registerSchlick(PlugIns& plugIns) {
  plugIns.phaseFunctions.add(
      {{.name = "schlick",
        .summary =
            "Schlick's phase function, an approximation of Henyey and Greenstein's that is faster to sample.",
        .parameters = {realParameter("k", "0", "1.55 g - 0.55 g³ approximates hg with mean cosine g")
                           .range(-0.9999, 0.9999)},
        .examples = {"", "\"float k\" .6", "\"float k\" -.9"}},
       [](const Parameters& p, const NoContext&) { return std::make_unique<Schlick>(p.real("k")); }});
}

} // namespace recurse
