/** @file
 * Models of every kind that Assimp reads: node transforms, materials (the metal and roughness of glTF, and
 * the older ones of Wavefront's MTL and its like), pictures inside of the file or beside it, lights and
 * cameras.
 */
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include <assimp/DefaultIOSystem.h>
#include <assimp/GltfMaterial.h>
#include <assimp/Importer.hpp>
#include <assimp/ObjMaterial.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "recurse/core/image.h"
#include "recurse/model/plugIns.h"

namespace recurse {

namespace {

Vec3d vectorOf(const aiVector3D& v) { return {v.x, v.y, v.z}; }
Rgbd colourOf(const aiColor3D& c) { return {c.r, c.g, c.b}; }
Mat4d matrixOf(const aiMatrix4x4& m) { // rows there, columns here
  Mat4d out;
  for (unsigned row = 0; row < 4; ++row)
    for (unsigned column = 0; column < 4; ++column)
      out[static_cast<int>(column)][static_cast<int>(row)] = m[row][column];
  return out;
}

std::string counted(size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

double clamp01(double x) { return x > 0 ? std::min(x, 1.0) : 0; } // 0 for what is no number

/** Notes which files are read. */
class NotingIoSystem : public Assimp::DefaultIOSystem {
 public:
  explicit NotingIoSystem(std::vector<std::string>& read) : read(read) {}

  Assimp::IOStream* Open(const char* file, const char* mode) override {
    Assimp::IOStream* stream = DefaultIOSystem::Open(file, mode);
    if (stream) read.emplace_back(file);
    return stream;
  }

 private:
  std::vector<std::string>& read;
};

/** A colour or number that may be multiplied by a texture. */
struct Value {
  Rgbd factor{1};
  std::string texture; ///< name in the scene; empty: the factor alone
};

class MeshFileImport {
 public:
  MeshFileImport(const Parameters& p, const ImportContext& context, SceneImport& import)
      : p(p), import(import), out(import, context), path(p.filePath("filename")),
        directory(std::filesystem::path(path).parent_path().string()),
        materialsWanted(p.boolean("materials")), lightsWanted(p.boolean("lights")),
        isGltf(path.ends_with(".gltf") || path.ends_with(".glb")) {}

  void run() {
    // Lines and points have no surface.
    importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_LINE | aiPrimitiveType_POINT);
    importer.SetIOHandler(new NotingIoSystem(import.filesRead)); // the importer's own from here
    importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
    scene = importer.ReadFile(path, aiProcess_Triangulate | aiProcess_SortByPType |
                                        aiProcess_JoinIdenticalVertices | aiProcess_ValidateDataStructure);
    if (!scene || !scene->mRootNode) fail(importer.GetErrorString());
    if (scene->mNumMeshes == 0) fail("it has no faces");
    countUses(*scene->mRootNode, 0);
    materials.resize(scene->mNumMaterials);
    objects.resize(scene->mNumMeshes);
    addNode(*scene->mRootNode, axes());
    if (triangles == 0) fail("it has no triangles that are placed anywhere");
    addLights();
    addCameras();
    note();
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    p.fail("filename", path + ": cannot be used: " + (what.empty() ? "it is damaged" : what));
  }

  // ---- geometry

  static constexpr int MAX_DEPTH = 1000;

  void countUses(const aiNode& node, int depth) {
    if (depth > MAX_DEPTH) fail("its nodes are nested too deeply");
    uses.resize(scene->mNumMeshes);
    for (unsigned i = 0; i < node.mNumMeshes; ++i) ++uses.at(node.mMeshes[i]);
    for (unsigned i = 0; i < node.mNumChildren; ++i) countUses(*node.mChildren[i], depth + 1);
  }

  int metadata(const char* key, int otherwise) const {
    int32_t value = otherwise;
    return scene->mMetaData && scene->mMetaData->Get(key, value) ? value : otherwise;
  }

  /** FBX says in its metadata which of its axes points where, and how many centimetres a unit has; everything
   * else comes with y up. */
  Mat4d axes() const {
    if (!scene->mMetaData || !scene->mMetaData->HasKey("UpAxis")) return Mat4d(1);
    const int axis[3] = {metadata("CoordAxis", 0), metadata("UpAxis", 1), metadata("FrontAxis", 2)};
    const int sign[3] = {metadata("CoordAxisSign", 1), metadata("UpAxisSign", 1),
                         metadata("FrontAxisSign", 1)};
    float centimetres = 0;
    double precise = 0;
    if (!scene->mMetaData->Get("UnitScaleFactor", centimetres) &&
        scene->mMetaData->Get("UnitScaleFactor", precise))
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
    const aiMesh& mesh = *scene->mMeshes[index];
    if (!(mesh.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) || mesh.mNumFaces == 0) return;
    const double determinant = glm::determinant(Mat3d(placement));
    if (!std::isfinite(determinant) || determinant == 0) {
      ++flat;
      return;
    }
    if (uses[index] > 1) { // a mesh that stands in several places is one object
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

  /** The corners of the box around a mesh. */
  static std::vector<Vec3d> corners(const aiMesh& mesh) {
    Bounds3d box;
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) box.add(vectorOf(mesh.mVertices[i]));
    std::vector<Vec3d> points;
    for (int i = 0; i < 8; ++i)
      points.emplace_back(i & 1 ? box.upper.x : box.lower.x, i & 2 ? box.upper.y : box.lower.y,
                          i & 4 ? box.upper.z : box.lower.z);
    return points;
  }

  /** Directives of a mesh with its material. */
  std::string shapeOf(const aiMesh& mesh, const Mat4d& placement, const std::string& nodeName) {
    MeshData data;
    const unsigned uvChannel = materialsWanted && mesh.mMaterialIndex < scene->mNumMaterials
                                   ? material(mesh.mMaterialIndex).uvChannel
                                   : 0;
    const aiVector3D* uvs =
        uvChannel < AI_MAX_NUMBER_OF_TEXTURECOORDS ? mesh.mTextureCoords[uvChannel] : nullptr;
    data.positions.reserve(mesh.mNumVertices);
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      data.positions.push_back(vectorOf(mesh.mVertices[i]));
      const Vec3d& position = data.positions.back();
      if (!std::isfinite(position.x) || !std::isfinite(position.y) || !std::isfinite(position.z))
        fail("mesh \"" + meshName(mesh, nodeName) + "\": vertex " + std::to_string(i) + " is not finite");
      if (mesh.HasNormals()) data.normals.push_back(vectorOf(mesh.mNormals[i]));
      if (uvs) data.uvs.emplace_back(finite(uvs[i].x), finite(uvs[i].y));
    }
    data.triangles.reserve(mesh.mNumFaces);
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      if (face.mNumIndices != 3) continue;
      const glm::uvec3 t(face.mIndices[0], face.mIndices[1], face.mIndices[2]);
      if (std::max({t.x, t.y, t.z}) >= mesh.mNumVertices)
        fail("mesh \"" + meshName(mesh, nodeName) + "\": face " + std::to_string(i) +
             " names a vertex that is not there");
      data.triangles.push_back(t);
    }
    if (mesh.mColors[0]) ++colouredMeshes;
    if (mesh.mNumBones > 0) ++skinnedMeshes;
    ++meshes;
    std::string before, parameters;
    if (materialsWanted && mesh.mMaterialIndex < scene->mNumMaterials) {
      const MadeMaterial& m = material(mesh.mMaterialIndex);
      before = m.directive + "\n" + m.areaLight;
      parameters = m.shapeParameters;
    }
    return before + out.meshShape(meshName(mesh, nodeName), data, placement, parameters) + "\n";
  }

