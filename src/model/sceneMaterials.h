/** @file
 * Materials and textures of a scene, made when they are first used.
 */
#pragma once

#include <map>

#include "model/buildContext.h"
#include "recurse/model/bsdf.h"
#include "recurse/model/medium.h"
#include "recurse/model/plugIns.h"

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
  struct NamedTexture {
    const Texture* texture = nullptr;
    bool underWay = false;
  };
  struct Named {
    const Material* material = nullptr;
    bool underWay = false;
  };

  TexturedRgb lookUp(const Parameters& p, const std::string& name, bool spectrum) const;
  const Material* makeMaterial(const ParsedDirective& d);
  const Material* namedMaterial(const std::string& name, const SourceLocation& where);
  uint16_t mediumWithin(const Material* m) const;
  /** The first of the nested materials that is the same matter: priority and index are; or their number. */
  size_t sameNested(const Material& material) const;

  BuildContext& c;
  std::vector<std::unique_ptr<Texture>>& textures;
  std::vector<std::unique_ptr<Material>>& materials;
  mutable std::map<std::pair<std::string, bool>, NamedTexture> texturesByName;
  std::map<std::string, Named> materialsByName;
  std::map<const Material*, uint16_t> mediumInNested;
  std::vector<std::pair<bool, const Material*>> materialsByIndex;
  std::vector<Material*> nested; ///< those with a priority, in the order of their use
  size_t nestedKinds = 0;        ///< of those, the ones that are not the same matter as another
};

} // namespace recurse
