/** @file
 * Spot light: a point light with a cone and a soft edge.
 */
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** The falloff is smoothstep in the cosine between the edge and the full cone, as in pbrt-v4. */
class Spot final : public Light {
 public:
  Spot(const Vec3f& position, const Vec3f& axis, const Rgb& intensity, double cosEdge, double cosFull)
      : position(position), frame(axis), intensity(intensity), cosEdge(cosEdge), cosFull(cosFull),
        pdfInside(static_cast<float>(1 / solidAngle(cosEdge, cosFull))) {}

  /** ∫ falloff dω over 2π: the full cone, and half of the soft ring, since smoothstep has mean 1/2. */
  static double solidAngle(double cosEdge, double cosFull) {
    return 2 * double(PI) * ((1 - cosFull) + (cosFull - cosEdge) / 2);
  }
  LightKind kind() const override { return LightKind::POINT; }
  Rgb power() const override { return intensity * static_cast<float>(solidAngle(cosEdge, cosFull)); }

  std::optional<LeSample> sampleLe(const LeRandom& sample) const override {
    // Directions are sampled in proportion to the falloff, so that every photon has the same flux.
    const double full = 1 - cosFull, ring = (cosFull - cosEdge) / 2;
    const Vec2f& u = sample.direction;
    double c = double(u.x) * (full + ring);
    c = c < full ? 1 - c : cosEdge + (cosFull - cosEdge) * inverseSmoothStep((c - full) / ring);
    const double s = std::sqrt(std::max(0.0, (1 - c) * (1 + c)));
    const float phi = 2 * PI * u.y;
    const Vec3f local(static_cast<float>(s) * std::cos(phi), static_cast<float>(s) * std::sin(phi),
                      static_cast<float>(c));
    const float part = falloff(c);
    return LeSample{{position, frame.toWorld(local)}, intensity * part, 1, part * pdfInside, power()};
  }
  LePdf pdfLe(const LeRay& ray) const override {
    return {0, falloff(double(glm::dot(ray.direction, frame.z))) * pdfInside, true};
  }
  std::optional<LiSample> sampleLi(const Vec3f& point, float, const Vec2f&) const override {
    const Vec3f towards = position - point;
    const float distance2 = lengthSquared(towards);
    if (distance2 == 0) return {};
    const float distance = std::sqrt(distance2);
    const Vec3f direction = towards / distance;
    const float part = falloff(-glm::dot(direction, frame.z));
    if (!(part > 0)) return {};
    return LiSample{direction, position, distance, intensity * (part / distance2), 1, true};
  }

 private:
  /** Intensity relative to the full cone, at an angle of cosine c to the axis. */
  float falloff(double c) const {
    if (c <= cosEdge) return 0;
    if (c >= cosFull) return 1;
    const auto x = static_cast<float>((c - cosEdge) / (cosFull - cosEdge));
    return x * x * (3 - 2 * x);
  }
  /** Solves ∫₀ˣ smoothstep = u/2, that is 2x³ − x⁴ = u, for x in [0,1] by bisection and Newton's steps. */
  static double inverseSmoothStep(double u) {
    double low = 0, high = 1, x = 0.5;
    for (int i = 0; i < 60; ++i) {
      const double error = x * x * x * (2 - x) - u;
      if (std::abs(error) < 1e-12) break;
      (error < 0 ? low : high) = x;
      const double slope = x * x * (6 - 4 * x);
      const double next = slope > 0 ? x - error / slope : low;
      x = next > low && next < high ? next : (low + high) / 2;
    }
    return x;
  }

  Vec3f position;
  Frame frame;
  Rgb intensity;
  double cosEdge, cosFull;
  float pdfInside; ///< density of directions in the full cone [1/sr]
};

} // namespace

void registerSpot(PlugIns& plugIns) {
  plugIns.lights.add(
      {{.name = "spot",
        .summary = "A light at a point that emits into a cone, with a smoothstep falloff at its edge.",
        .parameters =
            {spectrumParameter("I", "1", SpectrumKind::ILLUMINANT,
                               "radiant intensity inside the cone [W/sr]"),
             realParameter("scale", "1", "factor on I").range(0, 1e30),
             realParameter("power", "", "total power [W]; replaces the scale of I").positive(),
             arrayParameter(ParameterType::POINT3, "from", 1, "0 0 0", "position"),
             arrayParameter(ParameterType::POINT3, "to", 1, "0 0 1", "a point on the axis of the cone"),
             realParameter("coneangle", "30", "angle between the axis and the edge of the cone [degrees]")
                 .range(1e-3, 180),
             realParameter("conedeltaangle", "5", "width of the falloff, inside of the cone [degrees]")
                 .range(0, 180)},
        .examples = {"\"point3 from\" [0 1 0] \"point3 to\" [0 0 0] \"float coneangle\" 40",
                     "\"float conedeltaangle\" 0"}},
       [](const Parameters& p, const LightContext& c) {
         const Vec3d from = transformPoint(c.sceneFromLight, p.vector3("from"));
         const Vec3d axis = transformPoint(c.sceneFromLight, p.vector3("to")) - from;
         if (!(glm::length(axis) > 0)) p.fail("to", "\"from\" and \"to\" are the same point");
         if (p.real("conedeltaangle") > p.real("coneangle"))
           p.fail("conedeltaangle", "the falloff is wider than the cone", "at most \"coneangle\"");
         const double cosEdge = std::cos(glm::radians(p.real("coneangle")));
         const double cosFull = std::cos(glm::radians(p.real("coneangle") - p.real("conedeltaangle")));
         double scale = p.real("scale");
         if (p.hasValue("power")) scale *= p.real("power") / Spot::solidAngle(cosEdge, cosFull);
         return std::make_unique<Spot>(Vec3f(from), Vec3f(glm::normalize(axis)), Rgb(p.spectrum("I") * scale),
                                       cosEdge, cosFull);
       }});
}

} // namespace recurse
