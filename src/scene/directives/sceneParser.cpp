/** @file
 * Table of directives, the loop over them, and resynchronisation after an error.
 */
#include "scene/directives/sceneParser.h"

#include <algorithm>
#include <unordered_map>

#include "recurse/core/threads/interrupt.h"
#include "recurse/scene/parameters/otherNames.h"
#include "recurse/scene/parameters/spectrum.h"
#include "scene/parameters/parameterParser.h"
#include "scene/text/directiveNames.h"
#include "scene/text/pbrt3.h"

namespace recurse::sceneFile {

const std::vector<SceneParser::Directive>& SceneParser::directives() {
  using enum DirectiveScope;
  using P = SceneParser;
  static const std::vector<Directive> TABLE = {
      {"Accelerator", "\"name\" parameters", BEFORE_WORLD,
       "The acceleration structure for rays; no effect on the picture.", &P::accelerator},
      {"ActiveTransform", "All | StartTime | EndTime", ANYWHERE,
       "Chooses which of the two transforms of a moving object the following directives change, for motion "
       "blur.",
       &P::activeTransform},
      {"Animate", "\"name\" parameters", ANYWHERE,
       "Numbers that change from frame to frame, see below: `$name` replaces numbers and parts of strings in "
       "the following directives.",
       &P::animate},
      {"AreaLightSource", "\"name\" parameters", IN_WORLD,
       "The following shapes emit light, until the name \"\".", &P::areaLightSource},
      {"Attribute", "\"shape|light|material|medium|texture\" parameters", ANYWHERE,
       "Default parameters of the following directives of this kind.", &P::attribute},
      {"AttributeBegin", "", IN_WORLD, "Saves transform, material, lights, media and attributes.",
       &P::attributeBegin},
      {"AttributeEnd", "", IN_WORLD, "Restores what the matching AttributeBegin saved.", &P::attributeEnd},
      {"Camera", "\"name\" parameters", BEFORE_WORLD,
       "The camera, at the inverse of the current transform; defines the coordinate system \"camera\". A "
       "scene "
       "may have several with different parameters \"name\": the first renders, or that of `--camera`, whose "
       "coordinate system \"camera\" is valid after WorldBegin.",
       &P::camera},
      {"ColorSpace", "\"name\"", ANYWHERE,
       "The colour space of the rgb values that follow: \"srgb\" (linear Rec. 709), \"rec2020\", \"dci-p3\", "
       "\"aces2065-1\"; pictures are Rec. 709.",
       &P::colorSpace},
      {"ConcatTransform", "[ 16 numbers ]", ANYWHERE,
       "Multiplies the current transform by a matrix, given column by column.", &P::concatTransform},
      {"CoordSysTransform", "\"name\"", ANYWHERE, "Sets the current transform to a named coordinate system.",
       &P::coordSysTransform},
      {"CoordinateSystem", "\"name\"", ANYWHERE, "Names the current transform as a coordinate system.",
       &P::coordinateSystem},
      {"Film", "\"name\" parameters", BEFORE_WORLD, "Size, crop and exposure of the picture.", &P::film},
      {"Identity", "", ANYWHERE, "Sets the current transform to the identity.", &P::identity},
      {"Import", "\"file\"", IN_WORLD, "Reads a file; its transforms and attributes end with the file.",
       &P::import},
      {"Include", "\"file\"", ANYWHERE, "Inserts the text of another file.", &P::doNothing},
      {"Integrator", "\"name\" parameters", BEFORE_WORLD, "The algorithm that computes light.",
       &P::integrator},
      {"LightScale", "\"lamp\" parameters", ANYWHERE,
       "Multiplies the light of the lamps of a name, given before or after: the parameter \"name\" of a "
       "light "
       "or of its shape, or the number that `recurse stills --by light` shows, such as \"light-3\".",
       &P::lightScale},
      {"LightSource", "\"name\" parameters", IN_WORLD, "A light without a surface.", &P::lightSource},
      {"LookAt", "eye.xyz target.xyz up.xyz", ANYWHERE,
       "Transform of a camera at a point that looks at another point.", &P::lookAt},
      {"MakeNamedMaterial", "\"name\" \"string type\" \"...\" parameters", IN_WORLD,
       "Defines a material; it may be used before its definition.", &P::makeNamedMaterial},
      {"MakeNamedMedium", "\"name\" \"string type\" \"...\" parameters", ANYWHERE, "Defines a medium.",
       &P::makeNamedMedium},
      {"Material", "\"name\" parameters", IN_WORLD,
       "The material of the following shapes; \"\" or \"interface\": a boundary without scattering.",
       &P::material},
      {"MediumInterface", "\"inside\" [\"outside\"]", ANYWHERE,
       "The media inside and outside of the following shapes; \"\": vacuum. One name sets both.",
       &P::mediumInterface},
      {"NamedMaterial", "\"name\"", IN_WORLD, "The following shapes get a material of MakeNamedMaterial.",
       &P::namedMaterial},
      {"ObjectBegin", "\"name\"", IN_WORLD, "Begins an object: its shapes appear only in instances.",
       &P::objectBegin},
      {"ObjectEnd", "", IN_WORLD, "Ends an object, and restores what ObjectBegin saved.", &P::objectEnd},
      {"ObjectInstance", "\"name\"", IN_WORLD,
       "Places an instance of an object at the current transform, in the world or inside of another object.",
       &P::objectInstance},
      {"Option", "\"name\" value", ANYWHERE, "Sets an option of the renderer, see below.", &P::option},
      {"PixelFilter", "\"name\" parameters", BEFORE_WORLD, "The filter of the film's pixels.",
       &P::pixelFilter},
      {"ReverseOrientation", "", IN_WORLD,
       "Reverses the normals of the following shapes. A mirroring Scale also reverses them for spheres, "
       "cylinders, discs and other quadrics that emit no light, as in pbrt.",
       &P::reverseOrientation},
      {"Rotate", "degrees axis.xyz", ANYWHERE, "Rotates about an axis through the origin.", &P::rotate},
      {"Sampler", "\"name\" parameters", BEFORE_WORLD, "Number of samples for each pixel, and the seed.",
       &P::sampler},
      {"Scale", "x y z", ANYWHERE, "Scales along the axes.", &P::scale},
      {"Shape", "\"name\" parameters", IN_WORLD, "A shape with the current transform, material and lights.",
       &P::shape},
      {"Texture", "\"name\" \"float|spectrum\" \"class\" parameters", IN_WORLD,
       "Defines a texture; float and spectrum textures have separate names.", &P::texture},
      {"Transform", "[ 16 numbers ]", ANYWHERE, "Sets the current transform to a matrix, column by column.",
       &P::transform},
      {"TransformBegin", "", IN_WORLD, "Old name of AttributeBegin.", &P::attributeBegin},
      {"TransformEnd", "", IN_WORLD, "Old name of AttributeEnd.", &P::attributeEnd},
      {"TransformTimes", "start end", BEFORE_WORLD, "Times of the two transforms of objects in motion.",
       &P::transformTimes},
      {"Translate", "x y z", ANYWHERE, "Translates the origin.", &P::translate},
      {"WorldBegin", "", BEFORE_WORLD,
       "Ends the settings and begins the scene; resets the current transform.", &P::worldBegin},
  };
  return TABLE;
}

const SceneParser::Directive* SceneParser::findDirective(std::string_view name) {
  static const std::unordered_map<std::string_view, const Directive*> BY_NAME = [] {
    std::unordered_map<std::string_view, const Directive*> map;
    for (const Directive& d : directives()) map.emplace(d.name, &d);
    return map;
  }();
  const auto found = BY_NAME.find(name);
  return found == BY_NAME.end() ? nullptr : found->second;
}

bool isDirectiveName(const Token& token) {
  return token.kind == TokenKind::WORD && (SceneParser::findDirective(token.text) ||
                                           pbrt3::isDirective(std::string(token.text.substr(0, 32))));
}

SceneParser::SceneParser(SceneDescription& scene, SourceFiles& files, Diagnostics& diagnostics,
                         std::string requestedCamera)
    : scene(scene), files(files), log(diagnostics), requestedCamera(std::move(requestedCamera)) {
  ParsedDirective diffuse;
  diffuse.type = "diffuse";
  scene.materials.push_back(diffuse);
}

void SceneParser::parse(const Source& top) {
  try {
    const std::string& text = top.text->text;
    if (text.rfind("\xff\xfe", 0) == 0 || text.rfind("\xfe\xff", 0) == 0) {
      Token start;
      start.source = &top;
      start.line = start.column = 1;
      log.error(start.location(), "the file is UTF-16; save it as UTF-8 or ASCII");
      return;
    }
    parseTokens(top);
    chooseCamera();
    nested.expand(scene, log);
    reportUnusedTracks();
    reportUnusedLamps();
    if (!inWorld) {
      SourceLocation where;
      where.source = top.text; // no line, since the directive is missing
      log.error(where, "the file has no WorldBegin, which separates the settings from the scene");
    }
  } catch (const TooManyErrors&) {
    // reported in the diagnostics
  }
}

void SceneParser::parseTokens(const Source& source) {
  TokenStream stream(source, files, log, includes, tokens);
  TokenStream* const outer = tokens;
  tokens = &stream;
  for (;;) {
    checkInterrupted();
    try {
      const Token token = tokens->take();
      if (token.kind == TokenKind::END) break;
      const Directive* directive = token.kind == TokenKind::WORD ? findDirective(token.text) : nullptr;
      if (directive) {
        carryOut(*directive, token);
      } else {
        unknownDirective(token);
        resynchronise();
      }
    } catch (const SceneError& e) {
      log.report(e);
      resynchronise();
    }
  }
  reportOpenBlocks();
  tokens = outer;
}

void SceneParser::carryOut(const Directive& directive, const Token& token) {
  if (directive.place == DirectiveScope::BEFORE_WORLD && inWorld && !assumedWorld) {
    log.error(token.location(), token.text == "WorldBegin"
                                    ? "a second WorldBegin: the scene has already begun"
                                    : std::string(directive.name) + " must stand before WorldBegin");
    resynchronise();
    return;
  }
  if (directive.place == DirectiveScope::IN_WORLD && !inWorld) {
    // Reports one error for all following directives: most likely WorldBegin is missing.
    log.error(token.location(), std::string(directive.name) + " must stand after WorldBegin");
    inWorld = assumedWorld = true;
  }
  (this->*directive.carryOut)(token);
}

void SceneParser::unknownDirective(const Token& token) {
  if (token.kind != TokenKind::WORD || looksLikeNumber(token)) {
    log.error(token.location(), "expected a directive, found " + token.shown());
    return;
  }
  const std::string word(token.text.substr(0, 64));
  if (pbrt3::isDirective(word)) {
    log.error(token.location(), "pbrt-v4 has no directive " + token.shown() +
                                    (word == "WorldEnd" ? "; the end of the file ends the world" : ""));
    warnOfPbrt3(token.location());
    return;
  }
  std::vector<std::string> names;
  for (const Directive& d : directives()) names.emplace_back(d.name);
  std::string message = "unknown directive " + token.shown();
  std::vector<std::string> near = nearestNames(word, names);
  if (near.empty())
    for (const PlugInName& meant : plugInsMeantBy(word))
      near.push_back(meant.kind == "MakeNamedMedium"
                         ? meant.kind + R"( "name" "string type" ")" + meant.name + "\""
                         : meant.kind + " \"" + meant.name + "\"");
  for (size_t i = 0; i < near.size(); ++i) message += (i ? " or " : "; did you mean ") + near[i];
  if (!near.empty()) message += "?";
  std::string accepted;
  for (const std::string& name : names) accepted += (accepted.empty() ? "" : " ") + name;
  log.error(token.location(), message, accepted);
}

