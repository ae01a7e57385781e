/** @file
 * Directives before WorldBegin: camera, film, sampler, options.
 */
#include <algorithm>
#include <array>

#include "recurse/core/io/text.h"
#include "recurse/scene/parameters/spectrum.h"
#include "scene/directives/sceneParser.h"
#include "scene/directives/track.h"
#include "scene/parameters/parameterParser.h"

namespace recurse {

const std::vector<ParameterSpec>& optionSpecs() {
  static const std::vector<ParameterSpec> SPECS = {
      integerParameter("seed", "0", "seed of the random numbers; the command line has precedence"),
      ignoredParameter(ParameterType::BOOLEAN, "disablepixeljitter",
                       "samples are always distributed over the pixel"),
      ignoredParameter(ParameterType::BOOLEAN, "disabletexturefiltering", "an option for debugging pbrt"),
      ignoredParameter(ParameterType::BOOLEAN, "disablewavelengthjitter", "light is always RGB"),
      ignoredParameter(ParameterType::REAL, "displacementedgescale", "for pbrt's displaced meshes"),
      ignoredParameter(ParameterType::BOOLEAN, "forcediffuse", "an option for debugging pbrt"),
      ignoredParameter(ParameterType::STRING, "msereferenceimage", "see `recurse compare`"),
      ignoredParameter(ParameterType::STRING, "msereferenceout", "see `recurse compare`"),
      ignoredParameter(ParameterType::BOOLEAN, "pixelstats", "for pbrt's own statistics"),
      ignoredParameter(ParameterType::STRING, "rendercoordsys", "the scene is always recentred"),
      ignoredParameter(ParameterType::BOOLEAN, "wavefront", "for pbrt's own integrators"),
  };
  return SPECS;
}

const std::vector<ParameterSpec>& lightScaleSpecs() {
  static const std::vector<ParameterSpec> SPECS = {
      spectrumParameter("scale", "1 1 1", SpectrumKind::ILLUMINANT, "factor on red, green and blue")};
  return SPECS;
}

namespace sceneFile {

void SceneParser::lightScale(const Token& t) {
  const SourceLocation where = tokens->peek().location();
  const ParsedDirective d = takePlugIn(t);
  Diagnostics found;
  const Parameters p = bindParameters(d, lightScaleSpecs(), found, false);
  for (const Diagnostic& one : found.all())
    one.severity == Severity::ERROR ? log.error(one.location, one.message, one.accepted)
                                    : log.warning(one.location, one.message, one.accepted);
  if (!found.hasErrors()) scene.lightScales.push_back({d.type, where, p.spectrum("scale")});
}

void SceneParser::takeSetting(const Token& directive, ParsedDirective& slot) {
  ParsedDirective d = takePlugIn(directive);
  if (slot.given())
    log.warning(d.location,
                "this " + std::string(directive.text) + " replaces the one at " + placeName(slot.location));
  slot = std::move(d);
}

void SceneParser::camera(const Token& t) {
  ReadCamera read;
  CameraDescription& made = read.description;
  made.camera = takePlugIn(t);
  for (const ParsedParameter& p : made.camera.parameters)
    if (p.name == "name" && p.strings.size() == 1) made.cameraName = p.strings[0];
  made.worldFromCamera = glm::inverse(firstTransform(made.camera.location));
  if (const auto last = lastTransform()) made.worldFromCameraLast = glm::inverse(*last);
  made.cameraMedium = state.medium.outside;
  read.coordinates.fault = state.transforms.fault;
  for (size_t i = 0; i < 2; ++i) read.coordinates.at[i] = glm::inverse(state.transforms.at[i]);
  coordinateSystems["camera"] = read.coordinates;
  const auto same = findCamera(made.cameraName);
  if (same == cameras.end()) {
    cameras.push_back(std::move(read));
    return;
  }
  log.warning(made.camera.location,
              "this Camera replaces the one at " + placeName(same->description.camera.location),
              "several cameras with different parameters \"name\"");
  *same = std::move(read);
}

std::vector<SceneParser::ReadCamera>::iterator SceneParser::findCamera(const std::string& name) {
  return std::find_if(cameras.begin(), cameras.end(),
                      [&name](const ReadCamera& c) { return c.description.cameraName == name; });
}

void SceneParser::chooseCamera() {
  if (cameras.empty()) return;
  auto chosen = requestedCamera.empty() ? cameras.begin() : findCamera(requestedCamera);
  if (chosen == cameras.end()) chosen = cameras.begin();
  coordinateSystems["camera"] = chosen->coordinates;
  static_cast<CameraDescription&>(scene) = std::move(chosen->description);
  cameras.erase(chosen);
  for (ReadCamera& other : cameras) scene.otherCameras.push_back(std::move(other.description));
  cameras.clear();
}

void SceneParser::colorSpace(const Token& t) {
  const Token token = takeString(t, "a colour space");
  const std::string name = lowerCase(token.value());
  const std::vector<std::string>& known = namedColorSpaces();
  if (std::find(known.begin(), known.end(), name) != known.end()) {
    state.colorSpace = name == "srgb" ? "" : name;
    return;
  }
  std::string accepted;
  for (const std::string& n : known) accepted += (accepted.empty() ? "\"" : " \"") + n + "\"";
  log.error(token.location(), "colour space " + token.shown() + " does not exist", accepted);
}

void SceneParser::option(const Token& t) {
  const Token token = takeString(t, "the name of an option");
  ParsedParameter p;
  p.location = token.location();
  if (token.text.find_first_of(" \t") != std::string_view::npos)
    splitDeclaration(token, p.type, p.name, log);
  else
    p.name = token.value();
  // Options are case-insensitive and ignore - and _, as in pbrt: Pixel-Stats, pixel_stats, pixelstats.
  std::string name;
  for (char c : p.name)
    if (c != '-' && c != '_') name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const auto& specs = optionSpecs();
  const auto spec =
      std::find_if(specs.begin(), specs.end(), [&](const ParameterSpec& s) { return s.name == name; });
  if (spec == specs.end()) {
    std::vector<std::string> names;
    for (const ParameterSpec& s : specs) names.push_back(s.name);
    std::string message = "unknown option \"" + p.name + "\"", accepted;
    const auto near = nearestNames(name, names, 1);
    if (!near.empty()) message += "; did you mean \"" + near[0] + "\"?";
    for (const std::string& n : names) accepted += (accepted.empty() ? "" : " ") + n;
    throw SceneError(p.location, message, accepted);
  }
  p.name = name;
  p.type = spec->type == ParameterType::BOOLEAN   ? "bool"
           : spec->type == ParameterType::INTEGER ? "integer"
           : spec->type == ParameterType::REAL    ? "float"
                                                  : "string";
  parseValues(*tokens, log, p);
  // Checks count and range like any parameter.
  ParsedDirective alone;
  alone.type = "Option";
  alone.location = p.location;
  alone.parameters = {p};
  Diagnostics found;
  bindParameters(alone, {*spec}, found, false);
  for (const Diagnostic& d : found.all()) log.error(d.location, d.message, d.accepted);
  constexpr std::array CHANGE_PICTURES = {"disablepixeljitter", "disabletexturefiltering", "forcediffuse"};
  if (std::find(CHANGE_PICTURES.begin(), CHANGE_PICTURES.end(), name) != CHANGE_PICTURES.end() &&
      !p.booleans.empty() && p.booleans[0])
    log.warning(p.location, "the option \"" + name + "\" has no effect: pbrt's picture differs");
  scene.options[name] = std::move(p);
}

void SceneParser::worldBegin(const Token& t) {
  (void)t;
  inWorld = true;
  assumedWorld = false;
  chooseCamera();
  // Media and attributes are kept, as in pbrt-v4.
  state.transforms = {};
  state.active = {true, true};
  coordinateSystems["world"] = state.transforms;
}

} // namespace sceneFile

} // namespace recurse
