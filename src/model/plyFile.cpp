/** @file
 * Reading of PLY files in one pass, so that a large mesh is in memory once.
 */
#include "model/plyFile.h"

#include <charconv>
#include <cstring>
#include <filesystem>
#include <unordered_map>
#include <zlib.h>

#include "recurse/core/error.h"

namespace recurse {

namespace {

enum class ScalarType { INT8, UINT8, INT16, UINT16, INT32, UINT32, FLOAT32, FLOAT64 };

size_t sizeOf(ScalarType t) {
  switch (t) {
  case ScalarType::INT8:
  case ScalarType::UINT8:
    return 1;
  case ScalarType::INT16:
  case ScalarType::UINT16:
    return 2;
  case ScalarType::INT32:
  case ScalarType::UINT32:
  case ScalarType::FLOAT32:
    return 4;
  case ScalarType::FLOAT64:
    break;
  }
  return 8;
}

enum class Encoding { TEXT, BINARY_LITTLE, BINARY_BIG };

struct Property {
  std::string name;
  ScalarType type = ScalarType::FLOAT32;
  bool isList = false;
  ScalarType countType = ScalarType::UINT8;
};

struct Element {
  std::string name;
  uint64_t count = 0;
  std::vector<Property> properties;

  int find(const std::string& property) const {
    for (size_t i = 0; i < properties.size(); ++i)
      if (properties[i].name == property) return static_cast<int>(i);
    return -1;
  }
};

bool isBlank(int c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f'; }

std::string printable(const std::string& text) {
  std::string out = text.substr(0, 40);
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7f) c = '?';
  return out.size() < text.size() ? out + "..." : out;
}

/** The bytes of a file, decompressed where it is gzip, and where we are in them. */
class ByteSource {
 public:
  explicit ByteSource(const FileReference& source)
      : path(source.path), content(source.content), buffer(content ? 0 : size_t{1} << 18) {
    if (content) return;
    file = gzopen(path.c_str(), "rb");
    if (!file) throw Error(path + ": cannot be opened: " + std::strerror(errno));
    gzbuffer(file, 1u << 17);
  }
  ~ByteSource() {
    if (file) gzclose(file);
  }
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;

  /** The next byte; -1 at the end. */
  int get() {
    if (position == end && !fill()) return -1;
    const auto c = static_cast<unsigned char>(data()[position++]);
    if (c == '\n') ++line;
    return c;
  }
  int peek() {
    if (position == end && !fill()) return -1;
    return static_cast<unsigned char>(data()[position]);
  }
  /** False when the file ends before. */
  bool read(char* to, size_t count) {
    if (end - position >= count) { // nearly always
      std::memcpy(to, data() + position, count);
      position += count;
      return true;
    }
    for (size_t i = 0; i < count; ++i) {
      if (position == end && !fill()) return false;
      to[i] = data()[position++];
    }
    return true;
  }
  bool skip(uint64_t count) {
    while (count > 0) {
      if (position == end && !fill()) return false;
      const uint64_t step = std::min<uint64_t>(count, end - position);
      position += step;
      count -= step;
    }
    return true;
  }
  uint64_t offset() const { return base + position; }
  uint64_t lineNumber() const { return line; }
  const std::string& name() const { return path; }
  bool compressed() const { return file && !gzdirect(file); }
  /** Of the file as it is stored; 0 where that is not known. */
  uint64_t storedBytes() const {
    std::error_code error;
    const uint64_t bytes = content ? content->size() : std::filesystem::file_size(path, error);
    return error ? 0 : bytes;
  }

