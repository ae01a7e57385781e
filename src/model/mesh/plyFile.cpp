/** @file
 * Reading of the elements after the header of a PLY file.
 */
#include "recurse/model/mesh/plyFile.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <unordered_map>

#include "model/mesh/plyHeader.h"

namespace recurse {

namespace {

class PlyReader {
 public:
  PlyReader(const FileReference& file, PlyContent content) : in(file), header(readPlyHeader(in, content)) {}

  PlyFile read() {
    for (const PlyElement& e : header.elements) {
      if (&e == &header.vertexElement())
        readVertices();
      else if (&e == &header.faceElement())
        readFaces();
      else
        skipElement(e);
    }
    refuseBrokenCorners();
    for (const auto& [vertex, what] : broken) // a position that does not widen the bounds
      mesh.positions[vertex] = mesh.positions[mesh.triangles.at(0).x];
    return {std::move(mesh), badNormals, broken.size()};
  }

  PlyPoints readPoints() {
    header.uvPlaces.clear();
    for (const PlyElement& e : header.elements) {
      if (&e != &header.vertexElement()) {
        skipElement(e);
        continue;
      }
      readVertices();
      for (const auto& [vertex, what] : broken) refuse(vertex, what);
    }
    return {std::move(mesh.positions), std::move(mesh.normals), std::move(radii)};
  }

 private:
  /** Current position, for messages: a line in text files, else a byte offset. */
  uint64_t currentPlace() const {
    const bool isLine = header.encoding == PlyEncoding::TEXT;
    return !isLine ? in.offset() : reportedLine ? reportedLine : in.lineNumber();
  }
  [[noreturn]] void fail(const std::string& what) const { failAt(currentPlace(), what); }
  [[noreturn]] void failAt(uint64_t place, const std::string& what) const {
    const bool isLine = header.encoding == PlyEncoding::TEXT;
    throw Error(in.name() + (isLine ? ":" : ": at byte ") + std::to_string(place) + ": " + what);
  }

  struct BrokenVertex {
    uint64_t place;
    const char* what;
  };
  [[noreturn]] void refuse(uint32_t vertex, const BrokenVertex& b) const {
    failAt(b.place, "vertex " + std::to_string(vertex) + " has a " + b.what + " that is not finite");
  }
  void refuseBrokenCorners() const {
    if (broken.empty()) return;
    for (const glm::uvec3& t : mesh.triangles)
      for (int k = 0; k < 3; ++k)
        if (const auto found = broken.find(t[k]); found != broken.end()) refuse(t[k], found->second);
  }

  [[noreturn]] void failAtEnd() const {
    fail("the file ends in " + current->name + " " + std::to_string(index) + " of " +
         std::to_string(current->count));
  }

  template <class T> double readBinary() {
    char bytes[sizeof(T)];
    if (!in.read(bytes, sizeof(T))) failAtEnd();
    if (header.encoding == PlyEncoding::BINARY_BIG) std::reverse(bytes, bytes + sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return static_cast<double>(value);
  }

  /** Reads a word of a text file. */
  void readWord() {
    constexpr size_t MAX_DIGITS = 400; // digits of a number, with a margin
    while (isPlyBlank(in.peek())) in.get();
    reportedLine = in.lineNumber();
    word.clear();
    for (int c = in.peek(); c >= 0 && !isPlyBlank(c); c = in.peek()) {
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
      // Underflow gives zero; overflow is for the caller to reject.
      value = std::strtod(begin, nullptr);
    } else if (error != std::errc() || stop != end) {
      fail("\"" + printable(word) + "\" is no number");
    }
    return value;
  }

  double readValue(PlyType type) {
    if (header.encoding == PlyEncoding::TEXT) return readText();
    switch (type) {
    case PlyType::INT8:
      return readBinary<int8_t>();
    case PlyType::UINT8:
      return readBinary<uint8_t>();
    case PlyType::INT16:
      return readBinary<int16_t>();
    case PlyType::UINT16:
      return readBinary<uint16_t>();
    case PlyType::INT32:
      return readBinary<int32_t>();
    case PlyType::UINT32:
      return readBinary<uint32_t>();
    case PlyType::FLOAT32:
      return readBinary<float>();
    case PlyType::FLOAT64:
      break;
    }
    return readBinary<double>();
  }

  uint64_t readListLength(const PlyProperty& p) {
    const double n = readValue(p.countType);
    if (!(n >= 0 && n <= double(std::numeric_limits<uint32_t>::max())) || n != std::floor(n))
      fail(current->name + " " + std::to_string(index) + " has a list of an impossible length");
    return static_cast<uint64_t>(n);
  }

  void skipValues(PlyType type, uint64_t count) {
    if (header.encoding == PlyEncoding::TEXT) {
      for (uint64_t i = 0; i < count; ++i) readWord();
    } else if (!in.skip(count * sizeOf(type))) {
      failAtEnd();
    }
  }

  void skipProperty(const PlyProperty& p) { skipValues(p.type, p.isList ? readListLength(p) : 1); }

  void skipElement(const PlyElement& e) {
    if (e.properties.empty()) return; // elements without properties take no bytes
    current = &e;
    for (index = 0; index < e.count; ++index)
      for (const PlyProperty& p : e.properties) skipProperty(p);
  }

  /** Number of elements to reserve memory for: the declared count, less if the file is too short for it. */
  size_t roomFor(const PlyElement& e) const {
    uint64_t bytesEach = 0;
    for (const PlyProperty& p : e.properties)
      bytesEach += header.encoding == PlyEncoding::TEXT ? 2 : sizeOf(p.isList ? p.countType : p.type);
    const uint64_t fileBytes = in.storedBytes();
    // Few meshes compress better than this; for one that does, the arrays grow while reading.
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
      if (!std::isfinite(v[i]) && places == header.normalPlaces) {
        ++badNormals;
        return V(0); // no normal: the face normal is used
      }
      if (!std::isfinite(v[i])) { // an error only where a face uses the vertex
        broken.emplace(static_cast<uint32_t>(index), BrokenVertex{currentPlace(), what});
        return V(0);
      }
    }
    return v;
  }

