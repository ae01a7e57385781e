/** @file
 * Quadrics of revolution as in pbrt-v3: cylinders, cones, paraboloids and hyperboloids, swept in part, open
 * or closed by caps.
 */
#include "recurse/core/math/integrate.h"
#include "recurse/model/scene/plugIns.h"
#include "shapes/analytic/mappedShape.h"

namespace recurse {

namespace {

/** Surface x² + y² = a z² + b z + c between two heights. */
struct Profile {
  double a = 0, b = 0, c = 0, zLow = 0, zHigh = 1;
  double radius2(double z) const { return std::max(0.0, (a * z + b) * z + c); }
  double radius(double z) const { return std::sqrt(radius2(z)); }
  /** Area per unit height and radian of azimuth, at height z. */
  double areaDensity(double z) const { return std::sqrt(radius2(z) + square(a * z + 0.5 * b)); }

  /** Surface in units of `size`. */
  Profile scaled(double size) const { return {a, b / size, c / square(size), zLow / size, zHigh / size}; }
};

/** Parameterization of pbrt: v at both ends, and the origin of phi. */
struct Coordinates {
  double vLow = 0, vHigh = 1;  ///< v at the lower and upper height
  Vec2d line0{1, 0}, line1{0}; ///< phi is measured from line0 + z line1
};

class RevolvedQuadric final : public MappedShape {
 public:
  RevolvedQuadric(const Profile& given, const Coordinates& coordinates, double phiMax, bool capped,
                  const ShapeContext& context)
      : coordinates(coordinates), phiMax(phiMax), capped(capped) {
    const double largest = std::max(given.radius(given.zLow), given.radius(given.zHigh));
    const double size = std::max({largest, std::abs(given.zLow), std::abs(given.zHigh)});
    profile = given.scaled(size);
    Mat4d m = context.sceneFromObject;
    for (int i = 0; i < 3; ++i) m[i] *= size;
    this->coordinates.line1 *= size;
    const double r = largest / size;
    const double side = phiMax * integrate([&](double z) { return profile.areaDensity(z); }, profile.zLow,
                                           profile.zHigh, 1e-12);
    std::vector<double> areas{side};
    if (capped)
      for (const double z : {profile.zLow, profile.zHigh}) areas.push_back(0.5 * phiMax * profile.radius2(z));
    perRadian = side / phiMax;
    middle = Vec3d(0, 0, 0.5 * (profile.zLow + profile.zHigh));
    // The generating line of a hyperboloid may begin at any azimuth.
    const bool startsAtX = coordinates.line1 == Vec2d(0);
    prepare(m, sectorBounds(r, startsAtX ? phiMax : TWO_PI, profile.zLow, profile.zHigh), areas,
            context.reverseOrientation, r);
  }

  std::vector<RimPiece> rim() const override {
    const auto side = [&](double u, double v) {
      const double z = profile.zLow + (profile.zHigh - profile.zLow) * v;
      return inScene(around(u, z, profile.radius(z)));
    };
    std::vector<RimPiece> pieces =
        rimOfSweep(side, phiMax < TWO_PI, !capped && profile.radius(profile.zLow) > 0,
                   !capped && profile.radius(profile.zHigh) > 0);
    if (capped && phiMax < TWO_PI)
      for (const double z : {profile.zLow, profile.zHigh}) {
        const auto cap = [&](double u, double v) { return inScene(around(u, z, profile.radius(z) * v)); };
        const std::vector<RimPiece> more = rimOfSweep(cap, true, false, false);
        pieces.insert(pieces.end(), more.begin(), more.end());
      }
    return pieces;
  }

 protected:
  enum Part : uint32_t { SIDE, LOW_CAP, HIGH_CAP };
  struct End {
    double t;
    uint32_t part;
  };