 private:
  const char* data() const { return content ? content->data() : buffer.data(); }
  bool fill() {
    if (content) { // the whole of it at once
      const bool more = end == 0 && !content->empty();
      end = content->size();
      return more;
    }
    base += end;
    position = end = 0;
    const int got = gzread(file, buffer.data(), static_cast<unsigned>(buffer.size()));
    if (got > 0) {
      end = static_cast<size_t>(got);
      return true;
    }
    int code = 0;
    const char* why = gzerror(file, &code);
    if (code == Z_ERRNO) throw Error(path + ": cannot be read: " + std::strerror(errno));
    if (code != Z_OK && code != Z_STREAM_END)
      throw Error(path + ": at byte " + std::to_string(base) +
                  ": the gzip data is damaged or cut off: " + why);
    return false;
  }

  std::string path;
  std::shared_ptr<const std::string> content; ///< null: the file is read
  gzFile file = nullptr;
  std::vector<char> buffer;
  size_t position = 0, end = 0;
  uint64_t base = 0; ///< offset of the buffer in the file
  uint64_t line = 1;
};

class PlyReader {
 public:
  explicit PlyReader(const FileReference& file) : in(file) {}

  PlyFile read() {
    readHeader();
    findVertexProperties();
    findFaceProperty();
    for (const Element& e : elements) {
      if (&e == vertexElement)
        readVertices();
      else if (&e == faceElement)
        readFaces();
      else
        skipElement(e);
    }
    refuseBrokenCorners();
    for (const auto& [vertex, what] : broken) // where it does not widen the bounds
      mesh.positions[vertex] = mesh.positions[mesh.triangles.at(0).x];
    return {std::move(mesh), badNormals, broken.size()};
  }

 private:
  /** A line of a text, else a byte. */
  uint64_t currentPlace() const {
    const bool isLine = inHeader || encoding == Encoding::TEXT;
    return !isLine ? in.offset() : reportedLine ? reportedLine : in.lineNumber();
  }
  [[noreturn]] void fail(const std::string& what) const { failAt(currentPlace(), what); }
  [[noreturn]] void failAt(uint64_t place, const std::string& what) const {
    const bool isLine = inHeader || encoding == Encoding::TEXT;
    throw Error(in.name() + (isLine ? ":" : ": at byte ") + std::to_string(place) + ": " + what);
  }

  void refuseBrokenCorners() const {
    if (broken.empty()) return;
    for (const glm::uvec3& t : mesh.triangles)
      for (int k = 0; k < 3; ++k)
        if (const auto found = broken.find(t[k]); found != broken.end())
          failAt(found->second.place,
                 "vertex " + std::to_string(t[k]) + " has a " + found->second.what + " that is not finite");
  }

  // ---- header

  std::string headerLine() {
    constexpr size_t MAX_DIGITS = 1 << 16;
    reportedLine = in.lineNumber();
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
      if (!isBlank(c)) {
        word += c;
      } else if (!word.empty()) {
        words.push_back(word);
        word.clear();
      }
    }
    return words;
  }

  ScalarType typeNamed(const std::string& name) const {
    static const std::pair<const char*, ScalarType> TYPES[] = {
        {"char", ScalarType::INT8},      {"int8", ScalarType::INT8},       {"uchar", ScalarType::UINT8},
        {"uint8", ScalarType::UINT8},    {"short", ScalarType::INT16},     {"int16", ScalarType::INT16},
        {"ushort", ScalarType::UINT16},  {"uint16", ScalarType::UINT16},   {"int", ScalarType::INT32},
        {"int32", ScalarType::INT32},    {"uint", ScalarType::UINT32},     {"uint32", ScalarType::UINT32},
        {"float", ScalarType::FLOAT32},  {"float32", ScalarType::FLOAT32}, {"double", ScalarType::FLOAT64},
        {"float64", ScalarType::FLOAT64}};
    for (const auto& t : TYPES)
      if (name == t.first) return t.second;
    fail("unknown type \"" + printable(name) + "\"");
  }

