/** @file
 * Two textures mixed: by an amount, or by the direction that the surface faces.
 */
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

Rgb mixture(const TexturedRgb& first, const TexturedRgb& second, const Rgb& amount,
            const SurfacePoint& point) {
  if (amount == Rgb(0)) return first.at(point);
  if (amount == Rgb(1)) return second.at(point);
  return first.at(point) * (1.0f - amount) + second.at(point) * amount;
}

class Mix final : public Texture {
 public:
  Mix(const TexturedRgb& first, const TexturedRgb& second, const TexturedRgb& amount)
      : first(first), second(second), amount(amount) {}
  Rgb value(const SurfacePoint& point) const override {
    return mixture(first, second, amount.at(point), point);
  }

 private:
  TexturedRgb first, second, amount;
};

class DirectionMix final : public Texture {
 public:
  DirectionMix(const TexturedRgb& first, const TexturedRgb& second, const Vec3f& direction)
      : first(first), second(second), direction(direction) {}
  Rgb value(const SurfacePoint& point) const override {
    return mixture(second, first, Rgb(std::min(absDot(point.geometricNormal, direction), 1.0f)), point);
  }

 private:
  TexturedRgb first, second;
  Vec3f direction; ///< unit, in the scene
};

std::unique_ptr<Texture> makeDirectionMix(const Parameters& p, const TextureContext& c) {
  const Vec3d direction = transformVector(c.worldFromTexture, p.vector3("dir"));
  const double length = glm::length(direction);
  if (!(length > 0)) p.fail("dir", "\"dir\" has no direction", "a vector that is not zero");
  return std::make_unique<DirectionMix>(c.value(p, "tex1"), c.value(p, "tex2"), Vec3f(direction / length));
}

} // namespace

void registerMixTextures(PlugIns& plugIns) {
  plugIns.textures.add(
      {{.name = "mix",
        .summary = "Blends two textures.",
        .parameters =
            {textureValue("tex1", "0", "the first texture"), textureValue("tex2", "1", "the second texture"),
             realParameter("amount", "0.5", "weight of the second texture").range(0, 1).withTexture()},
        .examples = {"\"float tex1\" .2 \"float tex2\" .9 \"float amount\" .25"}},
       [](const Parameters& p, const TextureContext& c) {
         return std::make_unique<Mix>(c.value(p, "tex1"), c.value(p, "tex2"), c.textures.real(p, "amount"));
       }});
  plugIns.textures.add(
      {{.name = "directionmix",
        .summary = "Blends two textures by the direction of the surface normal.",
        .parameters =
            {textureValue("tex1", "0", "texture if the normal is parallel to `dir`, in either direction"),
             textureValue("tex2", "1", "texture if the normal is perpendicular to `dir`"),
             arrayParameter(ParameterType::VECTOR3, "dir", 1, "0 1 0",
                            "direction in texture space; the weight of tex1 is the absolute cosine")},
        .examples = {"\"float tex1\" .8 \"vector3 dir\" [1 1 0]"}},
       makeDirectionMix});
}

} // namespace recurse
