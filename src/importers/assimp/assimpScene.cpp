/** @file
 * Conversion of Assimp's scenes to pieces of a scene.
 */
#include "importers/assimp/assimpScene.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <optional>
#include <set>

#include <assimp/scene.h>

#include "importers/assimp/assimpMaterials.h"
#include "importers/assimp/assimpPose.h"
#include "importers/assimp/assimpVectors.h"
#include "recurse/core/io/text.h"
#include "recurse/core/math/affine.h"

namespace recurse {

namespace {

bool isFloat(const Vec3d& v) { // false for NaN
  return glm::all(glm::lessThanEqual(glm::abs(v), Vec3d(double(FLT_MAX))));
}

std::string counted(size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

class AssimpSceneImport {
 public:
  AssimpSceneImport(const aiScene& scene, const std::string& path, const Parameters& p,
                    const ImportContext& context, const GltfDetails* gltf, SceneImport& import)
      : scene(scene), p(p), gltf(gltf), import(import), out(import, context), path(path),
        materials(scene, path, p, import, out), materialsWanted(p.boolean("materials")),
        lightsWanted(p.boolean("lights")), isGltfFile(isGltf(path)), uses(scene.mNumMeshes),
        objects(scene.mNumMeshes) {}

  void run() {
    if (scene.mNumMeshes == 0) fail("it has no faces");
    countUses(*scene.mRootNode, 0);
    chooseTime();
    pose.emplace(scene, axes(), time, gltf);
    addNode(*scene.mRootNode);
    warnOfPose();
    if (triangles == 0) fail("no node uses its triangles");
    addLights();
    addCameras();
    note();
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    p.fail("filename", path + ": cannot be used: " + what);
  }

  // ---- animation

  std::string animationName(unsigned index) const {
    const std::string name = scene.mAnimations[index]->mName.C_Str();
    return name.empty() ? "animation " + std::to_string(index + 1) : name;
  }

  /** Sets the animation and time that the parameters choose; none without them. */
  void chooseTime() {
    if (!wantsPose(p)) return;
    time = AnimationTime{std::nullopt, p.has("time") ? p.real("time") : 0};
    std::string names;
    for (unsigned i = 0; i < scene.mNumAnimations && !time->animation; ++i) {
      const std::string name = animationName(i);
      if (!p.has("animation") || name == p.string("animation")) time->animation = i;
      names += (names.empty() ? "" : ", ") + sceneText(name);
    }
    if (!time->animation) reportMissingAnimation(p, path, names);
    if (gltf) checkDetails();
  }

  void checkDetails() const {
    if (!gltf->misreadWeights.empty()) fail(gltf->misreadWeights);
    for (const std::string& mesh : gltf->meshesOfSeveralSkins)
      p.warn("time", path + ": nodes show the mesh " + sceneText(mesh) +
                         " with different skins or without; Assimp 5.2 reads one of them, and the other "
                         "nodes are left out");
    if (!time->animation || *time->animation >= gltf->animations.size()) return;
    const std::string name = "animation " + sceneText(animationName(*time->animation));
    const GltfAnimation& animation = gltf->animations[*time->animation];
    if (!animation.misread.empty()) fail(name + ": " + animation.misread);
    if (animation.hasSplines())
      p.warn("time", path + ": " + name + ": its CUBICSPLINE keyframes are interpolated linearly");
  }

  void warnOfPose() const {
    for (const std::string& name : pose->ambiguousNames())
      p.warn("time", path + ": several nodes that the pose needs are called " + sceneText(name));
    for (const std::string& name : pose->bonesWithoutNode())
      p.warn("time", path + ": the bone " + sceneText(name) + " has no node, and moves nothing");
  }

  // ---- geometry

  static constexpr int MAX_DEPTH = 1000;

  void countUses(const aiNode& node, int depth) {
    if (depth > MAX_DEPTH) fail("its nodes are nested too deeply");
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      if (node.mMeshes[i] >= scene.mNumMeshes) fail("a node names a mesh that does not exist");
      ++uses[node.mMeshes[i]];
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i) countUses(*node.mChildren[i], depth + 1);
  }

  int metadata(const char* key, int otherwise) const {
    int32_t value = otherwise;
    return scene.mMetaData && scene.mMetaData->Get(key, value) ? value : otherwise;
  }

  /** Axes of the model. FBX has the directions of its axes and the centimetres of a unit in its metadata;
   * all other formats have y up. */
  Mat4d axes() const {
    if (!scene.mMetaData || !scene.mMetaData->HasKey("UpAxis")) return Mat4d(1);
    const int axis[3] = {metadata("CoordAxis", 0), metadata("UpAxis", 1), metadata("FrontAxis", 2)};
    const int sign[3] = {metadata("CoordAxisSign", 1), metadata("UpAxisSign", 1),
                         metadata("FrontAxisSign", 1)};
    float centimetres = 0;
    double precise = 0;
    if (!scene.mMetaData->Get("UnitScaleFactor", centimetres) &&
        scene.mMetaData->Get("UnitScaleFactor", precise))
      centimetres = static_cast<float>(precise);
    const double scale = centimetres > 0 ? double(centimetres) / 100 : 1;
    Mat4d m(0);
    for (int row = 0; row < 3; ++row) {
      if (axis[row] < 0 || axis[row] > 2) return Mat4d(1);
      m[axis[row]][row] = (sign[row] < 0 ? -1 : 1) * scale;
    }
    m[3][3] = 1;
    return glm::determinant(m) == 0 ? Mat4d(1) : m;
  }

  void addNode(const aiNode& node) {
    for (unsigned i = 0; i < node.mNumMeshes; ++i) addMesh(node.mMeshes[i], node);
    for (unsigned i = 0; i < node.mNumChildren; ++i) addNode(*node.mChildren[i]);
  }

  void addMesh(unsigned index, const aiNode& node) {
    const aiMesh& mesh = *scene.mMeshes[index];
    if (!(mesh.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) || mesh.mNumFaces == 0) return;
    // Nodes with the same skinned mesh would repeat it in the same place.
    if (pose->isSkinned(mesh) && !skinned.insert(&mesh).second) return;
    const Mat4d placement = pose->isSkinned(mesh) ? Mat4d(1) : pose->placement(node);
    if (!isFinite(placement) || !isInvertible(placement)) {
      ++flat;
      return;
    }
    if (uses[index] > 1 && !pose->isDeformed(mesh)) { // a mesh with several placements is one object
      std::string& object = objects[index];
      if (object.empty()) {
        object = out.uniqueName(meshName(mesh, node));
        const std::string shape = shapeOf(mesh, std::nullopt, node);
        out.line("ObjectBegin " + sceneText(object) + "\n" + shape + "ObjectEnd");
      }
      for (const Vec3d& v : corners(mesh)) import.bounds.add(transformPoint(placement, v));
      out.line("AttributeBegin\nTransform " + sceneText(placement) + "\nObjectInstance " + sceneText(object) +
               "\nAttributeEnd");
      ++instances;
      triangles += mesh.mNumFaces;
      return;
    }
    const std::string shape = shapeOf(mesh, placement, node);
    out.line("AttributeBegin\nTransform " + sceneText(placement) + "\n" + shape + "AttributeEnd");
    triangles += mesh.mNumFaces;
  }

  static std::string meshName(const aiMesh& mesh, const aiNode& node) {
    const std::string name = mesh.mName.C_Str(), nodeName = node.mName.C_Str();
    return !name.empty() ? name : !nodeName.empty() ? nodeName : "mesh";
  }

  /** Corners of the bounding box of a mesh. */
  static std::vector<Vec3d> corners(const aiMesh& mesh) {
    Bounds3d box;
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) box.add(vectorOf(mesh.mVertices[i]));
    std::vector<Vec3d> points;
    for (int i = 0; i < 8; ++i)
      points.emplace_back(i & 1 ? box.upper.x : box.lower.x, i & 2 ? box.upper.y : box.lower.y,
                          i & 4 ? box.upper.z : box.lower.z);
    return points;
  }

