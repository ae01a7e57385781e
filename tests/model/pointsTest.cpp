/** @file
 * Point clouds against single spheres and discs, and their files.
 */
#include "model/shapeTesting.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

struct Cloud {
  std::vector<Vec3d> positions, normals;
  std::vector<double> radii;

  static Cloud random(uint64_t seed, int count) {
    Random random(seed);
    Cloud c;
    for (int i = 0; i < count; ++i) {
      c.positions.emplace_back(Vec3f(random.direction() * random.uniform(0, 2))); // rounded to float
      c.normals.emplace_back(random.direction() * random.uniform(.5, 2));
      c.radii.push_back(double(static_cast<float>(random.uniform(.05, .4))));
    }
    return c;
  }
  static std::string list(const std::vector<Vec3d>& values) {
    std::ostringstream text;
    text.precision(17);
    for (const Vec3d& v : values) text << v.x << " " << v.y << " " << v.z << "  ";
    return text.str();
  }
  std::string parameters(bool withNormals) const {
    std::ostringstream text;
    text.precision(17);
    text << "\"point3 P\" [" << list(positions) << "] \"float radius\" [";
    for (const double r : radii) text << r << " ";
    text << "]";
    if (withNormals) text << " \"normal N\" [" << list(normals) << "]";
    return text.str();
  }
};

/** Makes the shape from the content of a file. */
std::unique_ptr<Shape> fromFile(const std::string& bytes, const std::string& more, std::string& said) {
  ParsedDirective use = parseParameterText("points", "\"string filename\" \"cloud.ply\" " + more);
  use.files =
      std::make_shared<MemoryFiles>(MemoryFiles{{"cloud.ply", std::make_shared<const std::string>(bytes)}});
  Diagnostics diagnostics;
  auto shape = plugIns().shapes.make(use, {}, diagnostics);
  said = diagnostics.format();
  return shape;
}

} // namespace

TEST(Points, SpheresAreSpheres) {
  const Cloud cloud = Cloud::random(61, 40);
  Random random(62);
  for (const ShapeContext& context :
       {ShapeContext{}, ShapeContext{affine(random.rotation() * diagonal(2, 2, 2), {1, 2, 3}), true},
        ShapeContext{affine(random.rotation() * diagonal(1, .4, -2), {.5, 0, 1}), false}}) {
    const auto points = make("points", cloud.parameters(false), context);
    ASSERT_EQ(points->primitiveCount(), cloud.positions.size());
    double area = 0;
    size_t hits = 0;
    const Specimen whole{"", make("points", cloud.parameters(false), context)};
    for (uint32_t i = 0; i < points->primitiveCount(); ++i) {
      ShapeContext placed = context;
      placed.sceneFromObject = context.sceneFromObject * affine(Mat3d(1), cloud.positions[i]);
      // Centres are rounded to float, as positions of meshes are.
      placed.sceneFromObject[3] = Vec4d(Vec3d(Vec3f(Vec3d(placed.sceneFromObject[3]))), 1);
      const auto sphere = make("sphere", "\"float radius\" " + std::to_string(1), [&] {
        ShapeContext scaled = placed;
        for (int k = 0; k < 3; ++k) scaled.sceneFromObject[k] *= cloud.radii[i];
        return scaled;
      }());
      area += double(sphere->area());
      EXPECT_EQ(points->bounds(i).lower, sphere->bounds(0).lower);
      EXPECT_EQ(points->bounds(i).upper, sphere->bounds(0).upper);
      for (int k = 0; k < 400; ++k) {
        const auto [o, d] = randomLine(random, whole);
        const auto hit = points->intersect(i, o, d, 0, INFINITE),
                   expected = sphere->intersect(0, o, d, 0, INFINITE);
        ASSERT_EQ(hit.has_value(), expected.has_value());
        if (!hit) continue;
        ++hits;
        EXPECT_FLOAT_EQ(hit->t, expected->t);
        const SurfacePoint p = points->surfaceAt(i, hit->parameters),
                           q = sphere->surfaceAt(0, expected->parameters);
        EXPECT_LT(glm::length(p.position - q.position), 1e-6f * glm::length(q.position));
        EXPECT_LT(glm::length(p.geometricNormal - q.geometricNormal), 1e-5f);
        EXPECT_LT(glm::length(p.dpdu - q.dpdu), 1e-5f);
        EXPECT_LT(glm::length(p.dndv - q.dndv), 1e-4f);
        EXPECT_LT(glm::length(p.error - q.error), 1e-3f * glm::length(q.error));
      }
    }
    EXPECT_GT(hits, 30u);
    EXPECT_NEAR(double(points->area()), area, 1e-5 * area);
  }
}

