/** @file
 * Keyframe animation, morph targets and linear-blend skinning of Assimp's scenes.
 */
#include "importers/assimp/assimpPose.h"

#include <algorithm>
#include <cmath>

#include <assimp/scene.h>
#include <glm/gtc/quaternion.hpp>

#include "importers/assimp/assimpVectors.h"
#include "recurse/core/math/affine.h"

namespace recurse {

namespace {

/** Rate of formats that do not state one, as Assimp assumes [ticks/second]. */
constexpr double USUAL_TICKS_PER_SECOND = 25;

double ticksAt(const aiAnimation& animation, double seconds) {
  const double rate = animation.mTicksPerSecond;
  return seconds * (rate > 0 ? rate : USUAL_TICKS_PER_SECOND);
}

double fractionBetween(double start, double end, double time) {
  const double fraction = (time - start) / (end - start);
  return fraction > 0 ? std::min(fraction, 1.0) : 0; // 0 for NaN, of equal times
}

Vec3d keyValue(const aiVectorKey& key) { return vectorOf(key.mValue); }
glm::dquat keyValue(const aiQuatKey& key) {
  return glm::normalize(
      glm::dquat(double(key.mValue.w), double(key.mValue.x), double(key.mValue.y), double(key.mValue.z)));
}
Vec3d interpolate(const Vec3d& a, const Vec3d& b, double t) { return glm::mix(a, b, t); }
glm::dquat interpolate(const glm::dquat& a, const glm::dquat& b, double t) { return glm::slerp(a, b, t); }

/** Value at a time; that of the first key before it, and of the last key after it. `count` > 0. Values of
 * steps stay until the next key. */
template <class Key> auto valueAt(const Key* keys, unsigned count, double time, bool isStep) {
  const Key* next =
      std::upper_bound(keys, keys + count, time, [](double t, const Key& key) { return t < key.mTime; });
  if (next == keys) return keyValue(keys[0]);
  if (isStep || next == keys + count) return keyValue(next[-1]);
  return interpolate(keyValue(next[-1]), keyValue(*next), fractionBetween(next[-1].mTime, next->mTime, time));
}

/** Index in a key of the weight of a morph target; `mNumValuesAndWeights` where the key does not have it. */
unsigned weightIndex(const aiMeshMorphKey& key, unsigned target) {
  return static_cast<unsigned>(std::find(key.mValues, key.mValues + key.mNumValuesAndWeights, target) -
                               key.mValues);
}

/** Weight of a morph target at a time, between the keys that have it: those of FBX have only the targets
 * with a keyframe at their time. */
double weightAt(const aiMeshMorphAnim& channel, unsigned target, double time, bool isStep, double otherwise) {
  double startTime = 0, startWeight = 0;
  bool hasStart = false;
  for (unsigned i = 0; i < channel.mNumKeys; ++i) {
    const aiMeshMorphKey& key = channel.mKeys[i];
    const unsigned k = weightIndex(key, target);
    if (k == key.mNumValuesAndWeights) continue;
    if (key.mTime > time) {
      if (!hasStart) return key.mWeights[k];
      const double fraction = isStep ? 0 : fractionBetween(startTime, key.mTime, time);
      return glm::mix(startWeight, key.mWeights[k], fraction);
    }
    startTime = key.mTime;
    startWeight = key.mWeights[k];
    hasStart = true;
  }
  return hasStart ? startWeight : otherwise;
}

/** Inverse transpose of a matrix but for a positive factor; also where the matrix is singular. */
Mat3d normalMatrix(const Mat3d& m) {
  const Mat3d cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
  return glm::dot(m[0], cofactors[0]) < 0 ? -cofactors : cofactors;
}

/** `n` with unit length; `otherwise` where it has no direction. */
Vec3d unitVector(const Vec3d& n, const Vec3d& otherwise) {
  const double length = glm::length(n);
  return length > 0 && std::isfinite(length) ? n / length : otherwise;
}

} // namespace

AssimpPose::AssimpPose(const aiScene& scene, const Mat4d& world, const std::optional<AnimationTime>& time,
                       const GltfDetails* gltf)
    : scene(scene), isPosed(time.has_value()), gltf(gltf) {
  if (time && time->animation) {
    animationIndex = time->animation;
    const aiAnimation& animation = *scene.mAnimations[*animationIndex];
    // Assimp's keyframes of glTF have these roundings.
    ticks = gltf ? double(static_cast<float>(time->seconds) * 1000.F) : ticksAt(animation, time->seconds);
    for (unsigned i = 0; i < animation.mNumChannels; ++i)
      channels[animation.mChannels[i]->mNodeName.C_Str()] = animation.mChannels[i];
    for (unsigned i = 0; i < animation.mNumMorphMeshChannels; ++i)
      morphChannels[animation.mMorphMeshChannels[i]->mName.C_Str()] = animation.mMorphMeshChannels[i];
  }
  place(*scene.mRootNode, world);
}

void AssimpPose::place(const aiNode& node, const Mat4d& parent) {
  const Mat4d placement = parent * localTransform(node);
  byNode[&node] = placement;
  byName[node.mName.C_Str()] = placement;
  ++nameCounts[node.mName.C_Str()];
  for (unsigned i = 0; i < node.mNumChildren; ++i) place(*node.mChildren[i], placement);
}

const GltfAnimation* AssimpPose::gltfAnimation() const {
  return gltf && animationIndex && *animationIndex < gltf->animations.size()
             ? &gltf->animations[*animationIndex]
             : nullptr;
}

bool AssimpPose::isStep(const std::string& node, const char* property) const {
  const GltfAnimation* animation = gltfAnimation();
  if (!animation) return false;
  const auto found = animation->channels.find({node, property});
  return found != animation->channels.end() && found->second == GltfInterpolation::STEP;
}

bool AssimpPose::isStatic(const std::string& node, const char* property) const {
  const GltfAnimation* animation = gltfAnimation();
  return animation && !animation->channels.contains({node, property});
}

Mat4d AssimpPose::localTransform(const aiNode& node) const {
  const std::string name = node.mName.C_Str();
  const auto found = channels.find(name);
  const GltfAnimation* details = gltfAnimation();
  if (found == channels.end() || (details && !details->moves(name))) return matrixOf(node.mTransformation);
  const aiNodeAnim& channel = *found->second;
  // Components without keys have those of the node's matrix. Assimp does the same, and takes a mirrored
  // matrix for a rotation with three negative scales.
  aiVectorKey position, scale;
  aiQuatKey rotation;
  node.mTransformation.Decompose(scale.mValue, rotation.mValue, position.mValue);
  const auto at = [&](const auto* keys, unsigned count, const auto& otherwise, const char* property) {
    return count > 0 ? valueAt(keys, count, ticks, isStep(name, property)) : keyValue(otherwise);
  };
  const bool isUnrotated = isStatic(name, "rotation") && gltf->unrotatedNodes.contains(name);
  const Mat3d turn =
      isUnrotated ? Mat3d(1)
                  : glm::mat3_cast(at(channel.mRotationKeys, channel.mNumRotationKeys, rotation, "rotation"));
  const Vec3d size = at(channel.mScalingKeys, channel.mNumScalingKeys, scale, "scale");
  const unsigned positionKeys = isStatic(name, "translation") ? 0 : channel.mNumPositionKeys;
  Mat4d local(Mat3d(turn[0] * size.x, turn[1] * size.y, turn[2] * size.z));
  local[3] = Vec4d(at(channel.mPositionKeys, positionKeys, position, "translation"), 1);
  return local;
}

Mat4d AssimpPose::placement(const std::string& name) const {
  const auto found = byName.find(name);
  return found == byName.end() ? Mat4d(1) : found->second;
}

bool AssimpPose::isSkinned(const aiMesh& mesh) const { return isPosed && mesh.mNumBones > 0; }

bool AssimpPose::isDeformed(const aiMesh& mesh) const {
  return isPosed && (mesh.mNumBones > 0 || mesh.mNumAnimMeshes > 0);
}

void AssimpPose::deform(const aiMesh& mesh, const aiNode& node, MeshData& data) {
  if (!isDeformed(mesh)) return;
  morph(mesh, node, data);
  if (isSkinned(mesh)) skin(mesh, node, data);
}

std::vector<double> AssimpPose::morphWeights(const aiMesh& mesh, const aiNode& node) const {
  const unsigned count = mesh.mNumAnimMeshes;
  const std::string name = node.mName.C_Str();
  std::vector<double> weights(count, 0);
  // Assimp 5.2 reads neither the morph targets of COLLADA nor the static weights of FBX, where channels of
  // one shape have ones.
  if (gltf) {
    for (unsigned i = 0; i < count; ++i) weights[i] = double(mesh.mAnimMeshes[i]->mWeight);
    const auto ofNode = gltf->nodeWeights.find(name);
    if (ofNode != gltf->nodeWeights.end())
      std::copy_n(ofNode->second.begin(), std::min<size_t>(count, ofNode->second.size()), weights.begin());
  }
  auto found = morphChannels.find(name);
  if (found == morphChannels.end()) found = morphChannels.find(name + "*0"); // the node's first mesh in FBX
  if (found == morphChannels.end()) return weights;
  const aiMeshMorphAnim& channel = *found->second;
  // Of the tangents and weights of a spline, Assimp 5.2 drops one at either end.
  const bool isSpline =
      gltf && count > 1 && channel.mNumKeys > 0 && channel.mKeys[0].mNumValuesAndWeights == 3 * count - 2;
  for (unsigned i = 0; i < count; ++i)
    weights[i] = weightAt(channel, isSpline ? i + count - 1 : i, ticks, isStep(name, "weights"), weights[i]);
  return weights;
}

void AssimpPose::morph(const aiMesh& mesh, const aiNode& node, MeshData& data) const {
  const std::vector<double> weights = morphWeights(mesh, node);
  const std::vector<Vec3d> normals = data.normals;
  for (unsigned target = 0; target < mesh.mNumAnimMeshes; ++target) {
    const aiAnimMesh& shape = *mesh.mAnimMeshes[target];
    if (weights[target] == 0 || shape.mNumVertices != mesh.mNumVertices) continue;
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      if (shape.mVertices)
        data.positions[i] += weights[target] * (vectorOf(shape.mVertices[i]) - vectorOf(mesh.mVertices[i]));
      if (shape.mNormals && !normals.empty())
        data.normals[i] += weights[target] * (vectorOf(shape.mNormals[i]) - normals[i]);
    }
  }
  for (size_t i = 0; i < normals.size(); ++i)
    if (data.normals[i] != normals[i]) data.normals[i] = unitVector(data.normals[i], normals[i]);
}

