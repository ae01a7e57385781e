/** @file
 * Polka dots: at most one in each unit cell.
 */
#include "recurse/model/scene/plugIns.h"
#include "recurse/model/texture/noise.h"

namespace recurse {

namespace {

/** Whether a point is in a dot. Noise decides which cells have a dot and its position in the cell. Planes
 * and offsets of the noise are pbrt's, so that the dots are at the same positions. */
bool inDot(const Vec2d& st) {
  constexpr double RADIUS = 0.35, PLAY = 0.5 - RADIUS;
  const auto noise = [](double x, double y) { return perlinNoise({x, y, 0.5}); };
  const Vec2d cell = glm::floor(st + 0.5);
  if (!(noise(cell.x + 0.5, cell.y + 0.5) > 0)) return false;
  const Vec2d centre =
      cell + PLAY * Vec2d(noise(cell.x + 1.5, cell.y + 2.8), noise(cell.x + 4.5, cell.y + 9.8));
  const Vec2d away = st - centre;
  return glm::dot(away, away) < square(RADIUS);
}

class Dots final : public Texture {
 public:
  Dots(const TextureMapping& mapping, const TexturedRgb& inside, const TexturedRgb& outside)
      : mapping(mapping), inside(inside), outside(outside) {}
  Rgb value(const SurfacePoint& point) const override {
    return (inDot(mapping.at(point).st) ? inside : outside).at(point);
  }

 private:
  TextureMapping mapping;
  TexturedRgb inside, outside;
};

} // namespace

void registerDots(PlugIns& plugIns) {
  plugIns.textures.add(
      {{.name = "dots",
        .summary = "Random dots of radius 0.35, at most one in each unit square of (s, t).",
        .parameters = withMapping(
            {textureValue("inside", "1", "texture of the dots"), textureValue("outside", "0", "elsewhere")}),
        .examples = {"\"float inside\" .7 \"float outside\" .3 \"float uscale\" 10 \"float vscale\" 10"}},
       [](const Parameters& p, const TextureContext& c) {
         return std::make_unique<Dots>(TextureMapping(p, c), c.value(p, "inside"), c.value(p, "outside"));
       }});
}

} // namespace recurse