  static double finite(float x) { return std::isfinite(x) ? double(x) : 0; }

  // ---- materials

  struct MadeMaterial {
    bool made = false;
    std::string directive = "Material \"diffuse\"", areaLight, shapeParameters;
    unsigned uvChannel = 0;
  };

  const MadeMaterial& material(unsigned index) {
    MadeMaterial& m = materials[index];
    if (!m.made) {
      m.made = true;
      makeMaterial(*scene->mMaterials[index], m);
    }
    return m;
  }

  template <class T>
  static bool get(const aiMaterial& m, const char* key, unsigned type, unsigned i, T& value) {
    return m.Get(key, type, i, value) == AI_SUCCESS;
  }
  static double number(const aiMaterial& m, const char* key, unsigned type, unsigned i, double otherwise) {
    float value = 0;
    return get(m, key, type, i, value) && std::isfinite(value) ? double(value) : otherwise;
  }

  /** Parameters of an imagemap for the way that a picture lies on the surface. */
  static std::string layout(const aiMaterial& m, aiTextureType type) {
    std::string text;
    aiUVTransform transform;
    if (get(m, AI_MATKEY_UVTRANSFORM(type, 0), transform)) {
      const auto add = [&text](const char* name, float value, float usual) {
        if (value != usual && std::isfinite(value))
          text += std::string(" \"float ") + name + "\" " + sceneText(double(value));
      };
      add("uscale", transform.mScaling.x, 1);
      add("vscale", transform.mScaling.y, 1);
      add("udelta", transform.mTranslation.x, 0);
      add("vdelta", transform.mTranslation.y, 0);
    }
    int wrap = aiTextureMapMode_Wrap;
    if (get(m, AI_MATKEY_MAPPINGMODE_U(type, 0), wrap) && wrap == aiTextureMapMode_Clamp)
      text += " \"string wrap\" \"clamp\"";
    return text.empty() ? text : text.substr(1);
  }

