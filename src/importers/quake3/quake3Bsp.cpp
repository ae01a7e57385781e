/** @file
 * Reading of Quake III maps (layouts: the game's source as released in 2005, qfiles.h). Each lump is read as
 * a separate file, so that no offset can point outside of it.
 */
#include "importers/quake3/quake3Bsp.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "recurse/core/io/byteReader.h"
#include "recurse/core/io/text.h"

namespace recurse {

namespace {

enum Lump { ENTITIES = 0, SHADERS = 1, VERTICES = 10, INDICES = 11, FACES = 13, LUMPS = 17 };
constexpr uint64_t SHADER_BYTES = 72, VERTEX_BYTES = 44, INDEX_BYTES = 4, FACE_BYTES = 104;
constexpr int32_t SURFACE_SKY = 0x4, SURFACE_NODRAW = 0x80;
enum FaceType { POLYGON = 1, PATCH = 2, MESH = 3 };
constexpr uint64_t MAX_PATCH_SIDE = 129;

class BspReader {
 public:
  BspReader(const std::string& name, std::string_view bytes) : name(name), file(name, bytes) {
    if (file.text(0, 4, "the header") != "IBSP")
      file.fail(0, "this is no Quake III map: it does not begin with IBSP");
    if (const auto version = file.at<int32_t>(4, "the version"); version != 46)
      file.fail(4, "version " + std::to_string(version) + " of such maps is unknown; only 46 is");
    file.part(0, 8 + 8 * LUMPS, "the header");
  }

  Quake3Bsp read() {
    readShaders();
    readFaces();
    readEntities();
    return std::move(map);
  }

 private:
  ByteReader lump(Lump which, const char* what) const {
    const uint64_t at = 8 + 8 * static_cast<uint64_t>(which);
    const uint64_t offset = file.count(at, "the offset of a lump", file.size());
    const uint64_t length = file.count(at + 4, "the length of a lump", file.size());
    return {name + " (" + what + ")", file.part(offset, length, what)};
  }

  static uint64_t recordsOf(const ByteReader& lump, uint64_t bytesEach) {
    if (lump.size() % bytesEach != 0)
      lump.fail(0, "its " + std::to_string(lump.size()) + " bytes are not a multiple of " +
                       std::to_string(bytesEach));
    return lump.size() / bytesEach;
  }

  void readShaders() {
    const ByteReader in = lump(SHADERS, "list of shaders");
    for (uint64_t i = 0, count = recordsOf(in, SHADER_BYTES); i < count; ++i) {
      const auto flags = in.at<int32_t>(i * SHADER_BYTES + 64, "the flags of a shader");
      map.shaders.push_back({in.text(i * SHADER_BYTES, 64, "the name of a shader"),
                             (flags & SURFACE_SKY) != 0, (flags & SURFACE_NODRAW) != 0});
    }
  }

  static Quake3Bsp::Vertex vertexAt(const ByteReader& in, uint64_t index) {
    const uint64_t at = index * VERTEX_BYTES;
    const auto number = [&](uint64_t i) { return double(in.at<float>(at + 4 * i, "a vertex")); };
    return {{number(0), number(1), number(2)}, {number(7), number(8), number(9)}, {number(3), 1 - number(4)}};
  }

