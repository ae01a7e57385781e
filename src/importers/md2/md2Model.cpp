/** @file
 * Reading of MD2 models (layout: the game's source as released in 2001, qfiles.h).
 */
#include "importers/md2/md2Model.h"

#include <algorithm>
#include <cctype>
#include <map>

namespace recurse {

namespace {

// Limits of the game's own loader, with a margin for tools that go beyond it.
constexpr uint64_t MAX_SKIN_SIZE = 65535, MAX_SKINS = 1024, MAX_VERTICES = 65536, MAX_FRAMES = 65536,
                   MAX_TRIANGLES = 1 << 22;
constexpr uint64_t SKIN_BYTES = 64, FRAME_HEADER_BYTES = 40;

} // namespace

Md2Model::Md2Model(const std::string& name, std::string_view bytes) : file(name, bytes) {
  if (file.text(0, 4, "the header") != "IDP2")
    file.fail(0, "this is no MD2 model: it does not begin with IDP2");
  if (const auto version = file.at<int32_t>(4, "the version"); version != 8)
    file.fail(4, "MD2 version " + std::to_string(version) + " is unknown; only 8 is");
  skinWidth = file.count(8, "the width of the skin", MAX_SKIN_SIZE);
  skinHeight = file.count(12, "the height of the skin", MAX_SKIN_SIZE);
  frameSize = file.count(16, "the size of a frame", FRAME_HEADER_BYTES + 4 * MAX_VERTICES);
  skinCount = file.count(20, "the number of skins", MAX_SKINS);
  vertices = file.count(24, "the number of vertices", MAX_VERTICES);
  texCoords = file.count(28, "the number of texture coordinates", 3 * MAX_TRIANGLES);
  triangles = file.count(32, "the number of triangles", MAX_TRIANGLES);
  frameCount = file.count(40, "the number of frames", MAX_FRAMES);
  skinsAt = file.count(44, "the offset of the skins", file.size());
  texCoordsAt = file.count(48, "the offset of the texture coordinates", file.size());
  trianglesAt = file.count(52, "the offset of the triangles", file.size());
  framesAt = file.count(56, "the offset of the frames", file.size());
  if (vertices == 0 || triangles == 0 || frameCount == 0) file.fail(24, "the model is empty");
  if (frameSize < FRAME_HEADER_BYTES + 4 * vertices)
    file.fail(16, "a frame of " + std::to_string(frameSize) + " bytes cannot hold " +
                      std::to_string(vertices) + " vertices");
  file.part(skinsAt, skinCount * SKIN_BYTES, "the list of skins");
  file.part(texCoordsAt, texCoords * 4, "the list of texture coordinates");
  file.part(trianglesAt, triangles * 12, "the list of triangles");
  file.part(framesAt, frameCount * frameSize, "the list of frames");
}

std::vector<std::string> Md2Model::skins() const {
  std::vector<std::string> names;
  for (uint64_t i = 0; i < skinCount; ++i)
    names.push_back(file.text(skinsAt + i * SKIN_BYTES, SKIN_BYTES, "the name of a skin"));
  return names;
}

std::vector<Vec3d> Md2Model::positions(uint64_t frame) const {
  const uint64_t at = frameAt(frame);
  Vec3d scale, translate;
  for (int i = 0; i < 3; ++i) {
    scale[i] = double(file.at<float>(at + 4 * static_cast<uint64_t>(i), "the scale of a frame"));
    translate[i] = double(file.at<float>(at + 12 + 4 * static_cast<uint64_t>(i), "the origin of a frame"));
  }
  std::vector<Vec3d> out;
  for (uint64_t v = 0; v < vertices; ++v) {
    const std::string_view xyz = file.part(at + FRAME_HEADER_BYTES + 4 * v, 3, "a vertex");
    out.push_back(translate + scale * Vec3d(static_cast<uint8_t>(xyz[0]), static_cast<uint8_t>(xyz[1]),
                                            static_cast<uint8_t>(xyz[2])));
  }
  return out;
}

std::string Md2Model::animations() const {
  std::string list, last;
  for (uint64_t i = 0; i < frameCount; ++i) {
    std::string name = file.text(frameAt(i) + 24, 16, "the name of a frame");
    while (!name.empty() && std::isdigit(static_cast<unsigned char>(name.back()))) name.pop_back();
    if (name != last) list += (list.empty() ? "" : ", ") + name;
    last = name;
  }
  for (char& c : list)
    if (static_cast<unsigned char>(c) < 0x20) c = '?';
  return list;
}

MeshData Md2Model::pose(double frame) const {
  const auto first = static_cast<uint64_t>(frame);
  const double part = frame - double(first);
  std::vector<Vec3d> place = positions(first);
  if (part > 0) {
    const std::vector<Vec3d> next = positions(first + 1);
    for (size_t i = 0; i < place.size(); ++i) place[i] = glm::mix(place[i], next[i], part);
  }
  std::vector<Vec3d> normals(place.size(), Vec3d(0)); // sums of the area vectors of adjacent faces
  MeshData mesh;
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> made; // indices by position and texture coordinate
  for (uint64_t t = 0; t < triangles; ++t) {
    const uint64_t at = trianglesAt + 12 * t;
    uint32_t vertex[3], uv[3];
    for (uint64_t k = 0; k < 3; ++k) {
      vertex[k] = indexAt(at + 2 * k, "vertex", vertices);
      uv[k] = indexAt(at + 6 + 2 * k, "texture coordinate", texCoords);
    }
    std::swap(vertex[1], vertex[2]); // front faces are clockwise in the file
    std::swap(uv[1], uv[2]);
    const Vec3d& a = place[vertex[0]];
    const Vec3d area = glm::cross(place[vertex[1]] - a, place[vertex[2]] - a);
    glm::uvec3 triangle;
    for (int k = 0; k < 3; ++k) {
      normals[vertex[k]] += area;
      const auto [known, isNew] =
          made.try_emplace({vertex[k], uv[k]}, static_cast<uint32_t>(mesh.positions.size()));
      if (isNew) {
        mesh.positions.push_back(place[vertex[k]]);
        mesh.uvs.push_back(texCoord(uv[k]));
      }
      triangle[k] = known->second;
    }
    mesh.triangles.push_back(triangle);
  }
  mesh.normals.resize(mesh.positions.size());
  for (const auto& [key, index] : made) mesh.normals[index] = normals[key.first];
  return mesh;
}

uint32_t Md2Model::indexAt(uint64_t offset, const char* what, uint64_t count) const {
  const auto index = file.at<uint16_t>(offset, what);
  if (index >= count)
    file.fail(offset, std::string("a triangle names ") + what + " " + std::to_string(index) + "; there are " +
                          std::to_string(count));
  return index;
}

/** Texture coordinates, stored in pixels of the skin from its upper edge. */
Vec2d Md2Model::texCoord(uint32_t index) const {
  const uint64_t at = texCoordsAt + 4 * uint64_t(index);
  const double width = double(std::max<uint64_t>(skinWidth, 1));
  const double height = double(std::max<uint64_t>(skinHeight, 1));
  return {(file.at<int16_t>(at, "a texture coordinate") + 0.5) / width,
          1 - (file.at<int16_t>(at + 2, "a texture coordinate") + 0.5) / height};
}

} // namespace recurse
