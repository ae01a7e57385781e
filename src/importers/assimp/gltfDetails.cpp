/** @file
 * Interpolations, node weights and types of joint weights of glTF files.
 */
#include "importers/assimp/gltfDetails.h"

#include <algorithm>

#include "importers/assimp/json.h"
#include "recurse/core/io/byteReader.h"

namespace recurse {

namespace {

constexpr double FLOAT_COMPONENTS = 5126;

/** The JSON chunk of a binary file, which is the first one; else all bytes. */
std::string_view jsonOf(const std::string& name, std::string_view bytes) {
  if (!bytes.starts_with("glTF")) return bytes;
  const ByteReader reader(name, bytes);
  return reader.part(20, reader.at<uint32_t>(12, "the length of the JSON chunk"), "the JSON chunk");
}

/** Name of a node as Assimp forms it. */
std::string nodeName(const JsonValue& file, size_t index) {
  const std::string& name = file["nodes"][index]["name"].text();
  return name.empty() ? "nodes[" + std::to_string(index) + "]" : name;
}

GltfInterpolation interpolationOf(const JsonValue& sampler) {
  const std::string& text = sampler["interpolation"].text();
  return text == "STEP"          ? GltfInterpolation::STEP
         : text == "CUBICSPLINE" ? GltfInterpolation::CUBICSPLINE
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
  const JsonValue file = JsonValue::parse(jsonOf(name, bytes));
  GltfDetails details;
  const auto checkType = [&](const JsonValue& accessor) {
    const JsonValue& type = file["accessors"][accessor.index()]["componentType"];
    if (type.number(FLOAT_COMPONENTS) != FLOAT_COMPONENTS) details.hasIntegers = true;
  };
  for (const JsonValue& animation : file["animations"].elements()) {
    auto& channels = details.animations.emplace_back();
    for (const JsonValue& sampler : animation["samplers"].elements()) checkType(sampler["output"]);
    for (const JsonValue& channel : animation["channels"].elements()) {
      const JsonValue& target = channel["target"];
      channels[{nodeName(file, target["node"].index()), target["path"].text()}] =
          interpolationOf(animation["samplers"][channel["sampler"].index()]);
    }
  }
  for (size_t i = 0; i < file["nodes"].size(); ++i) {
    const JsonValue& weights = file["nodes"][i]["weights"];
    if (weights.size() == 0) continue;
    std::vector<double>& values = details.nodeWeights[nodeName(file, i)];
    for (const JsonValue& weight : weights.elements()) values.push_back(weight.number(0));
  }
  for (const JsonValue& mesh : file["meshes"].elements())
    for (const JsonValue& primitive : mesh["primitives"].elements())
      checkType(primitive["attributes"]["WEIGHTS_0"]);
  return details;
}

} // namespace recurse
