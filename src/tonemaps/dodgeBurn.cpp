/** @file
 * The local operator of Reinhard et al. 2002, "Photographic Tone Reproduction for Digital Images": automatic
 * dodging and burning.
 */
#include <cmath>

#include "recurse/model/film/toneCurve.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** Number of surround sizes, each 1.6 times the previous one, as in the paper. */
constexpr int SCALES = 8;
constexpr float RATIO = 1.6f;
/** Smallest size, as a fraction of the longer side: a pixel of the paper's pictures. Sizes in the formulas
 * have this unit, so that the result does not depend on the resolution. */
constexpr float UNIT = 0.001f;
/** Standard deviation of the Gaussian of size 1: its α is 1/(2√2), and its exponent has no ½. */
constexpr float SIGMA = 0.25f;

class DodgeBurn final : public ToneMap {
 public:
  DodgeBurn(float sharpness, float threshold) : sharpness(std::exp2(sharpness)), threshold(threshold) {}
  bool isLocal() const override { return true; }
  float haloBound() const override { return 0.65f; }

  void apply(Image& picture) const override {
    constexpr float SCALE = 1 / (1 - GREY_CARD); // keeps the grey card, a fixed point of L / (1 + L)
    std::vector<float> light = luminances(picture);
    for (float& y : light) y *= SCALE;
    const std::vector<float> adaptation = localAdaptation(light, picture.width, picture.height);
    size_t i = 0;
    changeColours(picture, [&](const Rgb& colour) {
      const float y = light[i] / (1 + adaptation[i]); // equation 9
      ++i;
      return withLuminance(colour, y);
    });
  }

 private:
  /** Mean of the largest surround that contains no edge (equations 5 to 8). */
  std::vector<float> localAdaptation(const std::vector<float>& light, int width, int height) const {
    const float unit = UNIT * float(std::max(width, height));
    const auto blurred = [&](float size) { return gaussianBlur(light, width, height, SIGMA * size * unit); };
    float size = 1;
    std::vector<float> centre = blurred(size), out = centre;
    std::vector<bool> ended(light.size());
    for (int scale = 0; scale < SCALES; ++scale, size *= RATIO) {
      std::vector<float> surround = blurred(size * RATIO);
      for (size_t i = 0; i < light.size(); ++i) {
        if (ended[i]) continue;
        out[i] = centre[i];
        const float difference =
            (centre[i] - surround[i]) / (sharpness * GREY_CARD / (size * size) + centre[i]);
        ended[i] = std::abs(difference) > threshold;
      }
      centre = std::move(surround);
    }
    return out;
  }

  float sharpness, threshold;
};

} // namespace

void registerDodgeBurn(PlugIns& plugIns) {
  plugIns.toneMaps.add(
      {{.name = "dodgeburn",
        .summary = "Local photographic operator: automatic dodging and burning (Reinhard et al. 2002).",
        .parameters = {realParameter("phi", "8", "sharpening parameter phi of the paper").range(0, 16),
                       realParameter("epsilon", "0.05",
                                     "contrast threshold that limits the size of the local neighbourhood")
                           .range(0.001, 1)},
        .examples = {"", "\"float phi\" 10"}},
       [](const Parameters& p, const NoContext&) {
         return std::make_unique<DodgeBurn>(static_cast<float>(p.real("phi")),
                                            static_cast<float>(p.real("epsilon")));
       }});
}

} // namespace recurse
