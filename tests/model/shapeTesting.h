/** @file
 * Shared functions of the tests of shapes: random numbers and transforms, shapes from parameters, objects by
 * name, and all intersections of a line.
 */
#pragma once

#include <gtest/gtest.h>
#include <random>

#include "recurse/model/mesh/triangleMesh.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/model/shape/curveShape.h"

namespace recurse::testing {

constexpr double PI_DOUBLE = 3.14159265358979323846;

class Random {
 public:
  explicit Random(uint64_t seed) : engine(seed) {}
  double uniform(double low = 0, double high = 1) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  float unit() { return std::min(static_cast<float>(uniform()), ONE_MINUS_EPSILON); }
  Vec2f unit2() {
    const float x = unit();
    return {x, unit()};
  }
  Vec3d direction() {
    const double z = uniform(-1, 1), phi = uniform(0, 2 * PI_DOUBLE), r = std::sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
  }
  Mat3d rotation() {
    const Vec3d a = direction();
    const Vec3d b = glm::normalize(glm::cross(a, direction()));
    return Mat3d(a, b, glm::cross(a, b));
  }
  double powerOfTen(double low, double high) { return std::pow(10, uniform(low, high)); }

 private:
  std::mt19937_64 engine;
};

/** Objects as operands of shapes. */
class TestObjects : public ShapeLookup {
 public:
  /** name, plug-in, parameters */
  std::vector<std::array<std::string, 3>> list{
      {"ball", "sphere", "\"float radius\" 1.2"},
      {"block", "box", "\"point3 p1\" [-1 -.9 -.8] \"point3 p2\" [1.1 1 .7]"}};
  std::vector<ComponentShape> object(const Parameters& p, const std::string& parameter,
                                     const std::string& name, const ShapeContext& context) override {
    std::vector<ComponentShape> made;
    for (const auto& o : list) {
      if (o[0] != name) continue;
      Diagnostics diagnostics;
      auto shape = plugIns().shapes.make(parseParameterText(o[1], o[2]), context, diagnostics);
      if (!shape) throw SceneError(diagnostics.format());
      made.push_back({std::move(shape), nullptr, p.location()});
    }
    if (made.empty()) p.fail(parameter, "no such object");
    return made;
  }
};

inline ShapeLookup* testObjects() {
  static TestObjects objects;
  return &objects;
}

inline std::unique_ptr<Shape> make(const std::string& name, const std::string& parameters,
                                   ShapeContext context = {}) {
  Diagnostics diagnostics;
  if (!context.shapes) context.shapes = testObjects();
  auto shape = plugIns().shapes.make(parseParameterText(name, parameters), context, diagnostics);
  EXPECT_TRUE(shape) << diagnostics.format();
  return shape;
}

inline Mat4d affine(const Mat3d& linear, const Vec3d& translation) {
  Mat4d m(linear);
  m[3] = Vec4d(translation, 1);
  return m;
}
inline Mat3d diagonal(double x, double y, double z) {
  Mat3d m(1);
  m[0][0] = x;
  m[1][1] = y;
  m[2][2] = z;
  return m;
}

struct Meeting {
  double t;
  uint32_t primitive;
  HitParameters parameters;
};

/** All intersections of a ray with a shape, the nearest first; triangles in double precision, without
 * Embree. */
inline std::vector<Meeting> allMeetings(const Shape& shape, const Vec3f& origin, const Vec3f& direction) {
  std::vector<Meeting> found;
  const TriangleMesh* mesh = shape.triangleMesh();
  for (uint32_t i = 0; i < shape.primitiveCount(); ++i) {
    if (mesh) {
      const glm::uvec3 t = mesh->indices()[i];
      const Vec3d p0 = mesh->positions()[t.x], e1 = Vec3d(mesh->positions()[t.y]) - p0,
                  e2 = Vec3d(mesh->positions()[t.z]) - p0, d = direction, s = Vec3d(origin) - p0;
      const Vec3d h = glm::cross(d, e2), q = glm::cross(s, e1);
      const double a = glm::dot(e1, h), u = glm::dot(s, h) / a, v = glm::dot(d, q) / a;
      const double distance = glm::dot(e2, q) / a;
      if (u >= 0 && v >= 0 && u + v <= 1 && distance > 0)
        found.push_back({distance, i, HitParameters(Vec2f(u, v))});
      continue;
    }
    float after = 0;
    while (const auto hit = shape.intersect(i, origin, direction, after, INFINITE)) {
      found.push_back({double(hit->t), i, hit->parameters});
      after = hit->t;
    }
  }
  std::sort(found.begin(), found.end(), [](const Meeting& a, const Meeting& b) { return a.t < b.t; });
  return found;
}

/** Shape of an example in the registry under a transform. */
struct Specimen {
  std::string name;
  std::unique_ptr<Shape> shape;
  bool reversed = false;
  Vec3d center() const { return shape->bounds().center(); }
  double radius() const { return 0.5 * glm::length(Vec3d(shape->bounds().diagonal())); }
};

enum class Transforms { ALL, FEW };

inline std::vector<Specimen> specimens(Transforms transforms = Transforms::ALL) {
  Random random(1);
  const Mat3d r1 = random.rotation(), r2 = random.rotation();
  std::vector<std::pair<const char*, ShapeContext>> contexts = {
      {"turned, scaled and moved", {affine(r1 * diagonal(3, 3, 3), {5, -4, 2}), false}},
      {"stretched", {affine(r1 * diagonal(1, 0.3, 2) * r2, {0.1, 0, 3}), true}}};
  if (transforms == Transforms::ALL) {
    contexts.push_back({"as it is", {}});
    contexts.push_back({"mirrored", {affine(diagonal(-1, 1.5, 0.5), {0, 2, 0}), false}});
  }
  std::vector<Specimen> all;
  for (const auto& entry : plugIns().shapes.entries())
    for (const std::string& example : entry.examples)
      for (const auto& [what, context] : contexts)
        all.push_back({entry.name + " [" + example + "] " + what, make(entry.name, example, context),
                       context.reverseOrientation});
  // Only Embree intersects curves.
  std::erase_if(all, [](const Specimen& s) { return dynamic_cast<const CurveShape*>(s.shape.get()); });
  return all;
}

/** Shapes that lamps can have. */
inline std::vector<Specimen> sampledSpecimens() {
  std::vector<Specimen> all = specimens(Transforms::FEW);
  std::erase_if(all, [](const Specimen& s) { return !s.shape->canBeSampled(); });
  return all;
}

/** Random line through the ball around a specimen: the number of intersections is proportional to the area of
 * a surface. */
inline std::pair<Vec3f, Vec3f> randomLine(Random& random, const Specimen& s) {
  const Vec3f direction(random.direction());
  const Frame frame(direction);
  const double r = s.radius() * std::sqrt(random.uniform()), phi = random.uniform(0, 2 * PI_DOUBLE);
  const Vec3d across = Vec3d(frame.x) * (r * std::cos(phi)) + Vec3d(frame.y) * (r * std::sin(phi));
  return {Vec3f(s.center() + across - Vec3d(direction) * (2 * s.radius())), direction};
}

/** Scales up to 1:`ratio` along random axes, and translates by `distance` times the size. */
inline Mat4d randomTransform(Random& random, double ratio, double distance) {
  const double scale = random.powerOfTen(-6, 6);
  const double e = std::log10(ratio) / 2;
  Vec3d axes(random.powerOfTen(-e, e), random.powerOfTen(-e, e), random.powerOfTen(-e, e));
  axes *= scale / std::max(axes.x, std::max(axes.y, axes.z));
  Mat3d linear = diagonal(axes.x, random.uniform() < 0.5 ? axes.y : -axes.y, axes.z);
  Vec3d moved = random.direction() * (distance * scale);
  if (random.uniform() < 0.5)
    linear = random.rotation() * linear * random.rotation();
  else if (random.uniform() < 0.5)
    moved.z = 0;
  return affine(linear, moved);
}

/** Uniform direction, or grazing by any angle on either side. */
inline Vec3f randomLeaving(Random& random, const Vec3f& normal) {
  Vec3d d = random.direction();
  if (random.uniform() < 0.5) {
    d = glm::normalize(glm::cross(Vec3d(normal), d));
    d += Vec3d(normal) * (random.powerOfTen(-9, 0) * (random.uniform() < 0.5 ? -1 : 1));
  }
  return glm::normalize(Vec3f(glm::normalize(d)));
}

} // namespace recurse::testing
