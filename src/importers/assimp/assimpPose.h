/** @file
 * Pose of a model that Assimp has read: placements of its nodes, and vertices of meshes with a skeleton or
 * morph targets, at a time of an animation.
 */
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "importers/assimp/gltfDetails.h"
#include "recurse/core/math/vector.h"
#include "recurse/model/mesh/triangleMesh.h"

struct aiMesh;
struct aiMeshMorphAnim;
struct aiNode;
struct aiNodeAnim;
struct aiScene;

namespace recurse {

/** Time of an animation, limited to the keyframes of each of its channels. */
struct AnimationTime {
  std::optional<unsigned> animation; ///< index in the scene; none: the model has no animation
  double seconds = 0;
};

class AssimpPose {
 public:
  /** `world`: transform above the root node. Without `time`, the nodes have the transforms of the file and
   * the vertices are those of the meshes. `gltf`: details of a glTF file; null for other formats. */
  AssimpPose(const aiScene& scene, const Mat4d& world, const std::optional<AnimationTime>& time,
             const GltfDetails* gltf);

  const Mat4d& placement(const aiNode& node) const { return byNode.at(&node); }
  /** Placement of the node of this name; identity where there is none. */
  Mat4d placement(const std::string& name) const;

  /** Whether bones place the vertices of a mesh: then deform() returns them in the space of the scene. */
  bool isSkinned(const aiMesh& mesh) const;
  bool isDeformed(const aiMesh& mesh) const;
  /** Applies morph targets, then bones, to the vertices and normals of a mesh. Vertices without bone weights
   * follow the node. Needs the triangles too. */
  void deform(const aiMesh& mesh, const aiNode& node, MeshData& data);

  /** Bones without a node, whose weights count for nothing. */
  const std::set<std::string>& bonesWithoutNode() const { return missingBones; }
  /** Names of channels and bones that several nodes have: all of them move, and the last one is the bone. */
  std::vector<std::string> ambiguousNames() const;

 private:
  void place(const aiNode& node, const Mat4d& parent);
  Mat4d localTransform(const aiNode& node) const;
  /** Details of the animation; null where there are none. */
  const GltfAnimation* gltfAnimation() const;
  bool isStep(const std::string& node, const char* property) const;
  /** Whether Assimp has the static value of a property in place of keyframes. */
  bool isStatic(const std::string& node, const char* property) const;
  std::vector<double> morphWeights(const aiMesh& mesh, const aiNode& node) const;
  void morph(const aiMesh& mesh, const aiNode& node, MeshData& data) const;
  void skin(const aiMesh& mesh, const aiNode& node, MeshData& data);

  const aiScene& scene;
  const bool isPosed;
  const GltfDetails* const gltf;
  std::optional<unsigned> animationIndex;
  double ticks = 0;
  std::map<std::string, const aiNodeAnim*> channels;           ///< by name of the node
  std::map<std::string, const aiMeshMorphAnim*> morphChannels; ///< by name of the node
  std::map<const aiNode*, Mat4d> byNode;
  std::map<std::string, Mat4d> byName;
  std::map<std::string, int> nameCounts;
  std::set<std::string> missingBones;
};

} // namespace recurse
