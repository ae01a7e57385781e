/** @file
 * Conversion of the materials of models that Assimp has read: the metallic-roughness model of glTF, and the
 * older models of Wavefront's MTL and similar formats, with pictures inside the file or beside it.
 */
#pragma once

#include <map>
#include <string>
#include <vector>

#include <assimp/scene.h>

#include "recurse/model/scene/sceneImport.h"

namespace recurse {

/** A colour or number that may be multiplied by a texture. */
struct AssimpValue {
  Rgbd factor{1};
  std::string texture; ///< name in the scene; empty: the factor alone
};

/** Colour of Assimp; components that are not finite become 0. */
Rgbd colourOf(const aiColor3D& colour);

class AssimpMaterials {
 public:
  AssimpMaterials(const aiScene& scene, const std::string& path, const Parameters& p, SceneImport& import,
                  ImportWriter& out);

  struct Made {
    bool made = false;
    std::string directive = "Material \"diffuse\"", areaLight, shapeParameters;
    unsigned uvChannel = 0;
  };
  /** Material at an index, converted on first use. */
  const Made& at(unsigned index);

  size_t count() const { return materialCount; }
  size_t emitterCount() const { return emitters; }
  size_t pictureCount() const { return pictures.size(); }

 private:
  void warnOfNumbers(const aiMaterial& m);
  void make(const aiMaterial& m, Made& made);
  std::string picture(const aiMaterial& m, aiTextureType type, bool& wanted);
  std::string loadPicture(const std::string& name);
  std::string embedded(const aiTexture& texture);
  AssimpValue spectrumValue(const aiMaterial& m, aiTextureType type, const Rgbd& factor);
  AssimpValue channelValue(const aiMaterial& m, aiTextureType type, const char* channel, double factor);
  std::string roughness(const aiMaterial& m, double factor);
  std::string normalMap(const aiMaterial& m);
  std::string metalAndRoughness(const aiMaterial& m, const std::string& name, aiTextureType colourType,
                                double eta, const std::string& bumps);
  std::string classic(const aiMaterial& m, aiTextureType colourType, double eta, const std::string& bumps,
                      Made& made);
  void readAlpha(const aiMaterial& m, aiTextureType colourType, Made& made);
  bool hasAlpha(const std::string& file) const;
  void readEmission(const aiMaterial& m, Made& made);

  const aiScene& scene;
  const Parameters& p;
  SceneImport& import;
  ImportWriter& out;
  std::string path, directory;
  bool lightsWanted;
  std::vector<Made> materials;
  std::map<std::string, std::string> pictures; ///< files by the model's names of pictures
  size_t materialCount = 0, emitters = 0;
};

} // namespace recurse
