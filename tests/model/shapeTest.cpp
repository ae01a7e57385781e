/** @file
 * Properties of every registered shape (bounds, normals, sampling), and rays that leave a surface without
 * hitting it again.
 */
#include <array>
#include <functional>

#include "model/embree/embree.h"
#include "model/shapeTesting.h"
#include "recurse/core/threads/parallel.h"
#include "sanitized.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Error message for a use of a plug-in. */
std::string complaint(const std::string& name, const std::string& parameters) {
  Diagnostics diagnostics;
  const auto shape = plugIns().shapes.make(parseParameterText(name, parameters), {}, diagnostics);
  EXPECT_FALSE(shape);
  return diagnostics.format();
}

void expectSound(const SurfacePoint& p, const std::string& what) {
  EXPECT_TRUE(isFinite(p.position)) << what;
  EXPECT_TRUE(p.error.x >= 0 && p.error.y >= 0 && p.error.z >= 0 && isFinite(p.error)) << what;
  EXPECT_NEAR(glm::length(p.geometricNormal), 1, 1e-6) << what;
  EXPECT_NEAR(glm::length(p.shadingNormal), 1, 1e-6) << what;
  EXPECT_GE(glm::dot(p.shadingNormal, p.geometricNormal), 0) << what;
  EXPECT_TRUE(isFinite(p.dpdu) && isFinite(p.dpdv)) << what;
  EXPECT_TRUE(std::isfinite(p.uv.x) && std::isfinite(p.uv.y)) << what;
}

} // namespace

// ---- properties of every shape

TEST(Shape, HitsLieInBoundsAndOnTheRay) {
  Random random(2);
  for (const Specimen& s : specimens()) {
    int found = 0;
    for (int i = 0; i < 2000; ++i) {
      const auto [origin, direction] = randomLine(random, s);
      for (const Meeting& m : allMeetings(*s.shape, origin, direction)) {
        ++found;
        const SurfacePoint p = s.shape->surfaceAt(m.primitive, m.parameters);
        expectSound(p, s.name);
        const SurfacePoint place = s.shape->placeAt(m.primitive, m.parameters);
        EXPECT_EQ(place.position, p.position) << s.name;
        EXPECT_EQ(place.error, p.error) << s.name;
        EXPECT_EQ(place.geometricNormal, p.geometricNormal) << s.name;
        const Bounds3f b = s.shape->bounds(m.primitive);
        EXPECT_TRUE(b.contains(p.position)) << s.name;
        const Vec3d onRay = Vec3d(origin) + Vec3d(direction) * m.t;
        EXPECT_LT(glm::length(onRay - Vec3d(p.position)), 1e-6 * (s.radius() + glm::length(s.center())))
            << s.name;
      }
    }
    EXPECT_GT(found, 100) << s.name;
  }
}

TEST(Shape, TangentsFollowTheSurface) {
  for (const Specimen& s : specimens()) {
    Random random(3);
    const bool hasNormalDerivatives = s.name.rfind("metaballs", 0) != 0;
    int compared = 0;
    for (int i = 0; i < 2000; ++i) {
      const auto [origin, direction] = randomLine(random, s);
      for (const Meeting& m : allMeetings(*s.shape, origin, direction)) {
        // Central differences over two coordinates of the hit point, if these are far from their limits.
        constexpr float STEP = 0.001f;
        const int first = i % 3;
        Vec3f x(0), y(0);
        x[first] = y[(first + 1) % 3] = STEP;
        const auto at = [&](const Vec3f& offset) {
          HitParameters moved(m.parameters.point() + offset, m.parameters.part());
          moved.setComponent(m.parameters.component());
          return s.shape->surfaceAt(m.primitive, moved);
        };
        const SurfacePoint p = at(Vec3f(0)), x1 = at(x), x0 = at(-x), y1 = at(y), y0 = at(-y);
        const Vec3d px = Vec3d(x1.position) - Vec3d(x0.position),
                    py = Vec3d(y1.position) - Vec3d(y0.position);
        const Vec2d tx = Vec2d(x1.uv) - Vec2d(x0.uv), ty = Vec2d(y1.uv) - Vec2d(y0.uv);
        const double determinant = tx.x * ty.y - tx.y * ty.x;
        const Vec3d normal = glm::cross(px, py);
        // Clamped at an edge, across a seam, or near a pole: differences are not comparable.
        const auto atEdge = [](const SurfacePoint& q) {
          return q.uv.x == 0 || q.uv.x == 1 || q.uv.y == 0 || q.uv.y == 1;
        };
        if (atEdge(p) || atEdge(x0) || atEdge(x1) || atEdge(y0) || atEdge(y1)) continue;
        if (glm::length(normal) < 0.1 * glm::length(px) * glm::length(py)) continue;
        if (glm::length(tx) > 0.1 || glm::length(ty) > 0.1 || std::abs(determinant) < 1e-7) continue;
        if (glm::length(px + py) == 0) continue;
        const auto moved = [&](const SurfacePoint& a, const SurfacePoint& b) {
          return glm::length(Vec3d(a.position) + Vec3d(b.position) - 2.0 * Vec3d(p.position));
        };
        if (moved(x1, x0) > 0.05 * glm::length(px) || moved(y1, y0) > 0.05 * glm::length(py)) continue;
        // Near a pole the coordinates are too curved for differences.
        const auto bends = [&](const SurfacePoint& a, const SurfacePoint& b, const Vec2d& difference) {
          return glm::length(Vec2d(a.uv) + Vec2d(b.uv) - 2.0 * Vec2d(p.uv)) > 0.02 * glm::length(difference);
        };
        if (bends(x1, x0, tx) || bends(y1, y0, ty)) continue;
        EXPECT_GT(std::abs(glm::dot(glm::normalize(normal), Vec3d(p.geometricNormal))), 0.9999) << s.name;
        const Vec3d dpdu = (px * ty.y - py * tx.y) / determinant;
        EXPECT_LT(glm::length(dpdu - Vec3d(p.dpdu)), 0.02 * glm::length(dpdu)) << s.name;
        const Vec3d dpdv = (py * tx.x - px * ty.x) / determinant;
        EXPECT_LT(glm::length(dpdv - Vec3d(p.dpdv)), 0.02 * glm::length(dpdv)) << s.name;
        if (hasNormalDerivatives) {
          const Vec3d nx = Vec3d(x1.shadingNormal) - Vec3d(x0.shadingNormal),
                      ny = Vec3d(y1.shadingNormal) - Vec3d(y0.shadingNormal);
          const Vec3d dndu = (nx * ty.y - ny * tx.y) / determinant,
                      dndv = (ny * tx.x - nx * ty.x) / determinant;
          const double tolerance = 0.02 * (glm::length(dndu) + glm::length(dndv)) + 2e-3;
          EXPECT_LT(glm::length(dndu - Vec3d(p.dndu)), tolerance) << s.name;
          EXPECT_LT(glm::length(dndv - Vec3d(p.dndv)), tolerance) << s.name;
        }
        ++compared;
      }
    }
    EXPECT_GT(compared, 20) << s.name;
  }
}