  void readVertices() {
    current = &header.vertexElement();
    const size_t room = roomFor(header.vertexElement());
    mesh.positions.reserve(room);
    if (!header.normalPlaces.empty()) mesh.normals.reserve(room);
    if (!header.uvPlaces.empty()) mesh.uvs.reserve(room);
    const std::vector<PlyProperty>& properties = header.vertexElement().properties;
    std::vector<double> values(properties.size());
    for (index = 0; index < header.vertexElement().count; ++index) {
      for (size_t i = 0; i < properties.size(); ++i) {
        if (properties[i].isList)
          skipProperty(properties[i]);
        else
          values[i] = readValue(properties[i].type);
      }
      mesh.positions.push_back(pickVector<Vec3d>(values, header.positionPlaces, "position"));
      if (!header.normalPlaces.empty())
        mesh.normals.push_back(pickVector<Vec3d>(values, header.normalPlaces, "normal"));
      if (header.radiusPlace >= 0) radii.push_back(values[size_t(header.radiusPlace)]);
      if (!header.uvPlaces.empty())
        mesh.uvs.push_back(pickVector<Vec2d>(values, header.uvPlaces, "texture coordinate"));
    }
  }

  void readFaces() {
    current = &header.faceElement();
    mesh.triangles.reserve(roomFor(header.faceElement()));
    for (index = 0; index < header.faceElement().count; ++index) {
      for (size_t i = 0; i < header.faceElement().properties.size(); ++i) {
        const PlyProperty& p = header.faceElement().properties[i];
        if (static_cast<int>(i) == header.indexPlace)
          readFace(p);
        else
          skipProperty(p);
      }
    }
  }

  /** A polygon becomes a fan of triangles around its first vertex. */
  void readFace(const PlyProperty& p) {
    const uint64_t n = readListLength(p);
    if (n < 3)
      fail("face " + std::to_string(index) + " has " + std::to_string(n) +
           (n == 1 ? " vertex" : " vertices"));
    uint32_t first = 0, previous = 0;
    for (uint64_t k = 0; k < n; ++k) {
      const double value = readValue(p.type);
      if (!(value >= 0 && value < double(header.vertexElement().count)) || value != std::floor(value)) {
        const std::string shown = header.encoding == PlyEncoding::TEXT ? printable(word)
                                  : std::abs(value) < 1e15 ? std::to_string(static_cast<int64_t>(value))
                                                           : std::to_string(value);
        fail("face " + std::to_string(index) + " names vertex " + shown + "; there are 0 to " +
             std::to_string(header.vertexElement().count - 1));
      }
      const auto vertex = static_cast<uint32_t>(value);
      if (k == 0) first = vertex;
      if (k >= 2) mesh.triangles.emplace_back(first, previous, vertex);
      previous = vertex;
    }
    if (mesh.triangles.size() >= std::numeric_limits<uint32_t>::max()) fail("there are too many faces");
  }

  CompressedFile in;
  PlyHeader header;
  MeshData mesh;
  uint64_t badNormals = 0; ///< number of normals that are not finite
  std::unordered_map<uint32_t, BrokenVertex> broken;
  std::vector<double> radii;

  // Position in the file, for messages.
  uint64_t reportedLine = 0; ///< line of the last word; 0: the current line
  const PlyElement* current = nullptr;
  uint64_t index = 0;
  std::string word;
};

} // namespace

PlyFile readPly(const FileReference& file) { return PlyReader(file, PlyContent::MESH).read(); }

PlyPoints readPlyPoints(const FileReference& file) {
  return PlyReader(file, PlyContent::POINTS).readPoints();
}

} // namespace recurse
