/** @file
 * Reading of PLY headers (Turk, "The PLY Polygon File Format", 1994).
 */
#include "model/mesh/plyHeader.h"

#include <charconv>
#include <limits>

#include "recurse/core/io/error.h"

namespace recurse {

size_t sizeOf(PlyType t) {
  switch (t) {
  case PlyType::INT8:
  case PlyType::UINT8:
    return 1;
  case PlyType::INT16:
  case PlyType::UINT16:
    return 2;
  case PlyType::INT32:
  case PlyType::UINT32:
  case PlyType::FLOAT32:
    return 4;
  case PlyType::FLOAT64:
    break;
  }
  return 8;
}

std::string printable(const std::string& text) {
  std::string out = text.substr(0, 40);
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7f) c = '?';
  return out.size() < text.size() ? out + "..." : out;
}

namespace {

/** Reads a header line by line, for messages that name the line. */
class HeaderReader {
 public:
  HeaderReader(CompressedFile& in, PlyContent content) : in(in), needsFaces(content == PlyContent::MESH) {}

  PlyHeader read() {
    readLines();
    findElements();
    findVertexProperties();
    if (needsFaces) findFaceProperty();
    return std::move(header);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(in.name() + ":" + std::to_string(line) + ": " + what);
  }

  std::string headerLine() {
    constexpr size_t MAX_DIGITS = 1 << 16;
    line = in.lineNumber();
    std::string text;
    for (int c = in.get(); c != '\n'; c = in.get()) {
      if (c < 0) fail("the file ends within the header");
      if (text.size() == MAX_DIGITS) fail("this is no PLY header: the line is too long");
      text += static_cast<char>(c);
    }
    if (!text.empty() && text.back() == '\r') text.pop_back();
    return text;
  }

  static std::vector<std::string> wordsOf(const std::string& text) {
    std::vector<std::string> words;
    std::string word;
    for (char c : text + " ") {
      if (!isPlyBlank(c)) {
        word += c;
      } else if (!word.empty()) {
        words.push_back(word);
        word.clear();
      }
    }
    return words;
  }

  PlyType typeNamed(const std::string& name) const {
    static const std::pair<const char*, PlyType> TYPES[] = {
        {"char", PlyType::INT8},      {"int8", PlyType::INT8},       {"uchar", PlyType::UINT8},
        {"uint8", PlyType::UINT8},    {"short", PlyType::INT16},     {"int16", PlyType::INT16},
        {"ushort", PlyType::UINT16},  {"uint16", PlyType::UINT16},   {"int", PlyType::INT32},
        {"int32", PlyType::INT32},    {"uint", PlyType::UINT32},     {"uint32", PlyType::UINT32},
        {"float", PlyType::FLOAT32},  {"float32", PlyType::FLOAT32}, {"double", PlyType::FLOAT64},
        {"float64", PlyType::FLOAT64}};
    for (const auto& t : TYPES)
      if (name == t.first) return t.second;
    fail("unknown type \"" + printable(name) + "\"");
  }

  void readFormat(const std::vector<std::string>& words) {
    if (words[2] != "1.0") fail("PLY version \"" + printable(words[2]) + "\" is unknown; only 1.0 is");
    if (words[1] == "ascii")
      header.encoding = PlyEncoding::TEXT;
    else if (words[1] == "binary_little_endian")
      header.encoding = PlyEncoding::BINARY_LITTLE;
    else if (words[1] == "binary_big_endian")
      header.encoding = PlyEncoding::BINARY_BIG;
    else
      fail("unknown format \"" + printable(words[1]) + "\"");
  }

  void addElement(const std::vector<std::string>& words) {
    PlyElement e;
    e.name = words[1];
    const auto [stop, error] = std::from_chars(words[2].data(), words[2].data() + words[2].size(), e.count);
    if (error != std::errc() || stop != words[2].data() + words[2].size())
      fail("\"" + printable(words[2]) + "\" is no number of elements");
    for (const PlyElement& other : header.elements)
      if (other.name == e.name) fail("element \"" + printable(e.name) + "\" is declared twice");
    header.elements.push_back(e);
  }