/** Each point of a surface is on one of its faces, at coordinates that map back to it, and all points of the
 * faces are on the surface: the areas are equal. */
TEST(Shape, FacesCoverTheSurfaceOnce) {
  Random random(14);
  int shapesWithFaces = 0;
  for (const Specimen& s : specimens(Transforms::FEW)) {
    const uint32_t faces = s.shape->faceCount();
    if (faces == 0) continue;
    ++shapesWithFaces;
    const auto distance = [](const Vec3f& a, const Vec3f& b) { return double(glm::length(a - b)); };
    const double tolerance = 1e-5 * (s.radius() + glm::length(s.center()));
    for (int i = 0; i < recurse::testing::samples(500); ++i) {
      const auto [origin, direction] = randomLine(random, s);
      for (const Meeting& m : allMeetings(*s.shape, origin, direction)) {
        const SurfacePoint p = s.shape->surfaceAt(m.primitive, m.parameters);
        const FacePoint f = s.shape->facePointOf(m.primitive, p);
        ASSERT_LT(f.face, faces) << s.name;
        EXPECT_TRUE(f.uv.x >= 0 && f.uv.x <= 1 && f.uv.y >= 0 && f.uv.y <= 1) << s.name;
        const SurfacePoint again = s.shape->pointOnFace(f);
        expectSound(again, s.name);
        EXPECT_LT(distance(again.position, p.position), tolerance) << s.name;
        EXPECT_GT(glm::dot(again.geometricNormal, p.geometricNormal), 0.99f) << s.name;
      }
    }
    // The area of a polygon of n sides is 6.6 / n² smaller than its circle: .3 % for 48 sides.
    constexpr int GRID = SANITIZED ? 16 : 48;
    const double tolerated = 0.005 * square(48.0 / GRID);
    double area = 0;
    for (uint32_t face = 0; face < faces; ++face) {
      std::vector<Vec3d> grid;
      for (int i = 0; i <= GRID; ++i)
        for (int j = 0; j <= GRID; ++j)
          grid.emplace_back(s.shape->pointOnFace({face, Vec2d(i, j) / double(GRID)}).position);
      for (size_t k = 0; k + GRID + 2 < grid.size(); ++k) {
        if (k % (GRID + 1) == GRID) continue;
        const Vec3d &a = grid[k], &b = grid[k + 1], &c = grid[k + GRID + 1], &d = grid[k + GRID + 2];
        area += glm::length(glm::cross(b - a, c - a)) / 2 + glm::length(glm::cross(b - d, c - d)) / 2;
      }
    }
    EXPECT_NEAR(area, double(s.shape->area()), tolerated * area) << s.name;
  }
  EXPECT_GT(shapesWithFaces, 30);
}

TEST(ShapeDensity, SamplesByAreaFollowTheirDensity) {
  Random random(4);
  for (const Specimen& s : sampledSpecimens()) {
    // Integrals over the surface of 1 and of the squared coordinates: by lines, and by samples.
    const Vec3d center = s.center();
    const double r = s.radius();
    const auto functions = [&](const Vec3f& position) {
      const Vec3d x = (Vec3d(position) - center) / r;
      return std::array<double, 4>{1, x.x * x.x, x.y * x.y, x.x * x.z};
    };
    std::array<double, 4> byLines{}, bySamples{};
    constexpr int LINES = SANITIZED ? 1250 : 40000, SAMPLES = LINES;
    const double noisier = std::sqrt(40000.0 / SAMPLES);
    for (int i = 0; i < LINES; ++i) {
      const auto [origin, direction] = randomLine(random, s);
      for (const Meeting& m : allMeetings(*s.shape, origin, direction)) {
        const auto f = functions(s.shape->surfaceAt(m.primitive, m.parameters).position);
        // Crofton: each line through a ball of area S intersects a surface of area A inside of it 2 A / S
        // times on average.
        for (size_t k = 0; k < 4; ++k) byLines[k] += f[k] * 2 * PI_DOUBLE * r * r / LINES;
      }
    }
    for (int i = 0; i < SAMPLES; ++i) {
      const ShapeSample sample = s.shape->sampleArea(random.unit(), random.unit2());
      if (s.name.rfind("csg", 0) == 0 && sample.pdf == 0) continue; // a point hidden by a second operand
      ASSERT_GT(sample.pdf, 0) << s.name;
      expectSound(sample.point, s.name);
      EXPECT_TRUE(s.shape->bounds().contains(sample.point.position)) << s.name;
      const auto f = functions(sample.point.position);
      for (size_t k = 0; k < 4; ++k) bySamples[k] += f[k] / double(sample.pdf) / SAMPLES;
    }
    EXPECT_NEAR(bySamples[0], double(s.shape->area()), 0.015 * noisier * bySamples[0]) << s.name;
    if (SANITIZED) continue; // too few lines hit thin shapes
    for (size_t k = 0; k < 4; ++k)
      EXPECT_NEAR(byLines[k], bySamples[k], 0.05 * noisier * bySamples[0]) << s.name << " " << k;
  }
}