  /** The file of a material's picture, kept for the scene; empty where there is none. `wanted` becomes true
   * where the material has one, found or not. */
  std::string picture(const aiMaterial& m, aiTextureType type, bool& wanted) {
    aiString name;
    if (m.GetTexture(type, 0, &name) != AI_SUCCESS || name.length == 0) return {};
    wanted = true;
    const std::string key = name.C_Str();
    const auto known = pictures.find(key);
    if (known != pictures.end()) return known->second;
    return pictures[key] = loadPicture(key);
  }

  std::string loadPicture(const std::string& name) {
    if (const aiTexture* inside = scene->GetEmbeddedTexture(name.c_str())) return embedded(*inside);
    const std::string file = findModelFile(directory, name);
    if (!file.empty()) {
      try {
        return out.copyFile(file);
      } catch (const Error& e) {
        p.warn("filename", e.what());
        return {};
      }
    }
    p.warn("filename", path + ": there is no picture \"" + name + "\"; a checkerboard stands for it");
    return {};
  }

  std::string embedded(const aiTexture& texture) {
    const char* bytes = reinterpret_cast<const char*>(texture.pcData);
    if (texture.mHeight == 0) {
      std::string extension = texture.achFormatHint;
      return out.addFile("picture." + (extension.empty() ? "png" : extension),
                         std::string(bytes, texture.mWidth));
    }
    if (texture.mWidth > 0xffff || texture.mHeight > 0xffff) return {};
    std::string tga(18, '\0'); // the texels are BGRA, as in TGA
    tga[2] = 2;
    tga[12] = static_cast<char>(texture.mWidth & 255);
    tga[13] = static_cast<char>(texture.mWidth >> 8);
    tga[14] = static_cast<char>(texture.mHeight & 255);
    tga[15] = static_cast<char>(texture.mHeight >> 8);
    tga[16] = 32;
    tga[17] = 0x28;
    tga.append(bytes, size_t(4) * texture.mWidth * texture.mHeight);
    return out.addFile("picture.tga", tga);
  }

  /** The colour `factor` times a picture. */
  Value spectrumValue(const aiMaterial& m, aiTextureType type, const Rgbd& factor) {
    bool wanted = false;
    const std::string file = picture(m, type, wanted);
    Value v{factor, ""};
    if (!wanted) return v;
    if (file.empty()) return {Rgbd(1), out.missingTexture()};
    v.texture = out.imageTexture("spectrum", file, layout(m, type));
    // Writers that mean the picture alone leave black beside it.
    if (factor != Rgbd(1) && factor != Rgbd(0)) {
      const std::string scaled = out.uniqueName(v.texture + "_scaled");
      out.line("Texture " + sceneText(scaled) + " \"spectrum\" \"scale\" \"texture tex\" " +
               sceneText(v.texture) + " \"rgb tint\" [ " + sceneText(Vec3d(factor)) + " ]");
      v.texture = scaled;
    }
    return v;
  }

