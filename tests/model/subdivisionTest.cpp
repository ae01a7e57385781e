/** @file
 * Subdivision surfaces against known limits.
 */
#include <map>
#include <random>
#include <set>

#include "model/shapeTesting.h"
#include "shapes/subdivision/dooSabin.h"
#include "shapes/subdivision/sqrt3.h"

using namespace recurse;
using namespace recurse::testing;

TEST(LoopSubdivision, LimitOfAnOctahedronIsRound) {
  // Symmetry keeps a vertex on its axis, at the distance given by the limit mask; a plane stays a plane.
  const char* octahedron = "\"point3 P\" [1 0 0 -1 0 0 0 1 0 0 -1 0 0 0 1 0 0 -1] \"integer indices\" "
                           "[0 2 4 2 1 4 1 3 4 3 0 4 2 0 5 1 2 5 3 1 5 0 3 5]";
  for (const int levels : {1, 3}) {
    const auto shape = make("loopsubdiv", "\"integer levels\" " + std::to_string(levels) + " " + octahedron);
    const TriangleMesh& mesh = *shape->triangleMesh();
    EXPECT_EQ(mesh.indices().size(), 8u << (2 * levels));
    // Limit mask of valence 4: the mean of the neighbours is 0, so that the factor is 1 - n w, w = 1 / (n + 3
    // / (8 β)), β = 3/32.
    for (int k = 0; k < 6; ++k) EXPECT_NEAR(glm::length(mesh.positions()[k]), 0.5, 1e-6) << levels;
    EXPECT_NO_THROW(shape->asSolid());
    EXPECT_TRUE(shape->asSolid()->normalsPointIn()); // as in pbrt-v4
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
  // Symmetry keeps corners on the diagonals, with normals along them.
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
    if (p.x < 1 || p.x >= 4 || p.y < 1 || p.y >= 4) continue; // the boundary has separate rules
    const auto weights = [](double t) {
      return std::array<double, 4>{(1 - t) * (1 - t) * (1 - t) / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
                                   (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6};
    };
    // Vertices are at rational coordinates up to rounding.
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
  // Faces are flat up to the edges, and the solid stays closed.
  for (uint32_t i = 0; i < shape->primitiveCount(); ++i) {
    const SurfacePoint p = shape->surfaceAt(i, HitParameters(Vec2f(.01f)));
    EXPECT_NEAR(glm::dot(p.shadingNormal, p.geometricNormal), 1, 1e-6);
  }
  EXPECT_NO_THROW(shape->asSolid());
}

TEST(CatmullClark, ACreaseIsASplineOfItsPositions) {
  // The loop around the top is a separate uniform cubic B-spline: (p + 4 p + p) / 6 at the positions.
  const auto shape =
      make("catmullclark", "\"integer levels\" 3 " + CUBE + "\"integer creases\" [4 5 5 7 7 6 6 4]");
  for (const int k : {4, 5, 6, 7}) {
    const Vec3f p = shape->triangleMesh()->positions()[size_t(k)];
    EXPECT_NEAR(std::abs(p.x), 2 / 3.0, 1e-6);
    EXPECT_NEAR(std::abs(p.y), 2 / 3.0, 1e-6);
    EXPECT_NEAR(p.z, 1, 1e-6);
  }
  // The lid inside of the crease is flat, with separate normals.
  for (uint32_t i = 0; i < shape->primitiveCount(); ++i) {
    const SurfacePoint p = shape->surfaceAt(i, HitParameters(Vec2f(1 / 3.0f)));
    if (p.geometricNormal.z > .999f) {
      EXPECT_NEAR(p.position.z, 1, 1e-6);
      EXPECT_NEAR(p.shadingNormal.z, 1, 1e-6);
    }
  }
}

TEST(CatmullClark, SharpnessOneIsOneSharpStep) {
  // Across the crease at x = 3: after one sharp step the neighbours are the midpoints of the edges, and the
  // limit is (left + 4 h + right) / 6 of these; without the crease, of the heights themselves; with an
  // infinitely sharp crease, h.
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
  // x = 3u, y = 3v, z = 3u(1-u) · 3v(1-v), a product of polynomials that the Bernstein basis represents
  // exactly.
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
    EXPECT_GT(glm::dot(Vec3d(p.shadingNormal), normal), 1 - 1e-6); // tolerance of floats
  }
}

TEST(BezierPatch, HasNormalsWhereASideIsAPoint) {
  // An octant of a round shape, with its pole in the first row.
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

namespace {

/** Numbers of corners, edges and faces of a polygon mesh. */
struct Counts {
  size_t vertices = 0, edges = 0, faces = 0, boundary = 0;
  std::map<size_t, size_t> facesOf; ///< number of faces by number of corners
  int64_t euler() const { return int64_t(vertices) - int64_t(edges) + int64_t(faces); }
};

Counts countsOf(const PolygonMesh& mesh) {
  Counts c;
  std::set<std::pair<uint32_t, uint32_t>> directed;
  std::set<uint32_t> used;
  for (size_t f = 0; f < mesh.faceCount(); ++f) {
    const uint32_t first = mesh.starts[f], n = mesh.starts[f + 1] - first;
    ++c.facesOf[n];
    for (uint32_t k = 0; k < n; ++k) {
      used.insert(mesh.vertices[first + k]);
      EXPECT_TRUE(directed.emplace(mesh.vertices[first + k], mesh.vertices[first + (k + 1) % n]).second);
    }
  }
  for (const auto& [a, b] : directed) {
    const bool isBoundary = !directed.contains({b, a});
    c.boundary += isBoundary;
    c.edges += isBoundary || a < b;
  }
  c.vertices = used.size();
  c.faces = mesh.faceCount();
  return c;
}

PolygonMesh polygons(std::vector<Vec3d> positions, const std::vector<std::vector<uint32_t>>& faces) {
  PolygonMesh mesh;
  mesh.positions = std::move(positions);
  mesh.starts = {0};
  for (const auto& f : faces) {
    mesh.vertices.insert(mesh.vertices.end(), f.begin(), f.end());
    mesh.starts.push_back(uint32_t(mesh.vertices.size()));
  }
  return mesh;
}

PolygonMesh asPolygons(const MeshData& mesh) {
  std::vector<std::vector<uint32_t>> faces;
  for (const glm::uvec3& t : mesh.triangles) faces.push_back({t.x, t.y, t.z});
  return polygons(mesh.positions, faces);
}

PolygonMesh cubeOfPolygons() {
  std::vector<Vec3d> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  return polygons(corners,
                  {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}});
}

/** A grid in the plane z = x / 2 of n by n squares, or twice the number of triangles. */
PolygonMesh grid(uint32_t n) {
  std::vector<Vec3d> positions;
  std::vector<std::vector<uint32_t>> faces;
  for (uint32_t y = 0; y <= n; ++y)
    for (uint32_t x = 0; x <= n; ++x) positions.emplace_back(x, y, 0.5 * x);
  for (uint32_t y = 0; y < n; ++y)
    for (uint32_t x = 0; x < n; ++x) {
      const uint32_t a = y * (n + 1) + x;
      faces.push_back({a, a + 1, a + n + 2, a + n + 1});
    }
  return polygons(positions, faces);
}
MeshData triangles(const PolygonMesh& mesh) {
  MeshData out;
  out.positions = mesh.positions;
  for (size_t f = 0; f < mesh.faceCount(); ++f)
    for (uint32_t c = mesh.starts[f] + 2; c < mesh.starts[f + 1]; ++c)
      out.triangles.emplace_back(mesh.vertices[mesh.starts[f]], mesh.vertices[c - 1], mesh.vertices[c]);
  return out;
}

MeshData tetrahedron() {
  MeshData mesh;
  mesh.positions = {{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  return mesh;
}

double volumeOf(const MeshData& mesh) {
  double sum = 0;
  for (const glm::uvec3& t : mesh.triangles)
    sum += glm::dot(mesh.positions[t.x], glm::cross(mesh.positions[t.y], mesh.positions[t.z])) / 6;
  return sum;
}

/** Expects consistent orientation of faces and normals, and edges with two triangles or at the boundary. */
void expectSurface(const MeshData& mesh, int64_t euler, double side) {
  EXPECT_EQ(countsOf(asPolygons(mesh)).euler(), euler);
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  for (const glm::uvec3& t : mesh.triangles) {
    const Vec3d& a = mesh.positions[t.x];
    const Vec3d across = glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
    for (int k = 0; k < 3; ++k) {
      EXPECT_GT(side * glm::dot(glm::normalize(mesh.normals[t[k]]), across), 0);
    }
  }
}

} // namespace

TEST(DooSabin, FirstStepsOfACube) {
  const PolygonMesh first = dooSabinStep(cubeOfPolygons());
  const Counts one = countsOf(first);
  EXPECT_EQ(one.vertices, 24u);
  EXPECT_EQ(one.faces, 26u);
  EXPECT_EQ(one.edges, 48u);
  EXPECT_EQ(one.facesOf, (std::map<size_t, size_t>{{3, 8}, {4, 18}}));
  // A corner of a square: weights 9/16, 3/16, 3/16, 1/16, so that a face of the cube shrinks to half.
  for (const Vec3d& p : first.positions) {
    std::array<double, 3> x{std::abs(p.x), std::abs(p.y), std::abs(p.z)};
    std::sort(x.begin(), x.end());
    EXPECT_NEAR(x[0], .5, 1e-15);
    EXPECT_NEAR(x[1], .5, 1e-15);
    EXPECT_NEAR(x[2], 1, 1e-15);
  }
  PolygonMesh mesh = first;
  for (int i = 0; i < 3; ++i) {
    mesh = dooSabinStep(mesh);
    const Counts c = countsOf(mesh);
    EXPECT_EQ(c.vertices, size_t(24) << (2 * (i + 1)));
    EXPECT_EQ(c.euler(), 2);
    EXPECT_EQ(c.boundary, 0u);
    EXPECT_EQ(c.facesOf.at(3), 8u);
  }
}

TEST(DooSabin, LimitOfACubeIsSymmetricAndHasItsVolume) {
  std::vector<double> volumes;
  for (const int levels : {1, 3, 5}) {
    const MeshData mesh = dooSabinSurface(cubeOfPolygons(), levels);
    expectSurface(mesh, 2, 1);
    volumes.push_back(volumeOf(mesh));
    double farthest = 0;
    for (size_t i = 0; i < mesh.positions.size(); ++i) {
      const Vec3d p = mesh.positions[i];
      farthest = std::max({farthest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
      // Mirrored and rotated points exist, too.
      for (const Vec3d& image : {Vec3d(-p.x, p.y, p.z), Vec3d(p.y, p.z, p.x), Vec3d(p.y, p.x, p.z)}) {
        if (i % 7 > 0) continue;
        double nearest = 1;
        for (const Vec3d& q : mesh.positions) nearest = std::min(nearest, glm::length(q - image));
        EXPECT_LT(nearest, 1e-12);
      }
    }
    EXPECT_NEAR(farthest, 1, 1e-12); // the centres of the faces do not move
  }
  // The error of chords decreases with the square of their length.
  const double last = volumes[2] + (volumes[2] - volumes[1]) / 15;
  EXPECT_NEAR(volumes[1], last, .02 * last);
  EXPECT_NEAR((last - volumes[0]) / (last - volumes[1]), 16, 4);
  EXPECT_GT(last, 4 / 3.0 * PI_D); // volume of the ball inside the cube
  EXPECT_LT(last, 8);
}

TEST(DooSabin, LimitDoesNotDependOnTheLevels) {
  // Centres of faces do not move, and keep their normals.
  const PolygonMesh cage = cubeOfPolygons();
  const MeshData coarse = dooSabinSurface(cage, 2), fine = dooSabinSurface(cage, 3);
  for (size_t i = 0; i < coarse.positions.size(); ++i) { // faces of faces come first after a step
    EXPECT_LT(glm::length(coarse.positions[i] - fine.positions[i]), 1e-14);
    EXPECT_GT(glm::dot(glm::normalize(coarse.normals[i]), glm::normalize(fine.normals[i])), 1 - 1e-12);
  }
}

TEST(DooSabin, GridsStayFlatUpToTheirBoundary) {
  PolygonMesh mesh = grid(3);
  for (int i = 0; i < 3; ++i) {
    mesh = dooSabinStep(mesh);
    const Counts c = countsOf(mesh);
    EXPECT_EQ(c.euler(), 1);
    EXPECT_EQ(c.boundary, size_t(12) << (i + 1));
  }
  for (const int levels : {1, 2, 4}) {
    const MeshData surface = dooSabinSurface(grid(3), levels);
    expectSurface(surface, 1, 1);
    Vec3d least(9), most(-9);
    for (size_t i = 0; i < surface.positions.size(); ++i) {
      const Vec3d& p = surface.positions[i];
      EXPECT_NEAR(p.z, p.x / 2, 1e-14);
      EXPECT_GT(glm::dot(glm::normalize(surface.normals[i]), glm::normalize(Vec3d(-.5, 0, 1))), 1 - 1e-12);
      least = glm::min(least, p);
      most = glm::max(most, p);
    }
    EXPECT_NEAR(least.x, 0, 1e-14);
    EXPECT_NEAR(most.y, 3, 1e-14);
  }
}

TEST(DooSabin, StaysInTheConvexHull) {
  // A surface inside of a ball, made of concave and twisted faces with a boundary.
  std::mt19937 random(5);
  PolygonMesh mesh = grid(4);
  for (Vec3d& p : mesh.positions)
    p = glm::normalize(Vec3d(random() % 200, random() % 200, random() % 200) - 99.5) * 2.0;
  for (const int levels : {1, 2, 3})
    for (const Vec3d& p : dooSabinSurface(mesh, levels).positions) EXPECT_LE(glm::length(p), 2 + 1e-12);
}

TEST(DooSabin, VerticesOfTwoFacesLeaveNoHole) {
  // Two triangles back to back, and two cubes with a common corner.
  PolygonMesh pillow = polygons({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {2, 1, 0}});
  for (int i = 0; i < 3; ++i) {
    pillow = dooSabinStep(pillow);
    EXPECT_EQ(countsOf(pillow).euler(), 2);
    EXPECT_EQ(countsOf(pillow).boundary, 0u);
  }
  const PolygonMesh cube = cubeOfPolygons();
  std::vector<Vec3d> positions = cube.positions;
  for (size_t i = 1; i < 8; ++i)
    positions.push_back(-cube.positions[i] - 2.0); // mirrored at the first corner
  std::vector<std::vector<uint32_t>> faces;
  for (size_t f = 0; f < 6; ++f) {
    faces.emplace_back(cube.vertices.begin() + long(4 * f), cube.vertices.begin() + long(4 * f + 4));
    std::vector<uint32_t> image(faces.back().rbegin(), faces.back().rend());
    for (uint32_t& v : image) v += v > 0 ? 7 : 0;
    faces.push_back(image);
  }
  const PolygonMesh cubes = polygons(positions, faces);
  const PolygonMesh apart = dooSabinStep(cubes);
  EXPECT_EQ(countsOf(apart).euler(), 4); // two surfaces
  EXPECT_EQ(countsOf(apart).boundary, 0u);
}

TEST(Sqrt3, FirstStepsOfATetrahedron) {
  MeshData mesh = tetrahedron();
  sqrt3Step(mesh, false);
  EXPECT_EQ(mesh.positions.size(), 8u);
  EXPECT_EQ(mesh.triangles.size(), 12u);
  // A vertex of valence 3 has the weight 4/9, and the mean of its neighbours, which is -p/3, the weight 5/9.
  EXPECT_LT(glm::length(mesh.positions[0] - Vec3d(4 / 9.0 - 5 / 27.0)), 1e-15);
  EXPECT_LT(glm::length(mesh.positions[4] - Vec3d(-1, 1, 1) / 3.0), 1e-15);
  for (int i = 1; i < 5; ++i) {
    sqrt3Step(mesh, i % 2 == 1);
    EXPECT_EQ(mesh.triangles.size(), size_t(4 * std::pow(3, i + 1)));
    const Counts c = countsOf(asPolygons(mesh));
    EXPECT_EQ(c.euler(), 2);
    EXPECT_EQ(c.boundary, 0u);
  }
}

TEST(Sqrt3, LimitDoesNotDependOnTheLevels) {
  const MeshData coarse = sqrt3Surface(tetrahedron(), 2), fine = sqrt3Surface(tetrahedron(), 5);
  for (size_t i = 0; i < coarse.positions.size(); ++i) {
    EXPECT_LT(glm::length(coarse.positions[i] - fine.positions[i]), 1e-14);
    EXPECT_GT(glm::dot(glm::normalize(coarse.normals[i]), glm::normalize(fine.normals[i])), 1 - 1e-12);
  }
  // The error of the volume is a third for three times the number of triangles.
  const auto volume = [](int levels) { return volumeOf(sqrt3Surface(tetrahedron(), levels)); };
  const double last = volume(8) + (volume(8) - volume(6)) / 8;
  EXPECT_NEAR((last - volume(4)) / (last - volume(6)), 9, 1.5);
  expectSurface(fine, 2, -1);
}

TEST(Sqrt3, TwoStepsDivideTheBoundaryInThree) {
  MeshData mesh = triangles(grid(3));
  const Counts before = countsOf(asPolygons(mesh));
  sqrt3Step(mesh, false);
  EXPECT_EQ(countsOf(asPolygons(mesh)).boundary, before.boundary);
  sqrt3Step(mesh, true);
  const Counts after = countsOf(asPolygons(mesh));
  EXPECT_EQ(after.boundary, 3 * before.boundary);
  EXPECT_EQ(after.faces, 9 * before.faces);
  EXPECT_EQ(after.euler(), 1);
  for (const int levels : {1, 2, 3, 4}) {
    const MeshData surface = sqrt3Surface(triangles(grid(3)), levels);
    expectSurface(surface, 1, -1);
    for (size_t i = 0; i < surface.positions.size(); ++i) {
      EXPECT_NEAR(surface.positions[i].z, surface.positions[i].x / 2, 1e-14);
      EXPECT_GT(-glm::dot(glm::normalize(surface.normals[i]), glm::normalize(Vec3d(-.5, 0, 1))), 1 - 1e-12);
    }
  }
}

TEST(Sqrt3, ABoundaryIsACubicSpline) {
  // A fan of triangles around a point: its rim is the uniform B-spline of the rim's positions.
  MeshData fan;
  constexpr uint32_t SIDES = 5;
  fan.positions = {{0, 0, 1}};
  for (uint32_t i = 0; i < SIDES; ++i) {
    fan.positions.emplace_back(std::cos(2 * PI_D * i / SIDES), std::sin(2 * PI_D * i / SIDES), .3 * (i % 2));
    fan.triangles.emplace_back(0, 1 + i, 1 + (i + 1) % SIDES);
  }
  const auto spline = [&](double t) {
    const auto i = uint32_t(t);
    const double u = t - i, v = 1 - u;
    const auto p = [&](uint32_t k) { return fan.positions[1 + (i + k + SIDES - 1) % SIDES]; };
    return (p(0) * (v * v * v) + p(1) * (3 * u * u * u - 6 * u * u + 4) +
            p(2) * (3 * v * v * v - 6 * v * v + 4) + p(3) * (u * u * u)) /
           6.0;
  };
  const MeshData surface = sqrt3Surface(fan, 4);
  const PolygonMesh mesh = asPolygons(surface);
  std::set<std::pair<uint32_t, uint32_t>> directed;
  for (const glm::uvec3& t : surface.triangles)
    for (int k = 0; k < 3; ++k) directed.emplace(t[k], t[(k + 1) % 3]);
  size_t onRim = 0;
  for (const auto& [a, b] : directed) {
    if (directed.contains({b, a})) continue;
    ++onRim;
    double nearest = 1;
    for (uint32_t k = 0; k < 9 * SIDES; ++k)
      nearest = std::min(nearest, glm::length(spline(k / 9.0) - surface.positions[a]));
    EXPECT_LT(nearest, 1e-12);
  }
  EXPECT_EQ(onRim, 9 * SIDES);
}

TEST(SubdivisionSchemes, AreChosenByAParameter) {
  const auto made = [](const std::string& name, const std::string& parameters) {
    Diagnostics diagnostics;
    auto shape = plugIns().shapes.make(parseParameterText(name, parameters), {}, diagnostics);
    return std::pair(std::move(shape), diagnostics.format());
  };
  const std::string cube =
      "\"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 0  0 0 1  1 0 1  0 1 1  1 1 1] \"integer indices\" "
      "[0 2 3 1  4 5 7 6  0 1 5 4  2 6 7 3  0 4 6 2  1 3 7 5] \"string scheme\" \"doosabin\" ";
  const auto cubeSurface = made("catmullclark", cube + "\"integer levels\" 1");
  ASSERT_TRUE(cubeSurface.first) << cubeSurface.second;
  EXPECT_EQ(cubeSurface.first->triangleMesh()->positions().size(), 26u);
  EXPECT_EQ(cubeSurface.first->primitiveCount(), 48u);
  const std::string tetrahedron = "\"point3 P\" [1 1 1  -1 -1 1  -1 1 -1  1 -1 -1] \"integer indices\" "
                                  "[0 2 1  0 1 3  1 2 3  2 0 3] \"string scheme\" \"sqrt3\" ";
  const auto rounded = made("loopsubdiv", tetrahedron + "\"integer levels\" 1");
  ASSERT_TRUE(rounded.first) << rounded.second;
  EXPECT_EQ(rounded.first->triangleMesh()->positions().size(), 8u);
  EXPECT_EQ(rounded.first->primitiveCount(), 12u);
  const auto refused = [&](const std::string& name, const std::string& parameters, const char* part) {
    const auto [shape, said] = made(name, parameters);
    EXPECT_FALSE(shape);
    EXPECT_NE(said.find(part), std::string::npos) << said;
  };
  refused("catmullclark", cube + "\"integer creases\" [0 1]", "only Catmull-Clark surfaces have creases");
  refused("catmullclark", cube + "\"integer sharpcorners\" [0]",
          "only Catmull-Clark surfaces have sharp corners");
  refused("catmullclark", cube + "\"integer holes\" [0]", "only Catmull-Clark surfaces have holes");
  refused("catmullclark", cube + "\"string boundary\" \"corner\"",
          "only Catmull-Clark surfaces have sharp corners");
  refused("catmullclark", cube + "\"integer levels\" 12 \"string scheme\" \"cubic\"", "doosabin");
  refused("loopsubdiv", tetrahedron + "\"string scheme\" \"butterfly\"", "sqrt3");
  refused("loopsubdiv",
          "\"integer levels\" 13 \"string scheme\" \"sqrt3\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer "
          "indices\" [0 1 2]",
          "levels");
  refused(
      "loopsubdiv",
      "\"string scheme\" \"sqrt3\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"integer indices\" [0 1 2 0 1 3]",
      "opposite orientations");
  refused("catmullclark",
          "\"string scheme\" \"doosabin\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0] \"integer corners\" [3 3] "
          "\"integer indices\" [0 1 2 0 1 3]",
          "opposite orientations");
}
