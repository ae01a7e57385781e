/** @file
 * The phase function of Henyey and Greenstein 1941, "Diffuse radiation in the galaxy".
 */
#include "recurse/model/medium/phaseFunction.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class HenyeyGreenstein final : public PhaseFunction {
 public:
  explicit HenyeyGreenstein(double g) : g(static_cast<float>(g)) {}
  float value(float cosine) const override {
    // 1 + g² - 2g cosine without the cancellation near a peak.
    const float d = square(1 - g) + 2 * g * (1 - cosine);
    return 0.25f * INV_PI * (1 - g) * (1 + g) / (d * std::sqrt(d));
  }
  float sampleCosine(float u) const override {
    if (std::abs(g) < ISOTROPIC) return 1 - 2 * u;
    const float s = (1 - g) * (1 + g) / (1 + g - 2 * g * u);
    return (1 + g * g - s * s) / (2 * g);
  }
  float meanCosine() const override { return g; }

 private:
  /** |g| below which the quotient is rounding error, and the peak less than a thousandth. */
  static constexpr float ISOTROPIC = 1e-4f;
  float g;
};

} // namespace

void registerHenyeyGreenstein(PlugIns& plugIns) {
  plugIns.phaseFunctions.add(
      {{.name = "hg",
        .summary = "Henyey and Greenstein's phase function: one lobe, forward or backward.",
        .parameters =
            {realParameter("g", "0", "mean cosine: 0 isotropic, above 0 forward").range(-0.9999, 0.9999)},
        .examples = {"", "\"float g\" .5", "\"float g\" -.8", "\"float g\" .99"}},
       [](const Parameters& p, const NoContext&) {
         return std::make_unique<HenyeyGreenstein>(p.real("g"));
       }});
}

} // namespace recurse