  void intersectAll(const Line& line, LineHits& found) const override {
    // The origin is moved near the shape, so that distance costs no precision.
    const double speed2 = glm::dot(line.direction, line.direction);
    if (!(speed2 > 0)) return;
    const double tNear = glm::dot(middle - line.origin, line.direction) / speed2;
    const Vec3d o = line.at(tNear), d = line.direction;
    const double a = d.x * d.x + d.y * d.y - profile.a * d.z * d.z;
    const double b = o.x * d.x + o.y * d.y - (profile.a * o.z + 0.5 * profile.b) * d.z;
    const double c = o.x * o.x + o.y * o.y - ((profile.a * o.z + profile.b) * o.z + profile.c);
    std::array<double, 2> roots;
    const int rootCount = solve(a, b, c, roots);
    const auto add = [&](const End& e, bool entering) {
      const Vec3d p = o + d * e.t;
      if (phiMax < TWO_PI && azimuth(p) > phiMax) return;
      found.add({tNear + e.t, e.part, entering, p});
    };
    if (!capped) {
      for (int i = 0; i < rootCount; ++i) {
        const double z = o.z + d.z * roots[i];
        if (z >= profile.zLow && z <= profile.zHigh) add({roots[i], SIDE}, false);
      }
      return;
    }
    // Spans inside the quadric and between the caps: entries and exits alternate whatever is rounded.
    End slab[2] = {{-INFINITE_D, LOW_CAP}, {INFINITE_D, HIGH_CAP}};
    if (d.z != 0) {
      slab[0].t = (profile.zLow - o.z) / d.z;
      slab[1].t = (profile.zHigh - o.z) / d.z;
      if (d.z < 0) std::swap(slab[0], slab[1]);
    } else if (o.z < profile.zLow || o.z > profile.zHigh) {
      return;
    }
    const auto addSpan = [&](double from, double to) {
      const End in = from > slab[0].t ? End{from, SIDE} : slab[0];
      const End out = to < slab[1].t ? End{to, SIDE} : slab[1];
      if (!(in.t < out.t)) return;
      add(in, true);
      add(out, false);
    };
    if (rootCount == 2 && a > 0) {
      addSpan(roots[0], roots[1]);
    } else if (rootCount == 2) {
      addSpan(-INFINITE_D, roots[0]);
      addSpan(roots[1], INFINITE_D);
    } else if (rootCount == 1) {
      if (b > 0)
        addSpan(-INFINITE_D, roots[0]);
      else
        addSpan(roots[0], INFINITE_D);
    } else if (c < 0) {
      addSpan(-INFINITE_D, INFINITE_D);
    }
  }

  OwnPoint ownPoint(uint32_t part, const Vec3d& near) const override {
    Vec3d p = near;
    const double rho0 = std::hypot(p.x, p.y);
    const Vec2d outwards = rho0 > 0 ? Vec2d(p) / rho0 : Vec2d(1, 0);
    OwnPoint s;
    if (part == SIDE) {
      p.z = std::clamp(p.z, profile.zLow, profile.zHigh);
      // Newton's method in the plane of the axis.
      double rho = rho0;
      for (int i = 0; i < 3; ++i) {
        const double f = rho * rho - ((profile.a * p.z + profile.b) * p.z + profile.c);
        const Vec2d gradient(2 * rho, -(2 * profile.a * p.z + profile.b));
        const double g2 = glm::dot(gradient, gradient);
        if (!(g2 > 0)) break;
        rho -= f * gradient.x / g2;
        p.z = std::clamp(p.z - f * gradient.y / g2, profile.zLow, profile.zHigh);
      }
      rho = std::max(rho, 0.0);
      const double slope = profile.a * p.z + 0.5 * profile.b; // derivative of rho²/2 by z
      const double steepness = std::hypot(rho, slope);
      // The tip of a cone has no normal; any of the normals around it is taken.
      s.normal = steepness > 0 ? Vec3d(outwards * rho, -slope) / steepness : Vec3d(outwards, 0);
      const double height = profile.zHigh - profile.zLow, w = (p.z - profile.zLow) / height;
      p = Vec3d(outwards * rho, p.z);
      s.uv.y = coordinates.vLow + (coordinates.vHigh - coordinates.vLow) * w;
      const double dzdv = height / (coordinates.vHigh - coordinates.vLow);
      // The azimuth of a hyperboloid's generating line changes along v.
      const Vec2d line = coordinates.line0 + coordinates.line1 * p.z;
      const double length2 = glm::dot(line, line);
      const double turn =
          length2 > 0 ? (line.x * coordinates.line1.y - line.y * coordinates.line1.x) / length2 : 0;
      const double drdz = rho > 0 ? slope / rho : 0;
      const Vec2d sideways(-outwards.y, outwards.x);
      s.dpdv = Vec3d(outwards * drdz + sideways * (turn * rho), 1) * dzdv;
      if (steepness > 0) {
        const Vec3d change(outwards * drdz + sideways * (turn * rho), -profile.a);
        s.dndv = (change - s.normal * glm::dot(s.normal, change)) * (dzdv / steepness);
        s.dndu = Vec3d(-s.normal.y, s.normal.x, 0) * phiMax;
      }
      s.uv.x = azimuth(p) / phiMax;
    } else {
      p.z = part == LOW_CAP ? profile.zLow : profile.zHigh;
      s.normal = {0, 0, part == LOW_CAP ? -1 : 1};
      const double rim = profile.radius(p.z), rho = std::min(rho0, rim);
      p = Vec3d(outwards * rho, p.z);
      s.uv = {azimuth(p) / phiMax, 1 - rho / rim};
      s.dpdv = Vec3d(outwards * -rim, 0);
    }
    s.uv = glm::clamp(s.uv, 0.0, 1.0);
    s.position = p;
    s.dpdu = Vec3d(-p.y, p.x, 0) * phiMax;
    return s;
  }

