/** @file
 * Media by name.
 */
#include "model/builder/sceneMedia.h"

#include <algorithm>

#include "recurse/core/io/text.h"
#include "recurse/model/scene/keptParts.h"
#include "recurse/model/scene/scene.h"

namespace recurse {

uint16_t SceneMedia::number(const std::string& name, const SourceLocation& usedAt) {
  if (name.empty()) return 0;
  const auto [known, isNew] = byName.try_emplace(name, uint16_t(0));
  if (!isNew) return known->second;
  const auto found = c.description.media.find(name);
  if (found == c.description.media.end()) {
    const std::vector<std::string> names = namesOf(c.description.media);
    c.diagnostics.error(usedAt, "there is no medium named \"" + name + "\"",
                        names.empty() ? "the name of a MakeNamedMedium"
                                      : quotedList(nearestNames(name, names)));
    return 0;
  }
  return known->second = add({name, &found->second, c.description.worldFromMedium.at(name)});
}

uint16_t SceneMedia::number(const ParsedDirective& filling) {
  const auto [known, isNew] = byFilling.try_emplace(&filling, uint16_t(0));
  if (isNew) known->second = add({"", &filling, Mat4d(1)});
  return known->second;
}

void SceneMedia::warnOfUnknownTypes() const {
  const auto& types = plugIns().media;
  for (const auto& [name, directive] : c.description.media)
    if (!byName.contains(name) && !types.find(directive.type))
      c.diagnostics.warning(directive.location,
                            unknownPlugInText(types.kind(), directive.type, types.names()) +
                                " (the medium \"" + name + "\" is not used)");
}

uint16_t SceneMedia::add(const Used& medium) {
  if (used.size() + 1 >= Scene::SURROUNDING_MEDIUM) {
    c.diagnostics.error(medium.directive->location, "there are too many media");
    return 0;
  }
  used.push_back(medium);
  return static_cast<uint16_t>(used.size());
}

std::string SceneMedia::key(size_t index, float maxExtinction) const {
  return keyOf(*used[index].directive, recentred(used[index].worldFromMedium, c.sceneOrigin)) + " " +
         std::to_string(maxExtinction);
}

std::shared_ptr<Medium> SceneMedia::make(size_t index, float maxExtinction) const {
  const ParsedDirective& d = *used[index].directive;
  ParsedDirective body = d, phase = d;
  phase.type = "hg";
  phase.parameters.clear();
  body.parameters.clear();
  for (const ParsedParameter& p : d.parameters)
    if (p.name == "phase" && p.strings.size() == 1) {
      phase.type = p.strings[0];
      phase.location = p.valueLocation;
    }
  const auto& phases = plugIns().phaseFunctions;
  const auto* entry = phases.find(phase.type);
  for (const ParsedParameter& p : d.parameters) {
    const auto declares = [&](const ParameterSpec& s) { return s.name == p.name; };
    if (p.name == "phase" && p.strings.size() == 1) continue;
    const bool ofPhase = entry && std::any_of(entry->parameters.begin(), entry->parameters.end(), declares);
    (ofPhase ? phase : body).parameters.push_back(p);
  }
  std::unique_ptr<PhaseFunction> function = phases.make(phase, {}, c.diagnostics, c.lenient);
  std::unique_ptr<Medium> made = plugIns().media.make(
      body, {recentred(used[index].worldFromMedium, c.sceneOrigin), maxExtinction}, c.diagnostics, c.lenient);
  if (!function || !made) return nullptr;
  made->phase = std::move(function);
  return made;
}

} // namespace recurse