  /** One channel of a picture times a number. */
  Value channelValue(const aiMaterial& m, aiTextureType type, const char* channel, double factor) {
    bool wanted = false;
    const std::string file = picture(m, type, wanted);
    Value v{Rgbd(factor), ""};
    if (file.empty()) return v;
    std::string more = layout(m, type);
    more += (more.empty() ? "" : " ") + std::string("\"string encoding\" \"linear\" \"string channel\" \"") +
            channel + "\" \"float scale\" " + sceneText(factor);
    v.texture = out.imageTexture("float", file, more);
    return v;
  }

  static std::string spectrumParameter(const char* name, const Value& v) {
    if (!v.texture.empty()) return std::string("\"texture ") + name + "\" " + sceneText(v.texture);
    return std::string("\"rgb ") + name + "\" [ " +
           sceneText(Vec3d(clamp01(v.factor.r), clamp01(v.factor.g), clamp01(v.factor.b))) + " ]";
  }
  static std::string floatParameter(const char* name, const Value& v) {
    if (!v.texture.empty()) return std::string("\"texture ") + name + "\" " + sceneText(v.texture);
    return std::string("\"float ") + name + "\" " + sceneText(v.factor.r);
  }

  /** glTF's roughness is the square root of alpha, and so is pbrt's roughness alpha squared. */
  std::string roughness(const aiMaterial& m, double factor) {
    Value v = channelValue(m, aiTextureType_DIFFUSE_ROUGHNESS, "green", clamp01(factor));
    if (v.texture.empty()) return "\"float roughness\" " + sceneText(v.factor.r * v.factor.r) + REMAP_OFF;
    const std::string squared = out.uniqueName(v.texture + "_squared");
    out.line("Texture " + sceneText(squared) + " \"float\" \"scale\" \"texture tex\" " +
             sceneText(v.texture) + " \"texture scale\" " + sceneText(v.texture));
    return "\"texture roughness\" " + sceneText(squared) + REMAP_OFF;
  }
  static constexpr const char* REMAP_OFF = " \"bool remaproughness\" false";

  void makeMaterial(const aiMaterial& m, MadeMaterial& made) {
    aiColor4D base4(1, 1, 1, 1);
    const bool isPhysical = m.GetTextureCount(aiTextureType_BASE_COLOR) > 0 ||
                            get(m, AI_MATKEY_BASE_COLOR, base4) ||
                            get(m, AI_MATKEY_ROUGHNESS_FACTOR, base4.r);
    const std::string name = m.GetName().C_Str();
    const std::string bumps = normalMap(m);
    const double transmission = number(m, AI_MATKEY_TRANSMISSION_FACTOR, 0);
    const aiTextureType colourType =
        m.GetTextureCount(aiTextureType_BASE_COLOR) > 0 ? aiTextureType_BASE_COLOR : aiTextureType_DIFFUSE;
    int uvSource = 0;
    if (get(m, AI_MATKEY_UVWSRC(colourType, 0), uvSource) && uvSource > 0)
      made.uvChannel = static_cast<unsigned>(uvSource);
    const double index = number(m, AI_MATKEY_REFRACTI, 1.5);
    const double eta = index > 1.01 && index < 10 ? index : 1.5;
    if (transmission > 0.5) {
      made.directive = glass(m, eta, bumps);
    } else if (isPhysical) {
      made.directive = metalAndRoughness(m, name, colourType, eta, bumps);
    } else {
      made.directive = classic(m, colourType, eta, bumps, made);
    }
    readAlpha(m, colourType, made);
    readEmission(m, made);
    ++materialCount;
  }

  std::string normalMap(const aiMaterial& m) {
    bool wanted = false;
    // "bump" of MTL is a height in principle, and comes as such.
    const std::string file = picture(m, aiTextureType_NORMALS, wanted);
    return file.empty() ? "" : " \"string normalmap\" " + sceneText(file);
  }

