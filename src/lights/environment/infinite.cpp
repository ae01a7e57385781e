/** @file
 * Environment light: uniform radiance, or a picture of the surroundings.
 */
#include "lights/environment/environmentMapLight.h"
#include "lights/maps/lightProbe.h"
#include "recurse/core/sampling/sampling.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class Uniform final : public EnvironmentLight {
 public:
  explicit Uniform(const Rgb& radiance) : constant(radiance) {}
  void prepare(const SceneBounds& b) override { bounds = b; }
  Rgb power() const override { return constant * (4 * square(PI * bounds.radius)); }
  std::optional<LeSample> sampleLe(const LeRandom& sample) const override {
    // Uniform point on a disc that covers the bounding sphere, perpendicular to a uniform direction.
    const Frame frame(uniformSphere(sample.direction));
    const Vec2f d = uniformDisk(sample.position) * bounds.radius;
    return LeSample{{bounds.center + frame.z * bounds.radius + frame.x * d.x + frame.y * d.y, -frame.z},
                    constant,
                    bounds.pdfDisc(),
                    UNIFORM,
                    power()};
  }
  LePdf pdfLe(const LeRay&) const override { return {bounds.pdfDisc(), UNIFORM}; }
  std::optional<LiSample> sampleLi(const Vec3f& point, float, const Vec2f& u) const override {
    return LiSample{uniformSphere(u), point, INFINITE, constant, UNIFORM};
  }
  Rgb radiance(const Vec3f&) const override { return constant; }
  float pdfLi(const Vec3f&, const Vec3f&) const override { return UNIFORM; }

 private:
  static constexpr float UNIFORM = 1 / (4 * PI);
  Rgb constant;
  SceneBounds bounds;
};

std::array<Vec3d, 4> portalCorners(const Parameters& p, const Vec3d& origin) {
  const std::vector<Vec3d> given = p.vector3s("portal");
  const Vec3d along = given[3] - given[0], up = given[1] - given[0];
  const double size = glm::length(along) * glm::length(up);
  constexpr double TOLERANCE = 1e-3;
  if (!(size > 0) || std::abs(glm::dot(along, up)) > TOLERANCE * size ||
      glm::length(given[2] - given[1] - along) > TOLERANCE * std::sqrt(size))
    p.fail("portal", "the four points are no rectangle", "the corners in order around the rectangle");
  return {given[0] - origin, given[1] - origin, given[2] - origin, given[3] - origin};
}

std::unique_ptr<Light> makeInfinite(const Parameters& p, const LightContext& c) {
  double scale = p.real("scale");
  const bool scaled = p.hasValue("illuminance"), portal = p.has("portal");
  if (p.has("filename") && p.has("L"))
    p.fail("L", "both a picture and \"L\" are given", "\"filename\" or \"L\"; \"scale\" for both");
  std::optional<EnvironmentMap> map;
  Rgb factor(1);
  if (p.has("filename")) {
    map = readLightProbe(p);
    if (scaled) {
      const double upper = map->upperIrradiance();
      if (!(upper > 0))
        p.fail("illuminance", "the upper half of the picture is black and has no irradiance to scale",
               "\"scale\"");
      scale *= 2 * p.real("illuminance") / upper;
    }
  } else {
    if (p.has("mapping")) p.fail("mapping", "\"mapping\" is given without a picture", "\"string filename\"");
    if (scaled) scale *= p.real("illuminance") / double(PI);
    const Rgb radiance(p.spectrum("L") * scale);
    if (!portal) return std::make_unique<Uniform>(radiance);
    Image white(1, 1, {"R", "G", "B"});
    white.pixels = {1, 1, 1};
    map.emplace(white, EnvironmentMapping::EQUAL_AREA);
    factor = Rgb(p.spectrum("L"));
  }
  const double determinant = glm::determinant(Mat3d(c.sceneFromLight));
  if (!std::isfinite(determinant) || determinant == 0)
    p.fail("", "the light's transform is singular: it cannot be inverted");
  auto light = std::make_unique<EnvironmentMapLight>(std::move(*map), factor * static_cast<float>(scale),
                                                     c.sceneFromLight);
  if (portal) light->addPortal(portalCorners(p, c.sceneOrigin));
  return light;
}

} // namespace

void registerInfinite(PlugIns& plugIns) {
  plugIns.lights.add(
      {{.name = "infinite",
        .summary = "Light from all directions outside of the scene: constant radiance, or an environment "
                   "map. Its upper edge (\"latlong\") or middle (\"equalarea\") is +z of light space; in "
                   "other layouts the front is towards -x, and the right towards -y.",
        .parameters = {spectrumParameter("L", "1", SpectrumKind::ILLUMINANT, "radiance [W/(m² sr)]"),
                       realParameter("scale", "1", "factor on L or on the picture").range(0, 1e30),
                       realParameter("illuminance", "",
                                     "irradiance of a surface to which L is scaled; for a picture, half of "
                                     "the irradiance from above (+z), as pbrt-v4 computes it")
                           .positive(),
                       stringParameter("filename", "", "environment map"),
                       stringParameter("mapping", "",
                                       "mapping of directions: pbrt-v4's octahedral map of equal areas, "
                                       "latitude-longitude (azimuth from +x to +y), Debevec's angular map, "
                                       "mirror ball, cube; by default chosen by the shape of the picture")
                           .oneOf(probeLayouts()),
                       arrayParameter(
                           ParameterType::POINT3, "portal", 4, "",
                           "portal: corners of a rectangle in world space, with sides p3-p0 and p1-p0 and "
                           "their cross product pointing outwards; light is sampled through it first")},
        .examples = {"\"rgb L\" [.4 .45 .5]", "\"string filename\" \"scenes/textures/evening.hdr\"",
                     "\"string filename\" \"scenes/textures/evening.hdr\" \"float scale\" 2 "
                     "\"point3 portal\" [-.5 1.5 -1  1.5 1.5 -1  1.5 1.5 .5  -.5 1.5 .5]"}},
       makeInfinite});
}

} // namespace recurse
