/** @file
 * The mappings of pbrt-v4 and their derivatives.
 */
#include "recurse/model/texture/textureMapping.h"

namespace recurse {

namespace {

Mat4d inverseOf(const TextureContext& context) {
  return glm::inverse(context.worldFromTexture); // the reader rejects singular transforms
}

Vec3d textureSpacePoint(const Mat4d& textureFromWorld, const Vec3d* origin, const SurfacePoint& point) {
  return transformPoint(textureFromWorld, origin ? Vec3d(point.position) + *origin : Vec3d(point.position));
}

bool finite(const Vec2f& v) { return std::isfinite(v.x) && std::isfinite(v.y); }

} // namespace

FootprintAxes::FootprintAxes(const SurfacePoint& point) {
  const Footprint& f = point.footprint;
  if (!(f.width > 0)) return;
  const Vec3f& n = point.geometricNormal;
  const float cosine = glm::dot(f.direction, n);
  const Vec3f slope = f.direction - n * cosine;
  const float sine = glm::length(slope);
  if (cosine == 0) return;
  if (sine < 1e-3f) { // seen head-on: the footprint is a circle, to within a millionth
    const Frame frame(n);
    x = frame.x * f.width;
    y = frame.y * f.width;
    return;
  }
  x = slope * (f.width / (sine * std::abs(cosine)));
  y = glm::cross(n, slope) * (f.width / sine);
  if (!isFinite(x)) x = y = Vec3f(0);
}

TextureMapping::TextureMapping(const Parameters& p, const TextureContext& context)
    : textureFromWorld(inverseOf(context)), origin(context.sceneOrigin) {
  const std::string name = p.string("mapping");
  kind = name == "uv"          ? Kind::UV
         : name == "spherical" ? Kind::SPHERICAL
         : name == "planar"    ? Kind::PLANAR
                               : Kind::CYLINDRICAL;
  const auto only = [&](const char* parameter, bool taken, const char* mappings) {
    if (p.has(parameter) && !taken)
      p.fail(parameter, "the " + name + " mapping has no \"" + parameter + "\"", mappings);
  };
  const bool uv = kind == Kind::UV, planar = kind == Kind::PLANAR;
  for (const char* n : {"uscale", "vscale"}) only(n, uv, "\"string mapping\" \"uv\"");
  for (const char* n : {"udelta", "vdelta"}) only(n, uv || planar, "\"string mapping\" \"uv\" or \"planar\"");
  for (const char* n : {"v1", "v2"}) only(n, planar, "\"string mapping\" \"planar\"");
  scale = {p.real("uscale"), p.real("vscale")};
  delta = {p.real("udelta"), p.real("vdelta")};
  axisS = p.vector3("v1");
  axisT = p.vector3("v2");
}

/** Coordinates of a point of texture space, and their gradients. */
Vec2d TextureMapping::of(const Vec3d& p, Vec3d& ds, Vec3d& dt) const {
  if (kind == Kind::PLANAR) {
    ds = axisS;
    dt = axisT;
    return delta + Vec2d(glm::dot(p, axisS), glm::dot(p, axisT));
  }
  const double rho2 = p.x * p.x + p.y * p.y, rho = std::sqrt(rho2), r2 = rho2 + p.z * p.z;
  const Vec3d azimuth = rho2 > 0 ? Vec3d(-p.y, p.x, 0) / (2 * PI_D * rho2) : Vec3d(0);
  if (kind == Kind::CYLINDRICAL) {
    ds = azimuth;
    dt = {0, 0, 1};
    return {(PI_D + std::atan2(p.y, p.x)) / (2 * PI_D), p.z};
  }
  ds = rho2 > 0 ? Vec3d(p.x * p.z / rho, p.y * p.z / rho, -rho) / (PI_D * r2) : Vec3d(0);
  dt = azimuth;
  const double phi = std::atan2(p.y, p.x);
  return {std::atan2(rho, p.z) / PI_D, (phi < 0 ? phi + 2 * PI_D : phi) / (2 * PI_D)};
}

MappedCoordinates TextureMapping::at(const SurfacePoint& point) const {
  MappedCoordinates m;
  const FootprintAxes axes(point);
  if (kind == Kind::UV) {
    m.st = Vec2f(Vec2d(point.uv) * scale + delta);
    if (axes.x == Vec3f(0)) return m;
    // Coordinates of the axes along dpdu and dpdv, by least squares: the axes are in their plane.
    const Vec3d u = point.dpdu, v = point.dpdv;
    const double uu = glm::dot(u, u), uv = glm::dot(u, v), vv = glm::dot(v, v),
                 determinant = uu * vv - uv * uv;
    if (!(determinant > 1e-12 * uu * vv)) return m;
    const auto coordinates = [&](const Vec3d& along) {
      const double a = glm::dot(along, u), b = glm::dot(along, v);
      return Vec2f(Vec2d(vv * a - uv * b, uu * b - uv * a) / determinant * scale);
    };
    m.alongX = coordinates(axes.x);
    m.alongY = coordinates(axes.y);
  } else {
    const Vec3d p = textureSpacePoint(textureFromWorld, origin, point);
    Vec3d ds, dt;
    m.st = Vec2f(of(p, ds, dt));
    if (axes.x == Vec3f(0)) return m;
    const auto coordinates = [&](const Vec3d& along) {
      const Vec3d d = transformVector(textureFromWorld, along);
      return Vec2f(Vec2d(glm::dot(ds, d), glm::dot(dt, d)));
    };
    m.alongX = coordinates(axes.x);
    m.alongY = coordinates(axes.y);
  }
  if (!finite(m.alongX) || !finite(m.alongY)) m.alongX = m.alongY = Vec2f(0);
  return m;
}

TextureSpace::TextureSpace(const TextureContext& context)
    : textureFromWorld(inverseOf(context)), origin(context.sceneOrigin) {}

MappedPoint TextureSpace::at(const SurfacePoint& point) const {
  MappedPoint m;
  m.p = textureSpacePoint(textureFromWorld, origin, point);
  const FootprintAxes axes(point);
  if (axes.x == Vec3f(0)) return m;
  m.alongX = Vec3f(transformVector(textureFromWorld, axes.x));
  m.alongY = Vec3f(transformVector(textureFromWorld, axes.y));
  return m;
}

std::vector<ParameterSpec> withMapping(std::vector<ParameterSpec> own) {
  own.insert(own.end(),
             {stringParameter("mapping", "uv",
                              "mapping of coordinates (s, t): uv of the surface, spherical, cylindrical, or "
                              "planar along two vectors in texture space")
                  .oneOf({"uv", "spherical", "cylindrical", "planar"}),
              realParameter("uscale", "1", "factor on s, for uv"),
              realParameter("vscale", "1", "factor on t, for uv"),
              realParameter("udelta", "0", "offset of s, for uv and planar"),
              realParameter("vdelta", "0", "offset of t, for uv and planar"),
              arrayParameter(ParameterType::VECTOR3, "v1", 1, "1 0 0", "direction of s, for planar"),
              arrayParameter(ParameterType::VECTOR3, "v2", 1, "0 1 0", "direction of t, for planar")});
  return own;
}

} // namespace recurse