void SceneParser::resynchronise() {
  for (;;) {
    try {
      while (tokens->peek().kind != TokenKind::END && !isDirectiveName(tokens->peek())) tokens->take();
      return;
    } catch (const SceneError&) {
      // A broken string in the skipped text: the lexer has moved past it.
    }
  }
}

void SceneParser::warnOfPbrt3(const SourceLocation& where) {
  if (!hasWarnedOfPbrt3) log.warning(where, pbrt3::ADVICE);
  hasWarnedOfPbrt3 = true;
}

void SceneParser::checkForPbrt3PlugIn(const char* directive, const ParsedDirective& d) {
  if (pbrt3::isPlugIn(directive, d.type)) warnOfPbrt3(d.location);
}

Token SceneParser::takeString(const Token& directive, const char* what) {
  const Token token = tokens->peek();
  if (token.kind != TokenKind::STRING)
    throw SceneError(token.kind == TokenKind::END ? directive.location() : token.location(),
                     std::string(directive.text) + " needs " + what + " in quotes, found " + token.shown());
  return tokens->take();
}

std::vector<ParsedParameter> SceneParser::takeParameters(const std::string& directory, SpectrumKind kind) {
  std::vector<ParsedParameter> parameters = parseParameters(*tokens, log, directory);
  if (state.colorSpace.empty()) return parameters;
  for (ParsedParameter& p : parameters) {
    if (p.type != "rgb") continue;
    auto& v = p.numbers;
    for (size_t i = 0; i + 2 < v.size(); i += 3) {
      const Rgbd c = rgbInColorSpace(state.colorSpace, {v[i], v[i + 1], v[i + 2]}, kind);
      for (int k = 0; k < 3; ++k) v[i + size_t(k)] = c[k];
    }
  }
  return parameters;
}

