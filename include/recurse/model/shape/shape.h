/** @file
 * Surfaces: shapes are made of primitives (a sphere is one, a mesh has many) that rays meet and lights
 * sample.
 */
#pragma once

#include <bit>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "recurse/core/math/ray.h"
#include "recurse/core/math/vector.h"
#include "recurse/scene/parameters/parameters.h"

namespace recurse {

class Dicing;
class Material;
class Solid;
class TriangleMesh;
class TextureLookup;
struct TexturedRgb;

/** What a sample stands for at a surface, for textures to be averaged over: a cone along `direction`. */
struct Footprint {
  Vec3f direction; ///< unit, of the ray that came; not set where the width is 0
  float width = 0; ///< across the ray [scene units]; 0: not known, a point
};

/** A point of a surface and what shading needs to know of it. */
struct SurfacePoint {
  Vec3f position;
  Vec3f error;           ///< bound on the absolute error of the position, an axis at a time
  Vec3f geometricNormal; ///< unit; the side that counts as outside, and that area lights emit from
  Vec3f shadingNormal;   ///< unit, in the hemisphere of the geometric normal
  Vec3f dpdu;            ///< derivative of the position by u; zero where there is none
  Vec3f dpdv;            ///< the same for v
  Vec3f dndu{0};         ///< derivative of the shading normal by u; zero where it is not worked out
  Vec3f dndv{0};         ///< the same for v
  /** What bumps take for dpdv: 0: itself; 1: shadingNormal x dpdu, as in pbrt on meshes with normals at their
   * vertices; -1: the same seen in a mirror. */
  int8_t crossTangent = 0;
  Vec2f uv;
  Footprint footprint;
  float indexOutside = 1; ///< refractive index on the outer side; of nested dielectrics only
  float time = 0;         ///< of the ray that came, and of those that leave; see Ray::time
  float wavelength = 0;   ///< by which a dispersive material refracts [nm]; 0: it does not disperse
  bool isWhite = true;    ///< the light has all wavelengths, and `wavelength` is one that was drawn
  /** Curves are too thin for a density of photons. Most of them turn to the ray that meets them. */
  enum class Curve : uint8_t { NONE, FIXED, FACES_RAY } curve = Curve::NONE;

  /** The geometric normal on the side that `direction` points to. */
  Vec3f normalTowards(const Vec3f& direction) const {
    return glm::dot(geometricNormal, direction) < 0 ? -geometricNormal : geometricNormal;
  }
  /**
   * Where a ray that leaves in `direction` starts: beyond the error of the position along the geometric
   * normal, on the side of the direction, so that it does not meet its own surface (after Pharr, Jakob,
   * Humphreys, "Physically Based Rendering", section on robust spawned ray origins).
   */
  Vec3f rayOrigin(const Vec3f& direction) const {
    const float distance = glm::dot(magnitude(geometricNormal), error);
    const float side = glm::dot(direction, geometricNormal) < 0 ? -1.0f : 1.0f;
    Vec3f p = position + geometricNormal * (side * distance);
    for (int i = 0; i < 3; ++i) { // the sum is rounded: make sure that it is rounded away from the surface
      const float away = side * geometricNormal[i];
      if (away != 0) p[i] = nextFloat(p[i], away);
    }
    return p;
  }
};

/**
 * Names a point of a primitive for Shape::surfaceAt. Embree carries it from the one to the other in the five
 * numbers of its hits, which are u, v and the normal where it intersects by itself. Other shapes keep a point
 * in a space of their own, the number of a part of the primitive, and that of a component of a compound.
 */
struct HitParameters {
  Vec2f uv{0};
  Vec3f normal{0};

  HitParameters() = default;
  explicit HitParameters(const Vec2f& uv) : uv(uv) {}
  HitParameters(const Vec2f& uv, const Vec3f& normal) : uv(uv), normal(normal) {}
  explicit HitParameters(const Vec3f& point, uint32_t part = 0)
      : uv(point), normal(point.z, std::bit_cast<float>(part), 0) {}

