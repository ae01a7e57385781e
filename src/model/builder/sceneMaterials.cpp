/** @file
 * Textures and materials by name, each made once.
 */
#include "model/builder/sceneMaterials.h"

#include <algorithm>
#include <utility>

#include "recurse/core/io/text.h"
#include "recurse/model/scene/scene.h"

namespace recurse {

namespace {

/** Levels of nested textures, and of nested materials: bounds the recursion. */
constexpr int MAX_LEVELS = 256;
/** Textures or materials evaluated for one value. */
constexpr double MAX_PARTS = 100000;

[[noreturn]] void failAsTooDeep(const Parameters& p, const std::string& name) {
  p.fail(name, "textures are nested more than " + std::to_string(MAX_LEVELS) + " levels");
}

} // namespace

uint16_t SceneMaterials::mediumWithin(const Material* m) const {
  const auto found = mediumInNested.find(m);
  return found == mediumInNested.end() ? Scene::SURROUNDING_MEDIUM : found->second;
}

size_t SceneMaterials::sameNested(const Material& material) const {
  const auto same = [&](const Material* m) {
    return m->priority() == material.priority() && m->indexInside() == material.indexInside() &&
           mediumWithin(m) == mediumWithin(&material);
  };
  return static_cast<size_t>(std::find_if(nested.begin(), nested.end(), same) - nested.begin());
}

void SceneMaterials::addPart(const Parameters& p, const std::string& name, const Extent& part) const {
  if (texturesUnderWay == 0) return;
  parts.levels = std::max(parts.levels, part.levels);
  parts.count += part.count;
  if (parts.levels >= MAX_LEVELS) failAsTooDeep(p, name);
  if (parts.count > MAX_PARTS)
    p.fail(name, formatted("a value depends on more than %.0f textures", MAX_PARTS));
}

TexturedRgb SceneMaterials::lookUp(const Parameters& p, const std::string& name, bool spectrum) const {
  const std::string texture = p.texture(name);
  if (texture.empty()) return {spectrum ? Rgb(p.spectrum(name)) : Rgb(static_cast<float>(p.real(name)))};
  const auto [lowest, highest] = p.range(name);
  const auto textured = [&, low = float(lowest), high = float(highest)](const Texture* t) {
    return TexturedRgb{BLACK, t, low, high};
  };
  const auto key = std::make_pair(texture, spectrum);
  const auto found = texturesByName.find(key);
  if (found != texturesByName.end()) {
    if (found->second.underWay) p.fail(name, "texture \"" + texture + "\" depends on itself");
    addPart(p, name, found->second.extent);
    return textured(found->second.texture);
  }
  std::vector<std::string> names;
  for (size_t i = c.description.textures.size(); i > 0; --i) {
    const TextureDescription& t = c.description.textures[i - 1];
    if (t.spectrum != spectrum) continue;
    if (t.name != texture) {
      names.push_back(t.name);
      continue;
    }
    if (texturesUnderWay >= MAX_LEVELS) failAsTooDeep(p, name);
    texturesByName[key] = {nullptr, true, {}};
    ++texturesUnderWay;
    const Extent around = std::exchange(parts, {});
    const TextureContext context{*this, spectrum, t.worldFromTexture, &c.sceneOrigin};
    std::unique_ptr<Texture> made = plugIns().textures.make(t.texture, context, c.diagnostics, c.lenient);
    const Texture* pointer = made.get();
    if (made) textures.push_back(std::move(made));
    const Extent extent{parts.levels + 1, parts.count + 1};
    parts = around;
    --texturesUnderWay;
    texturesByName[key] = {pointer, false, extent};
    addPart(p, name, extent);
    return textured(pointer);
  }
  const bool isOtherKind = std::ranges::any_of(
      c.description.textures, [&](const TextureDescription& t) { return t.name == texture; });
  const char *kind = spectrum ? "spectrum" : "float", *other = spectrum ? "float" : "spectrum";
  p.fail(name,
         isOtherKind ? formatted("texture \"%s\" is a %s texture; this parameter takes a %s texture",
                                 texture.c_str(), other, kind)
                     : formatted("there is no %s texture \"%s\"", kind, texture.c_str()),
         quotedList(nearestNames(texture, names)));
}

const Material* SceneMaterials::makeMaterial(const ParsedDirective& d) {
  const MaterialContext context{
      *this, [this](const Parameters& p, const std::string& parameter, const std::string& name) {
        SourceLocation where = p.location(parameter);
        const Material* m = namedMaterial(name, where);
        if (!m) p.fail(parameter, "material \"" + name + "\" cannot be used here");
        if (m->detail && p.plugInName() != "mix")
          p.fail(parameter, "material \"" + name + "\" has bumps, and cannot be used in another material",
                 "\"displacement\" or \"normalmap\" of \"" + p.plugInName() + "\" itself");
        if (m->opacity && p.plugInName() != "mix")
          p.fail(parameter,
                 "material \"" + name + "\" is a mix with \"interface\", and can be used in a mix only");
        if (m->filling)
          p.fail(parameter,
                 "material \"" + name + "\" contains a medium, and cannot be used in another material");
        return m;
      }};
  std::unique_ptr<Material> m = plugIns().materials.make(d, context, c.diagnostics, c.lenient);
  if (!m) return nullptr;
  if (m->priority() > 0) {
    if (sameNested(*m) == nested.size() && ++nestedKinds > Scene::MAX_NESTED)
      c.diagnostics.error(d.location,
                          "there are more than " + std::to_string(Scene::MAX_NESTED) +
                              " different dielectrics with a priority",
                          "priority and eta of one of the others");
    nested.push_back(m.get());
  }
  m->number = uint32_t(materials.size());
  materials.push_back(std::move(m));
  return materials.back().get();
}

bool SceneMaterials::addPart(const Extent& part, const SourceLocation& where) {
  if (materialsUnderWay == 0) return true;
  materialParts.levels = std::max(materialParts.levels, part.levels);
  materialParts.count += part.count;
  if (materialParts.levels >= MAX_LEVELS) {
    c.diagnostics.error(where, "materials are nested more than " + std::to_string(MAX_LEVELS) + " levels");
    return false;
  }
  if (materialParts.count > MAX_PARTS) {
    c.diagnostics.error(where, formatted("a material uses more than %.0f materials", MAX_PARTS));
    return false;
  }
  return true;
}

const Material* SceneMaterials::namedMaterial(const std::string& name, const SourceLocation& where) {
  const auto known = materialsByName.find(name);
  if (known != materialsByName.end()) {
    if (known->second.underWay) c.diagnostics.error(where, "material \"" + name + "\" depends on itself");
    return addPart(known->second.extent, where) ? known->second.material : nullptr;
  }
  const auto found = c.description.namedMaterials.find(name);
  if (found == c.description.namedMaterials.end()) {
    const std::vector<std::string> names = namesOf(c.description.namedMaterials);
    c.diagnostics.error(where, "there is no material named \"" + name + "\"",
                        quotedList(nearestNames(name, names)));
    materialsByName[name] = {};
    return nullptr;
  }
  if (materialsUnderWay >= MAX_LEVELS && !addPart({MAX_LEVELS, 0}, where)) return nullptr;
  materialsByName[name] = {nullptr, true, {}};
  ++materialsUnderWay;
  const Extent around = std::exchange(materialParts, {});
  const Material* m = makeMaterial(found->second);
  const Extent extent{materialParts.levels + 1, materialParts.count + 1};
  materialParts = around;
  --materialsUnderWay;
  materialsByName[name] = {m, false, extent};
  return addPart(extent, where) ? m : nullptr;
}

const Material* SceneMaterials::material(const MaterialReference& r) {
  switch (r.kind) {
  case MaterialReference::Kind::NONE:
    return nullptr;
  case MaterialReference::Kind::NAME: {
    const Material* m = namedMaterial(r.name, r.location);
    return m && m->lobes() == NO_LOBE ? nullptr : m; // an interface, like Material "interface"
  }
  case MaterialReference::Kind::INDEX:
    break;
  }
  const auto i = static_cast<size_t>(r.index);
  if (materialsByIndex.size() <= i) materialsByIndex.resize(c.description.materials.size());
  if (!materialsByIndex[i].first) materialsByIndex[i] = {true, makeMaterial(c.description.materials[i])};
  return materialsByIndex[i].second;
}

void SceneMaterials::fillNested(const Material& m, const MediumInterface& media,
                                const SourceLocation& where) {
  const uint16_t inside = media.isBoundary() ? media.inside : Scene::SURROUNDING_MEDIUM;
  const auto [known, isNew] = mediumInNested.try_emplace(&m, inside);
  if (!isNew && known->second != inside)
    c.diagnostics.error(where, "the material has a priority and contains another medium elsewhere",
                        "a material for each medium, with a priority of its own");
}

std::map<const Material*, std::string> SceneMaterials::names() const {
  std::map<const Material*, std::string> out;
  for (const auto& [name, m] : materialsByName)
    if (m.material) out[m.material] = name;
  ObjectNames kinds;
  for (size_t i = 0; i < materialsByIndex.size(); ++i) {
    const std::string& kind = c.description.materials[i].type;
    if (const Material* m = materialsByIndex[i].second)
      out[m] = kinds[kinds.add(kind.empty() ? "diffuse" : kind)];
  }
  return out;
}

std::vector<std::string> SceneMaterials::labels() const {
  std::vector<std::string> out(materials.size());
  for (const auto& [name, m] : materialsByName)
    if (m.material) out[m.material->number] = name;
  return out;
}

void SceneMaterials::numberNested(std::vector<float>& indices, std::vector<uint16_t>& media) {
  std::stable_sort(nested.begin(), nested.end(),
                   [](const Material* a, const Material* b) { return a->priority() > b->priority(); });
  for (size_t i = 0; i < nested.size(); ++i) {
    const size_t same = sameNested(*nested[i]);
    if (same < i) {
      nested[i]->nesting = nested[same]->nesting;
      continue;
    }
    nested[i]->nesting = static_cast<int>(indices.size());
    indices.push_back(nested[i]->indexInside());
    media.push_back(mediumWithin(nested[i]));
  }
}

} // namespace recurse
