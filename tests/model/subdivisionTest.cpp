/** @file
 * Subdivision surfaces against what is known of their limits.
 */
#include "model/shapeTesting.h"

using namespace recurse;
using namespace recurse::testing;

TEST(LoopSubdivision, LimitOfAnOctahedronIsRound) {
  // By symmetry a vertex stays on its axis, at the limit mask's distance; a plane stays a plane.
  const char* octahedron = "\"point3 P\" [1 0 0 -1 0 0 0 1 0 0 -1 0 0 0 1 0 0 -1] \"integer indices\" "
                           "[0 2 4 2 1 4 1 3 4 3 0 4 2 0 5 1 2 5 3 1 5 0 3 5]";
  for (const int levels : {1, 3}) {
    const auto shape = make("loopsubdiv", "\"integer levels\" " + std::to_string(levels) + " " + octahedron);
    const TriangleMesh& mesh = *shape->triangleMesh();
    EXPECT_EQ(mesh.indices().size(), 8u << (2 * levels));
    // The limit of valence 4: the neighbours' mean is 0, so that 1 - n w is left, w = 1 / (n + 3 / (8 β)), β
    // = 3/32.
    for (int k = 0; k < 6; ++k) EXPECT_NEAR(glm::length(mesh.positions()[k]), 0.5, 1e-6) << levels;
    EXPECT_NO_THROW(shape->asSolid());
    EXPECT_TRUE(shape->asSolid()->normalsPointIn()); // as pbrt-v4 has it
  }
  const auto flat =
      make("loopsubdiv", "\"point3 P\" [0 0 1 1 0 1 0 1 1 1 1 1] \"integer indices\" [0 1 2 1 3 2]");
  for (uint32_t i = 0; i < flat->primitiveCount(); ++i) {
    const SurfacePoint p = flat->surfaceAt(i, HitParameters(Vec2f(0.3f)));
    EXPECT_FLOAT_EQ(p.position.z, 1);
    EXPECT_NEAR(p.shadingNormal.z, -1, 1e-6);
  }
}

TEST(CatmullClark, LimitDoesNotDependOnTheLevels) {
  const char* cube = " \"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 0  0 0 1  1 0 1  0 1 1  1 1 1] "
                     "\"integer indices\" [0 2 3 1  4 5 7 6  0 1 5 4  2 6 7 3  0 4 6 2  1 3 7 5]";
  const auto coarse = make("catmullclark", "\"integer levels\" 1" + std::string(cube)),
             fine = make("catmullclark", "\"integer levels\" 4" + std::string(cube));
  const TriangleMesh &a = *coarse->triangleMesh(), &b = *fine->triangleMesh();
  EXPECT_EQ(b.indices().size(), 6u * 256 * 2);
  // The vertices of the coarse mesh are the first of the fine one.
  for (size_t i = 0; i < a.positions().size(); ++i)
    EXPECT_LT(glm::length(a.positions()[i] - b.positions()[i]), 1e-6f) << i;
  // Corners by symmetry on the diagonals, with normals along them.
  const Vec3f corner = b.positions()[7] - Vec3f(.5f);
  EXPECT_NEAR(corner.x, corner.y, 1e-6);
  EXPECT_NEAR(corner.x, corner.z, 1e-6);
  EXPECT_FALSE(fine->asSolid()->normalsPointIn());
  for (uint32_t i = 0; i < fine->primitiveCount(); ++i) {
    const SurfacePoint p = fine->surfaceAt(i, HitParameters(Vec2f(1 / 3.0f)));
    EXPECT_GT(glm::dot(p.shadingNormal, glm::normalize(p.position - Vec3f(.5f))), .9f);
    EXPECT_GT(glm::dot(p.shadingNormal, p.geometricNormal), .98f);
  }
}

TEST(CatmullClark, AGridIsABSpline) {
  // The limit over a regular grid is the uniform bicubic B-spline of its positions.
  const auto height = [](int x, int y) { return std::sin(1.3 * x) + std::cos(.7 * y * x); };
  std::ostringstream text;
  text << "\"integer levels\" 3 \"point3 P\" [";
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 6; ++x) text << x << " " << y << " " << height(x, y) << " ";
  text << "] \"integer indices\" [";
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 5; ++x)
      text << y * 6 + x << " " << y * 6 + x + 1 << " " << y * 6 + x + 7 << " " << y * 6 + x + 6 << " ";
  const auto shape = make("catmullclark", text.str() + "]");
  int compared = 0;
  for (const Vec3f& p : shape->triangleMesh()->positions()) {
    if (p.x < 1 || p.x >= 4 || p.y < 1 || p.y >= 4) continue; // the boundary has rules of its own
    const auto weights = [](double t) {
      return std::array<double, 4>{(1 - t) * (1 - t) * (1 - t) / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
                                   (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6};
    };
    // Vertices come out at rational places but for rounding.
    const double px = std::round(double(p.x) * 64) / 64, py = std::round(double(p.y) * 64) / 64;
    const int x = int(px), y = int(py);
    const auto wx = weights(px - x), wy = weights(py - y);
    double z = 0;
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 4; ++k) z += wx[size_t(i)] * wy[size_t(k)] * height(x + i - 1, y + k - 1);
    EXPECT_NEAR(double(p.z), z, 1e-5) << p.x << " " << p.y;
    ++compared;
  }
  EXPECT_GT(compared, 500);
}

