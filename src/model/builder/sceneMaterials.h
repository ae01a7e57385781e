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
  /** What is made is kept in `textures` and `materials`. */
  SceneMaterials(BuildContext& context, std::vector<std::unique_ptr<Texture>>& textures,
                 std::vector<std::unique_ptr<Material>>& materials)
      : c(context), textures(textures), materials(materials) {}

  TexturedRgb rgb(const Parameters& p, const std::string& name) const override {
    return lookUp(p, name, true);
  }
  TexturedRgb real(const Parameters& p, const std::string& name) const override {
    return lookUp(p, name, false);
  }
  /** Null for none, and after an error. */
  const Material* material(const MaterialReference& r);

  /** What is inside of a dielectric with priority is told by its material alone. */
  void fillNested(const Material& m, const MediumInterface& media, const SourceLocation& where);
  /** Of those that were made: the name in the file, or the kind with a number. */
  std::map<const Material*, std::string> names() const;
  /** Numbers the dielectrics with priority, the strongest first; for each number its index and its medium. */
  void numberNested(std::vector<float>& indices, std::vector<uint16_t>& media);

 private:
  /** Parts that a texture or a material is made of, itself included, as often as they are asked for it. */
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
  /** Adds a texture to those that the one under way is made of. Throws SceneError for too many. */
  void addPart(const Parameters& p, const std::string& name, const Extent& part) const;
  const Material* makeMaterial(const ParsedDirective& d);
  /** Of one that is a part of another, too. Null after an error. */
  const Material* namedMaterial(const std::string& name, const SourceLocation& where);
  /** Adds a material to those that the one under way is made of. False, after an error, for too many. */
  bool addPart(const Extent& part, const SourceLocation& where);
  uint16_t mediumWithin(const Material* m) const;
  /** The first of the nested materials that is the same matter: priority and index are; or their number. */
  size_t sameNested(const Material& material) const;

  BuildContext& c;
  std::vector<std::unique_ptr<Texture>>& textures;
  std::vector<std::unique_ptr<Material>>& materials;
  mutable std::map<std::pair<std::string, bool>, NamedTexture> texturesByName;
  mutable int texturesUnderWay = 0;
  mutable Extent parts; ///< of the texture under way
  int materialsUnderWay = 0;
  Extent materialParts; ///< of the material under way
  std::map<std::string, Named> materialsByName;
  std::map<const Material*, uint16_t> mediumInNested;
  std::vector<std::pair<bool, const Material*>> materialsByIndex;
  std::vector<Material*> nested; ///< those with a priority, in the order of their use
  size_t nestedKinds = 0;        ///< of those, the ones that are not the same matter as another
};

} // namespace recurse