TEST(Shape, SamplesAreFoundByRays) {
  Random random(5);
  for (const Specimen& s : sampledSpecimens()) {
    int missed = 0, samples = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec3f from(s.center() + random.direction() * (s.radius() * random.powerOfTen(-1, 1.5)));
      const auto sample = s.shape->sampleDirection(from, random.unit(), random.unit2());
      if (!sample) continue;
      ++samples;
      expectSound(sample->point, s.name);
      const Vec3d way = Vec3d(sample->point.position) - Vec3d(from);
      const double distance = glm::length(way);
      const Vec3f direction(way / distance);
      bool found = false;
      for (const Meeting& m : allMeetings(*s.shape, from, direction)) {
        const SurfacePoint p = s.shape->surfaceAt(m.primitive, m.parameters);
        const double apart = glm::length(Vec3d(p.position) - Vec3d(sample->point.position));
        if (apart > 1e-3 * s.radius()) continue;
        found = true;
        // Edge-on, the density depends on the last digits of the point.
        const double cosine = std::abs(glm::dot(Vec3d(p.geometricNormal), Vec3d(direction)));
        if (cosine < 0.1 || apart > 1e-5 * s.radius()) continue;
        if (glm::dot(p.geometricNormal, sample->point.geometricNormal) < 0.999f)
          continue; // a neighbouring face
        const float pdf = s.shape->pdfDirection(from, m.primitive, p);
        // On a curved surface the cosine differs between the two points.
        const double bent = double(glm::length(p.geometricNormal - sample->point.geometricNormal));
        EXPECT_NEAR(pdf / sample->pdf, 1, 2e-3 + 2 * bent / cosine) << s.name << " at cosine " << cosine;
        EXPECT_NEAR(s.shape->pdfDirection(from, m.primitive, sample->point) / sample->pdf, 1, 1e-4) << s.name;
      }
      missed += !found;
    }
    // Most points on operands of csg solids may be hidden.
    EXPECT_GT(samples, s.name.rfind("csg", 0) == 0 ? 700 : 1900) << s.name;
    EXPECT_LT(missed, 20) << s.name; // rays exactly at the edge
  }
}

/** Point at a fraction of the radius from the centre, but not close to the surface, where sampling by area is
 * poor. */
static Vec3f placeAway(Random& random, const Specimen& s, double distance) {
  while (true) {
    const Vec3f from(s.center() + random.direction() * (s.radius() * distance));
    bool near = false;
    for (int i = 0; i < 200 && !near; ++i) {
      const auto meetings = allMeetings(*s.shape, from, Vec3f(random.direction()));
      near = !meetings.empty() && meetings[0].t < 0.05 * s.radius();
    }
    if (!near) return from;
  }
}

TEST(ShapeDensity, SamplesByDirectionFollowTheirDensity) {
  Random random(6);
  for (const Specimen& s : sampledSpecimens()) {
    for (const double distance : {0.2, 1.2, 4.0}) {
      const Vec3f from = placeAway(random, s, distance);
      // Integrals over the directions towards the shape: by directions, and by samples.
      const Vec3d towards = distance > 1 ? glm::normalize(s.center() - Vec3d(from)) : Vec3d(0, 0, 1);
      const double cosMax = distance > 1 ? std::sqrt(1 - 1 / (distance * distance)) : -1;
      const Frame frame{Vec3f(towards)};
      const auto functions = [&](const Vec3d& d) {
        const double c = glm::dot(d, towards);
        return std::array<double, 3>{1, c * c, glm::dot(d, Vec3d(frame.x))};
      };
      std::array<double, 3> byDirections{}, bySamples{};
      constexpr int DIRECTIONS = SANITIZED ? 400 : 10000, SAMPLES = DIRECTIONS;
      for (int i = 0; i < DIRECTIONS; ++i) {
        const double c = random.uniform(cosMax, 1), phi = random.uniform(0, 2 * PI_DOUBLE),
                     r = std::sqrt(1 - c * c);
        const Vec3d d =
            Vec3d(frame.x) * (r * std::cos(phi)) + Vec3d(frame.y) * (r * std::sin(phi)) + towards * c;
        if (allMeetings(*s.shape, from, Vec3f(d)).empty()) continue;
        const auto f = functions(d);
        for (size_t k = 0; k < 3; ++k) byDirections[k] += f[k] * 2 * PI_DOUBLE * (1 - cosMax) / DIRECTIONS;
      }
      double squares = 0;
      for (int i = 0; i < SAMPLES; ++i) {
        const auto sample = s.shape->sampleDirection(from, random.unit(), random.unit2());
        if (!sample) continue;
        const Vec3d way = Vec3d(sample->point.position) - Vec3d(from);
        const double length = glm::length(way);
        const auto meetings = allMeetings(*s.shape, from, Vec3f(way / length));
        if (!meetings.empty() && meetings[0].t < length * (1 - 1e-3)) continue; // hidden
        const auto f = functions(way / length);
        for (size_t k = 0; k < 3; ++k) bySamples[k] += f[k] / double(sample->pdf) / SAMPLES;
        squares += square(1 / double(sample->pdf)) / SAMPLES;
      }
      if (SANITIZED) continue; // too few samples for the sum of squares
      const double solidAngle = 2 * PI_DOUBLE * (1 - cosMax);
      const double deviation =
          std::sqrt(squares / SAMPLES) + solidAngle * 0.5 / std::sqrt(double(DIRECTIONS));
      for (size_t k = 0; k < 3; ++k)
        EXPECT_NEAR(byDirections[k], bySamples[k], 4.5 * deviation)
            << s.name << " from " << distance << ": " << k;
    }
  }
}

/** The surface where the density is above 0 has the solid angle, counted once for each meeting of a ray, that
 * the samples have. */
