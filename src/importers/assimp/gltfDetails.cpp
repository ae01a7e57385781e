/** @file
 * Interpolations, node weights and types of joint weights of glTF files.
 */
#include "importers/assimp/gltfDetails.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "recurse/core/io/byteReader.h"
#include "recurse/core/io/error.h"

namespace recurse {

namespace {

using Json = nlohmann::json;

constexpr int FLOAT_COMPONENTS = 5126;

const Json ABSENT;

/** Member of an object; null where there is none, so that a path of names needs no checks on its way. */
const Json& member(const Json& value, const char* name) {
  if (!value.is_object()) return ABSENT;
  const auto found = value.find(name);
  return found == value.end() ? ABSENT : *found;
}

/** Elements of an array; none of another value. */
const Json& elements(const Json& value) { return value.is_array() ? value : ABSENT; }

/** Element of an array; null where there is none. */
const Json& element(const Json& array, const Json& index) {
  if (!index.is_number_unsigned() || index.get<uint64_t>() >= elements(array).size()) return ABSENT;
  return array[index.get<size_t>()];
}

std::string text(const Json& value) { return value.is_string() ? value.get<std::string>() : ""; }

/** The JSON chunk of a binary file, which is the first one; else all bytes. */
std::string_view jsonOf(const std::string& name, std::string_view bytes) {
  if (!bytes.starts_with("glTF")) return bytes;
  const ByteReader reader(name, bytes);
  return reader.part(20, reader.at<uint32_t>(12, "the length of the JSON chunk"), "the JSON chunk");
}

/** Name of a node as Assimp forms it. */
std::string nodeName(const Json& file, const Json& index) {
  const std::string name = text(member(element(member(file, "nodes"), index), "name"));
  return name.empty() && index.is_number_unsigned() ? "nodes[" + index.dump() + "]" : name;
}

GltfInterpolation interpolationOf(const Json& sampler) {
  const std::string name = text(member(sampler, "interpolation"));
  return name == "STEP"          ? GltfInterpolation::STEP
         : name == "CUBICSPLINE" ? GltfInterpolation::CUBICSPLINE
                                 : GltfInterpolation::LINEAR;
}

} // namespace

bool GltfDetails::hasSplines() const {
  return std::any_of(animations.begin(), animations.end(), [](const auto& channels) {
    return std::any_of(channels.begin(), channels.end(),
                       [](const auto& channel) { return channel.second == GltfInterpolation::CUBICSPLINE; });
  });
}

GltfDetails readGltfDetails(const std::string& name, std::string_view bytes) {
  const std::string_view json = jsonOf(name, bytes);
  Json file;
  try {
    file = Json::parse(json.begin(), json.end());
  } catch (const Json::exception& e) {
    const std::string_view what =
        e.what(); // such as "[json.exception.parse_error.101] parse error at line 1"
    throw Error("its JSON is not valid: " + std::string(what.substr(what.find(' ') + 1)));
  }
  GltfDetails details;
  const auto checkType = [&](const Json& accessor) {
    const Json& type = member(element(member(file, "accessors"), accessor), "componentType");
    if (type.is_number() && type != FLOAT_COMPONENTS) details.hasIntegers = true;
  };
  for (const Json& animation : elements(member(file, "animations"))) {
    auto& channels = details.animations.emplace_back();
    const Json& samplers = member(animation, "samplers");
    for (const Json& sampler : elements(samplers)) checkType(member(sampler, "output"));
    for (const Json& channel : elements(member(animation, "channels"))) {
      const Json& target = member(channel, "target");
      channels[{nodeName(file, member(target, "node")), text(member(target, "path"))}] =
          interpolationOf(element(samplers, member(channel, "sampler")));
    }
  }
  const size_t nodeCount = elements(member(file, "nodes")).size();
  for (size_t i = 0; i < nodeCount; ++i) {
    const Json& weights = elements(member(file["nodes"][i], "weights"));
    if (weights.empty()) continue;
    std::vector<double>& values = details.nodeWeights[nodeName(file, i)];
    for (const Json& weight : weights) values.push_back(weight.is_number() ? weight.get<double>() : 0);
  }
  for (const Json& mesh : elements(member(file, "meshes")))
    for (const Json& primitive : elements(member(mesh, "primitives")))
      checkType(member(member(primitive, "attributes"), "WEIGHTS_0"));
  return details;
}

} // namespace recurse
