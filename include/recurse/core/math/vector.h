/** @file
 * Vectors, boxes and orthonormal frames. Vectors are GLM's; a distance is in scene units, a direction has
 * unit length unless its name says otherwise.
 */
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include <glm/glm.hpp>

namespace recurse {

using Vec2f = glm::vec2;
using Vec3f = glm::vec3;
using Vec2d = glm::dvec2;
using Vec3d = glm::dvec3;
using Vec4d = glm::dvec4;
using Mat3d = glm::dmat3;
using Mat3f = glm::mat3;
/** Column major, applied from the left: m[column][row]. */
using Mat4d = glm::dmat4;

constexpr float PI = 3.14159265358979323846f;
constexpr double PI_D = 3.14159265358979323846;
constexpr float INV_PI = 0.31830988618379067154f;
constexpr float INFINITE = std::numeric_limits<float>::infinity();
constexpr double INFINITE_D = std::numeric_limits<double>::infinity();
/** The largest float below 1. */
constexpr float ONE_MINUS_EPSILON = 0x1.fffffep-1f;

/** Higham's bound on the relative error of n float operations: n·u / (1 − n·u), u = 2^-24. */
constexpr float roundingBound(int n) {
  constexpr float UNIT = std::numeric_limits<float>::epsilon() * 0.5f;
  return static_cast<float>(n) * UNIT / (1 - static_cast<float>(n) * UNIT);
}

/** The float next to a finite x: above it where `direction` is positive, below it where `direction` is
 * negative. A zero of either sign has the smallest denormals as its neighbours. */
inline float nextFloat(float x, float direction) {
  constexpr uint32_t SIGN = 0x80000000u;
  const uint32_t way = std::bit_cast<uint32_t>(direction) & SIGN;
  uint32_t bits = std::bit_cast<uint32_t>(x);
  if (x == 0) bits = way; // takes the zero on that side
  bits += (bits & SIGN) == way ? 1u : ~0u;
  return std::bit_cast<float>(bits);
}

template <class T> constexpr T square(T x) { return x * x; }

inline float lengthSquared(const Vec3f& v) { return glm::dot(v, v); }
/** Absolute value of each component, without the comparisons with zero that glm::abs makes. */
template <class T> inline glm::vec<3, T> magnitude(const glm::vec<3, T>& v) {
  return {std::abs(v.x), std::abs(v.y), std::abs(v.z)};
}
/** Axis, 0 to 2, of the largest component of a vector without negative ones; the first of equal ones. */
template <class T> constexpr int widestAxis(const glm::vec<3, T>& v) {
  return v.x >= v.y && v.x >= v.z ? 0 : v.y >= v.z ? 1 : 2;
}
/** Number of signed axes: two for each dimension. */
constexpr size_t SIGNED_AXES = 6;
/** Index of the signed axis nearest to a direction: 2 · axis, plus 1 if it is negative. */
inline size_t signedAxis(const Vec3f& v) {
  const int axis = widestAxis(magnitude(v));
  return static_cast<size_t>(2 * axis + (v[axis] < 0));
}
inline float absDot(const Vec3f& a, const Vec3f& b) { return std::abs(glm::dot(a, b)); }
inline bool isFinite(const Vec3f& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/** A point transformed by an affine matrix. */
inline Vec3d transformPoint(const Mat4d& m, const Vec3d& p) { return Vec3d(m * Vec4d(p, 1)); }
/** A vector (difference of points) transformed by an affine matrix. */
inline Vec3d transformVector(const Mat4d& m, const Vec3d& v) { return Vec3d(m * Vec4d(v, 0)); }
/** True where the matrix mirrors, so that surfaces change their orientation. */
inline bool swapsHandedness(const Mat4d& m) { return glm::determinant(Mat3d(m)) < 0; }

/** An axis-aligned box; empty until something is added. */
template <class V> struct Bounds {
  using Scalar = typename V::value_type;
  V lower = V(std::numeric_limits<Scalar>::infinity());
  V upper = V(-std::numeric_limits<Scalar>::infinity());

  bool empty() const { return !(lower.x <= upper.x && lower.y <= upper.y && lower.z <= upper.z); }
  void add(const V& p) {
    lower = glm::min(lower, p);
    upper = glm::max(upper, p);
  }
  void add(const Bounds& b) {
    lower = glm::min(lower, b.lower);
    upper = glm::max(upper, b.upper);
  }
  V center() const { return lower + (upper - lower) * Scalar(0.5); }
  V diagonal() const { return upper - lower; }
  bool contains(const V& p) const {
    return glm::all(glm::greaterThanEqual(p, lower)) && glm::all(glm::lessThanEqual(p, upper));
  }
};
using Bounds3f = Bounds<Vec3f>;
using Bounds3d = Bounds<Vec3d>;

/** A right-handed orthonormal frame; BSDFs use one whose z axis is the shading normal. */
struct Frame {
  Vec3f x, y, z;

  Frame() : x(1, 0, 0), y(0, 1, 0), z(0, 0, 1) {}
  /** Any frame around a unit normal, without a branch on its direction (Duff et al. 2017, listing 3). */
  explicit Frame(const Vec3f& n) : z(n) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1 / (sign + n.z);
    const float b = n.x * n.y * a;
    x = Vec3f(1 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    y = Vec3f(b, sign + n.y * n.y * a, -n.y);
  }
  /** Frame around n whose x axis is as close to `tangent` as possible; any frame around n where `tangent` is
   * zero or parallel to n. */
  Frame(const Vec3f& n, const Vec3f& tangent) : Frame(n) {
    const Vec3f t = tangent - n * glm::dot(n, tangent);
    const float length2 = lengthSquared(t);
    if (!(length2 > 1e-12f * lengthSquared(tangent))) return;
    x = t / std::sqrt(length2);
    y = glm::cross(z, x);
  }
  Vec3f toLocal(const Vec3f& v) const { return {glm::dot(v, x), glm::dot(v, y), glm::dot(v, z)}; }
  Vec3f toWorld(const Vec3f& v) const { return x * v.x + y * v.y + z * v.z; }
};

} // namespace recurse
