/** @file
 * A surface that emits the same radiance in all directions, from one side or both.
 */
#include "recurse/core/sampling.h"
#include "recurse/model/plugIns.h"

namespace recurse {

namespace {

class DiffuseArea final : public AreaLight {
 public:
  DiffuseArea(const Shape& shape, const Rgb& radiance, bool twoSided)
      : AreaLight(shape), constant(radiance), twoSided(twoSided) {}

  Rgb power() const override { return constant * (PI * shape().area() * (twoSided ? 2.0f : 1.0f)); }
  Rgb radiance(const SurfacePoint& point, const Vec3f& direction) const override {
    return twoSided || glm::dot(point.geometricNormal, direction) > 0 ? constant : BLACK;
  }
  std::optional<Emission> emit(const EmissionSample& sample) const override {
    const ShapeSample s = shape().sampleArea(sample.pick, sample.place);
    if (!(s.pdf > 0)) return {};
    Vec3f normal = s.point.geometricNormal;
    float sides = 1;
    Vec2f u = sample.direction;
    if (twoSided) { // one number for the side and what is left over of it
      if (u.x < 0.5f) normal = -normal;
      u.x = 2 * u.x - (u.x < 0.5f ? 0.0f : 1.0f);
      sides = 2;
    }
    const Vec3f direction = Frame(normal).toWorld(cosineHemisphere(u));
    return Emission{s.point.rayOrigin(direction), direction,
                    constant * (opacity(s.point) * PI * sides / s.pdf)};
  }
  std::optional<Illumination> illuminate(const Vec3f& point, float pick, const Vec2f& u) const override {
    std::optional<Illumination> light;
    const std::optional<ShapeSample> s = shape().sampleDirection(point, pick, u);
    if (!s) return light;
    const Vec3f towards = s->point.position - point;
    const float distance = glm::length(towards);
    if (!(distance > 0)) return light;
    const Vec3f direction = towards / distance;
    if (isBlack(DiffuseArea::radiance(s->point, -direction))) return light;
    light.emplace();
    light->direction = direction;
    light->target = s->point.rayOrigin(-direction);
    light->distance = distance;
    light->radiance = constant * opacity(s->point);
    light->pdf = s->pdf;
    light->delta = isUnseen();
    return light;
  }

 private:
  Rgb constant;
  bool twoSided;
};

} // namespace

void registerDiffuseArea(PlugIns& plugIns) {
  plugIns.areaLights.add(
      {{.name = "diffuse",
        .summary =
            "A surface that emits the same radiance in all directions; it also reflects with its material.",
        .parameters = {spectrumParameter("L", "1", SpectrumKind::ILLUMINANT, "emitted radiance [W/(m² sr)]"),
                       realParameter("scale", "1", "factor on L").range(0, 1e30),
                       realParameter("power", "", "total power [W] that L is scaled to").positive(),
                       booleanParameter("twosided", "false", "emits from the back as well"),
                       stringParameter("filename", "", "a picture that the surface shows; not rendered yet")},
        .examples = {"\"rgb L\" [4 3 2]", "\"float power\" 10 \"bool twosided\" true"}},
       [](const Parameters& p, const AreaLightContext& c) {
         if (p.has("filename"))
           p.fail("filename", "emitting pictures are not rendered yet", "a constant \"L\"");
         double scale = p.real("scale");
         if (p.hasValue("power"))
           scale *= p.real("power") / (double(PI) * double(c.shape.area()) * (p.boolean("twosided") ? 2 : 1));
         return std::make_unique<DiffuseArea>(c.shape, Rgb(p.spectrum("L") * scale), p.boolean("twosided"));
       }});
}

} // namespace recurse