namespace {

const std::string CUBE = "\"point3 P\" [-1 -1 -1  1 -1 -1  -1 1 -1  1 1 -1  -1 -1 1  1 -1 1  -1 1 1  1 1 1] "
                         "\"integer indices\" [0 2 3 1  4 5 7 6  0 1 5 4  2 6 7 3  0 4 6 2  1 3 7 5] ";

/** A sheet of 7 by 3 squares with heights that depend on x alone, and its vertices next to (x, 1). */
std::vector<Vec3f> sheet(const double (&heights)[8], const std::string& more, double x) {
  std::ostringstream text;
  text << "\"point3 P\" [";
  for (int k = 0; k < 32; ++k) text << k % 8 << " " << k / 8 << " " << heights[k % 8] << " ";
  text << "] \"integer indices\" [";
  for (int row = 0; row < 3; ++row)
    for (int k = 0; k < 7; ++k)
      text << row * 8 + k << " " << row * 8 + k + 1 << " " << row * 8 + k + 9 << " " << row * 8 + k + 8
           << " ";
  const auto shape = make("catmullclark", "\"integer levels\" 3 " + text.str() + "] " + more);
  std::vector<Vec3f> found;
  for (const Vec3f& p : shape->triangleMesh()->positions())
    if (std::abs(p.x - float(x)) < 1e-5f && std::abs(p.y - 1) < 1e-5f) found.push_back(p);
  return found;
}

} // namespace

TEST(CatmullClark, ACornerOfACubeComesHalfWay) {
  // Halstead's limit mask of three faces: (9 v + 4 Σ edges + Σ diagonals) / 24.
  const auto shape = make("catmullclark", "\"integer levels\" 2 " + CUBE);
  for (int k = 0; k < 8; ++k)
    EXPECT_NEAR(glm::length(shape->triangleMesh()->positions()[size_t(k)]), std::sqrt(.75), 1e-6);
}

TEST(CatmullClark, SharpEdgesLeaveTheCubeAsItIs) {
  const auto shape =
      make("catmullclark", "\"integer levels\" 3 " + CUBE +
                               "\"integer creases\" [0 1 1 3 3 2 2 0 4 5 5 7 7 6 6 4 0 4 1 5 2 6 3 7]");
  const TriangleMesh& mesh = *shape->triangleMesh();
  EXPECT_NEAR(shape->area(), 24, 1e-5);
  for (const Vec3f& p : mesh.positions())
    EXPECT_NEAR(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}), 1, 1e-6);
  // Flat faces up to the edges, which do not open the solid.
  for (uint32_t i = 0; i < shape->primitiveCount(); ++i) {
    const SurfacePoint p = shape->surfaceAt(i, HitParameters(Vec2f(.01f)));
    EXPECT_NEAR(glm::dot(p.shadingNormal, p.geometricNormal), 1, 1e-6);
  }
  EXPECT_NO_THROW(shape->asSolid());
}

TEST(CatmullClark, ACreaseIsASplineOfItsPositions) {
  // The loop around the top is a uniform cubic B-spline of its own: (p + 4 p + p) / 6 at the positions.
  const auto shape =
      make("catmullclark", "\"integer levels\" 3 " + CUBE + "\"integer creases\" [4 5 5 7 7 6 6 4]");
  for (const int k : {4, 5, 6, 7}) {
    const Vec3f p = shape->triangleMesh()->positions()[size_t(k)];
    EXPECT_NEAR(std::abs(p.x), 2 / 3.0, 1e-6);
    EXPECT_NEAR(std::abs(p.y), 2 / 3.0, 1e-6);
    EXPECT_NEAR(p.z, 1, 1e-6);
  }
  // The lid within the crease is flat, and its normals are its own.
  for (uint32_t i = 0; i < shape->primitiveCount(); ++i) {
    const SurfacePoint p = shape->surfaceAt(i, HitParameters(Vec2f(1 / 3.0f)));
    if (p.geometricNormal.z > .999f) {
      EXPECT_NEAR(p.position.z, 1, 1e-6);
      EXPECT_NEAR(p.shadingNormal.z, 1, 1e-6);
    }
  }
}

