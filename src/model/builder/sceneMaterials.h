/** @file
 * Materials and textures of a scene, made when they are first used.
 */
#pragma once

#include <map>

#include "model/builder/buildContext.h"
#include "recurse/model/bsdf/bsdf.h"
#include "recurse/model/medium/medium.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

class SceneMaterials final : public TextureLookup {
 public:
  /** `textures` and `materials` own the made objects. */
  SceneMaterials(BuildContext& context, std::vector<std::unique_ptr<Texture>>& textures,
                 std::vector<std::unique_ptr<Material>>& materials)
      : c(context), textures(textures), materials(materials) {}

  TexturedRgb rgb(const Parameters& p, const std::string& name) const override {
    return lookUp(p, name, true);
  }
  TexturedRgb real(const Parameters& p, const std::string& name) const override {
    return lookUp(p, name, false);
  }
  /** The material of a reference. Null for none, and after an error. */
  const Material* material(const MaterialReference& r);

  /** Sets the medium inside a dielectric with priority; an error where one material would have two. */
  void fillNested(const Material& m, const MediumInterface& media, const SourceLocation& where);
  /** Names of the made materials: the name in the file, or the kind with a number. */
  std::map<const Material*, std::string> names() const;
  /** Names in the file by Material::number; empty for a material without a name. */
  std::vector<std::string> labels() const;
  /** Numbers the dielectrics with priority, highest first, with refractive index and medium of each. */
  void numberNested(std::vector<float>& indices, std::vector<uint16_t>& media);

 private:
  /** Parts of a texture or material, itself included, each counted as often as it is evaluated. */
  struct Extent {
    int levels = 0;
    double count = 0;
  };
  struct NamedTexture {
    const Texture* texture = nullptr;
    bool underWay = false;
    Extent extent;
  };
  struct Named {
    const Material* material = nullptr;
    bool underWay = false;
    Extent extent;
  };

  TexturedRgb lookUp(const Parameters& p, const std::string& name, bool spectrum) const;
  /** Counts a texture as a part of the one being made. Throws SceneError for too many. */
  void addPart(const Parameters& p, const std::string& name, const Extent& part) const;
  const Material* makeMaterial(const ParsedDirective& d);
  /** The material of a name, also as a part of a composite material. Null after an error. */
  const Material* namedMaterial(const std::string& name, const SourceLocation& where);
  /** Counts a material as a part of the one being made. False, after an error, for too many. */
  bool addPart(const Extent& part, const SourceLocation& where);
  uint16_t mediumWithin(const Material* m) const;
  /** Index of the first nested material of equal priority, index and medium; if none, their number. */
  size_t sameNested(const Material& material) const;

  BuildContext& c;
  std::vector<std::unique_ptr<Texture>>& textures;
  std::vector<std::unique_ptr<Material>>& materials;
  mutable std::map<std::pair<std::string, bool>, NamedTexture> texturesByName;
  mutable int texturesUnderWay = 0;
  mutable Extent parts; ///< of the texture being made
  int materialsUnderWay = 0;
  Extent materialParts; ///< of the material being made
  std::map<std::string, Named> materialsByName;
  std::map<const Material*, uint16_t> mediumInNested;
  std::vector<std::pair<bool, const Material*>> materialsByIndex;
  std::vector<Material*> nested; ///< materials with a priority, in the order of their use
  size_t nestedKinds = 0;        ///< distinct combinations of priority, index and medium
};

} // namespace recurse
