/** @file
 * Conversion of Assimp's scenes to pieces of a scene.
 */
#include "importers/assimp/assimpScene.h"

#include <algorithm>
#include <cmath>

#include <assimp/scene.h>

#include "importers/assimp/assimpMaterials.h"
#include "recurse/core/math/affine.h"

namespace recurse {

namespace {

Vec3d worldVector(const aiVector3D& v) { return {v.x, v.y, v.z}; }
Mat4d matrixOf(const aiMatrix4x4& m) { // stored by rows in Assimp, by columns here
  Mat4d out;
  for (unsigned row = 0; row < 4; ++row)
    for (unsigned column = 0; column < 4; ++column)
      out[static_cast<int>(column)][static_cast<int>(row)] = m[row][column];
  return out;
}

std::string counted(size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

class AssimpSceneImport {
 public:
  AssimpSceneImport(const aiScene& scene, const std::string& path, const Parameters& p,
                    const ImportContext& context, SceneImport& import)
      : scene(scene), p(p), import(import), out(import, context), path(path),
        materials(scene, path, p, import, out), materialsWanted(p.boolean("materials")),
        lightsWanted(p.boolean("lights")), isGltf(path.ends_with(".gltf") || path.ends_with(".glb")),
        uses(scene.mNumMeshes), objects(scene.mNumMeshes) {}

  void run() {
    if (scene.mNumMeshes == 0) fail("it has no faces");
    countUses(*scene.mRootNode, 0);
    addNode(*scene.mRootNode, axes());
    if (triangles == 0) fail("no node uses its triangles");
    addLights();
    addCameras();
    note();
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    p.fail("filename", path + ": cannot be used: " + what);
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

  void addNode(const aiNode& node, const Mat4d& parent) {
    const Mat4d placement = parent * matrixOf(node.mTransformation);
    places[node.mName.C_Str()] = placement;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) addMesh(node.mMeshes[i], placement, node.mName.C_Str());
    for (unsigned i = 0; i < node.mNumChildren; ++i) addNode(*node.mChildren[i], placement);
  }

  void addMesh(unsigned index, const Mat4d& placement, const std::string& nodeName) {
    const aiMesh& mesh = *scene.mMeshes[index];
    if (!(mesh.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) || mesh.mNumFaces == 0) return;
    if (!isFinite(placement) || !isInvertible(placement)) {
      ++flat;
      return;
    }
    if (uses[index] > 1) { // a mesh with several placements is one object
      std::string& object = objects[index];
      if (object.empty()) {
        object = out.uniqueName(meshName(mesh, nodeName));
        const std::string shape = shapeOf(mesh, Mat4d(1), nodeName);
        out.line("ObjectBegin " + sceneText(object) + "\n" + shape + "ObjectEnd");
      }
      for (const Vec3d& v : corners(mesh)) import.bounds.add(transformPoint(placement, v));
      out.line("AttributeBegin\nTransform " + sceneText(placement) + "\nObjectInstance " + sceneText(object) +
               "\nAttributeEnd");
      ++instances;
      triangles += mesh.mNumFaces;
      return;
    }
    const std::string shape = shapeOf(mesh, placement, nodeName);
    out.line("AttributeBegin\nTransform " + sceneText(placement) + "\n" + shape + "AttributeEnd");
    triangles += mesh.mNumFaces;
  }

  static std::string meshName(const aiMesh& mesh, const std::string& nodeName) {
    const std::string name = mesh.mName.C_Str();
    return !name.empty() ? name : !nodeName.empty() ? nodeName : "mesh";
  }

  /** Corners of the bounding box of a mesh. */
  static std::vector<Vec3d> corners(const aiMesh& mesh) {
    Bounds3d box;
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) box.add(worldVector(mesh.mVertices[i]));
    std::vector<Vec3d> points;
    for (int i = 0; i < 8; ++i)
      points.emplace_back(i & 1 ? box.upper.x : box.lower.x, i & 2 ? box.upper.y : box.lower.y,
                          i & 4 ? box.upper.z : box.lower.z);
    return points;
  }

  /** Directives of a mesh with its material. */
  std::string shapeOf(const aiMesh& mesh, const Mat4d& placement, const std::string& nodeName) {
    MeshData data;
    const unsigned uvChannel = materialsWanted && mesh.mMaterialIndex < scene.mNumMaterials
                                   ? materials.at(mesh.mMaterialIndex).uvChannel
                                   : 0;
    const aiVector3D* uvs =
        uvChannel < AI_MAX_NUMBER_OF_TEXTURECOORDS ? mesh.mTextureCoords[uvChannel] : nullptr;
    data.positions.reserve(mesh.mNumVertices);
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      data.positions.push_back(worldVector(mesh.mVertices[i]));
      const Vec3d& position = data.positions.back();
      if (!std::isfinite(position.x) || !std::isfinite(position.y) || !std::isfinite(position.z))
        fail("mesh \"" + meshName(mesh, nodeName) + "\": vertex " + std::to_string(i) + " is not finite");
      if (mesh.HasNormals()) data.normals.push_back(worldVector(mesh.mNormals[i]));
      if (uvs) data.uvs.emplace_back(finite(uvs[i].x), finite(uvs[i].y));
    }
    data.triangles.reserve(mesh.mNumFaces);
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      if (face.mNumIndices != 3) continue;
      const glm::uvec3 t(face.mIndices[0], face.mIndices[1], face.mIndices[2]);
      if (std::max({t.x, t.y, t.z}) >= mesh.mNumVertices)
        fail("mesh \"" + meshName(mesh, nodeName) + "\": face " + std::to_string(i) +
             " names a vertex that does not exist");
      data.triangles.push_back(t);
    }
    if (mesh.mColors[0]) ++colouredMeshes;
    if (mesh.mNumBones > 0) ++skinnedMeshes;
    ++meshes;
    std::string before, parameters;
    if (materialsWanted && mesh.mMaterialIndex < scene.mNumMaterials) {
      const AssimpMaterials::Made& m = materials.at(mesh.mMaterialIndex);
      before = m.directive + "\n" + m.areaLight;
      parameters = m.shapeParameters;
    }
    return before + out.meshShape(meshName(mesh, nodeName), data, placement, parameters) + "\n";
  }

