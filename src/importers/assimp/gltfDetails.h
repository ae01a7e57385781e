/** @file
 * Members of glTF files that Assimp 5.2 does not report.
 */
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace recurse {

enum class GltfInterpolation { LINEAR, STEP, CUBICSPLINE };

struct GltfDetails {
  /** Node, and its animated property: translation, rotation, scale or weights. */
  using Channel = std::pair<std::string, std::string>;

  std::vector<std::map<Channel, GltfInterpolation>> animations;
  std::map<std::string, std::vector<double>> nodeWeights; ///< static weights of morph targets, by node
  bool hasIntegers =
      false; ///< true: joint weights or keyframes are integers, which Assimp 5.2 takes for floats

  bool hasSplines() const;
};

inline bool isGltf(const std::string& path) { return path.ends_with(".gltf") || path.ends_with(".glb"); }

/** Details of a .gltf or .glb file. Throws Error where it is not valid. */
GltfDetails readGltfDetails(const std::string& name, std::string_view bytes);

} // namespace recurse
