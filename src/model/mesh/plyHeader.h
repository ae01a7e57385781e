/** @file
 * Header of a PLY file: its elements and their properties.
 */
#pragma once

#include "model/mesh/compressedFile.h"

namespace recurse {

enum class PlyType { INT8, UINT8, INT16, UINT16, INT32, UINT32, FLOAT32, FLOAT64 };

enum class PlyEncoding { TEXT, BINARY_LITTLE, BINARY_BIG };

/** Property of an element: a number, or a list of numbers after their count. */
struct PlyProperty {
  std::string name;
  PlyType type = PlyType::FLOAT32;
  bool isList = false;
  PlyType countType = PlyType::UINT8;
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;

  int find(const std::string& property) const {
    for (size_t i = 0; i < properties.size(); ++i)
      if (properties[i].name == property) return static_cast<int>(i);
    return -1;
  }
};

size_t sizeOf(PlyType t);

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::TEXT;
  std::vector<PlyElement> elements;
  size_t vertex = 0, face = 0;                             ///< indices into `elements`
  std::vector<int> positionPlaces, normalPlaces, uvPlaces; ///< indices into the vertex's properties
  int indexPlace = -1;                                     ///< index into the face's properties
  int radiusPlace = -1;                                    ///< index into the vertex's properties; -1: none

  const PlyElement& vertexElement() const { return elements[vertex]; }
  const PlyElement& faceElement() const { return elements[face]; }
};

/** What a file must describe: a mesh has faces. */
enum class PlyContent { MESH, POINTS };

/** Reads up to the first element. Throws Error for a header that the content cannot follow. */
PlyHeader readPlyHeader(CompressedFile& in, PlyContent content);

/** True for characters that separate the words of a text file. */
inline bool isPlyBlank(int c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}

/** Text of a file for messages: at most 40 characters, printable ASCII only. */
std::string printable(const std::string& text);

} // namespace recurse