  void readHeader() {
    if (headerLine() != "ply") fail("this is no PLY file: it does not begin with the line \"ply\"");
    bool formatKnown = false;
    for (;;) {
      const std::string text = headerLine();
      const std::vector<std::string> words = wordsOf(text);
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      if (words[0] == "format" && words.size() == 3) {
        if (words[2] != "1.0") fail("PLY version \"" + printable(words[2]) + "\" is unknown; only 1.0 is");
        if (words[1] == "ascii")
          encoding = Encoding::TEXT;
        else if (words[1] == "binary_little_endian")
          encoding = Encoding::BINARY_LITTLE;
        else if (words[1] == "binary_big_endian")
          encoding = Encoding::BINARY_BIG;
        else
          fail("unknown format \"" + printable(words[1]) + "\"");
        formatKnown = true;
      } else if (words[0] == "element" && words.size() == 3) {
        Element e;
        e.name = words[1];
        const auto [stop, error] =
            std::from_chars(words[2].data(), words[2].data() + words[2].size(), e.count);
        if (error != std::errc() || stop != words[2].data() + words[2].size())
          fail("\"" + printable(words[2]) + "\" is no number of elements");
        for (const Element& other : elements)
          if (other.name == e.name) fail("element \"" + printable(e.name) + "\" is declared twice");
        elements.push_back(e);
      } else if (words[0] == "property" && (words.size() == 3 || (words.size() == 5 && words[1] == "list"))) {
        if (elements.empty()) fail("a property before the first element");
        Property p;
        p.isList = words.size() == 5;
        p.name = words.back();
        p.type = typeNamed(words[words.size() - 2]);
        if (p.isList) p.countType = typeNamed(words[2]);
        if (p.isList && (p.countType == ScalarType::FLOAT32 || p.countType == ScalarType::FLOAT64))
          fail("a list cannot be counted in \"" + printable(words[2]) + "\"");
        elements.back().properties.push_back(p);
      } else {
        fail("\"" + printable(text) + "\" does not belong in a PLY header");
      }
    }
    if (!formatKnown) fail("the header has no \"format\" line");
    for (const Element& e : elements) {
      if (e.name == "vertex") vertexElement = &e;
      if (e.name == "face") faceElement = &e;
    }
    if (!vertexElement || vertexElement->count == 0) fail("the file has no vertices");
    if (!faceElement || faceElement->count == 0) fail("the file has no faces");
    if (vertexElement->count > std::numeric_limits<uint32_t>::max()) fail("there are too many vertices");
  }

  /** The places of properties that make a vector; false when they are not all there. */
  bool findVector(std::initializer_list<const char*> names, std::vector<int>& places) const {
    std::vector<int> found;
    for (const char* name : names) {
      const int i = vertexElement->find(name);
      if (i < 0 || vertexElement->properties[size_t(i)].isList) return false;
      found.push_back(i);
    }
    places = found;
    return true;
  }

  void findVertexProperties() {
    if (!findVector({"x", "y", "z"}, positionPlaces)) fail("the vertices have no x, y and z");
    findVector({"nx", "ny", "nz"}, normalPlaces);
    // The names that pbrt knows, in its order.
    findVector({"u", "v"}, uvPlaces) || findVector({"s", "t"}, uvPlaces) ||
        findVector({"texture_u", "texture_v"}, uvPlaces) || findVector({"texture_s", "texture_t"}, uvPlaces);
  }

  void findFaceProperty() {
    for (const char* name : {"vertex_indices", "vertex_index"}) {
      indexPlace = faceElement->find(name);
      if (indexPlace >= 0 && faceElement->properties[size_t(indexPlace)].isList) break;
      indexPlace = -1;
    }
    if (indexPlace < 0) fail("the faces have no list \"vertex_indices\"");
    reportedLine = 0;
    inHeader = false;
  }

  // ---- values

  [[noreturn]] void failAtEnd() const {
    fail("the file ends in " + current->name + " " + std::to_string(index) + " of " +
         std::to_string(current->count));
  }

