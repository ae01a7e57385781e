/** @file
 * Members of glTF files that Assimp 5.2 does not report.
 */
#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "recurse/core/io/text.h"

namespace recurse {

enum class GltfInterpolation { LINEAR, STEP, CUBICSPLINE };

struct GltfAnimation {
  /** Node, and its animated property: translation, rotation, scale or weights. */
  using Channel = std::pair<std::string, std::string>;

  std::map<Channel, GltfInterpolation> channels;
  std::string misread; ///< keyframes that Assimp 5.2 takes for others; empty: none

  bool moves(const std::string& node) const;
  bool hasSplines() const;
};

struct GltfDetails {
  std::vector<GltfAnimation> animations;
  std::map<std::string, std::vector<double>> nodeWeights; ///< static weights of morph targets, by node
  std::set<std::string> unrotatedNodes;                   ///< nodes without static rotation and matrix
  std::set<std::string> meshesOfSeveralSkins;             ///< Assimp 5.2 keeps the last skin of a mesh
  std::string fault;          ///< place where Assimp 5.2 reads beyond its data; empty: none
  std::string misreadWeights; ///< joint weights that are integers, which Assimp 5.2 takes for floats
};

/** Whether a file is a glTF file by its name, as Assimp decides. */
inline bool isGltf(const std::string& path) {
  const std::string name = lowerCase(path);
  return name.ends_with(".gltf") || name.ends_with(".glb");
}

/** Details of a .gltf or .glb file. Throws Error where its JSON is not valid. */
GltfDetails readGltfDetails(const std::string& name, std::string_view bytes);

} // namespace recurse