  void addProperty(const std::vector<std::string>& words) {
    if (header.elements.empty()) fail("a property before the first element");
    PlyProperty p;
    p.isList = words.size() == 5;
    p.name = words.back();
    p.type = typeNamed(words[words.size() - 2]);
    if (p.isList) p.countType = typeNamed(words[2]);
    if (p.isList && (p.countType == PlyType::FLOAT32 || p.countType == PlyType::FLOAT64))
      fail("the length of a list cannot be of type \"" + printable(words[2]) + "\"");
    header.elements.back().properties.push_back(p);
  }

  void readLines() {
    if (headerLine() != "ply") fail("this is no PLY file: it does not begin with the line \"ply\"");
    bool formatKnown = false;
    for (;;) {
      const std::string text = headerLine();
      const std::vector<std::string> words = wordsOf(text);
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      if (words[0] == "format" && words.size() == 3) {
        readFormat(words);
        formatKnown = true;
      } else if (words[0] == "element" && words.size() == 3) {
        addElement(words);
      } else if (words[0] == "property" && (words.size() == 3 || (words.size() == 5 && words[1] == "list"))) {
        addProperty(words);
      } else {
        fail("\"" + printable(text) + "\" is not allowed in a PLY header");
      }
    }
    if (!formatKnown) fail("the header has no \"format\" line");
  }

  void findElements() {
    size_t& vertex = header.vertex = NONE;
    size_t& face = header.face = NONE;
    for (size_t i = 0; i < header.elements.size(); ++i) {
      if (header.elements[i].name == "vertex") vertex = i;
      if (header.elements[i].name == "face") face = i;
    }
    if (vertex == NONE || header.vertexElement().count == 0) fail("the file has no vertices");
    if (needsFaces && (face == NONE || header.faceElement().count == 0)) fail("the file has no faces");
    if (header.vertexElement().count > std::numeric_limits<uint32_t>::max())
      fail("there are too many vertices");
  }

  /** Finds the indices of the properties that make a vector; false unless all exist. */
  bool findVector(std::initializer_list<const char*> names, std::vector<int>& places) const {
    std::vector<int> found;
    for (const char* name : names) {
      const int i = header.vertexElement().find(name);
      if (i < 0 || header.vertexElement().properties[size_t(i)].isList) return false;
      found.push_back(i);
    }
    places = found;
    return true;
  }

  void findVertexProperties() {
    if (!findVector({"x", "y", "z"}, header.positionPlaces)) fail("the vertices have no x, y and z");
    findVector({"nx", "ny", "nz"}, header.normalPlaces);
    // Names that pbrt accepts, in its order.
    findVector({"u", "v"}, header.uvPlaces) || findVector({"s", "t"}, header.uvPlaces) ||
        findVector({"texture_u", "texture_v"}, header.uvPlaces) ||
        findVector({"texture_s", "texture_t"}, header.uvPlaces);
    std::vector<int> radius;
    if (findVector({"radius"}, radius)) header.radiusPlace = radius.front();
  }

  void findFaceProperty() {
    for (const char* name : {"vertex_indices", "vertex_index"}) {
      header.indexPlace = header.faceElement().find(name);
      if (header.indexPlace >= 0 && header.faceElement().properties[size_t(header.indexPlace)].isList) break;
      header.indexPlace = -1;
    }
    if (header.indexPlace < 0) fail("the faces have no list \"vertex_indices\"");
  }

  static constexpr size_t NONE = std::numeric_limits<size_t>::max();
  CompressedFile& in;
  bool needsFaces;
  PlyHeader header;
  uint64_t line = 0;
};

} // namespace

PlyHeader readPlyHeader(CompressedFile& in, PlyContent content) { return HeaderReader(in, content).read(); }

} // namespace recurse
