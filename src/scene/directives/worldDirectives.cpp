/** @file
 * Directives of the world: blocks, materials, textures, shapes, lights, media, objects, imports.
 */
#include <algorithm>

#include "scene/directives/sceneParser.h"
#include "scene/parameters/parameterParser.h"

namespace recurse::sceneFile {

namespace {

/** Maximum depth of nested blocks; each keeps a copy of the graphics state. */
constexpr size_t MAX_OPEN_BLOCKS = 4096;
/** Limits of defaults, which are copied whenever an Attribute directive changes them. */
constexpr size_t MAX_ATTRIBUTES = 256, MAX_ATTRIBUTE_VALUES = 4096;

constexpr const char* ATTRIBUTE_TARGET_NAMES[ATTRIBUTE_TARGETS] = {"shape", "light", "material", "medium",
                                                                   "texture"};

/** True for names of a surface without scattering. */
bool isInterface(const std::string& material) {
  return material.empty() || material == "none" || material == "interface";
}

/** True for light that is isotropic, and hence independent of the transform. */
bool isTheSameFromEverywhere(const ParsedDirective& light) {
  const auto depends = [](const std::vector<ParsedParameter>& parameters) {
    return std::any_of(parameters.begin(), parameters.end(),
                       [](const ParsedParameter& p) { return p.name == "filename" || p.name == "portal"; });
  };
  return light.type == "infinite" && !depends(light.parameters) &&
         !(light.attributes && depends(*light.attributes));
}

} // namespace

void SceneParser::openBlock(OpenBlock::Kind kind, const Token& directive) {
  if (blocks.size() >= MAX_OPEN_BLOCKS)
    throw SceneError(directive.location(),
                     "more than " + std::to_string(MAX_OPEN_BLOCKS) + " blocks are open");
  blocks.push_back({kind, directive.location(), state});
}

void SceneParser::closeBlock() {
  state = std::move(blocks.back().saved);
  if (blocks.back().kind == OpenBlock::Kind::OBJECT) object = nullptr;
  blocks.pop_back();
}

void SceneParser::reportOpenBlocks() {
  while (blocks.size() > firstBlock) {
    const bool isObject = blocks.back().kind == OpenBlock::Kind::OBJECT;
    log.error(blocks.back().location,
              isObject ? "this ObjectBegin has no ObjectEnd" : "this block has no AttributeEnd");
    closeBlock();
  }
}

void SceneParser::attributeBegin(const Token& t) { openBlock(OpenBlock::Kind::ATTRIBUTE, t); }

void SceneParser::attributeEnd(const Token& t) {
  const std::string name(t.text);
  if (blocks.size() <= firstBlock)
    throw SceneError(t.location(),
                     name + " without AttributeBegin" + (firstBlock > 0 ? " in the imported file" : ""));
  if (blocks.back().kind == OpenBlock::Kind::OBJECT)
    throw SceneError(t.location(), name + ", but the innermost open block is the ObjectBegin at " +
                                       placeName(blocks.back().location));
  closeBlock();
}

void SceneParser::attribute(const Token& t) {
  const Token target = takeString(t, "the kind of directive");
  const std::string name = target.value();
  std::vector<ParsedParameter> parameters =
      takeParameters("", name == "light" ? SpectrumKind::ILLUMINANT : SpectrumKind::UNBOUNDED);
  size_t index = 0;
  while (index < ATTRIBUTE_TARGETS && name != ATTRIBUTE_TARGET_NAMES[index]) ++index;
  if (index == ATTRIBUTE_TARGETS)
    throw SceneError(target.location(), "unknown target of Attribute: " + target.shown(),
                     "\"shape\" \"light\" \"material\" \"medium\" \"texture\"");
  auto changed = state.attributes[index]
                     ? std::make_shared<std::vector<ParsedParameter>>(*state.attributes[index])
                     : std::make_shared<std::vector<ParsedParameter>>();
  for (ParsedParameter& p : parameters) {
    if (p.numbers.size() + p.strings.size() + p.booleans.size() > MAX_ATTRIBUTE_VALUES)
      throw SceneError(p.location,
                       "an attribute takes at most " + std::to_string(MAX_ATTRIBUTE_VALUES) + " values");
    std::erase_if(*changed, [&](const ParsedParameter& old) { return old.name == p.name; });
    changed->push_back(std::move(p));
  }
  if (changed->size() > MAX_ATTRIBUTES)
    throw SceneError(t.location(), "more than " + std::to_string(MAX_ATTRIBUTES) + " attributes are set");
  state.attributes[index] = std::move(changed);
}

void SceneParser::reverseOrientation(const Token&) { state.reverseOrientation = !state.reverseOrientation; }

void SceneParser::material(const Token& t) {
  const Token name = tokens->peek();
  ParsedDirective d = takePlugIn(t, AttributeTarget::MATERIAL);
  state.material = {};
  state.material.location = name.location();
  if (isInterface(d.type)) {
    for (const ParsedParameter& p : d.parameters)
      log.error(p.location, "Material " + name.shown() + " takes no parameters");
    state.material.kind = MaterialReference::Kind::NONE;
    return;
  }
  state.material.index = static_cast<int>(scene.materials.size());
  scene.materials.push_back(std::move(d));
}

void SceneParser::makeNamedMaterial(const Token& t) {
  ParsedDirective d = takePlugIn(t, AttributeTarget::MATERIAL);
  const std::string name = d.type;
  const SourceLocation where = d.location;
  moveTypeOut(d, "material");
  checkForPbrt3PlugIn("Material", d);
  if (isInterface(d.type)) d.type = "interface";
  const auto [old, isNew] = scene.namedMaterials.emplace(name, std::move(d));
  if (!isNew)
    log.error(where, "material \"" + name + "\" is already defined, at " + placeName(old->second.location));
}

void SceneParser::namedMaterial(const Token& t) {
  const Token name = takeString(t, "the name of a material");
  state.material = {};
  state.material.kind = MaterialReference::Kind::NAME;
  state.material.name = name.value();
  state.material.location = name.location();
}

void SceneParser::texture(const Token& t) {
  const Token nameToken = takeString(t, "a name for the texture");
  const Token kind = takeString(t, "the type \"float\" or \"spectrum\"");
  TextureDescription texture;
  texture.name = nameToken.value();
  texture.texture = takePlugIn(t, AttributeTarget::TEXTURE);
  texture.spectrum = kind.text == "spectrum";
  if (kind.text == "color") warnOfPbrt3(kind.location());
  if (!texture.spectrum && kind.text != "float")
    throw SceneError(kind.location(), "unknown type of texture " + kind.shown(), "\"float\" \"spectrum\"");
  texture.worldFromTexture = restingTransform(nameToken.location(), "a texture");
  const auto [old, isNew] =
      textureNames.emplace(std::pair(texture.spectrum, texture.name), nameToken.location());
  if (!isNew) {
    log.error(nameToken.location(), std::string(kind.text) + " texture " + nameToken.shown() +
                                        " is already defined, at " + placeName(old->second));
    return;
  }
  scene.textures.push_back(std::move(texture));
}

void SceneParser::shape(const Token& t) {
  ShapeDescription s;
  lampsWithShape.insert(state.areaLight);
  s.shape = takePlugIn(t, AttributeTarget::SHAPE);
  s.worldFromObject = firstTransform(s.shape.location);
  s.worldFromObjectLast = lastTransform();
  s.reverseOrientation = state.reverseOrientation;
  s.material = state.material;
  s.areaLight = state.areaLight;
  s.medium = state.medium;
  (object ? object->shapes : scene.shapes).push_back(std::move(s));
}

void SceneParser::lightSource(const Token& t) {
  LightDescription l;
  l.light = takePlugIn(t, AttributeTarget::LIGHT);
  if (!isTheSameFromEverywhere(l.light))
    l.worldFromLight = restingTransform(l.light.location, "a LightSource");
  l.medium = state.medium.outside;
  scene.lights.push_back(std::move(l));
}

void SceneParser::areaLightSource(const Token& t) {
  ParsedDirective d = takePlugIn(t, AttributeTarget::LIGHT);
  state.areaLight = -1;
  if (d.type.empty()) return;
  state.areaLight = static_cast<int>(scene.areaLights.size());
  scene.areaLights.push_back(std::move(d));
}

void SceneParser::reportUnusedLamps() {
  for (size_t i = 0; i < scene.areaLights.size(); ++i)
    if (!lampsWithShape.contains(static_cast<int>(i)))
      log.warning(scene.areaLights[i].location, "no shape follows that this light could shine from",
                  "a Shape after it, in the same AttributeBegin and AttributeEnd");
}

void SceneParser::mediumInterface(const Token& t) {
  state.medium.inside = takeString(t, "the name of a medium").value();
  state.medium.outside =
      tokens->peek().kind == TokenKind::STRING ? tokens->take().value() : state.medium.inside;
}

void SceneParser::makeNamedMedium(const Token& t) {
  ParsedDirective d = takePlugIn(t, AttributeTarget::MEDIUM);
  const std::string name = d.type;
  const SourceLocation where = d.location;
  moveTypeOut(d, "medium");
  const Mat4d worldFromMedium = restingTransform(where, "a medium");
  const auto [old, isNew] = scene.media.emplace(name, std::move(d));
  if (!isNew)
    log.error(where, "medium \"" + name + "\" is already defined, at " + placeName(old->second.location));
  else
    scene.worldFromMedium[name] = worldFromMedium;
}

void SceneParser::objectBegin(const Token& t) {
  const Token name = takeString(t, "a name for the object");
  if (object)
    throw SceneError(t.location(),
                     "ObjectBegin inside the object that began at " + placeName(object->location));
  openBlock(OpenBlock::Kind::OBJECT, t);
  const auto [place, isNew] = scene.objects.try_emplace(name.value());
  if (isNew) {
    object = &place->second;
    object->name = place->first;
    object->location = name.location();
    return;
  }
  object = &discarded;
  object->location = name.location();
  log.error(name.location(),
            "object " + name.shown() + " is already defined, at " + placeName(place->second.location));
}

void SceneParser::objectEnd(const Token& t) {
  bool open = false;
  for (size_t i = firstBlock; i < blocks.size(); ++i) open |= blocks[i].kind == OpenBlock::Kind::OBJECT;
  if (!open)
    throw SceneError(t.location(), object ? "ObjectEnd for an object of the file that imports this one"
                                          : "ObjectEnd without ObjectBegin");
  while (blocks.back().kind != OpenBlock::Kind::OBJECT) {
    log.error(t.location(),
              "ObjectEnd, but the block at " + placeName(blocks.back().location) + " is still open");
    closeBlock();
  }
  closeBlock();
}

void SceneParser::objectInstance(const Token& t) {
  const Token name = takeString(t, "the name of an object");
  InstanceDescription instance;
  instance.object = name.value();
  instance.location = name.location();
  instance.worldFromInstance = firstTransform(name.location());
  instance.worldFromInstanceLast = lastTransform();
  if (!object)
    scene.instances.push_back(std::move(instance));
  else if (instance.worldFromInstanceLast)
    log.error(instance.location, "an instance inside of an object cannot move by itself",
              "the motion at the ObjectInstance of the whole object");
  else
    nested.add(object->name, std::move(instance));
}

void SceneParser::import(const Token& t) {
  const Token name = takeString(t, "a file name");
  const Source* source = tokens->resolve(name, "Import");
  if (!source) return;
  const GraphicsState saved = state;
  const size_t savedFirst = firstBlock;
  firstBlock = blocks.size();
  parseTokens(*source);
  firstBlock = savedFirst;
  state = saved;
}

} // namespace recurse::sceneFile