TEST(ShapeDensity, IsZeroWhereThereAreNoSamples) {
  Random random(61);
  for (const Specimen& s : sampledSpecimens())
    for (const double distance : {0.2, 4.0}) {
      const Vec3f from = placeAway(random, s, distance);
      const Vec3d towards = distance > 1 ? glm::normalize(s.center() - Vec3d(from)) : Vec3d(0, 0, 1);
      const double cosMax = distance > 1 ? std::sqrt(1 - 1 / (distance * distance)) : -1;
      const double solidAngle = 2 * PI_DOUBLE * (1 - cosMax);
      const Frame frame{Vec3f(towards)};
      constexpr int COUNT = SANITIZED ? 1000 : 10000;
      double byDensity = 0, bySamples = 0, squares = 0;
      for (int i = 0; i < COUNT; ++i) {
        const double c = random.uniform(cosMax, 1), phi = random.uniform(0, 2 * PI_DOUBLE),
                     r = std::sqrt(1 - c * c);
        const Vec3d d =
            Vec3d(frame.x) * (r * std::cos(phi)) + Vec3d(frame.y) * (r * std::sin(phi)) + towards * c;
        int meetings = 0;
        for (const Meeting& m : allMeetings(*s.shape, from, Vec3f(d)))
          meetings +=
              s.shape->pdfDirection(from, m.primitive, s.shape->surfaceAt(m.primitive, m.parameters)) > 0;
        byDensity += meetings * solidAngle / COUNT;
        squares += square(meetings * solidAngle) / COUNT;
        if (const auto sample = s.shape->sampleDirection(from, random.unit(), random.unit2())) {
          bySamples += 1 / double(sample->pdf) / COUNT;
          squares += square(1 / double(sample->pdf)) / COUNT;
        }
      }
      EXPECT_NEAR(byDensity, bySamples, 4.5 * std::sqrt(squares / COUNT)) << s.name << " from " << distance;
    }
}

TEST(Shape, OutsideIsWherePbrtHasIt) {
  Random random(7);
  const std::pair<const char*, ShapeContext> contexts[] = {
      {"plain", {}},
      {"reversed", {Mat4d(1), true}},
      {"mirrored", {affine(diagonal(-1, 1, 1), Vec3d(0)), false}},
      {"mirrored and reversed", {affine(diagonal(1, -1, 1), Vec3d(0)), true}}};
  for (const auto& [what, context] : contexts) {
    const float side = context.reverseOrientation ? -1.0f : 1.0f;
    for (int i = 0; i < 20; ++i) {
      const Vec2f u = random.unit2();
      const SurfacePoint ball = make("sphere", "", context)->sampleArea(0.5f, u).point;
      EXPECT_GT(side * glm::dot(ball.geometricNormal, ball.position), 0.99f) << what;
      const SurfacePoint disc = make("disk", "", context)->sampleArea(0.5f, u).point;
      EXPECT_EQ(side * disc.geometricNormal.z, 1) << what;
      // Meshes: the winding in object space, reversed by both the mirror and the transform.
      const SurfacePoint triangle =
          make("trianglemesh", "\"point3 P\" [0 0 0 1 0 0 0 1 0]", context)->sampleArea(0.5f, u).point;
      EXPECT_EQ(side * triangle.geometricNormal.z, 1) << what;
      const SurfacePoint patch =
          make("bilinearmesh", "\"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]", context)->sampleArea(0.5f, u).point;
      EXPECT_EQ(side * patch.geometricNormal.z, 1) << what;
      // Vertex normals decide, regardless of the winding.
      const SurfacePoint smooth =
          make("trianglemesh", "\"point3 P\" [0 0 0 0 1 0 1 0 0] \"normal N\" [0 0 1 0 .1 1 .1 0 1]", context)
              ->sampleArea(0.5f, u)
              .point;
      EXPECT_EQ(side * smooth.geometricNormal.z, 1) << what;
      EXPECT_GT(side * smooth.shadingNormal.z, 0.9f) << what;
    }
  }
}

// ---- accuracy

TEST(Sphere, ThinEllipsoidsAreMetWhereTheyAre) {
  Random random(8);
  for (const double thin : {1e-2, 1e-4}) {
    for (int i = 0; i < 20000; ++i) {
      const Mat3d rotation = random.rotation();
      const Vec3d axes(1, random.uniform() < 0.5 ? 1 : thin, thin), center = random.direction() * 2.0;
      const auto shape =
          make("sphere", "", {affine(rotation * diagonal(axes.x, axes.y, axes.z), center), false});
      const Vec3f origin(center + random.direction() * random.powerOfTen(0.1, 3));
      const Vec3f direction(
          glm::normalize(center + rotation * (axes * random.direction()) * 0.9 - Vec3d(origin)));
      const auto hit = shape->intersect(0, origin, direction, 0, INFINITE);
      if (!hit) continue;
      // Intersection of a sphere in long double.
      using Vec3l = glm::vec<3, long double>;
      const glm::mat<3, 3, long double> turn(glm::transpose(rotation));
      const Vec3l scale = Vec3l(1) / Vec3l(axes), o = scale * (turn * (Vec3l(origin) - Vec3l(center))),
                  d = scale * (turn * Vec3l(direction));
      const long double a = glm::dot(d, d), b = glm::dot(o, d), c = glm::dot(o, o) - 1;
      const long double root = b * b - a * c;
      if (root < 1e-4 * b * b) continue; // grazing: the intersection is ill-conditioned
      const long double t = c / (-b + std::sqrt(root));
      const Vec3l unit = o + d * t;
      const Vec3d normal = rotation * Vec3d(glm::normalize(scale * unit));
      EXPECT_NEAR(double(hit->t), double(t), 1e-6 * double(t));
      const SurfacePoint p = shape->surfaceAt(0, hit->parameters);
      const Vec3d position = Vec3d(origin) + Vec3d(direction) * double(t);
      EXPECT_LT(glm::length(Vec3d(p.position) - position), 1e-6 * (1 + double(t) * 1e-3));
      EXPECT_LT(glm::length(Vec3d(p.geometricNormal) - normal), 1e-5);
    }
  }
}

