/** @file
 * Durand and Dorsey 2002, "Fast Bilateral Filtering for the Display of High-Dynamic-Range Images": the large
 * contrasts are reduced, the detail is kept.
 */
#include <cmath>

#include "recurse/model/film/toneCurve.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** The bilateral filter of a field, piecewise linear in the field's value (section 5.1 of the paper).
 * `sigmaSpace` in pixels, `sigmaRange` in the field's unit. */
std::vector<float> bilateral(const std::vector<float>& field, int width, int height, float sigmaSpace,
                             float sigmaRange) {
  const auto [least, most] = std::minmax_element(field.begin(), field.end());
  const float low = *least, range = *most - low;
  const int segments = std::max(1, int(std::ceil(range / (0.5f * sigmaRange))));
  const float step = range / float(segments);
  std::vector<float> out(field.size());
  if (!(step > 0)) return field;
  for (int j = 0; j <= segments; ++j) {
    const float level = low + float(j) * step;
    std::vector<float> weight(field.size()), weighted(field.size());
    for (size_t i = 0; i < field.size(); ++i) {
      const float d = (field[i] - level) / sigmaRange;
      weight[i] = std::exp(-0.5f * d * d);
      weighted[i] = weight[i] * field[i];
    }
    weight = gaussianBlur(weight, width, height, sigmaSpace);
    weighted = gaussianBlur(weighted, width, height, sigmaSpace);
    for (size_t i = 0; i < field.size(); ++i) {
      const float share = 1 - std::abs(field[i] - level) / step; // weight of this level in the interpolation
      if (share > 0) out[i] += share * weighted[i] / weight[i];
    }
  }
  return out;
}

class Durand final : public ToneMap {
 public:
  Durand(float sigmaSpace, float sigmaRange) : sigmaSpace(sigmaSpace), sigmaRange(sigmaRange) {}
  bool measuresPicture() const override { return true; }
  bool isLocal() const override { return true; }
  float haloBound() const override { return 0.05f; }

  void apply(Image& picture) const override {
    std::vector<float> light = luminances(picture);
    const float brightest = *std::max_element(light.begin(), light.end());
    if (!(brightest > 0)) return;
    // Luminances more than six decades below the brightest are clamped.
    for (float& y : light) y = std::log10(std::max(y, 1e-6f * brightest));
    const std::vector<float> base =
        bilateral(light, picture.width, picture.height,
                  sigmaSpace * float(std::max(picture.width, picture.height)), sigmaRange);
    // Contrast of the base around the grey card, such that its bright end becomes white; never increased.
    std::vector<float> sorted = base;
    const auto top = sorted.begin() + std::ptrdiff_t(0.999 * double(sorted.size() - 1));
    std::nth_element(sorted.begin(), top, sorted.end());
    const float grey = std::log10(GREY_CARD);
    const float contrast = *top > 0 ? -grey / (*top - grey) : 1;
    size_t i = 0;
    changeColours(picture, [&](const Rgb& colour) {
      const float y = luminance(colour) * std::pow(10.0f, (contrast - 1) * (base[i] - grey));
      ++i;
      return withLuminance(colour, y);
    });
  }

 private:
  float sigmaSpace, sigmaRange;
};

} // namespace

void registerDurand(PlugIns& plugIns) {
  plugIns.toneMaps.add(
      {{.name = "durand",
        .summary =
            "Local operator by the bilateral filter: less contrast, all details (Durand and Dorsey 2002).",
        .parameters =
            {realParameter("sigmaspace", "0.02",
                           "spatial width of the filter, as a fraction of the longer side")
                 .range(0.001, 0.2),
             realParameter("sigmarange", "0.4", "width of the filter in luminance [decades]").range(0.05, 2)},
        .examples = {"", "\"float sigmarange\" 0.2"}},
       [](const Parameters& p, const NoContext&) {
         return std::make_unique<Durand>(static_cast<float>(p.real("sigmaspace")),
                                         static_cast<float>(p.real("sigmarange")));
       }});
}

} // namespace recurse
