/** @file
 * Interpolations, node weights and skins of glTF files, and places that Assimp 5.2 misreads.
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
constexpr const char* INTEGERS_ARE_MISREAD =
    " has integers, which Assimp 5.2 takes for floats; export it without compression";

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

/** Number of elements of an accessor; 0 where there is none. */
uint64_t elementCount(const Json& accessor) {
  const Json& count = member(accessor, "count");
  return count.is_number_unsigned() ? count.get<uint64_t>() : 0;
}

std::string placeIn(const std::string& list, size_t index) {
  return list + "[" + std::to_string(index) + "]";
}

class DetailReader {
 public:
  explicit DetailReader(const Json& file) : file(file) {}

  GltfDetails read() {
    const Json& animations = elements(member(file, "animations"));
    for (size_t i = 0; i < animations.size(); ++i) readAnimation(animations[i], placeIn("animations", i));
    readNodes();
    const Json& meshes = elements(member(file, "meshes"));
    for (size_t i = 0; i < meshes.size(); ++i) readMesh(meshes[i], placeIn("meshes", i));
    return std::move(details);
  }

 private:
  const Json& accessor(const Json& index) const { return element(member(file, "accessors"), index); }

  bool hasIntegers(const Json& accessorIndex) const {
    const Json& type = member(accessor(accessorIndex), "componentType");
    return type.is_number() && type != FLOAT_COMPONENTS;
  }

  void addFault(const std::string& fault) {
    if (details.fault.empty()) details.fault = fault;
  }

  /** Assimp 5.2 takes an absent node of a channel for the first one, and unknown properties for translations:
   * those are ignored where no other channel is lost by it. */
  void readAnimation(const Json& animation, const std::string& place) {
    GltfAnimation& made = details.animations.emplace_back();
    std::map<GltfAnimation::Channel, std::string> strays;
    const Json& channels = elements(member(animation, "channels"));
    for (size_t i = 0; i < channels.size(); ++i) {
      const Json &target = member(channels[i], "target"), &node = member(target, "node");
      const std::string path = text(member(target, "path"));
      const bool isProperty =
          path == "translation" || path == "rotation" || path == "scale" || path == "weights";
      const GltfAnimation::Channel channel(nodeName(file, node.is_null() ? Json(0U) : node),
                                           isProperty ? path : "translation");
      const Json& index = member(channels[i], "sampler");
      const Json& sampler = element(member(animation, "samplers"), index);
      const std::string samplerPlace = place + ".samplers[" + index.dump() + "]";
      const GltfInterpolation interpolation = interpolationOf(sampler);
      const Json &input = member(sampler, "input"), &output = member(sampler, "output");
      if (interpolation == GltfInterpolation::CUBICSPLINE &&
          elementCount(accessor(output)) / 3 < elementCount(accessor(input)))
        addFault(samplerPlace + " has fewer than the three values that a keyframe of CUBICSPLINE has");
      if (!isProperty || node.is_null()) {
        strays[channel] = placeIn(place + ".channels", i);
        continue;
      }
      strays.erase(channel);
      made.channels[channel] = interpolation;
      if (made.misread.empty() && (hasIntegers(input) || hasIntegers(output)))
        made.misread = samplerPlace + INTEGERS_ARE_MISREAD;
    }
    for (const auto& [channel, strayPlace] : strays)
      if (made.misread.empty() && (channel.second != "translation" || made.channels.contains(channel)))
        made.misread = strayPlace + " has no node or an unknown property; Assimp 5.2 takes it for the " +
                       channel.second + " of \"" + channel.first + "\"";
  }

  void readNodes() {
    const Json& nodes = elements(member(file, "nodes"));
    std::map<uint64_t, const Json*> skins; // skins by mesh
    for (size_t i = 0; i < nodes.size(); ++i) {
      const std::string name = nodeName(file, i);
      if (member(nodes[i], "rotation").is_null() && member(nodes[i], "matrix").is_null())
        details.unrotatedNodes.insert(name);
      const Json &weights = elements(member(nodes[i], "weights")), &mesh = member(nodes[i], "mesh");
      for (const Json& weight : weights)
        details.nodeWeights[name].push_back(weight.is_number() ? weight.get<double>() : 0);
      if (!mesh.is_number_unsigned()) continue;
      const Json& skin = member(nodes[i], "skin");
      checkSkin(skin);
      const auto [found, isNew] = skins.emplace(mesh.get<uint64_t>(), &skin);
      if (!isNew && *found->second != skin) details.meshesOfSeveralSkins.insert(meshName(mesh));
    }
  }

  std::string meshName(const Json& index) const {
    const std::string name = text(member(element(member(file, "meshes"), index), "name"));
    return name.empty() ? "meshes[" + index.dump() + "]" : name;
  }

  void checkSkin(const Json& index) {
    const Json& skin = element(member(file, "skins"), index);
    const Json& matrices = accessor(member(skin, "inverseBindMatrices"));
    if (!skin.is_null() &&
        (matrices.is_null() || elementCount(matrices) < elements(member(skin, "joints")).size()))
      addFault("skins[" + index.dump() +
               "] has no inverse bind matrix for each joint, which Assimp 5.2 needs");
  }

  void readMesh(const Json& mesh, const std::string& place) {
    const Json& primitives = elements(member(mesh, "primitives"));
    for (size_t i = 0; i < primitives.size(); ++i) {
      const Json& attributes = member(primitives[i], "attributes");
      for (const auto& [name, index] : attributes.items()) {
        if (!name.starts_with("WEIGHTS_") || !hasIntegers(index) || !details.misreadWeights.empty()) continue;
        details.misreadWeights = placeIn(place + ".primitives", i) + ".attributes.";
        details.misreadWeights += name + INTEGERS_ARE_MISREAD;
      }
    }
  }

  const Json& file;
  GltfDetails details;
};

} // namespace

bool GltfAnimation::moves(const std::string& node) const {
  const auto found = channels.lower_bound({node, ""});
  return found != channels.end() && found->first.first == node;
}

bool GltfAnimation::hasSplines() const {
  return std::any_of(channels.begin(), channels.end(),
                     [](const auto& channel) { return channel.second == GltfInterpolation::CUBICSPLINE; });
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
  return DetailReader(file).read();
}

} // namespace recurse
