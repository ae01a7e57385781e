/** @file
 * Spot light: a point light with a cone and a soft edge.
 */
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** The falloff is smoothstep in the cosine between the edge and the full cone, as in pbrt-v4. Angles are kept
 * as 1 − cosine (the opening of a cone): the cosine itself rounds to 1 in narrow cones. */
class Spot final : public Light {
 public:
  Spot(const Vec3f& position, const Vec3f& axis, const Rgb& intensity, double edge, double full)
      : position(position), frame(axis), intensity(intensity), edge(edge), full(full),
        pdfInside(static_cast<float>(1 / solidAngle(edge, full))) {}

  /** ∫ falloff dω: the full cone, and half of the soft ring, since smoothstep has mean 1/2. */
  static double solidAngle(double edge, double full) { return 2 * double(PI) * (full + (edge - full) / 2); }
  LightKind kind() const override { return LightKind::POINT; }
  Rgb power() const override { return intensity * static_cast<float>(solidAngle(edge, full)); }

  std::optional<LeSample> sampleLe(const LeRandom& sample) const override {
    // Directions are sampled in proportion to the falloff, so that every photon has the same flux.
    const double ring = (edge - full) / 2;
    const Vec2f& u = sample.direction;
    double opening = double(u.x) * (full + ring), x = 1;
    if (opening >= full) {
      x = inverseSmoothStep((opening - full) / ring);
      opening = edge - (edge - full) * x;
    }
    const float part = smoothStep(x);
    if (!(part > 0)) return {};
    const auto sine = static_cast<float>(std::sqrt(opening * (2 - opening)));
    const float phi = 2 * PI * u.y;
    const Vec3f local(sine * std::cos(phi), sine * std::sin(phi), static_cast<float>(1 - opening));
    return LeSample{{position, frame.toWorld(local)}, intensity * part, 1, part * pdfInside, power()};
  }
  LePdf pdfLe(const LeRay& ray) const override { return {0, falloff(ray.direction) * pdfInside, true}; }
  std::optional<LiSample> sampleLi(const Vec3f& point, float, const Vec2f&) const override {
    const Vec3f towards = position - point;
    const float distance2 = lengthSquared(towards);
    if (distance2 == 0) return {};
    const float distance = std::sqrt(distance2);
    const Vec3f direction = towards / distance;
    const float part = falloff(-direction);
    if (!(part > 0)) return {};
    return LiSample{direction, position, distance, intensity * (part / distance2), 1, true};
  }

 private:
  /** Intensity in a direction, relative to the full cone. */
  float falloff(const Vec3f& direction) const {
    const double opening = double(lengthSquared(direction - frame.z)) / 2;
    if (opening <= full) return 1;
    return opening < edge ? smoothStep((edge - opening) / (edge - full)) : 0;
  }
  static float smoothStep(double x) { return static_cast<float>(x * x * (3 - 2 * x)); }
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
  double edge, full; ///< openings of the cones outside of which it is dark, and inside of which it is full
  float pdfInside;   ///< density of directions in the full cone [1/sr]
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
         const auto opening = [](double degrees) { return 2 * square(std::sin(glm::radians(degrees) / 2)); };
         const double edge = opening(p.real("coneangle"));
         const double full = opening(p.real("coneangle") - p.real("conedeltaangle"));
         double scale = p.real("scale");
         if (p.hasValue("power")) scale *= p.real("power") / Spot::solidAngle(edge, full);
         return std::make_unique<Spot>(Vec3f(from), Vec3f(glm::normalize(axis)), Rgb(p.spectrum("I") * scale),
                                       edge, full);
       }});
}

} // namespace recurse
