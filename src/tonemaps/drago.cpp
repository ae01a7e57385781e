/** @file
 * Adaptive logarithmic mapping: Drago et al. 2003, "Adaptive Logarithmic Mapping For Displaying High Contrast
 * Scenes".
 */
#include <cmath>

#include "recurse/model/film/toneCurve.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class Drago final : public ToneMap {
 public:
  explicit Drago(float bias) : exponent(std::log(bias) / std::log(0.5f)) {}
  bool measuresPicture() const override { return true; }
  void apply(Image& picture) const override {
    // White is at least ten times the grey card: the curve is not defined for less.
    const float white = std::max(10 * GREY_CARD, luminanceQuantile(picture, 0.999));
    // Equation 4 at luminance y; `scale` is the paper's scale factor, found so that the grey card is kept.
    const auto curve = [&](float y, float scale) {
      const float t = std::min(y / white, 1.0f);
      const float shown = std::log1p(scale * t * white) * std::log(10.0f) /
                          (std::log1p(scale * white) * std::log(2 + 8 * std::pow(t, exponent)));
      return std::min(shown, 1.0f); // at high contrast the curve exceeds 1 before it returns to it
    };
    float low = 1e-4f, high = 1e4f;
    for (int i = 0; i < 60; ++i) {
      const float middle = std::sqrt(low * high);
      (curve(GREY_CARD, middle) < GREY_CARD ? low : high) = middle;
    }
    const float scale = std::sqrt(low * high);
    changeColours(picture,
                  [&](const Rgb& colour) { return withLuminance(colour, curve(luminance(colour), scale)); });
  }

 private:
  float exponent;
};

} // namespace

void registerDrago(PlugIns& plugIns) {
  plugIns.toneMaps.add(
      {{.name = "drago",
        .summary = "Adaptive logarithmic mapping (Drago et al. 2003).",
        .parameters = {realParameter("bias", "0.85",
                                     "larger values: more contrast, less detail in dark areas")
                           .range(0.6, 0.95)},
        .examples = {"", "\"float bias\" 0.75"}},
       [](const Parameters& p, const NoContext&) {
         return std::make_unique<Drago>(static_cast<float>(p.real("bias")));
       }});
}

} // namespace recurse
