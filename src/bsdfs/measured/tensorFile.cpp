/** @file
 * Reader of the field table of a tensor file: name, type, offset in the file and extents of each field.
 */
#include "bsdfs/measured/tensorFile.h"

#include <array>

namespace recurse {

namespace {

constexpr std::string_view MAGIC("tensor_file", 12); ///< includes the zero byte
constexpr uint64_t HEADER = 18;                      ///< magic, version, number of fields
enum Type : uint8_t { UINT8 = 1, FLOAT32 = 10, LAST_TYPE = 11 };

/** Names of the types of the format, and their sizes [bytes]. */
constexpr std::array<const char*, LAST_TYPE + 1> TYPE_NAMES = {"",      "uint8",   "int8",    "uint16",
                                                               "int16", "uint32",  "int32",   "uint64",
                                                               "int64", "float16", "float32", "float64"};
constexpr std::array<uint64_t, LAST_TYPE + 1> TYPE_BYTES = {0, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8};

std::string shapeText(const std::vector<uint64_t>& shape) {
  std::string text;
  for (const uint64_t n : shape)
    text += (text.empty() ? "" : " x ") + (n == TensorFile::ANY ? std::string("n") : std::to_string(n));
  return text.empty() ? "a single number" : text;
}

} // namespace

std::vector<float> FloatTensor::values() const {
  std::vector<float> all(size());
  if (!all.empty()) std::memcpy(all.data(), bytes.data(), bytes.size());
  return all;
}

bool TensorFile::isTensorFile(std::string_view bytes) { return bytes.starts_with(MAGIC); }

TensorFile::TensorFile(const std::string& name, std::string_view bytes) : in(name, bytes) {
  if (!isTensorFile(bytes)) in.fail(0, "this is not a tensor file");
  const auto major = in.at<uint8_t>(12, "the version"), minor = in.at<uint8_t>(13, "the version");
  if (major != 1 || minor != 0)
    in.fail(12, "version " + std::to_string(major) + "." + std::to_string(minor) + "; 1.0 is read");
  const auto count = in.at<uint32_t>(14, "the number of fields");
  uint64_t at = HEADER;
  for (uint32_t i = 0; i < count; ++i) at = readField(at);
}

uint64_t TensorFile::readField(uint64_t at) {
  const uint64_t begin = at;
  const auto length = in.at<uint16_t>(at, "the length of a field's name");
  const std::string name(in.part(at + 2, length, "the name of a field"));
  at += 2 + uint64_t(length);
  const auto dimensions = in.at<uint16_t>(at, "a number of dimensions");
  Field field;
  field.type = in.at<uint8_t>(at + 2, "a type");
  field.offset = in.at<uint64_t>(at + 3, "the offset of a field");
  if (field.type == 0 || field.type > LAST_TYPE)
    in.fail(at + 2, "\"" + name + "\" is of type " + std::to_string(field.type) + "; there are 1 to " +
                        std::to_string(LAST_TYPE));
  at += 11;
  uint64_t bytes = TYPE_BYTES[field.type];
  for (int d = 0; d < dimensions; ++d, at += 8) {
    const auto extent = in.at<uint64_t>(at, "an extent");
    if (extent == 0) in.fail(at, "\"" + name + "\" has an extent of 0");
    if (extent > in.size() / bytes)
      in.fail(at, "\"" + name + "\" would be larger than the file, which has " + std::to_string(in.size()) +
                      " bytes");
    bytes *= extent;
    field.shape.push_back(extent);
  }
  in.part(field.offset, bytes, ("\"" + name + "\"").c_str());
  if (!fields.emplace(name, std::move(field)).second) in.fail(begin, "\"" + name + "\" occurs twice");
  return at;
}

void TensorFile::fail(const std::string& field, const std::string& what) const {
  const auto found = fields.find(field);
  in.fail(found == fields.end() ? 0 : found->second.offset, "\"" + field + "\" " + what);
}

const TensorFile::Field& TensorFile::find(const std::string& name, uint8_t type,
                                          const std::vector<uint64_t>& shape) const {
  const auto found = fields.find(name);
  if (found == fields.end()) {
    std::string names;
    for (const auto& [other, field] : fields) names += (names.empty() ? "" : ", ") + other;
    throw Error(in.source() + ": there is no field \"" + name +
                "\"; there are: " + (names.empty() ? "none" : names));
  }
  const Field& field = found->second;
  if (field.type != type)
    fail(name, std::string("is of type ") + TYPE_NAMES[field.type] + "; " + TYPE_NAMES[type] + " is read");
  bool fits = field.shape.size() == shape.size();
  for (size_t i = 0; fits && i < shape.size(); ++i) fits = shape[i] == ANY || shape[i] == field.shape[i];
  if (!fits) fail(name, "is " + shapeText(field.shape) + "; it must be " + shapeText(shape));
  return field;
}

FloatTensor TensorFile::floats(const std::string& name, const std::vector<uint64_t>& shape) const {
  const Field& field = find(name, FLOAT32, shape);
  uint64_t count = 1;
  for (const uint64_t extent : field.shape) count *= extent;
  FloatTensor tensor(field.shape, in.part(field.offset, count * sizeof(float), name.c_str()));
  for (size_t i = 0; i < tensor.size(); ++i)
    if (!std::isfinite(tensor[i]))
      in.fail(field.offset + i * sizeof(float), "a value of \"" + name + "\" is not finite");
  return tensor;
}

uint8_t TensorFile::byte(const std::string& name) const {
  return in.at<uint8_t>(find(name, UINT8, {1}).offset, name.c_str());
}

} // namespace recurse
