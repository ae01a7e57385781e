/** @file
 * Tensor files: named arrays of numbers in one file, the format of the material database of EPFL's RGL.
 */
#pragma once

#include <map>
#include <string>
#include <vector>

#include "recurse/core/io/byteReader.h"

namespace recurse {

/** Finite numbers of single precision in the bytes of a file. */
class FloatTensor {
 public:
  FloatTensor(std::vector<uint64_t> shape, std::string_view bytes)
      : dimensions(std::move(shape)), bytes(bytes) {}
  size_t shape(size_t dimension) const { return static_cast<size_t>(dimensions[dimension]); }
  size_t size() const { return bytes.size() / sizeof(float); }
  float operator[](size_t i) const {
    float x;
    std::memcpy(&x, &bytes[i * sizeof x], sizeof x);
    return x;
  }
  std::vector<float> values() const;

 private:
  std::vector<uint64_t> dimensions;
  std::string_view bytes;
};

class TensorFile {
 public:
  /** Any extent of a dimension. */
  static constexpr uint64_t ANY = 0;

  static bool isTensorFile(std::string_view bytes);
  /** Throws Error for bytes that are not a tensor file. The bytes must outlive the object. */
  TensorFile(const std::string& name, std::string_view bytes);

  bool has(const std::string& field) const { return fields.contains(field); }
  /** Field of floats with the given extents. Throws Error where it is missing or of wrong type or shape. */
  FloatTensor floats(const std::string& field, const std::vector<uint64_t>& shape) const;
  /** A field of one byte. */
  uint8_t byte(const std::string& field) const;
  [[noreturn]] void fail(const std::string& field, const std::string& what) const;

 private:
  struct Field {
    uint8_t type;
    uint64_t offset;
    std::vector<uint64_t> shape;
  };
  uint64_t readField(uint64_t at);
  const Field& find(const std::string& field, uint8_t type, const std::vector<uint64_t>& shape) const;

  ByteReader in;
  std::map<std::string, Field> fields;
};

} // namespace recurse