TEST(CatmullClark, SharpnessOneIsOneSharpStep) {
  // Across the crease at x = 3: after one sharp step the neighbours are the middles of the edges, and the
  // limit is (left + 4 h + right) / 6 of those; without it, of the heights themselves; with a sharp crease,
  // h.
  const double heights[8] = {0, 1, 2, 7, 3, 1, 0, 0};
  const std::string crease = "\"integer creases\" [3 11  11 19  19 27] ";
  for (const auto& [more, expected] :
       {std::pair(std::string(), (2 + 4 * 7 + 3) / 6.0), std::pair(crease, 7.0),
        std::pair(crease + "\"float creasesharpness\" 1", (4.5 + 4 * 7 + 5) / 6)}) {
    const auto found = sheet(heights, more, 3);
    ASSERT_GE(found.size(), 1u) << more;
    for (const Vec3f& p : found) EXPECT_NEAR(p.z, expected, 1e-5) << more;
  }
  EXPECT_EQ(sheet(heights, crease, 3).size(), 2u); // a normal for each side
}

TEST(CatmullClark, SharpCornersAndCornersOfTheBoundaryStay) {
  const auto shape = make("catmullclark", "\"integer levels\" 2 " + CUBE +
                                              "\"integer sharpcorners\" [7] \"integer holes\" [0]");
  const auto near = [](const Vec3f& a, const Vec3f& b) { return glm::length(a - b) < 1e-6f; };
  EXPECT_TRUE(near(shape->triangleMesh()->positions()[7], Vec3f(1)));
  EXPECT_NEAR(glm::length(shape->triangleMesh()->positions()[0]), std::sqrt(.75), 1e-6); // beside the hole
  EXPECT_EQ(shape->primitiveCount(), 5u * 16 * 2);
  EXPECT_THROW(shape->asSolid(), Error);
  const std::string square = "\"point3 P\" [0 0 0  1 0 0  1 1 0  0 1 0] \"integer indices\" [0 1 2 3] ";
  EXPECT_TRUE(
      near(make("catmullclark", square + "\"string boundary\" \"corner\"")->triangleMesh()->positions()[2],
           Vec3f(1, 1, 0)));
  EXPECT_TRUE(near(make("catmullclark", square)->triangleMesh()->positions()[2], Vec3f(5 / 6.f, 5 / 6.f, 0)));
}

TEST(BezierPatch, LiesOnTheSurface) {
  // x = 3u, y = 3v, z a product of polynomials that Bernstein's stand for exactly: 3u(1-u) times 3v(1-v).
  std::string points;
  for (const double b : {0.0, 1.0, 1.0, 0.0})
    for (int i = 0; i < 4; ++i) {
      const double a = i == 1 || i == 2 ? 1 : 0;
      const int row = static_cast<int>(std::count(points.begin(), points.end(), ';'));
      points +=
          std::to_string(i) + " " + std::to_string(row) + " " + std::to_string(a * b) + (i == 3 ? " ;" : " ");
    }
  std::replace(points.begin(), points.end(), ';', ' ');
  Diagnostics diagnostics;
  const auto shape = plugIns().shapes.make(
      parseParameterText("bezierpatch", "\"integer steps\" 64 \"point3 P\" [" + points + "]"), {},
      diagnostics);
  ASSERT_TRUE(shape) << diagnostics.format();
  const TriangleMesh& mesh = *shape->triangleMesh();
  ASSERT_EQ(mesh.positions().size(), 65u * 65);
  for (uint32_t t = 0; t < mesh.primitiveCount(); t += 7) {
    const SurfacePoint p = mesh.surfaceAt(t, HitParameters(Vec2f(0)));
    const double u = double(p.position.x) / 3, v = double(p.position.y) / 3;
    EXPECT_NEAR(p.position.z, 9 * u * (1 - u) * v * (1 - v), 1e-6);
    const Vec3d slope(9 * (1 - 2 * u) * v * (1 - v) / 3, 9 * u * (1 - u) * (1 - 2 * v) / 3, 0);
    const Vec3d normal = glm::normalize(Vec3d(-slope.x, -slope.y, 1));
    EXPECT_GT(glm::dot(Vec3d(p.shadingNormal), normal), 1 - 1e-6); // of floats
  }
}

TEST(BezierPatch, HasNormalsWhereASideIsAPoint) {
  // An eighth of something round, with its pole in the first row.
  Diagnostics diagnostics;
  const auto shape = plugIns().shapes.make(
      parseParameterText("bezierpatch",
                         "\"integer steps\" 8 \"point3 P\" [0 0 1 0 0 1 0 0 1 0 0 1  .55 0 1 .55 .3 1 .3 .55 "
                         "1 0 .55 1  1 0 .55 1 .55 .55 .55 1 .55 0 1 .55  1 0 0 1 .55 0 .55 1 0 0 1 0]"),
      {}, diagnostics);
  ASSERT_TRUE(shape) << diagnostics.format();
  const SurfacePoint pole = shape->surfaceAt(0, HitParameters(Vec2f(0)));
  EXPECT_NEAR(std::abs(pole.shadingNormal.z), 1, 1e-3);
  Diagnostics complaints;
  EXPECT_FALSE(
      plugIns().shapes.make(parseParameterText("bezierpatch", "\"point3 P\" [0 0 0 1 1 1]"), {}, complaints));
  EXPECT_NE(complaints.format().find("2 points do not form patches"), std::string::npos);
}
