/** @file
 * Surfaces: shapes consist of primitives (a sphere is one, a mesh has many) that rays intersect and lights
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

/** Footprint of a sample at a surface, over which textures are filtered: a cone along `direction`. */
struct Footprint {
  Vec3f direction; ///< unit, of the incident ray; not set where the width is 0
  float width = 0; ///< across the ray [scene units]; 0: unknown, a point
};

/** Point of a surface with its shading data. Shapes set the geometry, queries of the scene the time, and
 * walks footprint, indexOutside, wavelength and isWhite. */
struct SurfacePoint {
  Vec3f position;
  Vec3f error;           ///< bound on the absolute error of the position, by axis [scene units]
  Vec3f geometricNormal; ///< unit, on the outer side, from which area lights emit
  Vec3f shadingNormal;   ///< unit, in the hemisphere of the geometric normal
  Vec3f dpdu;            ///< derivative of the position by u; zero where undefined
  Vec3f dpdv;            ///< derivative of the position by v; zero where undefined
  Vec3f dndu{0};         ///< derivative of the shading normal by u; zero where not computed
  Vec3f dndv{0};         ///< derivative of the shading normal by v; zero where not computed
  /** Tangent that bumps use for dpdv: 0: dpdv; 1: shadingNormal x dpdu, as in pbrt on meshes with normals at
   * their vertices; -1: the latter, mirrored. */
  int8_t crossTangent = 0;
  Vec2f uv; ///< surface coordinates; in [0, 1] unless a mesh has others
  Footprint footprint;
  float indexOutside = 1; ///< refractive index on the outer side; only for nested dielectrics
  /** Probability that a ray hits the surface here, set by Scene::intersect(), and that its material keeps
   * photons, where one of several is chosen at random. */
  float alpha = 1;
  float time = 0;       ///< Ray::time of the incident and the scattered rays
  float wavelength = 0; ///< wavelength for dispersive refraction [nm]; 0: no dispersion
  bool isWhite = true;  ///< true: the path still has all wavelengths; `wavelength` is a sample
  /** Kind of a curve: curves are too thin for photon density. Most of them turn to the ray that hits them. */
  enum class Curve : uint8_t { NONE, FIXED, FACES_RAY } curve = Curve::NONE;

  /** Geometric normal on the side of `direction`. */
  Vec3f normalTowards(const Vec3f& direction) const {
    return glm::dot(geometricNormal, direction) < 0 ? -geometricNormal : geometricNormal;
  }
  /**
   * Origin of a ray that leaves in `direction`: offset by the error of the position along the geometric
   * normal, to the side of the direction, so that the ray does not intersect its own surface (after Pharr,
   * Jakob, Humphreys, "Physically Based Rendering", section on robust spawned ray origins).
   */
  Vec3f rayOrigin(const Vec3f& direction) const {
    const float distance = glm::dot(magnitude(geometricNormal), error);
    const float side = glm::dot(direction, geometricNormal) < 0 ? -1.0f : 1.0f;
    Vec3f p = position + geometricNormal * (side * distance);
    for (int i = 0; i < 3; ++i) { // rounds away from the surface
      const float away = side * geometricNormal[i];
      if (away != 0) p[i] = nextFloat(p[i], away);
    }
    return p;
  }
};

/**
 * Identifies a point of a primitive for Shape::surfaceAt. Embree stores it in the five floats of its hits,
 * which are u, v and the normal for primitives of Embree. Other shapes store a point in their own space, the
 * index of a part of the primitive, and the index of a component of a compound.
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

/** Intersection of a ray with a primitive. */
struct PrimitiveHit {
  float t = 0;
  HitParameters parameters;
};

/** Sampled point of a surface. */
struct ShapeSample {
  SurfacePoint point;
  float pdf = 0; ///< density by area [1/length²] or by solid angle [1/sr], depending on the function
  uint32_t primitive = 0;
};

/** Point on a face of a shape. Coordinates in the unit square cover each face once. */
struct FacePoint {
  uint32_t face = 0;
  Vec2d uv{0};
};

/** Piece of the boundary curve of an open surface. */
struct RimPiece {
  Vec3f from, to;
  Vec3f inner; ///< point of the surface near the piece
};

/** Shape with its transforms applied: all data are in the space of the scene (or of its instance). Immutable
 * once alpha is set; any thread may call it. */
class Shape {
 public:
  virtual ~Shape() = default;