TEST(Points, DiscsAreDiscs) {
  const Cloud cloud = Cloud::random(63, 40);
  Random random(64);
  for (const ShapeContext& context :
       {ShapeContext{}, ShapeContext{affine(random.rotation() * diagonal(1, .4, 2), {.5, 0, 1}), true},
        ShapeContext{affine(diagonal(-1, 1, 1), {0, 0, 0}), false}}) {
    const auto points = make("points", cloud.parameters(true), context);
    double area = 0;
    size_t hits = 0;
    const Specimen whole{"", make("points", cloud.parameters(true), context)};
    for (uint32_t i = 0; i < points->primitiveCount(); ++i) {
      const Vec3d n(Vec3f(glm::normalize(cloud.normals[i])));
      const Vec3d x = glm::normalize(glm::cross(n, Vec3d(.3, .5, -.2))), y = glm::cross(n, x);
      ShapeContext placed = context;
      placed.sceneFromObject =
          context.sceneFromObject * affine(Mat3d(x, y, n) * cloud.radii[i], cloud.positions[i]);
      placed.sceneFromObject[3] = Vec4d(Vec3d(Vec3f(Vec3d(placed.sceneFromObject[3]))), 1);
      const auto disc = make("disk", "", placed);
      area += double(disc->area());
      EXPECT_LT(glm::length(points->bounds(i).lower - disc->bounds(0).lower), 1e-6f);
      for (int k = 0; k < 400; ++k) {
        const auto [o, d] = randomLine(random, whole);
        const auto hit = points->intersect(i, o, d, 0, INFINITE),
                   expected = disc->intersect(0, o, d, 0, INFINITE);
        ASSERT_EQ(hit.has_value(), expected.has_value());
        if (!hit) continue;
        ++hits;
        EXPECT_FLOAT_EQ(hit->t, expected->t);
        const SurfacePoint p = points->surfaceAt(i, hit->parameters),
                           q = disc->surfaceAt(0, expected->parameters);
        EXPECT_LT(glm::length(p.position - q.position), 1e-6f * (1 + glm::length(q.position)));
        EXPECT_LT(glm::length(p.geometricNormal - q.geometricNormal), 1e-6f);
      }
    }
    EXPECT_GT(hits, 30u);
    EXPECT_NEAR(double(points->area()), area, 1e-5 * area);
  }
}

TEST(Points, FilesGivePointsNormalsAndRadii) {
  const std::string file = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
                           "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
                           "property float radius\nelement face 1\nproperty list uchar int vertex_indices\n"
                           "end_header\n1 2 3 0 0 2 .5\n-1 0 4 1 0 0 .25\n3 0 1 1\n";
  std::string said;
  const auto discs = fromFile(file, "", said);
  ASSERT_TRUE(discs) << said;
  ASSERT_EQ(discs->primitiveCount(), 2u);
  EXPECT_NEAR(discs->area(), PI_DOUBLE * (.25 + .0625), 1e-6);
  EXPECT_EQ(discs->surfaceAt(0, HitParameters(Vec2f(0))).position, Vec3f(1, 2, 3));
  EXPECT_EQ(discs->surfaceAt(1, HitParameters(Vec2f(0))).geometricNormal, Vec3f(1, 0, 0));
  // Parameters have precedence over the file.
  const auto spheres = fromFile(file, "\"string type\" \"sphere\" \"float radius\" 2", said);
  ASSERT_TRUE(spheres) << said;
  EXPECT_NEAR(spheres->area(), 2 * 4 * PI_DOUBLE * 4, 1e-4);
  // A file without faces and normals.
  const auto bare = fromFile("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                             "property float z\nend_header\n1 2 3\n",
                             "\"float radius\" 1", said);
  ASSERT_TRUE(bare) << said;
  EXPECT_LT(glm::length(bare->bounds().center() - Vec3f(1, 2, 3)), 1e-6f);
}