  /** Directives of a mesh with its material. `placement`: see ImportWriter::meshShape(). */
  std::string shapeOf(const aiMesh& mesh, const std::optional<Mat4d>& placement, const aiNode& node) {
    MeshData data;
    const unsigned uvChannel = materialsWanted && mesh.mMaterialIndex < scene.mNumMaterials
                                   ? materials.at(mesh.mMaterialIndex).uvChannel
                                   : 0;
    const aiVector3D* uvs =
        uvChannel < AI_MAX_NUMBER_OF_TEXTURECOORDS ? mesh.mTextureCoords[uvChannel] : nullptr;
    data.positions.reserve(mesh.mNumVertices);
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      data.positions.push_back(vectorOf(mesh.mVertices[i]));
      if (mesh.HasNormals()) data.normals.push_back(vectorOf(mesh.mNormals[i]));
      if (uvs) data.uvs.emplace_back(finite(uvs[i].x), finite(uvs[i].y));
    }
    data.triangles.reserve(mesh.mNumFaces);
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      if (face.mNumIndices != 3) continue;
      const glm::uvec3 t(face.mIndices[0], face.mIndices[1], face.mIndices[2]);
      if (std::max({t.x, t.y, t.z}) >= mesh.mNumVertices)
        fail("mesh \"" + meshName(mesh, node) + "\": face " + std::to_string(i) +
             " names a vertex that does not exist");
      data.triangles.push_back(t);
    }
    pose->deform(mesh, node, data);
    for (size_t i = 0; i < data.positions.size(); ++i)
      if (!isFloat(data.positions[i]))
        fail("mesh \"" + meshName(mesh, node) + "\": vertex " + std::to_string(i) + " is not finite");
    if (mesh.mColors[0]) ++colouredMeshes;
    if (mesh.mNumBones > 0 && !pose->isSkinned(mesh)) ++unusedSkeletons;
    ++meshes;
    std::string before, parameters;
    if (materialsWanted && mesh.mMaterialIndex < scene.mNumMaterials) {
      const AssimpMaterials::Made& m = materials.at(mesh.mMaterialIndex);
      before = m.directive + "\n" + m.areaLight;
      parameters = m.shapeParameters;
    }
    return before + out.meshShape(meshName(mesh, node), data, placement, parameters) + "\n";
  }

  static double finite(float x) { return std::isfinite(x) ? double(x) : 0; }

  // ---- lights and cameras, in the space of the node of their name

  void addLights() {
    for (unsigned i = 0; lightsWanted && i < scene.mNumLights; ++i) {
      const aiLight& light = *scene.mLights[i];
      const Mat4d place = pose->placement(light.mName.C_Str());
      const Vec3d from = transformPoint(place, vectorOf(light.mPosition));
      const Vec3d direction = Mat3d(place) * vectorOf(light.mDirection);
      const Vec3d colour(colourOf(light.mColorDiffuse));
      if (!(maxComponent(Rgbd(colour)) > 0) ||
          !std::isfinite(glm::dot(colour, from) + glm::dot(direction, from))) {
        ++unknownLights;
        continue;
      }
      const bool directed = glm::length(direction) > 0;
      const std::string value = "[ " + sceneText(colour) + " ]", start = "[ " + sceneText(from) + " ]";
      const std::string end =
          "[ " + sceneText(from + (directed ? glm::normalize(direction) : Vec3d(0, 0, -1))) + " ]";
      if (light.mType == aiLightSource_POINT) {
        out.line(
            formatted(R"(LightSource "point" "rgb I" %s "point3 from" %s)", value.c_str(), start.c_str()));
      } else if (light.mType == aiLightSource_DIRECTIONAL) {
        out.line(formatted(R"(LightSource "distant" "rgb L" %s "point3 from" %s "point3 to" %s)",
                           value.c_str(), start.c_str(), end.c_str()));
      } else if (light.mType == aiLightSource_SPOT) {
        // Cone angles of the scene are half of Assimp's.
        const double outer = std::clamp(glm::degrees(finite(light.mAngleOuterCone)) / 2, 0.5, 180.0);
        const double inner = std::clamp(glm::degrees(finite(light.mAngleInnerCone)) / 2, 0.0, outer);
        out.line(
            formatted(R"(LightSource "spot" "rgb I" %s "point3 from" %s "point3 to" %s "float coneangle" %s)"
                      R"( "float conedeltaangle" %s)",
                      value.c_str(), start.c_str(), end.c_str(), sceneText(outer).c_str(),
                      sceneText(outer - inner).c_str()));
      } else {
        ++unknownLights;
        continue;
      }
      import.hasLights = true;
      ++lights;
    }
  }

  void addCameras() {
    for (unsigned i = 0; i < scene.mNumCameras; ++i) {
      const aiCamera& camera = *scene.mCameras[i];
      const Mat4d placement = pose->placement(camera.mName.C_Str());
      const Mat3d place(placement);
      // Assimp 5.2 puts the translation of glTF's node into the camera once more.
      const Vec3d offset = isGltfFile ? Vec3d(0) : vectorOf(camera.mPosition);
      const Vec3d eye = transformPoint(placement, offset);
      const Vec3d forward = place * vectorOf(camera.mLookAt), up = place * vectorOf(camera.mUp);
      const Vec3d right = glm::cross(forward, up); // right-handed, as Assimp's space is
      ImportedCamera made;
      made.name = camera.mName.length > 0 ? camera.mName.C_Str() : "camera " + std::to_string(i + 1);
      made.worldFromCamera[0] = Vec4d(glm::normalize(right), 0);
      made.worldFromCamera[1] = Vec4d(glm::normalize(glm::cross(right, forward)), 0);
      made.worldFromCamera[2] = Vec4d(glm::normalize(forward), 0);
      made.worldFromCamera[3] = Vec4d(eye, 1);
      if (!isFinite(made.worldFromCamera) || !isInvertible(made.worldFromCamera)) continue;
      const double across = std::clamp(finite(camera.mHorizontalFOV), 0.01, 3.1);
      const double aspect = camera.mAspect > 0 && std::isfinite(camera.mAspect) ? double(camera.mAspect) : 1;
      made.fov = glm::degrees(aspect > 1 ? 2 * std::atan(std::tan(across / 2) / aspect) : across);
      import.cameras.push_back(made);
    }
  }

  void note() {
    const auto add = [](std::vector<std::string>& list, size_t count, const char* one, const char* many) {
      if (count > 0) list.push_back(counted(count, one, many));
    };
    std::vector<std::string>&taken = import.taken, &left = import.leftOut;
    add(taken, meshes, "mesh", "meshes");
    add(taken, triangles, "triangle", "triangles");
    add(taken, instances, "instance", "instances");
    add(taken, materials.count(), "material", "materials");
    add(taken, materials.pictureCount(), "picture", "pictures");
    add(taken, materials.emitterCount(), "emitting material", "emitting materials");
    add(taken, lights, "light", "lights");
    for (const ImportedCamera& camera : import.cameras) taken.push_back("camera \"" + camera.name + "\"");
    add(left, materialsWanted ? 0 : scene.mNumMaterials, "material", "materials");
    add(left, lightsWanted ? 0 : scene.mNumLights, "light", "lights");
    const bool isPlayed = time && time->animation;
    if (isPlayed)
      taken.push_back("animation " + sceneText(animationName(*time->animation)) + " at " +
                      sceneText(time->seconds) + " s");
    add(left, scene.mNumAnimations - (isPlayed ? 1 : 0), "animation", "animations");
    add(left, unusedSkeletons, "mesh's bones", "meshes' bones");
    add(left, colouredMeshes, "mesh's vertex colours", "meshes' vertex colours");
    add(left, unknownLights, "light of an unsupported kind, or black",
        "lights of an unsupported kind, or black");
    add(left, flat, "mesh in a node with a singular transform", "meshes in nodes with a singular transform");
  }

  const aiScene& scene;
  const Parameters& p;
  const GltfDetails* const gltf;
  SceneImport& import;
  ImportWriter out;
  std::string path;
  AssimpMaterials materials;
  bool materialsWanted, lightsWanted, isGltfFile;
  std::vector<int> uses;            ///< number of nodes that show each mesh
  std::vector<std::string> objects; ///< object name of each mesh with several placements
  std::optional<AssimpPose> pose;
  std::optional<AnimationTime> time; ///< none: the file's rest pose
  std::set<const aiMesh*> skinned;   ///< meshes that bones have placed
  size_t meshes = 0, triangles = 0, instances = 0, lights = 0;
  size_t unknownLights = 0, flat = 0, colouredMeshes = 0, unusedSkeletons = 0;
};

} // namespace

bool wantsPose(const Parameters& p) { return p.has("time") || p.has("animation"); }

void reportMissingAnimation(const Parameters& p, const std::string& path, const std::string& names) {
  if (p.has("animation"))
    p.fail("animation",
           path + " has no animation " + sceneText(p.string("animation")) +
               (names.empty() ? ": it has none at all" : ""),
           names);
  if (p.has("time")) p.warn("time", path + " has no animation; its pose is the same at all times");
}

void importAssimpScene(const aiScene& scene, const std::string& path, const Parameters& p,
                       const ImportContext& context, const GltfDetails* gltf, SceneImport& import) {
  AssimpSceneImport(scene, path, p, context, gltf, import).run();
}

} // namespace recurse