TEST(Sphere, SmallAndFar) {
  Random random(9);
  for (const double distance : {1e2, 1e4, 1e6}) {
    const Vec3d center = random.direction();
    const auto shape = make("sphere", "\"float radius\" 1e-4", {affine(Mat3d(1), center), false});
    int hits = 0;
    for (int i = 0; i < 1000; ++i) {
      const Vec3f from(center + random.direction() * distance);
      const auto sample = shape->sampleDirection(from, 0, random.unit2());
      ASSERT_TRUE(sample);
      const double solidAngle = PI_DOUBLE * square(1e-4 / glm::length(Vec3d(from) - center));
      EXPECT_NEAR(double(sample->pdf) * solidAngle, 1, 1e-5);
      EXPECT_NEAR(glm::length(Vec3d(sample->point.position) - center), 1e-4, 2e-7);
      // A direction in floats has a resolution of 1e-7 of the distance; from nearby the ray must hit the
      // point.
      if (distance > 1e2) continue;
      const Vec3f direction(glm::normalize(Vec3d(sample->point.position) - Vec3d(from)));
      hits += shape->intersect(0, from, direction, 0, INFINITE).has_value();
    }
    if (distance == 1e2) {
      EXPECT_GT(hits, 900);
    }
    // A ray along an axis towards it, in coordinates that are exact in floats: the hit is exact to the last
    // digit.
    const auto placed = make("sphere", "\"float radius\" 1e-4");
    const auto hit = placed->intersect(0, {static_cast<float>(distance), 0, 0}, {-1, 0, 0}, 0, INFINITE);
    ASSERT_TRUE(hit);
    EXPECT_FLOAT_EQ(placed->surfaceAt(0, hit->parameters).position.x, 1e-4f);
  }
}

TEST(Sphere, GroundAsLargeAsAPlanet) {
  const auto shape = make("sphere", "\"float radius\" 1e6", {affine(Mat3d(1), {0, 0, -1e6}), false});
  Random random(10);
  for (int i = 0; i < 10000; ++i) {
    const Vec3f origin(random.uniform(-10, 10), random.uniform(-10, 10), random.uniform(0.1, 5));
    Vec3d d = random.direction();
    d.z = -std::abs(d.z) - 0.05;
    const Vec3f direction(glm::normalize(d));
    const auto hit = shape->intersect(0, origin, direction, 0, INFINITE);
    ASSERT_TRUE(hit);
    const SurfacePoint p = shape->surfaceAt(0, hit->parameters);
    const Vec3d expected = Vec3d(origin) + Vec3d(direction) * double(hit->t);
    EXPECT_LT(glm::length(Vec3d(p.position) - expected), 1e-4);
    EXPECT_NEAR(double(p.position.z), -0.5e-6 * (square(expected.x) + square(expected.y)), 1e-8 + 1e-9 * d.x);
    EXPECT_LT(p.error.z, 1e-6f); // objects on the sphere stay attached
  }
}

TEST(Sphere, AreaOfEllipsoids) {
  // Spheroids have a closed form: c along the axis, a perpendicular to it.
  const auto spheroid = [](double a, double c) {
    if (c < a) {
      const double e = std::sqrt(1 - c * c / (a * a));
      return 2 * PI_DOUBLE * a * a * (1 + (1 - e * e) / e * std::atanh(e));
    }
    const double e = std::sqrt(1 - a * a / (c * c));
    return 2 * PI_DOUBLE * a * a * (1 + c / (a * e) * std::asin(e));
  };
  Random random(11);
  for (const double ratio : {1e-4, 1e-2, 0.5, 1.5, 1e2, 1e4}) {
    const auto turned = make("sphere", "\"float radius\" 2",
                             {affine(random.rotation() * diagonal(1, 1, ratio) * 0.5, Vec3d(1)), false});
    EXPECT_NEAR(double(turned->area()) / spheroid(1, ratio), 1, 1e-5) << ratio;
    const auto across =
        make("sphere", "", {affine(random.rotation() * diagonal(ratio, 1, 1), Vec3d(1)), false});
    EXPECT_NEAR(double(across->area()) / spheroid(1, ratio), 1, 1e-5) << ratio;
  }
}

TEST(Sphere, CoordinatesAreThoseOfPbrt) {
  const auto shape =
      make("sphere", "\"float radius\" 2 \"float zmin\" -1 \"float zmax\" 1.5 \"float phimax\" 180");
  // At the azimuth of 90 degrees, on the equator: v runs from zmin to zmax in the polar angle.
  const auto hit = shape->intersect(0, {0, 9, 0}, {0, -1, 0}, 0, INFINITE);
  ASSERT_TRUE(hit);
  const SurfacePoint p = shape->surfaceAt(0, hit->parameters);
  EXPECT_NEAR(p.uv.x, 0.5, 1e-6);
  EXPECT_NEAR(p.uv.y, (PI_DOUBLE / 2 - std::acos(-0.5)) / (std::acos(0.75) - std::acos(-0.5)), 1e-6);
  EXPECT_LT(p.dpdu.x, 0);
  // The second half of the azimuth is absent.
  EXPECT_FALSE(shape->intersect(0, {0.1f, -9, 0}, {0, 1, 0}, 0, 8));
}

