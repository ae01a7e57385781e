/** @file
 * libFuzzer target: results of Assimp for a model, with arbitrary numbers, names and pictures, as a part of a
 * scene. Faults of Assimp itself are excluded.
 */
#include <bit>
#include <cstdlib>
#include <fuzzer/FuzzedDataProvider.h>

#include <assimp/GltfMaterial.h>
#include <assimp/ObjMaterial.h>
#include <assimp/scene.h>

#include "fuzz/fuzzing.h"
#include "importers/assimp/assimpScene.h"
#include "recurse/model/scene/plugIns.h"

namespace {

using namespace recurse;

class SceneMaker {
 public:
  SceneMaker(const uint8_t* data, size_t size) : in(data, size) {}

  std::unique_ptr<aiScene> make() {
    auto scene = std::make_unique<aiScene>();
    fill(scene->mMaterials, scene->mNumMaterials, 1, 3, [&] { return material(); });
    fill(scene->mTextures, scene->mNumTextures, 0, 2, [&] { return texture(); });
    fill(scene->mMeshes, scene->mNumMeshes, 0, 3, [&] { return mesh(scene->mNumMaterials); });
    scene->mRootNode = node(scene->mNumMeshes, 0);
    fill(scene->mLights, scene->mNumLights, 0, 2, [&] { return light(); });
    fill(scene->mCameras, scene->mNumCameras, 0, 2, [&] { return camera(); });
    fill(scene->mAnimations, scene->mNumAnimations, 0, 2, [&] { return animation(); });
    return scene;
  }

 private:
  unsigned below(unsigned count) { return in.ConsumeIntegralInRange(0u, count - 1); }
  /** Mostly common numbers, otherwise random bits. */
  float number() {
    return in.ConsumeBool() ? float(in.ConsumeIntegral<int8_t>()) / 8
                            : std::bit_cast<float>(in.ConsumeIntegral<uint32_t>());
  }
  aiVector3D vector() { return {number(), number(), number()}; }
  aiColor3D colour() { return {number(), number(), number()}; }
  std::string name() {
    static constexpr const char* NAMES[] = {"", "a", "*0", "*1", "m.png"};
    return in.ConsumeBool() ? NAMES[below(std::size(NAMES))] : in.ConsumeRandomLengthString(20);
  }
  template <class T, class Make>
  void fill(T**& list, unsigned& count, unsigned least, unsigned most, const Make& make) {
    count = in.ConsumeIntegralInRange(least, most);
    if (count == 0) return; // Assimp does not delete an empty list
    list = new T*[count];
    for (unsigned i = 0; i < count; ++i) list[i] = make();
  }

  aiMaterial* material() {
    auto* m = new aiMaterial;
    for (unsigned i = below(12); i > 0; --i) addProperty(*m);
    return m;
  }
  template <class T> static void add(aiMaterial& m, T value, const char* key, unsigned type, unsigned index) {
    m.AddProperty(&value, 1, key, type, index);
  }
  void addProperty(aiMaterial& m) {
    static constexpr aiTextureType PICTURES[] = {aiTextureType_BASE_COLOR,       aiTextureType_DIFFUSE,
                                                 aiTextureType_OPACITY,          aiTextureType_EMISSIVE,
                                                 aiTextureType_NORMALS,          aiTextureType_METALNESS,
                                                 aiTextureType_DIFFUSE_ROUGHNESS};
    const aiTextureType type = PICTURES[below(std::size(PICTURES))];
    switch (below(18)) {
    case 0:
      return add(m, colour(), AI_MATKEY_COLOR_DIFFUSE);
    case 1:
      return add(m, colour(), AI_MATKEY_COLOR_SPECULAR);
    case 2:
      return add(m, colour(), AI_MATKEY_COLOR_EMISSIVE);
    case 3:
      return add(m, aiColor4D(number(), number(), number(), 1), AI_MATKEY_BASE_COLOR);
    case 4:
      return add(m, number(), AI_MATKEY_ROUGHNESS_FACTOR);
    case 5:
      return add(m, number(), AI_MATKEY_METALLIC_FACTOR);
    case 6:
      return add(m, number(), AI_MATKEY_TRANSMISSION_FACTOR);
    case 7:
      return add(m, number(), AI_MATKEY_REFRACTI);
    case 8:
      return add(m, number(), AI_MATKEY_SHININESS);
    case 9:
      return add(m, number(), AI_MATKEY_OPACITY);
    case 10:
      return add(m, number(), AI_MATKEY_EMISSIVE_INTENSITY);
    case 11:
      return add(m, number(), AI_MATKEY_VOLUME_THICKNESS_FACTOR);
    case 12:
      return add(m, int(below(12)), AI_MATKEY_OBJ_ILLUM);
    case 13:
      return add(m, int(in.ConsumeIntegral<int8_t>()), AI_MATKEY_UVWSRC(type, 0));
    case 14: {
      static constexpr const char* MODES[] = {"OPAQUE", "MASK", "BLEND"};
      return add(m, aiString(MODES[below(3)]), AI_MATKEY_GLTF_ALPHAMODE);
    }
    case 15:
      return add(m, number(), AI_MATKEY_GLTF_ALPHACUTOFF);
    case 16: {
      aiUVTransform transform;
      transform.mTranslation = {number(), number()};
      transform.mScaling = {number(), number()};
      return add(m, transform, AI_MATKEY_UVTRANSFORM(type, 0));
    }
    default:
      return add(m, aiString(name()), AI_MATKEY_TEXTURE(type, 0));
    }
  }

