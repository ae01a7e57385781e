/** @file
 * Subdivision surfaces of Catmull and Clark, "Recursively Generated B-Spline Surfaces on Arbitrary
 * Topological Meshes" (1978), with creases as in DeRose, Kass, Truong, "Subdivision Surfaces in Character
 * Animation" (1998), by OpenSubdiv: faces are split level by level, then moved to the limit surface. The
 * scheme of dooSabin.h takes the same mesh, without creases, corners or holes.
 */
#include <algorithm>
#include <numeric>
#include <set>

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include "recurse/core/threads/interrupt.h"
#include "recurse/core/threads/resources.h"
#include "recurse/model/mesh/displacement.h"
#include "recurse/model/scene/plugIns.h"
#include "shapes/subdivision/dooSabin.h"

namespace recurse {

namespace {

namespace far = OpenSubdiv::Far;

/** Control mesh as the file describes it; sharpness is at most 10, which means infinitely sharp. */
struct ControlMesh {
  std::vector<Vec3d> positions;
  std::vector<Vec2d> uvs; ///< one for each position, or none
  std::vector<int> corners, indices;
  std::vector<int> creases; ///< ends of edges, two by two
  std::vector<float> creaseSharpness;
  std::vector<int> sharpCorners;
  std::vector<float> cornerSharpness;
  std::vector<int> holes; ///< faces
  bool cornersOfBoundary = false;
};

/** Value in the form that OpenSubdiv accumulates. */
template <class V> struct Weighted {
  V value{0};
  void Clear() { value = V(0); }
  void AddWithWeight(const Weighted& other, double weight) { value += weight * other.value; }
};

using Refiner = std::unique_ptr<far::TopologyRefiner>;

Refiner refined(const ControlMesh& mesh, int levels) {
  far::TopologyDescriptor d;
  d.numVertices = static_cast<int>(mesh.positions.size());
  d.numFaces = static_cast<int>(mesh.corners.size());
  d.numVertsPerFace = mesh.corners.data();
  d.vertIndicesPerFace = mesh.indices.data();
  d.numCreases = static_cast<int>(mesh.creaseSharpness.size());
  d.creaseVertexIndexPairs = mesh.creases.data();
  d.creaseWeights = mesh.creaseSharpness.data();
  d.numCorners = static_cast<int>(mesh.cornerSharpness.size());
  d.cornerVertexIndices = mesh.sharpCorners.data();
  d.cornerWeights = mesh.cornerSharpness.data();
  d.numHoles = static_cast<int>(mesh.holes.size());
  d.holeIndices = mesh.holes.data();
  OpenSubdiv::Sdc::Options options;
  options.SetVtxBoundaryInterpolation(mesh.cornersOfBoundary
                                          ? OpenSubdiv::Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER
                                          : OpenSubdiv::Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
  using Factory = far::TopologyRefinerFactory<far::TopologyDescriptor>;
  Refiner refiner(Factory::Create(d, Factory::Options(OpenSubdiv::Sdc::SCHEME_CATMARK, options)));
  if (!refiner) throw Error("the faces do not form a surface");
  far::TopologyRefiner::UniformOptions uniform(levels);
  uniform.fullTopologyInLastLevel = true;
  refiner->RefineUniform(uniform);
  return refiner;
}

/** Values at the vertices of the last level. */
template <class V>
std::vector<Weighted<V>> interpolated(const far::TopologyRefiner& refiner, const std::vector<V>& values) {
  std::vector<Weighted<V>> from(values.size()), to;
  for (size_t i = 0; i < values.size(); ++i) from[i].value = values[i];
  const far::PrimvarRefinerReal<double> primvars(refiner);
  for (int level = 1; level <= refiner.GetMaxLevel(); ++level) {
    to.assign(static_cast<size_t>(refiner.GetLevel(level).GetNumVertices()), {});
    primvars.Interpolate(level, from, to);
    from.swap(to);
  }
  return from;
}

/** Numbers the sectors into which sharp edges, but not the boundary, divide the faces around a vertex. */
std::vector<int> sectors(const far::TopologyLevel& level, int v) {
  const far::ConstIndexArray faces = level.GetVertexFaces(v);
  std::vector<int> sector(static_cast<size_t>(faces.size()));
  std::iota(sector.begin(), sector.end(), 0);
  for (const int e : level.GetVertexEdges(v)) {
    if (level.GetEdgeSharpness(e) > 0) continue;
    const far::ConstIndexArray sides = level.GetEdgeFaces(e);
    if (sides.size() != 2) continue;
    const int a = sector[size_t(faces.FindIndex(sides[0]))], b = sector[size_t(faces.FindIndex(sides[1]))];
    std::replace(sector.begin(), sector.end(), std::max(a, b), std::min(a, b));
  }
  return sector;
}

/** Quadrilaterals of the last level at their limits. Vertices on creases exist once for each side. */
MeshData limitOf(const ControlMesh& mesh, int levels) {
  const Refiner refiner = refined(mesh, levels);
  const far::TopologyLevel& last = refiner->GetLevel(levels);
  const auto count = static_cast<size_t>(last.GetNumVertices());
  const far::PrimvarRefinerReal<double> primvars(*refiner);
  std::vector<Weighted<Vec3d>> limits(count), alongS(count), alongT(count);
  primvars.Limit(interpolated(*refiner, mesh.positions), limits, alongS, alongT);
  std::vector<Weighted<Vec2d>> uvs(mesh.uvs.empty() ? 0 : count);
  if (!uvs.empty()) primvars.Limit(interpolated(*refiner, mesh.uvs), uvs);

  std::vector<std::array<uint32_t, 4>> quads(static_cast<size_t>(last.GetNumFaces()));
  std::vector<Vec3d> faceNormals(quads.size());
  for (size_t f = 0; f < quads.size(); ++f) {
    const far::ConstIndexArray v = last.GetFaceVertices(static_cast<int>(f));
    for (int k = 0; k < 4; ++k) quads[f][size_t(k)] = static_cast<uint32_t>(v[k]);
    faceNormals[f] = glm::cross(limits[quads[f][2]].value - limits[quads[f][0]].value,
                                limits[quads[f][3]].value - limits[quads[f][1]].value);
  }
  MeshData out;
  const auto add = [&](size_t v, const Vec3d& normal) {
    out.positions.push_back(limits[v].value);
    out.normals.push_back(normal);
    if (!uvs.empty()) out.uvs.push_back(uvs[v].value);
  };
  for (size_t v = 0; v < count; ++v) add(v, Vec3d(0)); // refined vertices first, then the duplicates
  for (size_t v = 0; v < count; ++v) {
    const far::ConstIndexArray faces = last.GetVertexFaces(static_cast<int>(v));
    const std::vector<int> sector = sectors(last, static_cast<int>(v));
    for (int s = 0; s < faces.size(); ++s) {
      if (sector[size_t(s)] != s) continue; // each sector once, by its first face
      Vec3d sum(0);
      for (int i = 0; i < faces.size(); ++i)
        if (sector[size_t(i)] == s) sum += faceNormals[size_t(faces[i])];
      const Vec3d tangents = glm::cross(alongS[v].value, alongT[v].value);
      const bool isWhole = std::count(sector.begin(), sector.end(), sector[0]) == faces.size();
      const Vec3d normal = !isWhole || !(glm::length(tangents) > 0) ? sum
                           : glm::dot(tangents, sum) < 0            ? -tangents
                                                                    : tangents;
      if (s == 0) {
        out.normals[v] = normal;
        continue;
      }
      for (int i = 0; i < faces.size(); ++i)
        if (sector[size_t(i)] == s)
          std::replace(quads[size_t(faces[i])].begin(), quads[size_t(faces[i])].end(), uint32_t(v),
                       uint32_t(out.positions.size()));
      add(v, normal);
    }
  }
  for (size_t f = 0; f < quads.size(); ++f) {
    if (last.IsFaceHole(static_cast<int>(f))) continue;
    const auto& q = quads[f];
    out.triangles.emplace_back(q[0], q[1], q[2]);
    out.triangles.emplace_back(q[0], q[2], q[3]);
  }
  return out;
}

/** Directed edges of all faces. Throws Error where faces do not agree on which side is the outside. */
std::set<std::pair<int, int>> edgesOf(const ControlMesh& mesh) {
  std::set<std::pair<int, int>> directed;
  size_t first = 0;
  for (const int n : mesh.corners) {
    for (int k = 0; k < n; ++k) {
      const int a = mesh.indices[first + size_t(k)], b = mesh.indices[first + size_t((k + 1) % n)];
      if (!directed.emplace(a, b).second)
        throw Error("the edge from position " + std::to_string(a) + " to " + std::to_string(b) +
                    " belongs to two faces with opposite orientations, or to three faces");
    }
    first += size_t(n);
  }
  return directed;
}

/** Sharpness parameter: one number for all, or one for each of `count` things. */
std::vector<float> sharpness(const Parameters& p, const std::string& name, size_t count, const char* things) {
  std::vector<double> given = p.reals(name);
  if (given.size() == 1) given.assign(count, given[0]);
  if (given.size() != count)
    p.fail(name,
           std::to_string(given.size()) + " given for " + std::to_string(count) + " " + std::string(things),
           "one for all, or one for each");
  return {given.begin(), given.end()};
}

/** Indices of things of which there are `count`. */
std::vector<int> numbersOf(const Parameters& p, const std::string& name, size_t count, const char* things) {
  const std::vector<int> numbers = p.has(name) ? p.integers(name) : std::vector<int>();
  for (const int i : numbers)
    if (i < 0 || size_t(i) >= count)
      p.fail(name, "there is no " + std::string(things) + " " + std::to_string(i),
             "0 to " + std::to_string(int64_t(count) - 1));
  return numbers;
}

void readSharpness(const Parameters& p, ControlMesh& mesh) {
  const size_t positions = mesh.positions.size();
  mesh.creases = numbersOf(p, "creases", positions, "position");
  if (mesh.creases.size() % 2 != 0)
    p.fail("creases", "the list has an odd number of values", "the positions at both ends of each edge");
  mesh.creaseSharpness = sharpness(p, "creasesharpness", mesh.creases.size() / 2, "creases");
  mesh.sharpCorners = numbersOf(p, "sharpcorners", positions, "position");
  mesh.cornerSharpness = sharpness(p, "cornersharpness", mesh.sharpCorners.size(), "corners");
  mesh.holes = numbersOf(p, "holes", mesh.corners.size(), "face");
  mesh.cornersOfBoundary = p.string("boundary") == "corner";
}

ControlMesh controlMesh(const Parameters& p) {
  ControlMesh mesh;
  mesh.positions = p.vector3s("P");
  if (p.has("uv")) {
    mesh.uvs = p.vector2s("uv");
    if (mesh.uvs.size() != mesh.positions.size())
      p.fail("uv",
             std::to_string(mesh.uvs.size()) + " given for " + std::to_string(mesh.positions.size()) +
                 " positions",
             "one for each element of \"P\"");
  }
  mesh.indices = numbersOf(p, "indices", mesh.positions.size(), "position");
  if (p.has("corners")) mesh.corners = p.integers("corners");
  if (mesh.corners.empty()) mesh.corners.assign(mesh.indices.size() / 4, 4);
  size_t next = 0;
  for (size_t f = 0; f < mesh.corners.size(); ++f) {
    const auto n = size_t(mesh.corners[f]);
    if (next + n > mesh.indices.size()) p.fail("corners", "they add up to more than the number of indices");
    std::vector<int> face(mesh.indices.begin() + long(next), mesh.indices.begin() + long(next + n));
    std::sort(face.begin(), face.end());
    if (std::adjacent_find(face.begin(), face.end()) != face.end())
      p.fail("indices", "face " + std::to_string(f) + " uses a vertex twice");
    next += n;
  }
  if (next != mesh.indices.size())
    p.fail("indices", std::to_string(mesh.indices.size() - next) + " indices belong to no face",
           "as many as \"corners\" add up to; four for each face without them");
  readSharpness(p, mesh);
  return mesh;
}

/** The mesh for the scheme of Doo and Sabin, which has no sharp features. */
PolygonMesh polygonMesh(const Parameters& p, const ControlMesh& mesh) {
  const std::pair<const char*, const char*> features[] = {
      {"creases", "creases"}, {"sharpcorners", "sharp corners"}, {"holes", "holes"}};
  for (const auto& [name, what] : features)
    if (p.has(name)) p.fail(name, "only Catmull-Clark surfaces have " + std::string(what));
  if (mesh.cornersOfBoundary)
    p.fail("boundary", "only Catmull-Clark surfaces have sharp corners", "\"edge\"");
  PolygonMesh out;
  out.positions = mesh.positions;
  out.uvs = mesh.uvs;
  out.vertices.assign(mesh.indices.begin(), mesh.indices.end());
  out.starts = {0};
  for (const int n : mesh.corners) out.starts.push_back(out.starts.back() + static_cast<uint32_t>(n));
  return out;
}

std::unique_ptr<Shape> makeCatmullClark(const Parameters& p, const ShapeContext& context) {
  const ControlMesh mesh = controlMesh(p);
  const int levels = p.integer("levels");
  constexpr double MOST_FACES = 1e8;
  const double faces = double(mesh.indices.size()) * std::pow(4.0, levels - 1);
  if (faces > MOST_FACES)
    p.fail("levels", "that makes more than " + std::to_string(int(MOST_FACES)) + " faces", "fewer levels");
  // Memory [bytes] and time [s] per face for topology, limits with their tangents, and normals.
  const double faceBytes = p.string("scheme") == "doosabin" ? 1000 : 500; // corners at boundaries double
  constexpr double FACE_SECONDS = 2e-6;
  const std::string subject = "subdivision by " + std::to_string(levels) + " levels";
  requireWork(subject, FACE_SECONDS * faces);
  requireMemory(subject, faceBytes * faces);
  try {
    const std::set<std::pair<int, int>> edges = edgesOf(mesh);
    for (size_t i = 0; i < mesh.creases.size(); i += 2) {
      const int a = mesh.creases[i], b = mesh.creases[i + 1];
      if (!edges.contains({a, b}) && !edges.contains({b, a}))
        p.fail("creases",
               "no face has an edge between positions " + std::to_string(a) + " and " + std::to_string(b));
    }
    if (p.string("scheme") == "doosabin")
      return makeDisplacedMesh(dooSabinSurface(polygonMesh(p, mesh), levels), p, context);
    return makeDisplacedMesh(limitOf(mesh, levels), p, context);
  } catch (const SceneError&) {
    throw;
  } catch (const Interrupted&) {
    throw;
  } catch (const Error& e) {
    p.fail("indices", e.what());
  }
}

} // namespace

void registerCatmullClark(PlugIns& plugIns) {
  plugIns.shapes.add(
      {{.name = "catmullclark",
        .summary =
            "A smooth surface from a control mesh of polygons, by subdivision of Catmull and Clark or of Doo "
            "and Sabin. On its outside the vertices of the faces are counterclockwise.",
        .parameters = withDisplacement(
            {integerParameter("levels", "3", "number of subdivision steps").range(1, 12),
             arrayParameter(ParameterType::INTEGER, "indices", 0, "",
                            "vertex indices, face by face, all with the same orientation")
                 .range(0, std::numeric_limits<int>::max())
                 .require(),
             arrayParameter(ParameterType::INTEGER, "corners", 0, "",
                            "number of corners of each face; by default 4")
                 .range(3, 1000),
             arrayParameter(ParameterType::POINT3, "P", 0, "", "positions of the control mesh").require(),
             arrayParameter(ParameterType::POINT2, "uv", 0, "",
                            "texture coordinates at the positions, smoothed like the positions"),
             arrayParameter(ParameterType::INTEGER, "creases", 0, "", "sharp edges: pairs of vertex indices"),
             arrayParameter(ParameterType::REAL, "creasesharpness", 0, "10",
                            "number of subdivision steps in which each edge is sharp; one for all or one "
                            "each. With at least \"levels\" the edge is sharp in the picture; 10 is infinite")
                 .range(0, 10),
             arrayParameter(ParameterType::INTEGER, "sharpcorners", 0, "",
                            "vertices that stay sharp points: their indices"),
             arrayParameter(ParameterType::REAL, "cornersharpness", 0, "10",
                            "sharpness of these, as for edges")
                 .range(0, 10),
             arrayParameter(
                 ParameterType::INTEGER, "holes", 0, "",
                 "faces to remove from the surface, without an effect on the others: their numbers"),
             stringParameter("boundary", "edge",
                             "boundary of the surface: a smooth curve, or with sharp corners at vertices of "
                             "a single face")
                 .oneOf({"edge", "corner"}),
             stringParameter("scheme", "catmullclark",
                             "\"catmullclark\", or \"doosabin\": closer to the control mesh, whose faces the "
                             "surface touches in their centres; without sharp features")
                 .oneOf({"catmullclark", "doosabin"})}),
        .examples =
            {"\"integer levels\" 2 \"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 0  0 0 1  1 0 1  0 1 1  1 1 1] "
             "\"integer indices\" [0 2 3 1  4 5 7 6  0 1 5 4  2 6 7 3  0 4 6 2  1 3 7 5]",
             "\"integer levels\" 1 \"point3 P\" [0 0 0  1 0 0  1 1 .3  0 1 0  2 .5 0] "
             "\"integer corners\" [4 3] \"integer indices\" [0 1 2 3  1 4 2] "
             "\"point2 uv\" [0 0  .5 0  .5 1  0 1  1 .5]",
             "\"integer levels\" 2 \"point3 P\" [0 0 0  1 0 0  0 1 0  1 1 0  0 0 1  1 0 1  0 1 1  1 1 1] "
             "\"integer indices\" [0 2 3 1  4 5 7 6  0 1 5 4  2 6 7 3  0 4 6 2  1 3 7 5] "
             "\"integer creases\" [4 5  5 7  7 6  6 4] \"float creasesharpness\" [10 10 1.5 10] "
             "\"integer sharpcorners\" [0] \"integer holes\" [0] \"string boundary\" \"corner\"",
             "\"string scheme\" \"doosabin\" \"integer levels\" 1 \"point3 P\" [0 0 0  1 0 0  1 1 .3  0 1 0  "
             "2 .5 0] "
             "\"integer corners\" [4 3] \"integer indices\" [0 1 2 3  1 4 2] "
             "\"point2 uv\" [0 0  .5 0  .5 1  0 1  1 .5]"}},
       makeCatmullClark});
}

} // namespace recurse