  void readFaces() {
    const ByteReader in = lump(FACES, "list of faces"), vertices = lump(VERTICES, "list of vertices"),
                     indices = lump(INDICES, "list of indices");
    const uint64_t vertexCount = recordsOf(vertices, VERTEX_BYTES),
                   indexCount = recordsOf(indices, INDEX_BYTES);
    // Faces share lists of indices but no vertices; without limits, few bytes could reference the same lists
    // again and again. A surface has at most twice as many triangles as vertices.
    uint64_t verticesLeft = 4 * vertexCount, indicesLeft = 6 * verticesLeft;
    for (uint64_t i = 0, count = recordsOf(in, FACE_BYTES); i < count; ++i) {
      const uint64_t at = i * FACE_BYTES;
      const auto type = in.at<int32_t>(at + 8, "the type of a face");
      if (type != POLYGON && type != PATCH && type != MESH) continue; // billboards are no surface
      Quake3Bsp::Face face;
      if (map.shaders.empty()) in.fail(at, "the map has faces and no shaders");
      face.shader = static_cast<uint32_t>(in.count(at, "the shader of a face", map.shaders.size() - 1));
      const uint64_t firstVertex = in.count(at + 12, "the first vertex of a face", vertexCount);
      const uint64_t ownVertices = in.count(at + 16, "the number of vertices of a face",
                                            std::min(vertexCount - firstVertex, verticesLeft));
      verticesLeft -= ownVertices;
      for (uint64_t v = 0; v < ownVertices; ++v) face.vertices.push_back(vertexAt(vertices, firstVertex + v));
      if (type == PATCH) {
        face.patchWidth = static_cast<uint32_t>(in.count(at + 96, "the width of a patch", MAX_PATCH_SIDE));
        face.patchHeight = static_cast<uint32_t>(in.count(at + 100, "the height of a patch", MAX_PATCH_SIDE));
        if (face.patchWidth < 3 || face.patchHeight < 3 || face.patchWidth % 2 == 0 ||
            face.patchHeight % 2 == 0 || uint64_t(face.patchWidth) * face.patchHeight != ownVertices)
          in.fail(at + 96, "a patch of " + std::to_string(face.patchWidth) + " by " +
                               std::to_string(face.patchHeight) + " points has " +
                               std::to_string(ownVertices) + " vertices");
      } else {
        const uint64_t firstIndex = in.count(at + 20, "the first index of a face", indexCount);
        const uint64_t ownIndices = in.count(at + 24, "the number of indices of a face",
                                             std::min(indexCount - firstIndex, indicesLeft));
        indicesLeft -= ownIndices;
        if (ownIndices % 3 != 0)
          in.fail(at + 24, std::to_string(ownIndices) + " indices are not a multiple of 3");
        if (ownIndices > 0 && ownVertices == 0) in.fail(at + 16, "a face has indices and no vertices");
        const auto index = [&](uint64_t k) {
          return static_cast<uint32_t>(
              indices.count((firstIndex + k) * INDEX_BYTES, "an index of a face", ownVertices - 1));
        };
        // Front faces are clockwise in the file.
        for (uint64_t k = 0; k < ownIndices; k += 3)
          face.triangles.emplace_back(index(k), index(k + 2), index(k + 1));
      }
      map.faces.push_back(std::move(face));
    }
  }

  /** Reads { "key" "value" ... } repeatedly, without escapes or comments. */
  void readEntities() {
    const ByteReader in = lump(ENTITIES, "text of entities");
    const std::string text = in.text(0, in.size(), "the text");
    size_t at = 0;
    const auto next = [&]() -> char {
      while (at < text.size() && static_cast<unsigned char>(text[at]) <= ' ') ++at;
      return at < text.size() ? text[at] : '\0';
    };
    const auto quoted = [&]() -> std::string {
      if (next() != '"') in.fail(at, "a quoted word is expected");
      const size_t end = text.find('"', at + 1);
      if (end == std::string::npos) in.fail(at, "a quoted word has no end");
      std::string word = text.substr(at + 1, end - at - 1);
      at = end + 1;
      return word;
    };
    while (next() == '{') {
      ++at;
      Quake3Bsp::Entity entity;
      while (next() != '}') {
        if (next() == '\0') in.fail(at, "an entity has no end");
        const std::string key = lowerCase(quoted());
        entity[key] = quoted();
      }
      ++at;
      map.entities.push_back(std::move(entity));
    }
    if (next() != '\0') in.fail(at, "an entity is expected");
  }