  std::optional<Vec3d> pointOfPart(uint32_t part, const Vec2d& uv) const override {
    if (part == SIDE) {
      const double w = (uv.y - coordinates.vLow) / (coordinates.vHigh - coordinates.vLow);
      const double z = profile.zLow + (profile.zHigh - profile.zLow) * w;
      return around(uv.x, z, profile.radius(z));
    }
    const double z = part == LOW_CAP ? profile.zLow : profile.zHigh;
    return around(uv.x, z, profile.radius(z) * (1 - uv.y));
  }

  Vec3d ownSample(uint32_t part, const Vec2d& u) const override {
    double z, rho;
    if (part == SIDE) {
      z = heightAt(u.x * perRadian);
      rho = profile.radius(z);
    } else {
      z = part == LOW_CAP ? profile.zLow : profile.zHigh;
      rho = profile.radius(z) * std::sqrt(u.x);
    }
    return around(u.y, z, rho);
  }

  std::string whyOpen() const override {
    if (phiMax < TWO_PI) return "it is not a full revolution (phimax below 360)";
    return capped ? "" : "it is open: \"bool caps\" true closes it";
  }

 private:
  /** Roots of a t² + 2 b t + c in ascending order. */
  static int solve(double a, double b, double c, std::array<double, 2>& roots) {
    if (a == 0) {
      if (b == 0) return 0;
      roots[0] = -0.5 * c / b;
      return 1;
    }
    const double discriminant = b * b - a * c;
    if (!(discriminant >= 0)) return 0;
    const double q = -(b + std::copysign(std::sqrt(discriminant), b));
    roots = {q / a, q != 0 ? c / q : 0};
    if (roots[0] > roots[1]) std::swap(roots[0], roots[1]);
    return 2;
  }

  Vec3d around(double u, double z, double rho) const {
    const double phi = phiMax * u + azimuthOfLine(z);
    return {rho * std::cos(phi), rho * std::sin(phi), z};
  }
  double azimuthOfLine(double z) const {
    const Vec2d line = coordinates.line0 + coordinates.line1 * z;
    return std::atan2(line.y, line.x);
  }
  /** Azimuth from the generating line of the surface, in [0, 2π]. */
  double azimuth(const Vec3d& p) const {
    double phi = std::atan2(p.y, p.x) - azimuthOfLine(p.z);
    if (phi < 0) phi += TWO_PI;
    return phi < 0 ? phi + TWO_PI : phi;
  }

  /** Height below which the side has area `wanted` per radian of azimuth. */
  double heightAt(double wanted) const {
    double low = profile.zLow, high = profile.zHigh, below = 0;
    const auto density = [&](double z) { return profile.areaDensity(z); };
    while (true) {
      const double z = 0.5 * (low + high);
      if (!(z > low && z < high) || high - low < 1e-9 * (profile.zHigh - profile.zLow)) return z;
      const double more = integrate(density, low, z, 1e-12 * perRadian, gauss7(density, low, z), 30);
      if (below + more <= wanted) {
        below += more;
        low = z;
      } else {
        high = z;
      }
    }
  }