  static std::string glass(const aiMaterial& m, double eta, const std::string& bumps) {
    const bool solid = number(m, AI_MATKEY_VOLUME_THICKNESS_FACTOR, 0) > 0;
    const double rough = number(m, AI_MATKEY_ROUGHNESS_FACTOR, 0);
    return std::string("Material \"") + (solid ? "dielectric" : "thindielectric") + "\" \"float eta\" " +
           sceneText(eta) +
           (solid ? " \"float roughness\" " + sceneText(clamp01(rough * rough)) + REMAP_OFF : "") + bumps;
  }

  std::string metalAndRoughness(const aiMaterial& m, const std::string& name, aiTextureType colourType,
                                double eta, const std::string& bumps) {
    aiColor4D base(1, 1, 1, 1);
    if (!get(m, AI_MATKEY_BASE_COLOR, base)) get(m, AI_MATKEY_COLOR_DIFFUSE, base);
    const Value colour = spectrumValue(m, colourType, Rgbd(base.r, base.g, base.b));
    const std::string reflectance = spectrumParameter("reflectance", colour);
    const std::string rough = " " + roughness(m, number(m, AI_MATKEY_ROUGHNESS_FACTOR, 1));
    const Value metal =
        channelValue(m, aiTextureType_METALNESS, "blue", clamp01(number(m, AI_MATKEY_METALLIC_FACTOR, 1)));
    const std::string coat = "\"plastic\" \"float eta\" " + sceneText(eta) + " " + reflectance + rough;
    const std::string conductor = "\"conductor\" " + reflectance + rough;
    if (metal.texture.empty() && metal.factor.r <= 0) return "Material " + coat + bumps;
    if (metal.texture.empty() && metal.factor.r >= 1) return "Material " + conductor + bumps;
    const std::string first = out.uniqueName(name + "_coat"), second = out.uniqueName(name + "_metal");
    out.line("MakeNamedMaterial " + sceneText(first) + " \"string type\" " + coat);
    out.line("MakeNamedMaterial " + sceneText(second) + " \"string type\" " + conductor);
    return "Material \"mix\" \"string materials\" [ " + sceneText(first) + " " + sceneText(second) + " ] " +
           floatParameter("amount", metal) + bumps;
  }

  /** Phong's model and its relatives. */
  std::string classic(const aiMaterial& m, aiTextureType colourType, double eta, const std::string& bumps,
                      MadeMaterial& made) {
    aiColor3D diffuse(0.6f, 0.6f, 0.6f), specular(0, 0, 0);
    get(m, AI_MATKEY_COLOR_DIFFUSE, diffuse);
    get(m, AI_MATKEY_COLOR_SPECULAR, specular);
    const double exponent = number(m, AI_MATKEY_SHININESS, 0);
    int illumination = 2;
    get(m, AI_MATKEY_OBJ_ILLUM, illumination);
    const double opacity = clamp01(number(m, AI_MATKEY_OPACITY, 1));
    const double shine = maxComponent(colourOf(specular)), body = maxComponent(colourOf(diffuse));
    // The width of the lobe of microfacets that a Phong lobe looks like; from 1000 on MTL means a mirror.
    const double alpha = exponent >= 999 ? 0 : std::sqrt(2 / (std::max(exponent, 0.0) + 2));
    const std::string rough = " \"float roughness\" " + sceneText(clamp01(alpha)) + REMAP_OFF;
    const bool refracts = illumination == 4 || illumination == 6 || illumination == 7 || illumination == 9;
    const bool hasIndex = number(m, AI_MATKEY_REFRACTI, 1) > 1.01;
    if (refracts || (opacity < 0.5 && hasIndex)) {
      made.shapeParameters.clear();
      return "Material \"dielectric\" \"float eta\" " + sceneText(eta) + bumps;
    }
    if ((illumination == 3 || illumination == 5 || illumination == 8) && shine > 0.3 && body < 0.3 * shine)
      return "Material \"conductor\" " + spectrumParameter("reflectance", {colourOf(specular), ""}) + rough +
             bumps;
    const std::string reflectance =
        spectrumParameter("reflectance", spectrumValue(m, colourType, colourOf(diffuse)));
    if (illumination < 2 || shine < 0.02 || exponent <= 1)
      return "Material \"diffuse\" " + reflectance + bumps;
    return "Material \"plastic\" \"float eta\" " + sceneText(eta) + " " + reflectance + rough + bumps;
  }