  virtual uint32_t primitiveCount() const = 0;
  /** Bounding box of a primitive, including rounding errors. */
  virtual Bounds3f bounds(uint32_t primitive) const = 0;
  /** Nearest intersection with tMin < t < tMax by a ray with a unit direction; empty: none. Alpha is left to
   * the caller. Not called for triangle meshes and curves, which Embree intersects. */
  virtual std::optional<PrimitiveHit> intersect(uint32_t primitive, const Vec3f& origin,
                                                const Vec3f& direction, float tMin, float tMax) const = 0;
  /** Surface at a hit: position, error, normals, derivatives, uv, crossTangent and curve. For triangles the
   * parameters u and v are the barycentric coordinates of the second and third vertex. */
  virtual SurfacePoint surfaceAt(uint32_t primitive, const HitParameters& parameters) const = 0;
  /** Partial surfaceAt(): only position, error and geometric normal. */
  virtual SurfacePoint placeAt(uint32_t primitive, const HitParameters& parameters) const {
    return surfaceAt(primitive, parameters);
  }

  /** False for surfaces without area sampling: these cannot be lights, and sampleArea() to pdfDirection() are
   * not called; area() only where faceCount() > 0. */
  virtual bool canBeSampled() const { return true; }
  /** False if the first sample of the area takes long, as it measures the area. */
  virtual bool isQuicklySampled() const { return canBeSampled(); }
  /** Area of all primitives, with parts that alpha cuts out [scene units²]. */
  virtual float area() const = 0;
  /** Samples a point of the whole shape by u in [0, 1)²; pdf by area. `pick`, in [0, 1), chooses the
   * primitive. A pdf of 0 means no point: densities integrate to the probability that there is one. */
  virtual ShapeSample sampleArea(float pick, const Vec2f& u) const = 0;
  /** Density of sampleArea() at a point of a primitive; constant 1/area() unless overridden. */
  virtual float pdfArea(uint32_t, const SurfacePoint&) const { return 1 / area(); }
  /** Samples a point as seen from `from`; pdf by solid angle. Empty where sampling yields no point, or one
   * that is seen edge-on. The point may face away or be hidden. */
  virtual std::optional<ShapeSample> sampleDirection(const Vec3f& from, float pick, const Vec2f& u) const;
  /** Density of sampleDirection() at a point of a primitive, as seen from `from` [1/sr]. */
  virtual float pdfDirection(const Vec3f& from, uint32_t primitive, const SurfacePoint& point) const;

  /** Number of faces with coordinates in the unit square, for even tessellation; 0: none, or a triangle
   * mesh. Where it is 0, the next two functions are not called. */
  virtual uint32_t faceCount() const { return 0; }
  /** Surface at a point of a face. */
  virtual SurfacePoint pointOnFace(const FacePoint&) const { return {}; }
  /** Face and coordinates of a point of a primitive. */
  virtual FacePoint facePointOf(uint32_t /*primitive*/, const SurfacePoint&) const { return {}; }

  /** Predicted cost of a ray through the shape [tests of a simple surface]: the mean number of overlapping
   * parts, or the equivalent of a costly function; at least 1. */
  virtual double testsOfRay() const { return 1; }
  /** The mesh itself where the shape is one, so that Embree intersects its triangles. */
  virtual const TriangleMesh* triangleMesh() const { return nullptr; }
  Bounds3f bounds() const;

  /** The shape as a closed solid. Throws Error with the reason where it does not enclose a volume. */
  virtual std::unique_ptr<Solid> asSolid() const;
  /** Boundary curve of the surface: straight edges whole, curved ones as short pieces with gaps. Pieces with
   * the same ends are seams between parts. A piece of zero length represents an edge at an unknown
   * location. */
  virtual std::vector<RimPiece> rim() const { return {}; }
  /** Materials of a compound's components; empty: the whole has the material of the Shape directive. */
  virtual std::vector<const Material*> componentMaterials() const { return {}; }
  /** Material of a compound at a hit. */
  virtual const Material* materialAt(const HitParameters&) const { return nullptr; }

  /** Opacity: probability that rays hit the surface; null: 1. Set after construction. */
  std::shared_ptr<const TexturedRgb> alpha;
};

/** Closed shape, which a line enters and leaves. Must not outlive its shape. */
class Solid {
 public:
  struct Crossing {
    double t = 0;
    bool entering = false;
    uint32_t primitive = 0;
    HitParameters parameters; ///< for Shape::surfaceAt
  };
  virtual ~Solid() = default;
  /** Appends all crossings of the infinite line origin + t·direction, with t of either sign; in any
   * order. */
  virtual void crossings(const Vec3d& origin, const Vec3d& direction, std::vector<Crossing>& found) const = 0;
  /** True where the shape's geometric normals point into the solid. */
  virtual bool normalsPointIn() const { return false; }
};

