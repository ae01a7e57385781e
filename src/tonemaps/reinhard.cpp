/** @file
 * The global operator of Reinhard et al. 2002, "Photographic Tone Reproduction for Digital Images".
 */
#include "recurse/model/film/toneCurve.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class Reinhard final : public ToneMap {
 public:
  explicit Reinhard(float white) : white(white) {}
  bool measuresPicture() const override { return white == 0; }
  void apply(Image& picture) const override {
    const float w = white > 0 ? white : std::max(1.0f, luminanceQuantile(picture, 0.999));
    // Equation 4 with L = s · luminance and L_white = s · w; s keeps the grey card.
    const float s = (1 - GREY_CARD / (w * w)) / (1 - GREY_CARD);
    changeColours(picture, [&](const Rgb& colour) {
      const float y = luminance(colour);
      return withLuminance(colour, (s * y + y * y / (w * w)) / (1 + s * y));
    });
  }

 private:
  float white;
};

} // namespace

void registerReinhard(PlugIns& plugIns) {
  plugIns.toneMaps.add(
      {{.name = "reinhard",
        .summary = "Global photographic operator (Reinhard et al. 2002, equation 4).",
        .parameters = {realParameter("white", "0",
                                     "luminance that becomes white, where middle grey is 0.18; 0: the 99.9th "
                                     "percentile of the picture, at least 1")
                           .range(0, 1e6)},
        .examples = {"", "\"float white\" 6"}},
       [](const Parameters& p, const NoContext&) {
         const double white = p.real("white");
         if (white != 0 && white < 1) p.fail("white", "white must be brighter than grey", "0, or at least 1");
         return std::make_unique<Reinhard>(static_cast<float>(white));
       }});
}

} // namespace recurse
