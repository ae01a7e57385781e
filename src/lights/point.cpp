/** @file
 * Point light of uniform intensity.
 */
#include "recurse/core/sampling/sampling.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class Point final : public Light {
 public:
  Point(const Vec3f& position, const Rgb& intensity) : position(position), intensity(intensity) {}
  LightKind kind() const override { return LightKind::POINT; }
  Rgb power() const override { return intensity * (4 * PI); }
  std::optional<LeSample> sampleLe(const LeRandom& sample) const override {
    return LeSample{{position, uniformSphere(sample.direction)}, intensity, 1, UNIFORM, power()};
  }
  LePdf pdfLe(const LeRay&) const override { return {0, UNIFORM, true}; }
  std::optional<LiSample> sampleLi(const Vec3f& point, float, const Vec2f&) const override {
    const Vec3f towards = position - point;
    const float distance2 = lengthSquared(towards);
    if (distance2 == 0) return {};
    const float distance = std::sqrt(distance2);
    return LiSample{towards / distance, position, distance, intensity / distance2, 1, true};
  }

 private:
  static constexpr float UNIFORM = 1 / (4 * PI);
  Vec3f position;
  Rgb intensity;
};

} // namespace

void registerPoint(PlugIns& plugIns) {
  plugIns.lights.add(
      {{.name = "point",
        .summary = "A light at a point with the same intensity in all directions.",
        .parameters = {spectrumParameter("I", "1", SpectrumKind::ILLUMINANT, "radiant intensity [W/sr]"),
                       realParameter("scale", "1", "factor on I").range(0, 1e30),
                       realParameter("power", "", "total power [W]; replaces the scale of I").positive(),
                       arrayParameter(ParameterType::POINT3, "from", 1, "0 0 0", "position")},
        .examples = {"\"rgb I\" [3 2 1] \"point3 from\" [0 .5 0]"}},
       [](const Parameters& p, const LightContext& c) {
         double scale = p.real("scale");
         if (p.hasValue("power")) scale *= p.real("power") / (4 * double(PI));
         return std::make_unique<Point>(Vec3f(transformPoint(c.sceneFromLight, p.vector3("from"))),
                                        Rgb(p.spectrum("I") * scale));
       }});
}

} // namespace recurse
