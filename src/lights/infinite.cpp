/** @file
 * The same radiance from everywhere outside the scene.
 */
#include "recurse/core/sampling.h"
#include "recurse/model/plugIns.h"

namespace recurse {

namespace {

class Infinite final : public EnvironmentLight {
 public:
  explicit Infinite(const Rgb& radiance) : constant(radiance) {}
  void prepare(const SceneBounds& b) override { bounds = b; }
  Rgb power() const override { return constant * (4 * square(PI * bounds.radius)); }
  std::optional<Emission> emit(const EmissionSample& sample) const override {
    // A disc over the bounding sphere, seen from a direction that is uniform on the sphere.
    const Frame frame(uniformSphere(sample.direction));
    const Vec2f d = uniformDisk(sample.place) * bounds.radius;
    return Emission{bounds.center + frame.z * bounds.radius + frame.x * d.x + frame.y * d.y, -frame.z,
                    power()};
  }
  std::optional<Illumination> illuminate(const Vec3f&, float, const Vec2f& u) const override {
    return Illumination{uniformSphere(u), Vec3f(0), INFINITE, constant, pdfIlluminate({}), false};
  }
  Rgb radiance(const Vec3f&) const override { return constant; }
  float pdfIlluminate(const Vec3f&) const override { return 1 / (4 * PI); }

 private:
  Rgb constant;
  SceneBounds bounds;
};

} // namespace

void registerInfinite(PlugIns& plugIns) {
  plugIns.lights.add(
      {{.name = "infinite",
        .summary = "The same radiance from everywhere outside the scene.",
        .parameters = {spectrumParameter("L", "1", SpectrumKind::ILLUMINANT, "radiance [W/(m² sr)]"),
                       realParameter("scale", "1", "factor on L").range(0, 1e30),
                       realParameter("illuminance", "", "irradiance that L is scaled to").positive(),
                       stringParameter("filename", "", "a picture of the surroundings; not rendered yet")},
        .examples = {"\"rgb L\" [.4 .45 .5]"}},
       [](const Parameters& p, const LightContext&) {
         if (p.has("filename"))
           p.fail("filename", "environment pictures are not rendered yet", "a constant \"L\"");
         double scale = p.real("scale");
         if (p.hasValue("illuminance")) scale *= p.real("illuminance") / double(PI);
         return std::make_unique<Infinite>(Rgb(p.spectrum("L") * scale));
       }});
}

} // namespace recurse
