/** @file
 * Names of a scene's lamps and surfaces.
 */
#include "recurse/transport/integrator/sceneNames.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "recurse/core/io/error.h"
#include "recurse/pathclasses/pathNames.h"
#include "recurse/transport/integrator/integrator.h"

namespace recurse {

namespace {

/** Names of media as light sources: never those of lamps, of other media or empty. */
std::vector<std::string> mediumSources(const Scene& scene) {
  std::set<std::string> taken;
  for (const Lamp& lamp : scene.lamps()) taken.insert(lamp.name);
  std::vector<std::string> out;
  for (const std::string& medium : scene.mediumNames()) {
    std::string name = medium.empty() ? "medium-" + std::to_string(out.size() + 1) : medium;
    while (!taken.insert(name).second) name += "_";
    out.push_back(name);
  }
  return out;
}

std::string placeOf(const Lamp& lamp) {
  const SourceLocation& where = lamp.location;
  if (!where.source) return lamp.kind;
  return lamp.kind + ", " + std::filesystem::path(where.source->name).filename().string() + ":" +
         std::to_string(where.line);
}

} // namespace

PathNames pathNames(const Scene& scene, const Integrator* integrator) {
  PathNames names;
  const std::vector<std::string> media = mediumSources(scene);
  for (size_t i = 0; i < scene.lights().size(); ++i) {
    names.lights.push_back({scene.lamps()[scene.lampOf(i)].name});
  }
  // A medium that emits nothing has the names of a source that exists, so that all lights have a name.
  PathNames::List any = names.lights.empty() ? PathNames::List() : names.lights.front();
  for (size_t i = 0; i < scene.mediumCount(); ++i)
    if (scene.medium(uint16_t(i + 1))->isEmissive() && any.empty()) any = {media[i]};
  for (size_t i = 0; i < scene.mediumCount(); ++i)
    names.lights.push_back(scene.medium(uint16_t(i + 1))->isEmissive() ? PathNames::List{media[i]} : any);
  if (integrator && integrator->addsLightOfNoLamp()) names.lights.emplace_back();
  for (uint32_t i = 0; i < scene.objects().size(); ++i) {
    names.objects.push_back({scene.objects().common(i)});
    if (std::string numbered = scene.objects()[i]; numbered != names.objects.back().front())
      names.objects.back().push_back(std::move(numbered));
  }
  if (names.objects.empty()) names.objects.emplace_back();
  for (const std::string& label : scene.materialLabels())
    names.materials.push_back(label.empty() ? PathNames::List() : PathNames::List{label});
  if (names.materials.empty()) names.materials.emplace_back();
  return names;
}

PathClasses sceneClasses(std::vector<PathClass> classes, const Scene& scene, const Integrator* integrator) {
  const bool named = std::any_of(classes.begin(), classes.end(), [](const PathClass& c) {
    return c.expression.find('\'') != std::string::npos;
  });
  return named ? PathClasses(std::move(classes), pathNames(scene, integrator))
               : PathClasses(std::move(classes));
}

std::vector<LampGroup> lampGroups(const Scene& scene) {
  std::vector<LampGroup> groups;
  std::map<std::string, size_t> known;
  for (size_t i = 0; i < scene.lights().size(); ++i) {
    const Lamp& lamp = scene.lamps()[scene.lampOf(i)];
    const auto [at, isNew] = known.try_emplace(lamp.name, groups.size());
    if (isNew) groups.push_back({lamp.name, placeOf(lamp)});
    groups[at->second].power += double(maxComponent(scene.lights()[i].power()));
  }
  const std::vector<std::string> media = mediumSources(scene);
  for (size_t i = 0; i < scene.mediumCount(); ++i)
    if (scene.medium(uint16_t(i + 1))->isEmissive()) groups.push_back({media[i], "emissive medium", 0, true});
  return groups;
}

} // namespace recurse
