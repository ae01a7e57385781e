/** @file
 * A texture times a number or a colour.
 */
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class Scale final : public Texture {
 public:
  Scale(const TexturedRgb& texture, const TexturedRgb& factor, const Rgb& tint)
      : texture(texture), factor(factor), tint(tint) {}
  Rgb value(const SurfacePoint& point) const override {
    const Rgb f = factor.at(point);
    return isBlack(f) ? f : texture.at(point) * f * tint;
  }

 private:
  TexturedRgb texture, factor;
  Rgb tint;
};

} // namespace

void registerScale(PlugIns& plugIns) {
  plugIns.textures.add(
      {{.name = "scale",
        .summary = "A texture multiplied by a number and by a colour.",
        .parameters = {textureValue("tex", "1", "the texture"),
                       realParameter("scale", "1", "the number").withTexture(),
                       spectrumParameter("tint", "1", SpectrumKind::UNBOUNDED,
                                         "factor as a colour; a float texture uses its red")},
        .examples = {"\"float tex\" .5 \"float scale\" .8"}},
       [](const Parameters& p, const TextureContext& c) {
         return std::make_unique<Scale>(c.value(p, "tex"), c.textures.real(p, "scale"),
                                        Rgb(p.spectrum("tint")));
       }});
}

} // namespace recurse
