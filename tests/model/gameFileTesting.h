/** @file
 * Small files of games, written for tests: MD2 models, PCX pictures, zip archives and Quake III maps.
 */
#pragma once

#include <cstring>
#include <map>
#include <string>
#include <zlib.h>

#include "recurse/core/math/vector.h"

namespace recurse::testing {

/** Little-endian bytes, with overwriting of values. */
struct Bytes {
  std::string data;
  template <class T> Bytes& put(T value) {
    data.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Bytes& text(const std::string& s, size_t size) {
    data += s + std::string(size - s.size(), '\0');
    return *this;
  }
  template <class T> void over(size_t at, T value) { std::memcpy(&data[at], &value, sizeof value); }
};

/** Two frames of one triangle in the plane y = 0 with its front towards -y; in the second frame it is twice
 * as large. */
inline std::string md2File(const std::string& skin = "") {
  Bytes b;
  const int32_t skins = skin.empty() ? 0 : 1;
  b.text("IDP2", 4);
  const int32_t skinsAt = 68, uvsAt = skinsAt + 64 * skins, trianglesAt = uvsAt + 12,
                framesAt = trianglesAt + 12, end = framesAt + 2 * 52;
  for (const int32_t v : {8, 4, 4, 52, skins, 3, 3, 1, 0, 2, skinsAt, uvsAt, trianglesAt, framesAt, end, end})
    b.put(v);
  if (skins) b.text(skin, 64);
  for (const int16_t v : {0, 3, 3, 3, 0, 0}) b.put(v);  // pixels from the upper edge
  for (const uint16_t v : {0, 2, 1, 0, 2, 1}) b.put(v); // clockwise seen from the front
  for (const float scale : {0.1f, 0.2f}) {
    for (int i = 0; i < 3; ++i) b.put(scale);
    for (int i = 0; i < 3; ++i) b.put(i == 2 ? 5.0f : 0.0f);
    b.text(scale < 0.15f ? "stand01" : "stand02", 16);
    for (const uint8_t v : {0, 0, 0, 7, 10, 0, 0, 7, 0, 0, 10, 7}) b.put(v);
  }
  return b.data;
}

/** Four by four pixels: rows red, green, blue, white from the top, by a palette. */
inline std::string pcxFile() {
  Bytes b;
  b.put<uint8_t>(10).put<uint8_t>(5).put<uint8_t>(1).put<uint8_t>(8);
  for (const uint16_t v : {0, 0, 3, 3, 72, 72}) b.put(v);
  b.text("", 48).put<uint8_t>(0).put<uint8_t>(1).put<uint16_t>(4).put<uint16_t>(1).text("", 58);
  for (const uint8_t index : {1, 2, 200, 3}) {
    if (index == 2)
      b.put<uint8_t>(2).put<uint8_t>(2).put<uint8_t>(2).put<uint8_t>(2);
    else
      b.put<uint8_t>(0xc4).put(index);
  }
  b.put<uint8_t>(12);
  for (int i = 0; i < 256; ++i) {
    b.put<uint8_t>(i == 1 || i == 3 ? 255 : 0).put<uint8_t>(i == 2 || i == 3 ? 255 : 0);
    b.put<uint8_t>(i == 200 || i == 3 ? 255 : 0);
  }
  return b.data;
}

/** A zip archive of files that are not compressed. */
inline std::string zipFile(const std::map<std::string, std::string>& files) {
  Bytes b, directory;
  for (const auto& [name, content] : files) {
    const auto crc = static_cast<uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(content.data()), static_cast<uInt>(content.size())));
    const auto at = static_cast<uint32_t>(b.data.size()), size = static_cast<uint32_t>(content.size());
    const auto length = static_cast<uint16_t>(name.size());
    const auto common = [&](Bytes& to) {
      to.put<uint16_t>(20).put<uint16_t>(0).put<uint16_t>(0).put<uint32_t>(0x21).put(crc).put(size).put(size);
      to.put(length).put<uint16_t>(0);
    };
    b.put<uint32_t>(0x04034b50);
    common(b);
    b.data += name + content;
    directory.put<uint32_t>(0x02014b50).put<uint16_t>(20);
    common(directory);
    directory.put<uint16_t>(0).put<uint16_t>(0).put<uint16_t>(0).put<uint32_t>(0).put(at);
    directory.data += name;
  }
  const auto start = static_cast<uint32_t>(b.data.size());
  b.data += directory.data;
  b.put<uint32_t>(0x06054b50).put<uint16_t>(0).put<uint16_t>(0);
  b.put(static_cast<uint16_t>(files.size())).put(static_cast<uint16_t>(files.size()));
  b.put(static_cast<uint32_t>(directory.data.size())).put(start).put<uint16_t>(0);
  return b.data;
}

/** Assembles a map lump by lump. */
struct BspWriter {
  Bytes shaders, vertices, indices, faces;
  std::string entities = "{ \"classname\" \"worldspawn\" }";
  int32_t vertexCount = 0, indexCount = 0;

  void shader(const std::string& name, int32_t flags = 0) {
    shaders.text(name, 64).put(flags).put<int32_t>(0);
  }
  void vertex(const Vec3f& p, const Vec2f& st, const Vec3f& n) {
    vertices.put(p).put(st).put(Vec2f(0)).put(n).put<uint32_t>(~0u);
    ++vertexCount;
  }
  void face(int32_t shader, int32_t type, int32_t firstVertex, int32_t firstIndex, int32_t width = 0,
            int32_t height = 0) {
    for (const int32_t v : {shader, -1, type, firstVertex, vertexCount - firstVertex, firstIndex,
                            indexCount - firstIndex, -1, 0, 0, 0, 0})
      faces.put(v);
    for (int i = 0; i < 12; ++i) faces.put(0.0f);
    faces.put(width).put(height);
  }
  /** A square of 80 units at a height, visible from above; st = 0 is at its corner with the smallest x and
   * y. */
  void square(int32_t shader, float z) {
    const int32_t firstVertex = vertexCount, firstIndex = indexCount;
    for (const Vec2f& c : {Vec2f(0, 0), Vec2f(0, 1), Vec2f(1, 1), Vec2f(1, 0)})
      vertex({80 * c.x, 80 * c.y, z}, c, {0, 0, 1});
    for (const int32_t i : {0, 1, 2, 0, 2, 3}) {
      indices.put(i);
      ++indexCount;
    }
    face(shader, 1, firstVertex, firstIndex);
  }
  std::string file() const {
    Bytes b;
    b.text("IBSP", 4).put<int32_t>(46);
    const std::map<int, std::string> lumps = {
        {0, entities}, {1, shaders.data}, {10, vertices.data}, {11, indices.data}, {13, faces.data}};
    int32_t at = 8 + 8 * 17;
    for (int i = 0; i < 17; ++i) {
      const auto found = lumps.find(i);
      const int32_t size = found == lumps.end() ? 0 : static_cast<int32_t>(found->second.size());
      b.put(at).put(size);
      at += size;
    }
    for (const auto& [i, data] : lumps) b.data += data;
    return b.data;
  }
};

} // namespace recurse::testing
