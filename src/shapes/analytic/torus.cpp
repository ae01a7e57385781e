/** @file
 * Tori around the z axis, whole or swept in part.
 */
#include "recurse/core/math/polynomialRoots.h"
#include "recurse/model/scene/plugIns.h"
#include "shapes/analytic/mappedShape.h"

namespace recurse {

namespace {

class Torus final : public MappedShape {
 public:
  Torus(double majorRadius, double minorRadius, double phiMax, const ShapeContext& context) : phiMax(phiMax) {
    const double size = majorRadius + minorRadius;
    major = majorRadius / size;
    minor = minorRadius / size;
    Mat4d m = context.sceneFromObject;
    for (int i = 0; i < 3; ++i) m[i] *= size;
    prepare(m, sectorBounds(1, phiMax, -minor, minor), {phiMax * TWO_PI * major * minor},
            context.reverseOrientation, 1);
  }

  std::vector<RimPiece> rim() const override {
    const auto point = [&](double u, double v) { return inScene(*pointOfPart(0, {u, v})); };
    return rimOfSweep(point, phiMax < TWO_PI, false, false);
  }

 protected:
  void intersectAll(const Line& line, LineHits& found) const override {
    const double speed = glm::length(line.direction);
    if (!(speed > 0)) return;
    // The origin is the point nearest to the middle, so that the quartic has no cubic term.
    const Vec3d d = line.direction / speed;
    const double tNear = -glm::dot(line.origin, d);
    const Vec3d o = line.origin + d * tNear;
    const double away2 = glm::dot(o, o), reach2 = 1 - away2;
    if (!(reach2 > 0)) return;
    const double reach = std::sqrt(reach2) * (1 + 1e-9);
    const double k = away2 + square(major) - square(minor), f = 4 * square(major);
    const std::array<double, 5> quartic{k * k - f * (o.x * o.x + o.y * o.y), -2 * f * (o.x * d.x + o.y * d.y),
                                        2 * k - f * (d.x * d.x + d.y * d.y), 0, 1};
    const auto distance = [&](double t) {
      const Vec3d p = o + d * t;
      return std::sqrt(square(std::sqrt(square(p.x) + square(p.y)) - major) + square(p.z)) - minor;
    };
    constexpr double RESOLUTION = 1e-10;
    isolateRoots<4>(bernsteinForm<4>(quartic, -reach, reach), -reach, reach, RESOLUTION,
                    [&](double low, double high, bool rising) {
                      const double t = refineRoot(distance, low, high);
                      const Vec3d p = o + d * t;
                      if (phiMax >= TWO_PI || azimuth(p) <= phiMax)
                        found.add({(tNear + t) / speed, 0, !rising, p});
                    });
  }

  OwnPoint ownPoint(uint32_t, const Vec3d& near) const override {
    const double rho = std::hypot(near.x, near.y);
    const Vec2d outwards = rho > 0 ? Vec2d(near) / rho : Vec2d(1, 0);
    const Vec2d across(rho - major, near.z);
    const double length = glm::length(across);
    const Vec2d unit = length > 0 ? across / length : Vec2d(1, 0);
    OwnPoint s;
    s.position = Vec3d(outwards * (major + minor * unit.x), minor * unit.y);
    s.normal = Vec3d(outwards * unit.x, unit.y);
    s.dpdu = Vec3d(-s.position.y, s.position.x, 0) * phiMax;
    s.dndv = Vec3d(outwards * -unit.y, unit.x) * TWO_PI;
    s.dpdv = s.dndv * minor;
    s.dndu = Vec3d(-s.normal.y, s.normal.x, 0) * phiMax;
    const double theta = std::atan2(unit.y, unit.x);
    s.uv = glm::clamp(Vec2d(azimuth(near) / phiMax, (theta < 0 ? theta + TWO_PI : theta) / TWO_PI), 0.0, 1.0);
    return s;
  }

  std::optional<Vec3d> pointOfPart(uint32_t, const Vec2d& uv) const override {
    const double phi = phiMax * uv.x, psi = TWO_PI * uv.y, rho = major + minor * std::cos(psi);
    return Vec3d(rho * std::cos(phi), rho * std::sin(phi), minor * std::sin(psi));
  }

  Vec3d ownSample(uint32_t, const Vec2d& u) const override {
    // Angle around the tube: its outer side has more area.
    const double wanted = TWO_PI * major * u.x;
    const double theta =
        refineRoot([&](double angle) { return major * angle + minor * std::sin(angle) - wanted; }, 0, TWO_PI);
    const double phi = phiMax * u.y, rho = major + minor * std::cos(theta);
    return {rho * std::cos(phi), rho * std::sin(phi), minor * std::sin(theta)};
  }

  std::string whyOpen() const override {
    return phiMax < TWO_PI ? "it is not a full revolution (phimax below 360)" : "";
  }

 private:
  static double azimuth(const Vec3d& p) {
    const double phi = std::atan2(p.y, p.x);
    return phi < 0 ? phi + TWO_PI : phi;
  }

  double major, minor, phiMax;
};

} // namespace

void registerTorus(PlugIns& plugIns) {
  ParameterSpec sweep = realParameter("phimax", "360", "angle of the sector around the z axis [degrees]");
  sweep.positive().maximum = 360;
  plugIns.shapes.add(
      {{.name = "torus",
        .summary = "A torus around the z axis.",
        .parameters = {realParameter("majorradius", "1", "distance from the z axis to the center of the tube")
                           .positive(),
                       realParameter("minorradius", "0.25", "radius of the tube").positive(), sweep},
        .examples = {"", "\"float majorradius\" 2 \"float minorradius\" 1.5",
                     "\"float minorradius\" .1 \"float phimax\" 250"}},
       [](const Parameters& p, const ShapeContext& context) {
         const double major = p.real("majorradius"), minor = p.real("minorradius");
         if (!(minor < major))
           p.fail(p.has("minorradius") ? "minorradius" : "majorradius", "the torus has no hole",
                  "a minorradius less than the majorradius");
         return std::make_unique<Torus>(major, minor, p.real("phimax") / 360 * 6.28318530717958647693,
                                        context);
       }});
}

} // namespace recurse