struct ShapeContext;

/** Component of a compound shape. */
struct ComponentShape {
  std::unique_ptr<Shape> shape;
  const Material* material = nullptr;
  SourceLocation location; ///< of the Shape directive
};

/** Lookup of shapes by the name of their ObjectBegin. */
class ShapeLookup {
 public:
  virtual ~ShapeLookup() = default;
  /** Makes the object's shapes in the space of `context`, without those that have errors, which are reported.
   * Throws SceneError at the naming parameter where no such object exists or it contains itself. */
  virtual std::vector<ComponentShape> object(const Parameters& p, const std::string& parameter,
                                             const std::string& name, const ShapeContext& context) = 0;
};

/** Arguments of makers of shapes besides parameters. Pointers are valid during construction only, except the
 * one to the material, which belongs to the scene. */
struct ShapeContext {
  Mat4d sceneFromObject{1}; ///< transform of the file, followed by the recentring of the scene
  bool reverseOrientation = false;
  const TextureLookup* textures = nullptr; ///< null: no texture can be named
  ShapeLookup* shapes = nullptr;           ///< null: no object can be named
  const Material* material = nullptr;      ///< of the Shape directive; null: no scattering
  const Dicing* dicing = nullptr;          ///< null: no displacement, or no camera
  Vec3d textureShift{0};                   ///< added to a position for texture lookups
};

/**
 * Rim of a surface p(u, v): short pieces, with gaps, of the edges u = 0 and u = 1 if `uEnds`, v = 0 if
 * `vLow`, v = 1 if `vHigh`, of p on the unit square. Edges that are degenerate to a point have no pieces.
 */
std::vector<RimPiece> rimOfSweep(const std::function<Vec3d(double u, double v)>& p, bool uEnds, bool vLow,
                                 bool vHigh);

/** Transforms normals and derivatives of a point; normalMap is the inverse transpose of `map`. */
void transformDirections(const Mat3d& map, const Mat3d& normalMap, SurfacePoint& point);

// Tools of shapes that compute in double precision.

/** Derivative of the unit vector side · v / |v|, given dv; zero where v is zero. */
inline Vec3f derivativeOfUnit(const Vec3d& v, const Vec3d& dv, double side) {
  const double length2 = glm::dot(v, v);
  return length2 > 0 ? Vec3f((dv - v * (glm::dot(v, dv) / length2)) * (side / std::sqrt(length2))) : Vec3f(0);
}

/** Box of floats around a box of doubles, including every point of it rounded to float. */
Bounds3f roundedOut(const Bounds3d& box);
/**
 * SurfacePoint::error of a position that is rounded to float from a point with the error `exactError`, by
 * axis, on a surface with the error `offset` along its normal.
 */
inline Vec3f positionError(const Vec3d& position, const Vec3d& exactError, const Vec3d& normal,
                           double offset) {
  // The slack covers the float operations of SurfacePoint::rayOrigin().
  constexpr double UNIT = 0x1p-24, SLACK = 1 + 0x1p-20;
  return Vec3f((UNIT * magnitude(position) + exactError + offset * magnitude(normal)) * SLACK);
}

/**
 * Minimum offset of ray origins along the normal of a flat surface [scene units] whose bounding box has the
 * size `extent`. The side of a grazing ray is decided with a normal rounded to float, with an error of up to
 * 4 units of roundoff at the far end of the surface. In addition, a plane through the origin has zero
 * coordinates, where the neighbouring floats are denormal, so that coplanar surfaces would be hit.
 */
inline double flatOffset(const Vec3d& extent, const Vec3d& position, const Vec3d& normal) {
  const Vec3d n = magnitude(normal);
  const double largest = std::max(extent.x, std::max(extent.y, extent.z));
  return std::max(0x1p-22 * glm::dot(extent, n),
                  0x1p-28 * largest - 0x1p-24 * glm::dot(magnitude(position), n));
}

/** SurfacePoint::error of a point computed from floats; `rounding`: magnitudes of the coordinates that are
 * not exact, zero for exact ones. */
inline Vec3f positionError(const Vec3f& rounding, const Vec3f& normal, float offset) {
  // The slack covers these operations and the float operations of SurfacePoint::rayOrigin().
  constexpr float UNIT = 0x1p-24f, SLACK = 1 + 0x1p-19f;
  return (UNIT * rounding + offset * magnitude(normal)) * SLACK;
}

} // namespace recurse
