/** @file
 * Squares or cubes of two textures in turn, averaged over the footprint in closed form.
 */
#include "recurse/model/scene/plugIns.h"
#include "recurse/model/texture/noise.h"

namespace recurse {

namespace {

/** Mean over [x - r, x + r] of the square wave that is 1 on [0, 1), -1 on [1, 2), and so on. */
double squareWave(double x, double r) {
  const auto sign = [](double cell) { return std::fmod(cell, 2) == 0 ? 1.0 : -1.0; };
  if (std::floor(x - r) == std::floor(x + r)) return sign(std::floor(x));
  // The integral of the wave is a triangle wave: up from 0 to 1, and down again.
  const auto integral = [](double y) { return 1 - std::abs(1 - (y - 2 * std::floor(y / 2))); };
  return (integral(x + r) - integral(x - r)) / (2 * r);
}

class Checkerboard final : public Texture {
 public:
  Checkerboard(const TexturedRgb& first, const TexturedRgb& second, std::optional<TextureMapping> mapping,
               const TextureSpace& space)
      : first(first), second(second), mapping(std::move(mapping)), space(space) {}
  Rgb value(const SurfacePoint& point) const override {
    double wave = 1;
    if (mapping) {
      const MappedCoordinates m = mapping->at(point);
      const Vec2f r = m.extent();
      for (int i = 0; i < 2; ++i) wave *= squareWave(double(m.st[i]), double(r[i]));
    } else {
      const MappedPoint m = space.at(point);
      const Vec3f r = 0.5f * (glm::abs(m.alongX) + glm::abs(m.alongY));
      for (int i = 0; i < 3; ++i) wave *= squareWave(m.p[i], double(r[i]));
    }
    const auto part = static_cast<float>(0.5 + 0.5 * wave);
    if (part == 1) return first.at(point);
    if (part == 0) return second.at(point);
    return first.at(point) * part + second.at(point) * (1 - part);
  }

 private:
  TexturedRgb first, second;
  std::optional<TextureMapping> mapping; ///< empty: three dimensions
  TextureSpace space;
};

} // namespace

void registerCheckerboard(PlugIns& plugIns) {
  plugIns.textures.add(
      {{.name = "checkerboard",
        .summary = "A checkerboard of two textures in squares or cubes.",
        .parameters = withMapping(
            {integerParameter("dimension", "2", "2: squares of (s, t); 3: cubes in texture space")
                 .range(2, 3),
             textureValue("tex1", "1",
                          "texture of the square from (0, 0) to (1, 1), and of every second square"),
             textureValue("tex2", "0", "texture of the other squares")}),
        .examples = {"\"float uscale\" 8 \"float vscale\" 8 \"float tex1\" .8 \"float tex2\" .2",
                     "\"integer dimension\" 3"}},
       [](const Parameters& p, const TextureContext& c) {
         const TextureMapping mapping(p, c);
         return std::make_unique<Checkerboard>(
             c.value(p, "tex1"), c.value(p, "tex2"),
             p.integer("dimension") == 2 ? std::optional(mapping) : std::nullopt, TextureSpace(c));
       }});
}

} // namespace recurse