TEST(BilinearMesh, RectanglesAreExact) {
  const auto shape = make("bilinearmesh", "\"point3 P\" [-3 -2 5  4 -2 5  -3 6 5  4 6 5]");
  EXPECT_EQ(shape->area(), 56);
  Random random(12);
  for (int i = 0; i < 10000; ++i) {
    const Vec3f origin(random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-9, 9));
    const Vec3f direction(random.direction());
    const double t = (5 - double(origin.z)) / double(direction.z);
    const Vec3d expected = Vec3d(origin) + Vec3d(direction) * t;
    const bool inside = t > 0 && expected.x > -3 && expected.x < 4 && expected.y > -2 && expected.y < 6;
    const auto hit = shape->intersect(0, origin, direction, 0, INFINITE);
    ASSERT_EQ(hit.has_value(), inside);
    if (!hit) continue;
    EXPECT_EQ(hit->t, static_cast<float>(t));
    const SurfacePoint p = shape->surfaceAt(0, hit->parameters);
    EXPECT_EQ(p.position.z, 5);
    EXPECT_EQ(p.error.z, 0);
    EXPECT_EQ(p.geometricNormal, Vec3f(0, 0, 1));
    EXPECT_LT(glm::length(Vec3d(p.position) - expected), 2e-6);
  }
}

TEST(BilinearMesh, PatchesMeetAtTheirEdges) {
  // No ray passes between two twisted patches at their common edge.
  const auto shape = make("bilinearmesh", "\"integer indices\" [0 1 2 3 1 4 3 5] "
                                          "\"point3 P\" [0 0 .3  1 0 0  0 1 .5  1.1 1 .2  2 0 .2  2.5 1 0]");
  Random random(13);
  int slipped = 0;
  for (int i = 0; i < 100000; ++i) {
    const Vec3d target = glm::mix(Vec3d(1, 0, 0), Vec3d(1.1f, 1, 0.2f), random.uniform(0.01, 0.99));
    const Vec3f origin(random.uniform(0.8, 1.3), random.uniform(0.3, 0.7), 20);
    slipped += allMeetings(*shape, origin, Vec3f(glm::normalize(target - Vec3d(origin)))).empty();
  }
  EXPECT_EQ(slipped, 0);
}

// ---- rays that leave a surface

namespace {

/** Number of rays that leave sampled points and hit the shape where they should not. */
int selfHits(const std::string& name, const std::string& example, double ratio, double distance, int shapes,
             const std::function<bool(const Shape&, const SurfacePoint&, const Vec3f&)>& wrong) {
  Random random(14);
  int count = 0;
  for (int k = 0; k < shapes; ++k) {
    const auto shape = make(name, example, {randomTransform(random, ratio, distance), false});
    for (int i = 0; i < 200; ++i) {
      const ShapeSample sample = shape->sampleArea(random.unit(), random.unit2());
      if (!(sample.pdf > 0)) continue;
      count += wrong(*shape, sample.point, randomLeaving(random, sample.point.geometricNormal));
    }
  }
  return count;
}

} // namespace

class LeavingRays : public ::testing::Test {
 protected:
  // Float mode of the renderer: displacements that are denormal numbers are zero.
  void SetUp() override { setThreadFloatMode(); }
};

TEST_F(LeavingRays, SpheresAreNotMetAgain) {
  for (const bool whole : {true, false}) {
    const auto wrong = [whole](const Shape& shape, const SurfacePoint& p, const Vec3f& direction) {
      const Vec3f origin = p.rayOrigin(direction);
      int meetings = 0;
      float t = 0;
      while (const auto hit = shape.intersect(0, origin, direction, t, INFINITE)) {
        ++meetings;
        t = hit->t;
      }
      // A ray to the outside hits nothing, a ray to the inside the far side if it exists.
      if (glm::dot(direction, p.geometricNormal) >= 0) return meetings > 0;
      return whole ? meetings != 1 : meetings > 1;
    };
    const char* example = whole ? "" : "\"float zmin\" -.5 \"float phimax\" 200";
    for (const double distance : {0.0, 1.0, 1e2, 1e3, 1e5})
      EXPECT_EQ(selfHits("sphere", example, 1, distance, 200, wrong), 0) << example << " at " << distance;
    // Ellipsoids whose sharpest tip has points that floats resolve.
    for (const double distance : {0.0, 1.0})
      EXPECT_EQ(selfHits("sphere", example, 30, distance, 200, wrong), 0) << example << " at " << distance;
  }
}

TEST_F(LeavingRays, FlatShapesAreNotMetAgain) {
  const auto met = [](const Shape& shape, const SurfacePoint& p, const Vec3f& direction) {
    return shape.intersect(0, p.rayOrigin(direction), direction, 0, INFINITE).has_value();
  };
  for (const double distance : {0.0, 1.0, 1e2, 1e3, 1e5}) {
    for (const double ratio : {1.0, 1e4}) {
      EXPECT_EQ(selfHits("disk", "", ratio, distance, 200, met), 0) << distance;
      EXPECT_EQ(selfHits("disk", "\"float height\" 0.3 \"float innerradius\" .5", ratio, distance, 200, met),
                0)
          << distance;
      EXPECT_EQ(selfHits("bilinearmesh", "\"point3 P\" [-1 -1 0  1 -1 0  -1 1 0  1 1 0]", ratio, distance,
                         200, met),
                0)
          << distance;
    }
  }
}

TEST_F(LeavingRays, TwistedPatchesAreMetAgainOnlyElsewhere) {
  // Opposite the patch, height over the tangent plane grows with the square of the distance: a ray cannot
  // return before it loses its own height.
  const auto wrong = [](const Shape& shape, const SurfacePoint& p, const Vec3f& direction) {
    const Vec3f origin = p.rayOrigin(direction);
    const auto hit = shape.intersect(0, origin, direction, 0, INFINITE);
    if (!hit) return false;
    const double size = glm::length(Vec3d(shape.bounds().diagonal()));
    const double cosine = std::abs(glm::dot(Vec3d(direction), Vec3d(p.geometricNormal)));
    const double height = std::abs(glm::dot(Vec3d(origin) - Vec3d(p.position), Vec3d(p.geometricNormal)));
    // The curvature of this patch is at most 2 / size.
    return double(hit->t) < 0.5 * std::max(cosine, std::sqrt(height / size)) * size;
  };
  for (const double distance : {0.0, 1.0, 1e2, 1e3})
    EXPECT_EQ(selfHits("bilinearmesh", "\"point3 P\" [0 0 0  1 0 .3  0 1 .4  1.2 1.1 -.2]", 1, distance, 200,
                       wrong),
              0)
        << distance;
}

