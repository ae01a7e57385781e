/** @file
 * Small glTF files of tests: JSON with all numbers in one buffer.
 */
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace recurse::testing {

class GltfFile {
 public:
  /** Adds an accessor of floats; returns its index. `type`: SCALAR, VEC3, VEC4 or MAT4. */
  int floats(const std::string& type, const std::vector<float>& values) {
    return add(type, 5126, values.data(), values.size() * sizeof(float), values.size());
  }
  /** Adds an accessor of numbers below 256. */
  int bytes(const std::string& type, const std::vector<uint8_t>& values) {
    return add(type, 5121, values.data(), values.size(), values.size());
  }

  /** Text of the file. `members`: scenes, nodes, meshes and so on, as JSON. */
  std::string text(const std::string& members) const {
    return json(members, R"(,"uri":"data:application/octet-stream;base64,)" + base64() + "\"");
  }
  /** Binary file (.glb) with the same contents. */
  std::string binary(const std::string& members) const {
    std::string first = json(members, "");
    first.resize((first.size() + 3) / 4 * 4, ' ');
    const auto length = [](size_t bytes) {
      const auto value = static_cast<uint32_t>(bytes);
      return std::string(reinterpret_cast<const char*>(&value), sizeof value);
    };
    return "glTF" + length(2) + length(28 + first.size() + buffer.size()) + length(first.size()) + "JSON" +
           first + length(buffer.size()) + std::string("BIN\0", 4) + buffer;
  }

 private:
  std::string json(const std::string& members, const std::string& uri) const {
    return R"({"asset":{"version":"2.0"},"scene":0,)" + members + R"(,"accessors":[)" + accessors +
           R"(],"bufferViews":[)" + views + R"(],"buffers":[{"byteLength":)" + std::to_string(buffer.size()) +
           uri + "}]}";
  }

  int add(const std::string& type, int component, const void* data, size_t size, size_t values) {
    const size_t perElement = type == "SCALAR" ? 1 : type == "MAT4" ? 16 : size_t(type.back() - '0');
    const std::string comma = count > 0 ? "," : "";
    accessors += comma + R"({"bufferView":)" + std::to_string(count) + R"(,"componentType":)" +
                 std::to_string(component) + R"(,"count":)" + std::to_string(values / perElement) +
                 R"(,"type":")" + type + "\"}";
    views += comma + R"({"buffer":0,"byteOffset":)" + std::to_string(buffer.size()) + R"(,"byteLength":)" +
             std::to_string(size) + "}";
    buffer.append(static_cast<const char*>(data), size);
    buffer.resize((buffer.size() + 3) / 4 * 4);
    return count++;
  }

  std::string base64() const {
    static constexpr char DIGITS[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (size_t i = 0; i < buffer.size(); i += 3) {
      uint32_t bits = 0;
      for (size_t k = 0; k < 3; ++k)
        bits = bits << 8 | (i + k < buffer.size() ? static_cast<unsigned char>(buffer[i + k]) : 0);
      for (size_t k = 0; k < 4; ++k) out += i + k > buffer.size() ? '=' : DIGITS[bits >> (18 - 6 * k) & 63];
    }
    return out;
  }

  std::string buffer, accessors, views;
  int count = 0;
};

} // namespace recurse::testing