  Vec3f point() const { return {uv, normal.x}; }
  uint32_t part() const { return std::bit_cast<uint32_t>(normal.y); }
  uint32_t component() const { return std::bit_cast<uint32_t>(normal.z); }
  void setComponent(uint32_t component) { normal.z = std::bit_cast<float>(component); }
};

/** Where a ray meets a primitive. */
struct PrimitiveHit {
  float t = 0;
  HitParameters parameters;
};

/** A point chosen on a surface. */
struct ShapeSample {
  SurfacePoint point;
  float pdf = 0; ///< density, a unit of area [1/length²] or of solid angle [1/sr]; says the function
  uint32_t primitive = 0;
};

/** A place on one of a shape's faces, each of which coordinates in the unit square cover once. */
struct FacePoint {
  uint32_t face = 0;
  Vec2d uv{0};
};

/** A piece of the edge where a surface ends. */
struct RimPiece {
  Vec3f from, to;
  Vec3f inner; ///< a point of the surface beside it
};

/** Made with the transforms baked in: everything is in the space of the scene (or of its instance). */
class Shape {
 public:
  virtual ~Shape() = default;

  virtual uint32_t primitiveCount() const = 0;
  /** A box that contains the primitive, rounding included. */
  virtual Bounds3f bounds(uint32_t primitive) const = 0;
  /** The nearest meeting with tMin < t < tMax. Not called for triangle meshes, which Embree intersects. */
  virtual std::optional<PrimitiveHit> intersect(uint32_t primitive, const Vec3f& origin,
                                                const Vec3f& direction, float tMin, float tMax) const = 0;
  /** The surface at a hit; for triangles u and v are the barycentric weights of the second and third
   * vertex. */
  virtual SurfacePoint surfaceAt(uint32_t primitive, const HitParameters& parameters) const = 0;
  /** Of the same only what says where the surface is: position, error and geometric normal. */
  virtual SurfacePoint placeAt(uint32_t primitive, const HitParameters& parameters) const {
    return surfaceAt(primitive, parameters);
  }

  /** False for surfaces that no points can be chosen on: they cannot be lamps, and the functions that follow
   * are not called. */
  virtual bool canBeSampled() const { return true; }
  virtual float area() const = 0;
  /** A point of the whole shape; pdf per unit of area. `pick` chooses the primitive. A pdf of 0: none was
   * found, which is a part of the density of the others. */
  virtual ShapeSample sampleArea(float pick, const Vec2f& u) const = 0;
  /** The density of sampleArea at a point of a primitive; constant 1/area() unless overridden. */
  virtual float pdfArea(uint32_t, const SurfacePoint&) const { return 1 / area(); }
  /** The point where the geometric normal is this one [unit], of shapes that have one for each and of which
   * equally many point everywhere: spheres; pdf as of sampleArea. Empty for all others. */
  virtual std::optional<ShapeSample> pointWithNormal(const Vec3f& /*normal*/) const { return {}; }
  /** A point as seen from `from`; pdf per unit of solid angle. Empty when none can be seen. */
  virtual std::optional<ShapeSample> sampleDirection(const Vec3f& from, float pick, const Vec2f& u) const;
  /** The density of sampleDirection for a point of a primitive that is seen from `from`. */
  virtual float pdfDirection(const Vec3f& from, uint32_t primitive, const SurfacePoint& point) const;

  /** How many faces make up the surface, for what divides it evenly; 0: it does not consist of such, or of
   * triangles. */
  virtual uint32_t faceCount() const { return 0; }
  virtual SurfacePoint pointOnFace(const FacePoint&) const { return {}; }
  /** Where a point of a primitive lies. */
  virtual FacePoint facePointOf(uint32_t /*primitive*/, const SurfacePoint&) const { return {}; }

  /** Mean number of parts that a ray through the shape tests where its parts overlap; 1 for all others. */
  virtual double testsOfRay() const { return 1; }
  /** The mesh itself when the shape is one, so that Embree can have its triangles. */
  virtual const TriangleMesh* triangleMesh() const { return nullptr; }
  Bounds3f bounds() const;

  /** The shape as a closed solid. Throws Error with the reason where it does not enclose a volume. */
  virtual std::unique_ptr<Solid> asSolid() const;
  /** Where the surface ends: straight edges whole, of curved ones short pieces. Pieces with the same ends are
   * where its parts meet. One of no length stands for an edge that cannot be told. */
  virtual std::vector<RimPiece> rim() const { return {}; }
  /** The materials of a compound's components; empty: the whole has that of the Shape directive. */
  virtual std::vector<const Material*> componentMaterials() const { return {}; }
  /** Of such a compound, the material at a hit. */
  virtual const Material* materialAt(const HitParameters&) const { return nullptr; }

