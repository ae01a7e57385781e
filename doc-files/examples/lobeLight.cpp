/** @file
 * A small lamp that shines forward, as light emitting diodes do: its intensity falls with a power of the
 * cosine.
 */
#include <cmath>

#include "recurse/core/sampling/sampling.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** Intensity I cosᵐ θ around an axis; none backward. */
class LobeLight final : public Light {
 public:
  LobeLight(const Vec3f& position, const Vec3f& axis, const Rgb& intensity, float exponent)
      : position(position), frame(axis), intensity(intensity), exponent(exponent) {}

  LightKind kind() const override { return LightKind::POINT; }
  /** ∫ cosᵐ θ over the hemisphere is 2π / (m + 1). */
  Rgb power() const override { return intensity * (2 * PI / (exponent + 1)); }

  /** A photon, in proportion to the intensity, so that all have the same flux. */
  std::optional<LeSample> sampleLe(const LeRandom& sample) const override {
    const float cosine = std::pow(1 - sample.direction.x, 1 / (exponent + 1));
    const float sine = std::sqrt(std::max(0.0f, 1 - square(cosine))), phi = 2 * PI * sample.direction.y;
    const Vec3f direction = frame.toWorld({sine * std::cos(phi), sine * std::sin(phi), cosine});
    return LeSample{{position, direction}, intensity * lobe(cosine), 1, pdf(cosine), power()};
  }
  LePdf pdfLe(const LeRay& ray) const override { return {0, pdf(glm::dot(ray.direction, frame.z)), true}; }

  /** Result for a shadow ray: the direction to the light, and the irradiance perpendicular to it. */
  std::optional<LiSample> sampleLi(const Vec3f& point, float, const Vec2f&) const override {
    const Vec3f towards = position - point;
    const float distance = glm::length(towards);
    if (!(distance > 0)) return {};
    const Vec3f direction = towards / distance;
    const Rgb arriving = intensity * (lobe(-glm::dot(direction, frame.z)) / square(distance));
    if (isBlack(arriving)) return {};
    return LiSample{direction, position, distance, arriving, 1, true};
  }

 private:
  float lobe(float cosine) const { return cosine > 0 ? std::pow(cosine, exponent) : 0; }
  float pdf(float cosine) const { return (exponent + 1) / (2 * PI) * lobe(cosine); }

  Vec3f position;
  Frame frame; ///< z: the axis
  Rgb intensity;
  float exponent;
};

} // namespace

void registerLobeLight(PlugIns& plugIns) {
  plugIns.lights.add(
      {{.name = "lobe",
        .summary =
            "A lamp at a point whose intensity falls with a power of the cosine to its axis, light space +z.",
        .parameters =
            {spectrumParameter("I", "1", SpectrumKind::ILLUMINANT, "intensity along the axis [W/sr]"),
             realParameter("halfangle", "60", "where the intensity is half of that [degrees]").range(1, 89)},
        .examples = {"\"rgb I\" [3 2 1]", "\"float halfangle\" 15"}},
       [](const Parameters& p, const LightContext& c) {
         const Vec3d axis = glm::normalize(transformVector(c.sceneFromLight, {0, 0, 1}));
         const double exponent = -std::log(2.0) / std::log(std::cos(glm::radians(p.real("halfangle"))));
         return std::make_unique<LobeLight>(Vec3f(transformPoint(c.sceneFromLight, Vec3d(0))), Vec3f(axis),
                                            Rgb(p.spectrum("I")), float(exponent));
       }});
}

} // namespace recurse
