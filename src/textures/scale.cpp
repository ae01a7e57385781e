/** @file
 * A texture times a number.
 */
#include "recurse/model/plugIns.h"

namespace recurse {

namespace {

class Scale final : public Texture {
 public:
  Scale(const TexturedRgb& texture, const TexturedRgb& factor) : texture(texture), factor(factor) {}
  Rgb value(const SurfacePoint& point) const override {
    const Rgb f = factor.at(point);
    return isBlack(f) ? f : texture.at(point) * f;
  }

 private:
  TexturedRgb texture, factor;
};

} // namespace

void registerScale(PlugIns& plugIns) {
  plugIns.textures.add({{.name = "scale",
                         .summary = "A texture times a number.",
                         .parameters = {textureValue("tex", "1", "the texture"),
                                        realParameter("scale", "1", "the number").withTexture()},
                         .examples = {"\"float tex\" .5 \"float scale\" .8"}},
                        [](const Parameters& p, const TextureContext& c) {
                          return std::make_unique<Scale>(c.value(p, "tex"), c.textures.real(p, "scale"));
                        }});
}

} // namespace recurse