  /** Opacity, by which rays meet the surface or pass through; null: 1. Set once the shape is made. */
  std::shared_ptr<const TexturedRgb> alpha;
};

/** A closed shape, which a line crosses in and out again. Lives no longer than its shape. */
class Solid {
 public:
  struct Crossing {
    double t = 0;
    bool entering = false;
    uint32_t primitive = 0;
    HitParameters parameters; ///< for Shape::surfaceAt
  };
  virtual ~Solid() = default;
  /** Appends where the whole line origin + t·direction, with t of either sign, goes in and out; in any order.
   */
  virtual void crossings(const Vec3d& origin, const Vec3d& direction, std::vector<Crossing>& found) const = 0;
  /** True where the shape's geometric normals point into the solid. */
  virtual bool normalsPointIn() const { return false; }
};

struct ShapeContext;

/** A shape that another is made of. */
struct ComponentShape {
  std::unique_ptr<Shape> shape;
  const Material* material = nullptr;
  SourceLocation location; ///< of the Shape directive
};

/** Finds shapes by the name of their ObjectBegin. */
class ShapeLookup {
 public:
  virtual ~ShapeLookup() = default;
  /** Makes the shapes of the object in the space of `context`; fails at the parameter that names it. */
  virtual std::vector<ComponentShape> object(const Parameters& p, const std::string& parameter,
                                             const std::string& name, const ShapeContext& context) = 0;
};

/** What makers of shapes are given besides parameters. */
struct ShapeContext {
  Mat4d sceneFromObject{1}; ///< the file's transform, then the scene's recentring
  bool reverseOrientation = false;
  const TextureLookup* textures = nullptr; ///< null: no texture can be named
  ShapeLookup* shapes = nullptr;           ///< null: no object can be named
  const Material* material = nullptr;      ///< of the Shape directive; null: it does not scatter
  const Dicing* dicing = nullptr;          ///< null: no camera sees it
  Vec3d textureShift{0};                   ///< added to a position makes it what textures take for it
};

/**
 * The rim of a surface p(u, v), as pieces of its edges at u = 0, u = 1, v = 0 and v = 1 of those that are
 * asked for. Edges that have come down to a point are none.
 */
std::vector<RimPiece> rimOfSweep(const std::function<Vec3d(double u, double v)>& p, bool uEnds, bool vLow,
                                 bool vHigh);

/** Takes a point's normals and derivatives to another space; normalMap is the transposed inverse of `map`. */
void transformDirections(const Mat3d& map, const Mat3d& normalMap, SurfacePoint& point);

// Tools for shapes that compute in double precision.

/** The derivative of side · v / |v| where that of v is dv; zero where v is. */
inline Vec3f derivativeOfUnit(const Vec3d& v, const Vec3d& dv, double side) {
  const double length2 = glm::dot(v, v);
  return length2 > 0 ? Vec3f((dv - v * (glm::dot(v, dv) / length2)) * (side / std::sqrt(length2))) : Vec3f(0);
}

/** A box of floats around a box of doubles and around every point of it that is rounded to float. */
Bounds3f roundedOut(const Bounds3d& box);
/**
 * SurfacePoint::error of a position that is rounded to float from a point known to `exactError`, an axis at a
 * time, on a surface known to `offset` along its normal.
 */
inline Vec3f positionError(const Vec3d& position, const Vec3d& exactError, const Vec3d& normal,
                           double offset) {
  // The slack covers the float operations of SurfacePoint::rayOrigin.
  constexpr double UNIT = 0x1p-24, SLACK = 1 + 0x1p-20;
  return Vec3f((UNIT * magnitude(position) + exactError + offset * magnitude(normal)) * SLACK);
}

/**
 * How far along its normal rays at least start off a flat surface. A grazing ray's side is decided with a
 * normal rounded to float, which is wrong by up to 4 units of roundoff at the other end of what the surface
 * spans. And a plane through the origin has coordinates of zero, next to which floats are denormal: something
 * else in the same plane would be met.
 */
inline double flatOffset(const Vec3d& extent, const Vec3d& position, const Vec3d& normal) {
  const Vec3d n = magnitude(normal);
  const double largest = std::max(extent.x, std::max(extent.y, extent.z));
  return std::max(0x1p-22 * glm::dot(extent, n),
                  0x1p-28 * largest - 0x1p-24 * glm::dot(magnitude(position), n));
}

/** The same for a point computed from floats, of which `rounding` are the magnitudes of those coordinates
 * that are not exact. */
inline Vec3f positionError(const Vec3f& rounding, const Vec3f& normal, float offset) {
  // The slack covers these and the float operations of SurfacePoint::rayOrigin.
  constexpr float UNIT = 0x1p-24f, SLACK = 1 + 0x1p-19f;
  return (UNIT * rounding + offset * magnitude(normal)) * SLACK;
}

} // namespace recurse