TEST_F(LeavingRays, TrianglesAreNotMetAgainByEmbree) {
  enum Kind { ANY, AXIS_PLANE, AXIS_PLANE_AT_0, SLIVER_100, SLIVER_10000, NEARLY_AXIS_PLANE };
  Random random(16);
  RTCDevice device = rtcNewDevice(nullptr);
  for (const Kind kind : {ANY, AXIS_PLANE, AXIS_PLANE_AT_0, SLIVER_100, SLIVER_10000, NEARLY_AXIS_PLANE}) {
    for (const double distance : {0.0, 1.0, 1e2, 1e3, 1e5}) {
      int met = 0;
      for (int k = 0; k < 300; ++k) {
        const double scale = random.powerOfTen(-6, 6);
        Vec3d corners[3], moved = random.direction() * (distance * scale);
        for (Vec3d& c : corners) c = random.direction() * random.uniform();
        if (kind == AXIS_PLANE || kind == AXIS_PLANE_AT_0) {
          for (Vec3d& c : corners) c.z = kind == AXIS_PLANE ? 0.37 : 0;
          if (kind == AXIS_PLANE_AT_0) moved.z = 0;
        }
        if (kind == SLIVER_100 || kind == SLIVER_10000)
          corners[2] = glm::mix(corners[0], corners[1], random.uniform() < 0.5 ? 1 : random.uniform()) +
                       random.direction() * (kind == SLIVER_100 ? 1e-2 : 1e-4);
        if (kind == NEARLY_AXIS_PLANE)
          for (Vec3d& c : corners) c.z = random.uniform(-1e-3, 1e-3);
        MeshData data;
        for (const Vec3d& c : corners) data.positions.push_back(c * scale + moved);
        data.triangles = {{0, 1, 2}};
        const TriangleMesh mesh(data, {});

        RTCScene scene = rtcNewScene(device);
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        std::copy(mesh.positions().begin(), mesh.positions().end(),
                  static_cast<Vec3f*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                              RTC_FORMAT_FLOAT3, sizeof(Vec3f), 3)));
        *static_cast<glm::uvec3*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(glm::uvec3), 1)) = {0, 1, 2};
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene);
        for (int i = 0; i < 40; ++i) {
          Vec2f b = random.unit2();
          if (b.x + b.y > 1) b = Vec2f(1) - b;
          const SurfacePoint p = mesh.surfaceAt(0, HitParameters(b));
          const Vec3f direction = randomLeaving(random, p.geometricNormal), origin = p.rayOrigin(direction);
          RTCRayHit ray{};
          ray.ray.org_x = origin.x;
          ray.ray.org_y = origin.y;
          ray.ray.org_z = origin.z;
          ray.ray.dir_x = direction.x;
          ray.ray.dir_y = direction.y;
          ray.ray.dir_z = direction.z;
          ray.ray.tfar = INFINITE;
          ray.ray.mask = ~0u;
          ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
          embree::intersect(scene, ray);
          met += ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        }
        rtcReleaseScene(scene);
      }
      EXPECT_EQ(met, 0) << "kind " << kind << " at " << distance;
    }
  }
  rtcReleaseDevice(device);
}

// ---- meshes

TEST(TriangleMesh, TrianglesWithoutAreaAreNeverSampled) {
  MeshData data;
  data.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {5, 5, 5}};
  data.triangles = {{4, 4, 4}, {0, 1, 3}, {0, 1, 2}, {0, 0, 1}};
  const TriangleMesh mesh(data, {});
  EXPECT_FLOAT_EQ(mesh.area(), 0.5f);
  Random random(17);
  for (int i = 0; i < 1000; ++i) {
    const ShapeSample s = mesh.sampleArea(random.unit(), random.unit2());
    EXPECT_FLOAT_EQ(s.pdf, 2);
    EXPECT_LE(s.point.position.x + s.point.position.y, 1 + 1e-6f);
  }
  for (const float pick : {0.0f, ONE_MINUS_EPSILON})
    EXPECT_EQ(mesh.sampleArea(pick, {ONE_MINUS_EPSILON, 0}).point.geometricNormal, Vec3f(0, 0, 1));
  for (uint32_t i = 0; i < 4; ++i)
    expectSound(mesh.surfaceAt(i, HitParameters(Vec2f(0.2f, 0.3f))), "triangle " + std::to_string(i));

  data.triangles = {{0, 1, 3}};
  const TriangleMesh line(data, {});
  EXPECT_EQ(line.sampleArea(0.5f, {0.5f, 0.5f}).pdf, 0);
  EXPECT_FALSE(line.sampleDirection({0, 0, 1}, 0.5f, {0.5f, 0.5f}));
}

TEST(TriangleMesh, ManyTrianglesAreSampledEvenly) {
  // A strip of more small triangles than a single random float selects uniformly.
  MeshData data;
  constexpr uint32_t COUNT = 3000000;
  data.positions.reserve(COUNT + 2);
  for (uint32_t i = 0; i < COUNT + 2; ++i) data.positions.emplace_back(double(i / 2) / (COUNT / 2), i % 2, 0);
  data.triangles.reserve(COUNT);
  for (uint32_t i = 0; i < COUNT; ++i) data.triangles.emplace_back(i, i + 1, i + 2);
  const TriangleMesh mesh(std::move(data), {});
  EXPECT_TRUE(data.positions.empty());
  EXPECT_NEAR(mesh.area(), 1, 1e-3);
  Random random(18);
  constexpr int CELLS = 16, SAMPLES = 160000;
  std::vector<int> cells(CELLS * CELLS);
  for (int i = 0; i < SAMPLES; ++i) {
    const Vec3f p = mesh.sampleArea(random.unit(), random.unit2()).point.position;
    const auto x = std::min(static_cast<int>(p.x * CELLS), CELLS - 1);
    const auto y = std::min(static_cast<int>(p.y * CELLS), CELLS - 1);
    ++cells[size_t(y * CELLS + x)];
  }
  double chiSquare = 0;
  constexpr double EXPECTED = double(SAMPLES) / (CELLS * CELLS);
  for (const int n : cells) chiSquare += square(n - EXPECTED) / EXPECTED;
  EXPECT_LT(chiSquare, 255 + 5 * std::sqrt(2.0 * 255));
}

