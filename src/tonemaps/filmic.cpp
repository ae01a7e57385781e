/** @file
 * Filmic curves, applied to each channel, so that bright colours fade to white as they do on film.
 */
#include "recurse/model/film/toneCurve.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** Hable 2010, "Filmic Tonemapping for Real-time Rendering": a short toe and a long shoulder. The
 * difference ... - E/F of the publication is one fraction here, which is exactly 0 at 0. */
float hable(float x) {
  constexpr float A = 0.15f, B = 0.50f, C = 0.10f, D = 0.20f, E = 0.02f, F = 0.30f;
  return x * (A * (1 - E / F) * x + B * (C - E / F)) / (x * (A * x + B) + D * F);
}

float hableToWhite(float x) {
  constexpr float WHITE = 11.2f; // the linear white point of the publication
  static const float AT_WHITE = hable(WHITE);
  return hable(x) / AT_WHITE;
}

/** Narkowicz 2016, "ACES Filmic Tone Mapping Curve": a fit of the ACES reference transform. */
float aces(float x) { return x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f); }

template <float (*curve)(float)> class Filmic final : public ToneMap {
 public:
  void apply(Image& picture) const override {
    changeColours(picture, [this](const Rgb& c) {
      return Rgb(curve(scale * c.r), curve(scale * c.g), curve(scale * c.b));
    });
  }

 private:
  float scale = greyKeepingScale(curve);
};

} // namespace

void registerFilmic(PlugIns& plugIns) {
  plugIns.toneMaps.add(
      {{.name = "filmic",
        .summary =
            "A film curve of low contrast with a long shoulder (Hable 2010); luminance 3.8 becomes white.",
        .parameters = {},
        .examples = {""}},
       [](const Parameters&, const NoContext&) { return std::make_unique<Filmic<hableToWhite>>(); }});
  plugIns.toneMaps.add(
      {{.name = "aces",
        .summary = "A film curve of high contrast: Narkowicz's fit of the ACES reference transform (2016).",
        .parameters = {},
        .examples = {""}},
       [](const Parameters&, const NoContext&) { return std::make_unique<Filmic<aces>>(); }});
}

} // namespace recurse