  Profile profile;
  Coordinates coordinates;
  double phiMax;
  bool capped;
  double perRadian = 0; ///< area of the side per radian of azimuth
  Vec3d middle{0};
};

double phiMaxOf(const Parameters& p) { return p.real("phimax") / 360 * 6.28318530717958647693; }

std::unique_ptr<Shape> makeCylinder(const Parameters& p, const ShapeContext& context) {
  double zLow = p.real("zmin"), zHigh = p.real("zmax");
  if (zLow > zHigh) std::swap(zLow, zHigh); // as in pbrt
  if (zLow == zHigh) p.fail(p.has("zmin") ? "zmin" : "zmax", "the cylinder has no height", "zmin < zmax");
  return std::make_unique<RevolvedQuadric>(Profile{0, 0, square(p.real("radius")), zLow, zHigh},
                                           Coordinates{}, phiMaxOf(p), p.boolean("caps"), context);
}

std::unique_ptr<Shape> makeCone(const Parameters& p, const ShapeContext& context) {
  const double r = p.real("radius"), h = p.real("height"), k = square(r / h);
  return std::make_unique<RevolvedQuadric>(Profile{k, -2 * h * k, r * r, 0, h}, Coordinates{}, phiMaxOf(p),
                                           p.boolean("caps"), context);
}

std::unique_ptr<Shape> makeParaboloid(const Parameters& p, const ShapeContext& context) {
  double zLow = p.real("zmin"), zHigh = p.real("zmax");
  if (zLow > zHigh) std::swap(zLow, zHigh); // as in pbrt
  if (zLow < 0 || zLow == zHigh)
    p.fail(p.has("zmin") ? "zmin" : "zmax",
           "zmin and zmax must differ, and be 0 or more: the paraboloid opens upwards from the origin",
           "0 <= zmin < zmax");
  return std::make_unique<RevolvedQuadric>(Profile{0, square(p.real("radius")) / zHigh, 0, zLow, zHigh},
                                           Coordinates{}, phiMaxOf(p), p.boolean("caps"), context);
}

/** The line from p1 to p2 turns about the z axis: its distance from the axis, squared, is a quadratic in z.
 */
std::unique_ptr<Shape> makeHyperboloid(const Parameters& p, const ShapeContext& context) {
  const Vec3d p1 = p.vector3("p1"), p2 = p.vector3("p2");
  if (p1.z == p2.z)
    p.fail(p.has("p1") ? "p1" : "p2",
           "the line is perpendicular to the z axis: its surface of revolution is a disc",
           "two points of different z, or Shape \"disk\"");
  const Vec2d slope = Vec2d(p2 - p1) / (p2.z - p1.z), at0 = Vec2d(p1) - slope * p1.z;
  const Profile profile{glm::dot(slope, slope), 2 * glm::dot(slope, at0), glm::dot(at0, at0),
                        std::min(p1.z, p2.z), std::max(p1.z, p2.z)};
  if (!(profile.radius(profile.zLow) > 0 || profile.radius(profile.zHigh) > 0))
    p.fail(p.has("p1") ? "p1" : "p2", "the line lies on the z axis");
  Coordinates coordinates;
  if (p1.z > p2.z) std::swap(coordinates.vLow, coordinates.vHigh);
  coordinates.line0 = at0;
  coordinates.line1 = slope;
  return std::make_unique<RevolvedQuadric>(profile, coordinates, phiMaxOf(p), p.boolean("caps"), context);
}

ParameterSpec phiMaxParameter() {
  ParameterSpec sweep = realParameter("phimax", "360", "angle of revolution around the z axis [degrees]");
  sweep.positive().maximum = 360;
  return sweep;
}

ParameterSpec capsParameter() {
  return booleanParameter("caps", "false", "close the ends with discs, as \"csg\" needs");
}

} // namespace

void registerQuadrics(PlugIns& plugIns) {
  plugIns.shapes.add({{.name = "cylinder",
                       .summary = "The side of a cylinder around the z axis, optionally with caps.",
                       .parameters = {realParameter("radius", "1", "radius").positive(),
                                      realParameter("zmin", "-1", "lower end on the z axis"),
                                      realParameter("zmax", "1", "upper end on the z axis"),
                                      phiMaxParameter(), capsParameter()},
                       .examples = {"", "\"float radius\" 0.3 \"bool caps\" true",
                                    "\"float radius\" 2 \"float zmin\" 0 \"float zmax\" 2 "
                                    "\"float phimax\" 200"}},
                      makeCylinder});
  plugIns.shapes.add(
      {{.name = "cone",
        .summary =
            "A cone with its base on the xy plane and its tip on the z axis; optionally with the base.",
        .parameters = {realParameter("radius", "1", "radius at z = 0").positive(),
                       realParameter("height", "1", "height of the tip").positive(), phiMaxParameter(),
                       capsParameter()},
        .examples = {"", "\"float radius\" 0.5 \"float height\" 2 \"bool caps\" true",
                     "\"float radius\" 0.6 \"float phimax\" 140"}},
       makeCone});
  plugIns.shapes.add({{.name = "paraboloid",
                       .summary = "A paraboloid around the z axis that opens upwards from the origin.",
                       .parameters = {realParameter("radius", "1", "radius at zmax").positive(),
                                      realParameter("zmin", "0", "lower end on the z axis"),
                                      realParameter("zmax", "1", "upper end on the z axis"),
                                      phiMaxParameter(), capsParameter()},
                       .examples = {"", "\"float radius\" 0.7 \"float zmin\" .2 \"bool caps\" true",
                                    "\"float zmax\" 2 \"float phimax\" 300"}},
                      makeParaboloid});
  plugIns.shapes.add(
      {{.name = "hyperboloid",
        .summary = "The surface of revolution of a line segment around the z axis.",
        .parameters = {arrayParameter(ParameterType::POINT3, "p1", 1, "0 0 0", "one end of the line"),
                       arrayParameter(ParameterType::POINT3, "p2", 1, "1 1 1", "the other end"),
                       phiMaxParameter(), capsParameter()},
        .examples = {"", "\"point3 p1\" [1 -.5 -1] \"point3 p2\" [.8 .9 1] \"bool caps\" true",
                     "\"point3 p1\" [1 0 1] \"point3 p2\" [0 1 -1] \"float phimax\" 230"}},
       makeHyperboloid});
}

} // namespace recurse