  void readAlpha(const aiMaterial& m, aiTextureType colourType, MadeMaterial& made) {
    if (made.directive.find("dielectric\"") != std::string::npos) return;
    double opacity = clamp01(number(m, AI_MATKEY_OPACITY, 1));
    if (opacity == 0) opacity = 1; // writers disagree on its sense, and nobody models what cannot be seen
    aiString mode;
    const bool hasMode = get(m, AI_MATKEY_GLTF_ALPHAMODE, mode);
    bool wanted = false;
    if (hasMode && std::string(mode.C_Str()) == "OPAQUE") return;
    const aiTextureType type =
        m.GetTextureCount(aiTextureType_OPACITY) > 0 ? aiTextureType_OPACITY : colourType;
    if (type == aiTextureType_OPACITY || hasMode) {
      if (const std::string file = picture(m, type, wanted); !file.empty()) {
        std::string more =
            layout(m, type) + " \"string encoding\" \"linear\" \"float scale\" " + sceneText(opacity);
        if (hasMode) more += " \"string channel\" \"alpha\"";
        if (std::string(mode.C_Str()) == "MASK")
          more += " \"float threshold\" " + sceneText(number(m, AI_MATKEY_GLTF_ALPHACUTOFF, 0.5));
        if (hasMode && !hasAlpha(file)) return;
        made.shapeParameters = "\"texture alpha\" " + sceneText(out.imageTexture("float", file, more));
        return;
      }
    }
    if (opacity < 1) made.shapeParameters = "\"float alpha\" " + sceneText(opacity);
  }

  /** A picture without that channel is opaque. */
  bool hasAlpha(const std::string& file) {
    try {
      return readImage({file, import.files.at(file)}).channel("A") >= 0;
    } catch (const Error&) {
      return false; // where it is used as a colour the error is told
    }
  }

  void readEmission(const aiMaterial& m, MadeMaterial& made) {
    aiColor3D colour(0, 0, 0);
    get(m, AI_MATKEY_COLOR_EMISSIVE, colour);
    double strength = number(m, AI_MATKEY_EMISSIVE_INTENSITY, 1);
    if (!(strength > 0)) strength = 1;
    Rgbd light = colourOf(colour) * strength;
    bool wanted = false;
    const std::string file = picture(m, aiTextureType_EMISSIVE, wanted);
    if (!file.empty() && !(maxComponent(light) > 0)) light = Rgbd(1);
    if (!lightsWanted || !(maxComponent(light) > 0) || !std::isfinite(maxComponent(light))) return;
    int twoSided = 0;
    get(m, AI_MATKEY_TWOSIDED, twoSided);
    made.areaLight = "AreaLightSource \"diffuse\" " +
                     (file.empty() ? "\"rgb L\" [ " + sceneText(Vec3d(light)) + " ]"
                                   : "\"string filename\" " + sceneText(file) + " \"float scale\" " +
                                         sceneText(luminance(light))) +
                     (twoSided ? " \"bool twosided\" true" : "") + "\n";
    import.hasLights = true;
    ++emitters;
  }

  // ---- lights and cameras, in the space of the node of their name

  Mat4d placeOf(const aiString& node) const {
    const auto found = places.find(node.C_Str());
    return found == places.end() ? Mat4d(1) : found->second;
  }