  std::string name;
  ByteReader file;
  Quake3Bsp map;
};

/** Weights of the three control points at t, and their derivatives. */
std::array<double, 3> weights(double t) { return {(1 - t) * (1 - t), 2 * t * (1 - t), t * t}; }
std::array<double, 3> slopes(double t) { return {-2 * (1 - t), 2 - 4 * t, 2 * t}; }

/** Point of the patch piece whose first control point is (column, row). */
Quake3Bsp::Vertex patchPoint(const Quake3Bsp::Face& face, uint32_t column, uint32_t row, double s, double t) {
  const std::array<double, 3> across = weights(s), down = weights(t), acrossSlope = slopes(s),
                              downSlope = slopes(t);
  Quake3Bsp::Vertex out;
  Vec3d alongColumns(0), alongRows(0);
  for (uint32_t j = 0; j < 3; ++j)
    for (uint32_t i = 0; i < 3; ++i) {
      const Quake3Bsp::Vertex& c = face.vertices[(row + j) * face.patchWidth + column + i];
      const double w = across[i] * down[j];
      out.position += w * c.position;
      out.normal += w * c.normal;
      out.uv += w * c.uv;
      alongColumns += acrossSlope[i] * down[j] * c.position;
      alongRows += across[i] * downSlope[j] * c.position;
    }
  // Where control points coincide there is no tangent; the stored normals are used.
  const Vec3d normal = glm::cross(alongColumns, alongRows);
  const double size = glm::length(alongColumns) * glm::length(alongRows);
  if (glm::length(normal) > 1e-6 * size && size > 0) out.normal = normal;
  return out;
}

} // namespace

Quake3Bsp readQuake3Bsp(const std::string& name, std::string_view bytes) {
  return BspReader(name, bytes).read();
}

int patchSteps(const Quake3Bsp& map, double tolerance, int most) {
  double bend = 0; // second difference of control points; the arc deviates from its chord by a quarter of it
  for (const Quake3Bsp::Face& face : map.faces)
    for (uint32_t row = 0; row < face.patchHeight; ++row)
      for (uint32_t column = 0; column < face.patchWidth; ++column) {
        const auto at = [&](uint32_t c, uint32_t r) {
          return face.vertices[r * face.patchWidth + c].position;
        };
        if (column % 2 == 1)
          bend =
              std::max(bend, glm::length(at(column - 1, row) - 2.0 * at(column, row) + at(column + 1, row)));
        if (row % 2 == 1)
          bend =
              std::max(bend, glm::length(at(column, row - 1) - 2.0 * at(column, row) + at(column, row + 1)));
      }
  // With n parts the deviation is a quarter of the bend over n², along each of two directions.
  const double steps = std::sqrt(2 * bend / 4 / tolerance);
  return std::clamp(static_cast<int>(std::ceil(std::min(steps, double(most)))), 1, most);
}

void tessellatePatch(Quake3Bsp::Face& face, int steps) {
  const auto n = static_cast<uint32_t>(steps);
  const uint32_t columns = (face.patchWidth - 1) / 2 * n + 1, rows = (face.patchHeight - 1) / 2 * n + 1;
  std::vector<Quake3Bsp::Vertex> made;
  for (uint32_t r = 0; r < rows; ++r)
    for (uint32_t c = 0; c < columns; ++c) {
      const uint32_t pieceColumn = std::min(c / n, (face.patchWidth - 3) / 2);
      const uint32_t pieceRow = std::min(r / n, (face.patchHeight - 3) / 2);
      made.push_back(patchPoint(face, 2 * pieceColumn, 2 * pieceRow, double(c - pieceColumn * n) / n,
                                double(r - pieceRow * n) / n));
    }
  for (uint32_t r = 0; r + 1 < rows; ++r)
    for (uint32_t c = 0; c + 1 < columns; ++c) {
      const uint32_t a = r * columns + c;
      face.triangles.emplace_back(a, a + 1, a + columns);
      face.triangles.emplace_back(a + 1, a + columns + 1, a + columns);
    }
  face.vertices = std::move(made);
  face.patchWidth = face.patchHeight = 0;
}

std::string valueOf(const Quake3Bsp::Entity& entity, const std::string& key) {
  const auto found = entity.find(key);
  return found == entity.end() ? "" : found->second;
}

/** Numbers separated by blanks; the first word that is no number ends the list. */
static std::vector<double> numbersOf(const Quake3Bsp::Entity& entity, const std::string& key) {
  const std::string text = valueOf(entity, key);
  std::vector<double> out;
  const char* at = text.c_str();
  for (char* end = nullptr;; at = end) {
    const double value = std::strtod(at, &end);
    if (end == at || !std::isfinite(value)) return out;
    out.push_back(value);
  }
}

std::optional<Vec3d> vectorOf(const Quake3Bsp::Entity& entity, const std::string& key) {
  const std::vector<double> v = numbersOf(entity, key);
  return v.size() < 3 ? std::nullopt : std::optional(Vec3d(v[0], v[1], v[2]));
}

double numberOf(const Quake3Bsp::Entity& entity, const std::string& key, double otherwise) {
  const std::vector<double> v = numbersOf(entity, key);
  return v.empty() ? otherwise : v[0];
}

} // namespace recurse