  aiTexture* texture() {
    auto* t = new aiTexture;
    t->mWidth = in.ConsumeIntegralInRange(1u, 30u);
    t->mHeight = below(3);
    t->pcData = new aiTexel[t->mWidth * std::max(t->mHeight, 1u)]();
    const std::string hint = in.ConsumeRandomLengthString(8);
    hint.copy(t->achFormatHint, sizeof t->achFormatHint - 1);
    return t;
  }

  aiMesh* mesh(unsigned materialCount) {
    auto* m = new aiMesh;
    m->mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
    m->mName = aiString(name());
    m->mMaterialIndex = below(materialCount);
    m->mNumVertices = in.ConsumeIntegralInRange(1u, 6u);
    m->mVertices = vectors(m->mNumVertices);
    if (in.ConsumeBool()) m->mNormals = vectors(m->mNumVertices);
    if (in.ConsumeBool()) m->mTextureCoords[below(2)] = vectors(m->mNumVertices);
    m->mNumFaces = below(5);
    m->mFaces = new aiFace[m->mNumFaces];
    for (unsigned i = 0; i < m->mNumFaces; ++i) {
      m->mFaces[i].mNumIndices = 3;
      m->mFaces[i].mIndices = new unsigned[3];
      for (int k = 0; k < 3; ++k)
        m->mFaces[i].mIndices[k] = below(m->mNumVertices + (in.ConsumeBool() ? 0 : 1));
    }
    fill(m->mBones, m->mNumBones, 0, 2, [&] { return bone(m->mNumVertices); });
    fill(m->mAnimMeshes, m->mNumAnimMeshes, 0, 2, [&] { return morphTarget(m->mNumVertices); });
    return m;
  }
  aiBone* bone(unsigned vertexCount) {
    auto* b = new aiBone;
    b->mName = aiString(name());
    b->mNumWeights = below(4);
    b->mWeights = new aiVertexWeight[b->mNumWeights];
    for (unsigned i = 0; i < b->mNumWeights; ++i) b->mWeights[i] = {below(vertexCount + 1), number()};
    if (in.ConsumeBool()) b->mOffsetMatrix = matrix();
    return b;
  }
  aiAnimMesh* morphTarget(unsigned vertexCount) {
    auto* m = new aiAnimMesh;
    m->mNumVertices = in.ConsumeBool() ? vertexCount : below(vertexCount + 1);
    if (in.ConsumeBool()) m->mVertices = vectors(m->mNumVertices);
    if (in.ConsumeBool()) m->mNormals = vectors(m->mNumVertices);
    m->mWeight = number();
    return m;
  }

