/** @file
 * The header of a PLY file: which elements follow, and what each is made of.
 */
#pragma once

#include "model/mesh/compressedFile.h"

namespace recurse {

enum class PlyType { INT8, UINT8, INT16, UINT16, INT32, UINT32, FLOAT32, FLOAT64 };

enum class PlyEncoding { TEXT, BINARY_LITTLE, BINARY_BIG };

/** Of an element: a number, or a list of them after their count. */
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
  size_t vertex = 0, face = 0;                             ///< which of the elements
  std::vector<int> positionPlaces, normalPlaces, uvPlaces; ///< among the vertex's properties
  int indexPlace = -1;                                     ///< among the face's

  const PlyElement& vertexElement() const { return elements[vertex]; }
  const PlyElement& faceElement() const { return elements[face]; }
};

/** Reads as far as the first element. A header that no mesh can follow is an error. */
PlyHeader readPlyHeader(CompressedFile& in);

/** Between words of a text. */
inline bool isPlyBlank(int c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}

/** Words of a file, cut short, for messages. */
std::string printable(const std::string& text);

} // namespace recurse
