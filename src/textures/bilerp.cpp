/** @file
 * Bilinear interpolation between four corners.
 */
#include "recurse/model/scene/plugIns.h"
#include "recurse/model/texture/textureMapping.h"

namespace recurse {

namespace {

class Bilerp final : public Texture {
 public:
  Bilerp(const Parameters& p, const TextureContext& c)
      : mapping(p, c), v00(c.value(p, "v00").constant), v01(c.value(p, "v01").constant),
        v10(c.value(p, "v10").constant), v11(c.value(p, "v11").constant) {}
  /** The mean over the footprint is the value in its middle. */
  Rgb value(const SurfacePoint& point) const override {
    const Vec2f p = mapping.at(point).st;
    return (v00 * (1 - p.x) + v10 * p.x) * (1 - p.y) + (v01 * (1 - p.x) + v11 * p.x) * p.y;
  }

 private:
  TextureMapping mapping;
  Rgb v00, v01, v10, v11;
};

} // namespace

void registerBilerp(PlugIns& plugIns) {
  const auto corner = [](const char* name, const char* value, const char* where) {
    ParameterSpec s = textureValue(name, value, where);
    s.textured = false;
    return s;
  };
  plugIns.textures.add(
      {{.name = "bilerp",
        .summary =
            "Bilinear interpolation between the corners of the unit square, extrapolated outside of it.",
        .parameters =
            withMapping({corner("v00", "0", "value at (0, 0)"), corner("v01", "1", "value at (0, 1)"),
                         corner("v10", "0", "value at (1, 0)"), corner("v11", "1", "value at (1, 1)")}),
        .examples = {"\"float v00\" .2 \"float v01\" .4 \"float v10\" .6 \"float v11\" .8"}},
       [](const Parameters& p, const TextureContext& c) { return std::make_unique<Bilerp>(p, c); }});
}

} // namespace recurse