  aiAnimation* animation() {
    auto* a = new aiAnimation;
    a->mName = aiString(name());
    a->mDuration = double(number());
    a->mTicksPerSecond = double(number());
    fill(a->mChannels, a->mNumChannels, 0, 2, [&] { return nodeChannel(); });
    fill(a->mMorphMeshChannels, a->mNumMorphMeshChannels, 0, 2, [&] { return morphChannel(); });
    return a;
  }
  template <class Key, class Value> Key* keys(unsigned& count, const Value& value) {
    count = below(4);
    auto* list = new Key[count];
    for (unsigned i = 0; i < count; ++i) {
      list[i].mTime = double(number());
      list[i].mValue = value();
    }
    return list;
  }
  aiNodeAnim* nodeChannel() {
    auto* c = new aiNodeAnim;
    c->mNodeName = aiString(name());
    c->mPositionKeys = keys<aiVectorKey>(c->mNumPositionKeys, [&] { return vector(); });
    c->mRotationKeys = keys<aiQuatKey>(c->mNumRotationKeys,
                                       [&] { return aiQuaternion(number(), number(), number(), number()); });
    c->mScalingKeys = keys<aiVectorKey>(c->mNumScalingKeys, [&] { return vector(); });
    return c;
  }
  aiMeshMorphAnim* morphChannel() {
    auto* c = new aiMeshMorphAnim;
    c->mName = aiString(name());
    c->mNumKeys = below(4);
    c->mKeys = new aiMeshMorphKey[c->mNumKeys];
    for (unsigned i = 0; i < c->mNumKeys; ++i) {
      aiMeshMorphKey& key = c->mKeys[i];
      key.mTime = double(number());
      key.mNumValuesAndWeights = in.ConsumeIntegralInRange(1u, 4u);
      key.mValues = new unsigned[key.mNumValuesAndWeights];
      key.mWeights = new double[key.mNumValuesAndWeights];
      for (unsigned k = 0; k < key.mNumValuesAndWeights; ++k) {
        key.mValues[k] = below(5);
        key.mWeights[k] = double(number());
      }
    }
    return c;
  }
  aiVector3D* vectors(unsigned count) {
    auto* list = new aiVector3D[count];
    for (unsigned i = 0; i < count; ++i) list[i] = vector();
    return list;
  }

  aiMatrix4x4 matrix() {
    aiMatrix4x4 m;
    for (unsigned row = 0; row < 3; ++row)
      for (unsigned column = 0; column < 4; ++column) m[row][column] = number();
    return m;
  }

  aiNode* node(unsigned meshCount, int depth) {
    auto* n = new aiNode(name());
    if (in.ConsumeBool()) n->mTransformation = matrix();
    if (meshCount > 0) {
      n->mNumMeshes = below(3);
      n->mMeshes = new unsigned[n->mNumMeshes];
      for (unsigned i = 0; i < n->mNumMeshes; ++i) n->mMeshes[i] = below(meshCount);
    }
    if (depth < 4) fill(n->mChildren, n->mNumChildren, 0, 2, [&] { return node(meshCount, depth + 1); });
    return n;
  }

  aiLight* light() {
    auto* l = new aiLight;
    l->mName = aiString(name());
    l->mType = static_cast<aiLightSourceType>(below(6));
    l->mPosition = vector();
    l->mDirection = vector();
    l->mColorDiffuse = colour();
    l->mAngleInnerCone = number();
    l->mAngleOuterCone = number();
    return l;
  }

  aiCamera* camera() {
    auto* c = new aiCamera;
    c->mName = aiString(name());
    c->mPosition = vector();
    c->mUp = vector();
    c->mLookAt = vector();
    c->mHorizontalFOV = number();
    c->mAspect = number();
    return c;
  }

  FuzzedDataProvider in;
};

/** Steps, static weights and nodes without rotation, for the names of SceneMaker. */
GltfDetails gltfDetails() {
  GltfDetails details;
  details.animations.resize(1);
  details.animations[0].channels = {{{"a", "rotation"}, GltfInterpolation::STEP},
                                    {{"a", "weights"}, GltfInterpolation::STEP},
                                    {{"", "translation"}, GltfInterpolation::LINEAR}};
  details.nodeWeights = {{"a", {0.5, 2, -1}}};
  details.unrotatedNodes = {""};
  return details;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::vector<ParameterSpec> SPECS = {
      stringParameter("filename", "", ""), booleanParameter("materials", "true", ""),
      booleanParameter("lights", "true", ""), realParameter("time", "", ""),
      stringParameter("animation", "", "")};
  const std::unique_ptr<aiScene> scene = SceneMaker(data, size).make();
  static const GltfDetails DETAILS = gltfDetails();
  static constexpr const char* TIMES[] = {"", " \"float time\" 0.5", " \"float time\" -1",
                                          " \"string animation\" \"a\" \"float time\" 2"};
  const ParsedDirective shape = parseParameterText("mesh", "\"string filename\" \"/nowhere/model.gltf\"" +
                                                               std::string(TIMES[size % std::size(TIMES)]));
  Diagnostics diagnostics;
  const Parameters p = bindParameters(shape, SPECS, diagnostics, false);
  SceneImport import;
  bool made = false;
  readAnything([&] {
    importAssimpScene(*scene, "/nowhere/model.gltf", p, {"import1:", "import1/"},
                      size % 3 == 0 ? nullptr : &DETAILS, import);
    made = true;
  });
  if (made) checkImport(import);
  return 0;
}
