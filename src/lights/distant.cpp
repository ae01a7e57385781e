/** @file
 * Parallel light from infinity.
 */
#include "recurse/core/sampling/sampling.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class Distant final : public Light {
 public:
  Distant(const Vec3f& towardsLight, const Rgb& irradiance) : frame(towardsLight), irradiance(irradiance) {}
  LightKind kind() const override { return LightKind::DISTANT; }
  void prepare(const SceneBounds& b) override { bounds = b; }
  Rgb power() const override { return irradiance * (PI * square(bounds.radius)); }
  std::optional<LeSample> sampleLe(const LeRandom& sample) const override {
    const Vec2f d = uniformDisk(sample.position) * bounds.radius;
    return LeSample{{bounds.center + frame.z * bounds.radius + frame.x * d.x + frame.y * d.y, -frame.z},
                    irradiance,
                    bounds.pdfDisc(),
                    1,
                    power()};
  }
  LePdf pdfLe(const LeRay&) const override { return {bounds.pdfDisc(), 0, false, true}; }
  std::optional<LiSample> sampleLi(const Vec3f& point, float, const Vec2f&) const override {
    return LiSample{frame.z, point, INFINITE, irradiance, 1, true};
  }

 private:
  Frame frame;
  Rgb irradiance;
  SceneBounds bounds;
};

} // namespace

void registerDistant(PlugIns& plugIns) {
  plugIns.lights.add(
      {{.name = "distant",
        .summary = "Parallel light from an infinite distance, such as sunlight.",
        .parameters = {spectrumParameter("L", "1", SpectrumKind::ILLUMINANT,
                                         "irradiance of a surface perpendicular to the light [W/m²]"),
                       realParameter("scale", "1", "factor on L").range(0, 1e30),
                       realParameter("illuminance", "", "irradiance to which L is scaled").positive(),
                       arrayParameter(ParameterType::POINT3, "from", 1, "0 0 0",
                                      "point that the light comes from ..."),
                       arrayParameter(ParameterType::POINT3, "to", 1, "0 0 1",
                                      "... and that it goes to; only the direction is used")},
        .examples = {"\"point3 from\" [1 2 3] \"point3 to\" [0 0 0] \"rgb L\" [2 2 1]"}},
       [](const Parameters& p, const LightContext& c) {
         const Vec3d towards = transformVector(c.sceneFromLight, p.vector3("from") - p.vector3("to"));
         if (!(glm::length(towards) > 0)) p.fail("to", "\"from\" and \"to\" are the same point");
         double scale = p.real("scale");
         if (p.hasValue("illuminance")) scale *= p.real("illuminance");
         return std::make_unique<Distant>(Vec3f(glm::normalize(towards)), Rgb(p.spectrum("L") * scale));
       }});
}

} // namespace recurse
