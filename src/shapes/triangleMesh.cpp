/** @file
 * Triangle meshes written in the scene file itself.
 */
#include "recurse/model/mesh/displacement.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** An array with one element for each position, or an error at its parameter. */
template <class T>
std::vector<T> perVertex(const Parameters& p, const char* name, std::vector<T> values, size_t vertexCount) {
  if (values.size() != vertexCount)
    p.fail(name, std::to_string(values.size()) + " given for " + std::to_string(vertexCount) + " positions",
           "one for each element of \"P\"");
  return values;
}

std::unique_ptr<Shape> makeTriangleMesh(const Parameters& p, const ShapeContext& context) {
  MeshData mesh;
  mesh.positions = p.vector3s("P");
  const size_t count = mesh.positions.size();
  if (!p.has("indices")) {
    if (count != 3)
      p.fail("P", "there are " + std::to_string(count) + " positions and no \"indices\"",
             "\"indices\" with three numbers for each triangle, or exactly three positions");
    mesh.triangles = {{0, 1, 2}};
  } else {
    const std::vector<int> indices = p.integers("indices");
    if (indices.size() % 3 != 0)
      p.fail("indices", std::to_string(indices.size()) + " indices do not form triangles",
             "three for each triangle");
    for (size_t i = 0; i < indices.size(); ++i)
      if (indices[i] < 0 || size_t(indices[i]) >= count)
        p.fail("indices",
               "index " + std::to_string(indices[i]) + " (the " + std::to_string(i + 1) +
                   ". number) is not the index of a position",
               "0 to " + std::to_string(int64_t(count) - 1));
    mesh.triangles.reserve(indices.size() / 3);
    for (size_t i = 0; i < indices.size(); i += 3)
      mesh.triangles.emplace_back(indices[i], indices[i + 1], indices[i + 2]);
  }
  if (p.has("N")) mesh.normals = perVertex(p, "N", p.vector3s("N"), count);
  if (p.has("S")) mesh.tangents = perVertex(p, "S", p.vector3s("S"), count);
  if (p.has("uv")) mesh.uvs = perVertex(p, "uv", p.vector2s("uv"), count);
  try {
    return makeDisplacedMesh(std::move(mesh), p, context);
  } catch (const SceneError&) {
    throw;
  } catch (const Error& e) {
    p.fail("P", e.what());
  }
}

} // namespace

void registerTriangleMesh(PlugIns& plugIns) {
  plugIns.shapes.add(
      {{.name = "trianglemesh",
        .summary = "Triangles with shared vertices.",
        .parameters = withDisplacement(
            {arrayParameter(ParameterType::INTEGER, "indices", 0, "",
                            "vertex indices, three for each triangle; not needed with three positions")
                 .range(0, std::numeric_limits<int>::max()),
             arrayParameter(ParameterType::POINT3, "P", 0, "", "positions of the vertices").require(),
             arrayParameter(ParameterType::NORMAL, "N", 0, "",
                            "normals at the vertices, interpolated for shading"),
             arrayParameter(ParameterType::VECTOR3, "S", 0, "", "tangents at the vertices"),
             arrayParameter(ParameterType::POINT2, "uv", 0, "", "texture coordinates at the vertices"),
             ignoredParameter(ParameterType::INTEGER, "faceIndices", "face numbers for Ptex textures")}),
        .examples =
            {"\"point3 P\" [0 0 0 1 0 0 0 1 .5]",
             "\"integer indices\" [0 1 2 2 3 0] \"point3 P\" [-1 0 -1  -1 0 1  1 0 1  1 0 -1]",
             "\"integer indices\" [0 2 1 0 1 3 1 2 3 2 0 3] \"point3 P\" [1 1 1 -1 -1 1 -1 1 -1 1 -1 -1] "
             "\"normal N\" [1 1 1 -1 -1 1 -1 1 -1 1 -1 -1] \"point2 uv\" [0 0 1 0 0 1 1 1]"}},
       makeTriangleMesh});
}

} // namespace recurse