  static double finite(float x) { return std::isfinite(x) ? double(x) : 0; }

  // ---- lights and cameras, in the space of the node of their name

  Mat4d placeOf(const aiString& node) const {
    const auto found = places.find(node.C_Str());
    return found == places.end() ? Mat4d(1) : found->second;
  }

  void addLights() {
    for (unsigned i = 0; lightsWanted && i < scene.mNumLights; ++i) {
      const aiLight& light = *scene.mLights[i];
      const Mat4d place = placeOf(light.mName);
      const Vec3d from = transformPoint(place, worldVector(light.mPosition));
      const Vec3d direction = Mat3d(place) * worldVector(light.mDirection);
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
        out.line("LightSource \"point\" \"rgb I\" " + value + " \"point3 from\" " + start);
      } else if (light.mType == aiLightSource_DIRECTIONAL) {
        out.line("LightSource \"distant\" \"rgb L\" " + value + " \"point3 from\" " + start +
                 " \"point3 to\" " + end);
      } else if (light.mType == aiLightSource_SPOT) {
        // Cone angles of the scene are half of Assimp's.
        const double outer = std::clamp(glm::degrees(finite(light.mAngleOuterCone)) / 2, 0.5, 180.0);
        const double inner = std::clamp(glm::degrees(finite(light.mAngleInnerCone)) / 2, 0.0, outer);
        out.line("LightSource \"spot\" \"rgb I\" " + value + " \"point3 from\" " + start + " \"point3 to\" " +
                 end + " \"float coneangle\" " + sceneText(outer) + " \"float conedeltaangle\" " +
                 sceneText(outer - inner));
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
      const Mat3d place(placeOf(camera.mName));
      // Assimp 5.2 puts the translation of glTF's node into the camera once more.
      const Vec3d offset = isGltf ? Vec3d(0) : worldVector(camera.mPosition);
      const Vec3d eye = transformPoint(placeOf(camera.mName), offset);
      const Vec3d forward = place * worldVector(camera.mLookAt), up = place * worldVector(camera.mUp);
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
    add(left, scene.mNumAnimations, "animation", "animations");
    add(left, skinnedMeshes, "mesh's bones", "meshes' bones");
    add(left, colouredMeshes, "mesh's vertex colours", "meshes' vertex colours");
    add(left, unknownLights, "light of an unsupported kind, or black",
        "lights of an unsupported kind, or black");
    add(left, flat, "mesh in a node with a singular transform", "meshes in nodes with a singular transform");
  }

  const aiScene& scene;
  const Parameters& p;
  SceneImport& import;
  ImportWriter out;
  std::string path;
  AssimpMaterials materials;
  bool materialsWanted, lightsWanted, isGltf;
  std::vector<int> uses;               ///< number of nodes that show each mesh
  std::vector<std::string> objects;    ///< object name of each mesh with several placements
  std::map<std::string, Mat4d> places; ///< transforms of nodes, by name
  size_t meshes = 0, triangles = 0, instances = 0, lights = 0;
  size_t unknownLights = 0, flat = 0, colouredMeshes = 0, skinnedMeshes = 0;
};

} // namespace

void importAssimpScene(const aiScene& scene, const std::string& path, const Parameters& p,
                       const ImportContext& context, SceneImport& import) {
  AssimpSceneImport(scene, path, p, context, import).run();
}

} // namespace recurse