/** Linear-blend skinning: the transform of a vertex is the mean of its bones' placements, each after the
 * inverse bind matrix. The weights are divided by their sum. Triangles that it mirrors keep their front. */
void AssimpPose::skin(const aiMesh& mesh, const aiNode& node, MeshData& data) {
  std::vector<Mat4d> blends(mesh.mNumVertices, Mat4d(0));
  std::vector<double> sums(mesh.mNumVertices, 0);
  std::vector<bool> mirrored(mesh.mNumVertices);
  for (unsigned b = 0; b < mesh.mNumBones; ++b) {
    const aiBone& bone = *mesh.mBones[b];
    const auto found = byName.find(bone.mName.C_Str());
    if (found == byName.end()) {
      missingBones.insert(bone.mName.C_Str());
      continue;
    }
    const Mat4d transform = found->second * matrixOf(bone.mOffsetMatrix);
    for (unsigned i = 0; i < bone.mNumWeights; ++i) {
      const aiVertexWeight& weight = bone.mWeights[i];
      if (weight.mVertexId >= mesh.mNumVertices || !(weight.mWeight > 0)) continue;
      blends[weight.mVertexId] += double(weight.mWeight) * transform;
      sums[weight.mVertexId] += double(weight.mWeight);
    }
  }
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    const Mat4d blend = sums[i] > 0 ? blends[i] / sums[i] : placement(node);
    mirrored[i] = glm::determinant(Mat3d(blend)) < 0;
    data.positions[i] = transformPoint(blend, data.positions[i]);
    if (data.normals.empty()) continue;
    data.normals[i] = unitVector(normalMatrix(Mat3d(blend)) * data.normals[i], data.normals[i]);
  }
  for (glm::uvec3& triangle : data.triangles)
    if (mirrored[triangle.x]) std::swap(triangle.y, triangle.z);
}

std::vector<std::string> AssimpPose::ambiguousNames() const {
  std::set<std::string> names;
  for (const auto& [name, channel] : channels) names.insert(name);
  for (const auto& [name, channel] : morphChannels) names.insert(name);
  for (unsigned m = 0; isPosed && m < scene.mNumMeshes; ++m)
    for (unsigned b = 0; b < scene.mMeshes[m]->mNumBones; ++b)
      names.insert(scene.mMeshes[m]->mBones[b]->mName.C_Str());
  std::vector<std::string> ambiguous;
  for (const std::string& name : names)
    if (const auto found = nameCounts.find(name); found != nameCounts.end() && found->second > 1)
      ambiguous.push_back(name);
  return ambiguous;
}

} // namespace recurse