TEST(Points, BadCloudsAreExplained) {
  const auto expect = [](const std::string& said, const char* part) {
    EXPECT_NE(said.find(part), std::string::npos) << "\"" << part << "\" is not in:\n" << said;
  };
  const auto complaint = [](const std::string& parameters) {
    Diagnostics diagnostics;
    EXPECT_FALSE(plugIns().shapes.make(parseParameterText("points", parameters), {}, diagnostics))
        << parameters;
    return diagnostics.format();
  };
  expect(complaint("\"float radius\" 1"), "there are no points");
  expect(complaint("\"point3 P\" [0 0 0]"), "the points have no radius");
  expect(complaint("\"point3 P\" [0 0 0  1 1 1] \"float radius\" [1 2 3]"), "3 given for 2 points");
  expect(complaint("\"point3 P\" [0 0 0] \"float radius\" 0"), "radius");
  Diagnostics diagnostics;
  EXPECT_FALSE(
      plugIns().shapes.make(parseParameterText("points", "\"point3 P\" [0 0 1e37] \"float radius\" 1"),
                            {affine(diagonal(1e3, 1e3, 1e3), {0, 0, 0})}, diagnostics));
  expect(diagnostics.format(), "point 0 is too large for single precision");
  expect(complaint("\"point3 P\" [0 0 0] \"float radius\" 1 \"string type\" \"disk\""),
         "0 normals given for 1 disc");
  expect(complaint("\"point3 P\" [0 0 0] \"float radius\" 1 \"normal N\" [0 0 1 0 0 1]"),
         "2 normals given for 1 disc");
  expect(complaint("\"point3 P\" [0 0 0] \"float radius\" 1 \"normal N\" [0 0 0]"),
         "the normal of point 0 is zero");
  expect(complaint("\"point3 P\" [0 0 0] \"float radius\" 1 \"string type\" \"cube\""), "\"disk\"");
  expect(complaint("\"string filename\" \"a.ply\" \"point3 P\" [0 0 0]"), "the points are in the file");
  expect(complaint("\"string filename\" \"there-is-none.ply\" \"float radius\" 1"), "there is no file");

  const auto fileComplaint = [](const std::string& properties, const std::string& data,
                                const std::string& more = "") {
    std::string said;
    EXPECT_FALSE(fromFile("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n" +
                              properties + "end_header\n" + data,
                          more, said))
        << data;
    return said;
  };
  const std::string z = "property float z\n", radius = z + "property float radius\n",
                    normals = radius + "property float nx\nproperty float ny\nproperty float nz\n";
  expect(fileComplaint("", "0 0\n1 1\n"), "the vertices have no x, y and z");
  expect(fileComplaint(z, "0 0 0\n1 1 1\n"), "the points have no radius");
  expect(fileComplaint(radius, "0 0 0 1\n1 1 1 -1\n"), "point 1 has a radius that is not positive");
  expect(fileComplaint(radius, "0 0 0 1\n1 1 1 nan\n"), "point 1 has a radius that is not positive");
  expect(fileComplaint(radius, "0 0 0 1\n1 nan 1 1\n"), ":10: vertex 1 has a position that is not finite");
  expect(fileComplaint(radius, "0 0 0 1\n1 1\n"), "the file ends in vertex 1 of 2");
  expect(fileComplaint(radius, "0 0 0 1\n1 x 1 1\n"), ":10: \"x\" is no number");
  expect(fileComplaint(normals, "0 0 0 1 0 0 1\n1 1 1 1 nan 0 0\n"),
         "the normal of point 1 is zero or not finite");
  expect(fileComplaint(radius, "0 0 0 1\n1 1 1 1\n", "\"string type\" \"disk\""),
         "0 normals given for 2 discs");
  std::string said;
  EXPECT_FALSE(fromFile("ply\nformat ascii 1.0\nelement face 0\nend_header\n", "", said));
  expect(said, "the file has no vertices");
  EXPECT_FALSE(fromFile("no ply\n", "", said));
  expect(said, "this is no PLY file");
}