ParsedDirective SceneParser::takePlugIn(const Token& directive) {
  const Token name = takeString(directive, "a name");
  ParsedDirective d;
  d.type = name.value();
  d.location = name.location();
  d.directory = name.source->directory;
  d.topDirectory = files.topDirectory;
  const bool isLight = directive.text == "LightSource" || directive.text == "AreaLightSource";
  d.parameters = takeParameters(d.directory, isLight ? SpectrumKind::ILLUMINANT : SpectrumKind::UNBOUNDED);
  for (const ParsedParameter& p : d.parameters)
    if (p.type == "blackbody" && p.numbers.size() == 2) warnOfPbrt3(p.location);
  if (log.sawPbrt3Type) warnOfPbrt3(d.location);
  checkForPbrt3PlugIn(std::string(directive.text).c_str(), d);
  return d;
}

ParsedDirective SceneParser::takePlugIn(const Token& directive, AttributeTarget target) {
  ParsedDirective d = takePlugIn(directive);
  d.attributes = state.attributes[static_cast<size_t>(target)];
  return d;
}

void SceneParser::moveTypeOut(ParsedDirective& d, const std::string& what) {
  // The last of several parameters with the same name counts, as everywhere.
  const ParsedParameter* type = nullptr;
  for (const ParsedParameter& p : d.parameters)
    if (p.name == "type" && p.type == "string" && p.strings.size() == 1) type = &p;
  if (!type)
    throw SceneError(d.location,
                     what + " \"" + d.type + "\" needs a parameter \"string type\" with its kind");
  d.type = type->strings[0];
  d.location = type->valueLocation;
  std::erase_if(d.parameters, [](const ParsedParameter& p) { return p.name == "type"; });
}

} // namespace recurse::sceneFile