TEST(TriangleMesh, NormalsThatCancelFallBack) {
  const auto shape =
      make("trianglemesh", "\"point3 P\" [0 0 0 1 0 0 0 1 0] \"normal N\" [0 0 1 0 0 -1 0 0 0]");
  const SurfacePoint p = shape->surfaceAt(0, HitParameters(Vec2f(0.5f, 0)));
  expectSound(p, "cancelling normals");
  EXPECT_EQ(p.shadingNormal, Vec3f(0, 0, 1));
}

TEST(TriangleMesh, BadDataIsRefused) {
  MeshData data;
  data.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  data.triangles = {{0, 1, 3}};
  EXPECT_THROW(TriangleMesh(data, {}), Error);
  data.triangles = {{0, 1, 2}};
  data.normals = {{0, 0, 1}};
  EXPECT_THROW(TriangleMesh(data, {}), Error);
  data.normals.clear();
  data.positions[1].x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(TriangleMesh(data, {}), Error);
  data.positions[1].x = 1e300;
  EXPECT_THROW(TriangleMesh(data, {}), Error);
}

TEST(Shape, BadParametersAreExplained) {
  const auto has = [](const std::string& text, const char* part) {
    EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" is not in:\n" << text;
  };
  has(complaint("sphere", "\"float radius\" -1"), "radius");
  has(complaint("sphere", "\"float zmin\" 2 \"float zmax\" 3"), "no part of the sphere");
  has(complaint("sphere", "\"float phimax\" 400"), "phimax");
  has(complaint("sphere", "\"texture alpha\" \"holes\""), "texture");
  has(complaint("disk", "\"float innerradius\" 2"), "the hole is as large as the disc");
  has(complaint("trianglemesh", "\"integer indices\" [0 1 2]"), "P");
  has(complaint("trianglemesh", "\"point3 P\" [0 0 0 1 0 0]"), "no \"indices\"");
  has(complaint("trianglemesh", "\"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1]"),
      "do not form triangles");
  has(complaint("trianglemesh", "\"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]"), "index 3");
  has(complaint("trianglemesh", "\"point3 P\" [0 0 0 1 0 0 0 1 0] \"normal N\" [0 0 1]"), "1 given for 3");
  has(complaint("trianglemesh", "\"point3 P\" [0 0 0 1 0 0 0 1e200 0]"), "single precision");
  has(complaint("bilinearmesh", "\"point3 P\" [0 0 0 1 0 0 0 1 0]"), "no \"indices\"");
  has(complaint("bilinearmesh", "\"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"integer indices\" [0 1 2 4]"),
      "index 4");
  has(complaint("cylinder", "\"float zmin\" 1 \"float zmax\" 1"), "no height");
  has(complaint("cone", "\"float height\" -1"), "height");
  has(complaint("paraboloid", "\"float zmin\" -1"), "0 <= zmin < zmax");
  has(complaint("hyperboloid", "\"point3 p1\" [1 0 1] \"point3 p2\" [2 0 1]"), "is a disc");
  has(complaint("hyperboloid", "\"point3 p1\" [0 0 0] \"point3 p2\" [0 0 1]"), "on the z axis");
  has(complaint("torus", "\"float minorradius\" 2"), "has no hole");
  has(complaint("box", "\"point3 p1\" [0 1 0] \"point3 p2\" [1 1 1]"), "flat");
  has(complaint("csg", "\"string operands\" [\"a\" \"b\"]"), "objects are not supported here");
  has(complaint("metaballs", "\"point3 P\" []"), "0 values");
  has(complaint("metaballs", "\"point3 P\" [0 0 0] \"float threshold\" 2"), "below the threshold everywhere");
  has(complaint("metaballs", "\"point3 P\" [0 0 0] \"float radius\" [1 2]"), "2 given for 1 positions");
  has(complaint("metaballs", "\"point3 P\" [0 0 0] \"string field\" \"cubic\""), "quartic");
  has(complaint("loopsubdiv", "\"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]"), "index 3");
  has(complaint("loopsubdiv", "\"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 1]"),
      "uses a vertex twice");
  has(complaint("loopsubdiv", "\"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"integer indices\" [0 1 2 0 1 3]"),
      "opposite orientations");
  has(complaint("loopsubdiv",
                "\"integer levels\" 12 \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" "
                "[0 1 2 1 0 2 0 1 2 0 1 2 0 1 2 0 1 2 0 1 2 0 1 2 0 1 2 0 1 2 0 1 2 0 1 2 0 1 2]"),
      "fewer levels");
  const std::string square = "\"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0] \"integer indices\" [0 1 2 3] ";
  has(complaint("catmullclark", square + "\"integer creases\" [0 1 2]"), "an odd number of values");
  has(complaint("catmullclark", square + "\"integer creases\" [0 4]"), "there is no position 4");
  has(complaint("catmullclark", square + "\"integer creases\" [0 2]"), "no face has an edge between");
  has(complaint("catmullclark", square + "\"integer creases\" [0 1] \"float creasesharpness\" [1 2]"),
      "2 given for 1 creases");
  has(complaint("catmullclark", square + "\"integer holes\" [1]"), "there is no face 1");
  has(complaint("catmullclark", square + "\"integer sharpcorners\" [-1]"), "there is no position -1");
  has(complaint("curve", "\"point3 P\" [0 0 0 1 0 0 0 1 0]"), "3 control points do not form bezier curves");
  has(complaint("curve", "\"string type\" \"ribbon\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 1]"),
      "0 normals given for a ribbon");
}