  template <class T> double readBinary() {
    char bytes[sizeof(T)];
    if (!in.read(bytes, sizeof(T))) failAtEnd();
    if (encoding == Encoding::BINARY_BIG) std::reverse(bytes, bytes + sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return static_cast<double>(value);
  }

  /** A word of a text file. */
  void readWord() {
    constexpr size_t MAX_DIGITS = 400; // digits of a number, with a margin
    while (isBlank(in.peek())) in.get();
    reportedLine = in.lineNumber();
    word.clear();
    for (int c = in.peek(); c >= 0 && !isBlank(c); c = in.peek()) {
      if (word.size() == MAX_DIGITS) fail("\"" + printable(word) + "\" is no number");
      word += static_cast<char>(in.get());
    }
    if (word.empty()) failAtEnd();
  }

  double readText() {
    readWord();
    const char* begin = word.data() + (word[0] == '+' ? 1 : 0);
    const char* end = word.data() + word.size();
    double value = 0;
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (error == std::errc::result_out_of_range && stop == end) {
      // Too small is zero; too large is for the caller to refuse.
      value = std::strtod(begin, nullptr);
    } else if (error != std::errc() || stop != end) {
      fail("\"" + printable(word) + "\" is no number");
    }
    return value;
  }

  double readValue(ScalarType type) {
    if (encoding == Encoding::TEXT) return readText();
    switch (type) {
    case ScalarType::INT8:
      return readBinary<int8_t>();
    case ScalarType::UINT8:
      return readBinary<uint8_t>();
    case ScalarType::INT16:
      return readBinary<int16_t>();
    case ScalarType::UINT16:
      return readBinary<uint16_t>();
    case ScalarType::INT32:
      return readBinary<int32_t>();
    case ScalarType::UINT32:
      return readBinary<uint32_t>();
    case ScalarType::FLOAT32:
      return readBinary<float>();
    case ScalarType::FLOAT64:
      break;
    }
    return readBinary<double>();
  }

  uint64_t readListLength(const Property& p) {
    const double n = readValue(p.countType);
    if (!(n >= 0 && n <= double(std::numeric_limits<uint32_t>::max())) || n != std::floor(n))
      fail(current->name + " " + std::to_string(index) + " has a list of an impossible length");
    return static_cast<uint64_t>(n);
  }

  void skipValues(ScalarType type, uint64_t count) {
    if (encoding == Encoding::TEXT) {
      for (uint64_t i = 0; i < count; ++i) readWord();
    } else if (!in.skip(count * sizeOf(type))) {
      failAtEnd();
    }
  }

  void skipProperty(const Property& p) { skipValues(p.type, p.isList ? readListLength(p) : 1); }

  void skipElement(const Element& e) {
    if (e.properties.empty()) return; // takes no bytes, however many
    current = &e;
    for (index = 0; index < e.count; ++index)
      for (const Property& p : e.properties) skipProperty(p);
  }

  /** How many elements to make room for: what the file says, unless it is too short for that many. */
  size_t roomFor(const Element& e) const {
    uint64_t bytesEach = 0;
    for (const Property& p : e.properties)
      bytesEach += encoding == Encoding::TEXT ? 2 : sizeOf(p.isList ? p.countType : p.type);
    const uint64_t fileBytes = in.storedBytes();
    // Meshes hardly ever compress better than this; if one does, the arrays grow on the way.
    constexpr uint64_t USUAL_COMPRESSION = 8;
    return static_cast<size_t>(std::min(
        e.count,
        fileBytes * (in.compressed() ? USUAL_COMPRESSION : 1) / std::max<uint64_t>(bytesEach, 1) + 1));
  }

  template <class V>
  V pickVector(const std::vector<double>& values, const std::vector<int>& places, const char* what) {
    V v;
    for (int i = 0; i < V::length(); ++i) {
      v[i] = values[size_t(places[size_t(i)])];
      if (!std::isfinite(v[i]) && places == normalPlaces) {
        ++badNormals;
        return V(0); // stands for none: the face's own counts
      }
      if (!std::isfinite(v[i])) { // which does no harm where no face uses the vertex
        broken.emplace(static_cast<uint32_t>(index), BrokenVertex{currentPlace(), what});
        return V(0);
      }
    }
    return v;
  }

  void readVertices() {
    current = vertexElement;
    const size_t room = roomFor(*vertexElement);
    mesh.positions.reserve(room);
    if (!normalPlaces.empty()) mesh.normals.reserve(room);
    if (!uvPlaces.empty()) mesh.uvs.reserve(room);
    const std::vector<Property>& properties = vertexElement->properties;
    std::vector<double> values(properties.size());
    for (index = 0; index < vertexElement->count; ++index) {
      for (size_t i = 0; i < properties.size(); ++i) {
        if (properties[i].isList)
          skipProperty(properties[i]);
        else
          values[i] = readValue(properties[i].type);
      }
      mesh.positions.push_back(pickVector<Vec3d>(values, positionPlaces, "position"));
      if (!normalPlaces.empty()) mesh.normals.push_back(pickVector<Vec3d>(values, normalPlaces, "normal"));
      if (!uvPlaces.empty()) mesh.uvs.push_back(pickVector<Vec2d>(values, uvPlaces, "texture coordinate"));
    }
  }

  void readFaces() {
    current = faceElement;
    mesh.triangles.reserve(roomFor(*faceElement));
    for (index = 0; index < faceElement->count; ++index) {
      for (size_t i = 0; i < faceElement->properties.size(); ++i) {
        const Property& p = faceElement->properties[i];
        if (static_cast<int>(i) == indexPlace)
          readFace(p);
        else
          skipProperty(p);
      }
    }
  }

  /** A polygon becomes a fan of triangles around its first vertex. */
  void readFace(const Property& p) {
    const uint64_t n = readListLength(p);
    if (n < 3)
      fail("face " + std::to_string(index) + " has " + std::to_string(n) +
           (n == 1 ? " vertex" : " vertices"));
    uint32_t first = 0, previous = 0;
    for (uint64_t k = 0; k < n; ++k) {
      const double value = readValue(p.type);
      if (!(value >= 0 && value < double(vertexElement->count)) || value != std::floor(value)) {
        const std::string shown = encoding == Encoding::TEXT ? printable(word)
                                  : std::abs(value) < 1e15   ? std::to_string(static_cast<int64_t>(value))
                                                             : std::to_string(value);
        fail("face " + std::to_string(index) + " names vertex " + shown + "; there are 0 to " +
             std::to_string(vertexElement->count - 1));
      }
      const auto vertex = static_cast<uint32_t>(value);
      if (k == 0) first = vertex;
      if (k >= 2) mesh.triangles.emplace_back(first, previous, vertex);
      previous = vertex;
    }
    if (mesh.triangles.size() >= std::numeric_limits<uint32_t>::max()) fail("there are too many faces");
  }

  ByteSource in;
  Encoding encoding = Encoding::TEXT;
  std::vector<Element> elements;
  const Element *vertexElement = nullptr, *faceElement = nullptr;
  std::vector<int> positionPlaces, normalPlaces, uvPlaces; ///< among the vertex's properties
  int indexPlace = -1;                                     ///< among the face's
  MeshData mesh;
  uint64_t badNormals = 0; ///< that are not finite
  struct BrokenVertex {
    uint64_t place;
    const char* what;
  };
  std::unordered_map<uint32_t, BrokenVertex> broken;

  // Where we are, for messages.
  bool inHeader = true;
  uint64_t reportedLine = 0; ///< of the word read last; 0: where the reading has got to
  const Element* current = nullptr;
  uint64_t index = 0;
  std::string word;
};

} // namespace

PlyFile readPly(const FileReference& file) {
  try {
    return PlyReader(file).read();
  } catch (const Error& e) {
    const std::string what = e.what();
    throw Error(what.rfind(file.path, 0) == 0 ? what : file.path + ": " + what);
  }
}

} // namespace recurse
