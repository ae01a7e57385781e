/** @file
 * Materials of models that Assimp reads: the metal and roughness of glTF, the older ones of Wavefront's MTL
 * and its like, and their pictures, inside of the file or beside it.
 */
#pragma once

#include <map>

#include <assimp/material.h>
#include <assimp/scene.h>

#include "recurse/model/sceneImport.h"

namespace recurse {

/** Directives of a material, as a scene file has them. */
struct MeshMaterial {
  bool made = false; ///< once it is asked for
  std::string directive = "Material \"diffuse\"", areaLight, shapeParameters;
  unsigned uvChannel = 0;
};

inline Rgbd colourOf(const aiColor3D& c) { return {c.r, c.g, c.b}; }

class AssimpMaterials {
 public:
  /** `p`: the parameters "filename" and "lights". */
  AssimpMaterials(const Parameters& p, SceneImport& import, ImportWriter& out);

  /** Whose materials they are; it must outlive this. */
  void use(const aiScene& scene);
  /** Written where it is asked for first. */
  const MeshMaterial& at(unsigned index);

  size_t count() const { return materialCount; }
  size_t pictureCount() const { return pictures.size(); }
  size_t emitterCount() const { return emitters; }

 private:
  /** A colour or number that may be multiplied by a texture. */
  struct Value {
    Rgbd factor{1};
    std::string texture; ///< name in the scene; empty: the factor alone
  };

  /** The file of a material's picture, kept for the scene; empty where there is none. `wanted` becomes true
   * where the material has one, found or not. */
  std::string picture(const aiMaterial& m, aiTextureType type, bool& wanted);
  std::string loadPicture(const std::string& name);
  std::string embedded(const aiTexture& texture);
  /** The colour `factor` times a picture. */
  Value spectrumValue(const aiMaterial& m, aiTextureType type, const Rgbd& factor);
  /** One channel of a picture times a number. */
  Value channelValue(const aiMaterial& m, aiTextureType type, const char* channel, double factor);
  /** glTF's roughness is the square root of alpha, and so is pbrt's roughness alpha squared. */
  std::string roughness(const aiMaterial& m, double factor);
  void makeMaterial(const aiMaterial& m, MeshMaterial& made);
  std::string normalMap(const aiMaterial& m);
  std::string metalAndRoughness(const aiMaterial& m, const std::string& name, aiTextureType colourType,
                                double eta, const std::string& bumps);
  /** Phong's model and its relatives. */
  std::string classic(const aiMaterial& m, aiTextureType colourType, double eta, const std::string& bumps,
                      MeshMaterial& made);
  void readAlpha(const aiMaterial& m, aiTextureType colourType, MeshMaterial& made);
  /** A picture without that channel is opaque. */
  bool hasAlpha(const std::string& file);
  void readEmission(const aiMaterial& m, MeshMaterial& made);
  static std::string spectrumParameter(const char* name, const Value& v);
  static std::string floatParameter(const char* name, const Value& v);

  const Parameters& p;
  SceneImport& import;
  ImportWriter& out;
  std::string path, directory;
  bool lightsWanted;
  const aiScene* scene = nullptr;
  std::vector<MeshMaterial> materials;
  std::map<std::string, std::string> pictures; ///< by the model's names for them
  size_t materialCount = 0, emitters = 0;
};

} // namespace recurse