  void addLights() {
    for (unsigned i = 0; lightsWanted && i < scene->mNumLights; ++i) {
      const aiLight& light = *scene->mLights[i];
      const Mat4d place = placeOf(light.mName);
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
        out.line("LightSource \"point\" \"rgb I\" " + value + " \"point3 from\" " + start);
      } else if (light.mType == aiLightSource_DIRECTIONAL) {
        out.line("LightSource \"distant\" \"rgb L\" " + value + " \"point3 from\" " + start +
                 " \"point3 to\" " + end);
      } else if (light.mType == aiLightSource_SPOT) {
        // Half angles there are whole ones of Assimp.
        const double outer = std::clamp(glm::degrees(double(light.mAngleOuterCone)) / 2, 0.5, 180.0);
        const double inner = std::clamp(glm::degrees(double(light.mAngleInnerCone)) / 2, 0.0, outer);
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
    for (unsigned i = 0; i < scene->mNumCameras; ++i) {
      const aiCamera& camera = *scene->mCameras[i];
      const Mat3d place(placeOf(camera.mName));
      // Assimp 5.2 puts the translation of glTF's node into the camera once more.
      const Vec3d offset = isGltf ? Vec3d(0) : vectorOf(camera.mPosition);
      const Vec3d eye = transformPoint(placeOf(camera.mName), offset);
      const Vec3d forward = place * vectorOf(camera.mLookAt), up = place * vectorOf(camera.mUp);
      const Vec3d right = glm::cross(forward, up); // of a world that is right-handed, as Assimp's is
      if (!(glm::length(right) > 0) || !std::isfinite(glm::length(right) + glm::length(eye))) continue;
      ImportedCamera made;
      made.name = camera.mName.length > 0 ? camera.mName.C_Str() : "camera " + std::to_string(i + 1);
      made.worldFromCamera[0] = Vec4d(glm::normalize(right), 0);
      made.worldFromCamera[1] = Vec4d(glm::normalize(glm::cross(right, forward)), 0);
      made.worldFromCamera[2] = Vec4d(glm::normalize(forward), 0);
      made.worldFromCamera[3] = Vec4d(eye, 1);
      const double across = std::clamp(double(camera.mHorizontalFOV), 0.01, 3.1);
      const double aspect = camera.mAspect > 0 ? double(camera.mAspect) : 1;
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
    add(taken, materialCount, "material", "materials");
    add(taken, pictures.size(), "picture", "pictures");
    add(taken, emitters, "emitting material", "emitting materials");
    add(taken, lights, "light", "lights");
    for (const ImportedCamera& camera : import.cameras) taken.push_back("camera \"" + camera.name + "\"");
    add(left, materialsWanted ? 0 : scene->mNumMaterials, "material", "materials");
    add(left, lightsWanted ? 0 : scene->mNumLights, "light", "lights");
    add(left, scene->mNumAnimations, "animation", "animations");
    add(left, skinnedMeshes, "mesh's bones", "meshes' bones");
    add(left, colouredMeshes, "mesh's vertex colours", "meshes' vertex colours");
    add(left, unknownLights, "light of another kind, or black", "lights of another kind, or black");
    add(left, flat, "mesh in a node that flattens it", "meshes in nodes that flatten them");
  }

  const Parameters& p;
  SceneImport& import;
  ImportWriter out;
  std::string path, directory;
  bool materialsWanted, lightsWanted, isGltf;
  Assimp::Importer importer;
  const aiScene* scene = nullptr;
  std::vector<int> uses;            ///< of each mesh, how many nodes show it
  std::vector<std::string> objects; ///< of each mesh that stands in several places, the name
  std::vector<MadeMaterial> materials;
  std::map<std::string, std::string> pictures; ///< by the model's names for them
  std::map<std::string, Mat4d> places;         ///< of nodes
  size_t meshes = 0, triangles = 0, instances = 0, materialCount = 0, emitters = 0, lights = 0;
  size_t unknownLights = 0, flat = 0, colouredMeshes = 0, skinnedMeshes = 0;
};

} // namespace

void registerMeshFile(PlugIns& plugIns) {
  plugIns.imports.add(
      {{.name = "mesh",
        .summary =
            "A model of a kind that Assimp reads (glTF, OBJ with MTL, COLLADA, FBX, 3DS, STL and more), with "
            "its materials, pictures, lights and cameras.",
        .parameters = {stringParameter("filename", "", "the model").require(),
                       booleanParameter(
                           "materials", "true",
                           "take the file's materials; false: the one that the Shape stands under"),
                       booleanParameter("lights", "true", "take the file's lights and emitting materials")},
        .examples = {}},
       [](const Parameters& p, const ImportContext& context) {
         auto import = std::make_unique<SceneImport>();
         MeshFileImport(p, context, *import).run();
         return import;
       }});
}

} // namespace recurse
