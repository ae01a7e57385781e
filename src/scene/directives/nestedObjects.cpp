/** @file
 * Expansion of nested objects to instances of the world.
 */
#include "scene/directives/nestedObjects.h"

#include <algorithm>
#include <memory>

namespace recurse::sceneFile {

namespace {

/** Limit of about 6 GB of memory; a few directives could request any number. */
constexpr size_t MAX_INSTANCES = size_t(1) << 24;
/** Maximum depth of nested objects, which bounds the recursion. */
constexpr int MAX_LEVELS = 256;

/** Key of an object with copies of all shapes inside it. */
std::string wholeName(const std::string& name) { return name + " and its contents"; }

/** Calls visit(names) for the operand names of each solid: in its parameters, and in attributes, which shapes
 * share and continue to share. */
template <class Visit> void forOperands(SceneDescription& scene, const Visit& visit) {
  const auto isOperands = [](const ParsedParameter& p) { return p.name == "operands"; };
  const auto visitAll = [&](std::vector<ParsedParameter>& parameters) {
    for (ParsedParameter& p : parameters)
      if (isOperands(p)) visit(p.strings);
  };
  using Attributes = decltype(ParsedDirective::attributes);
  std::map<Attributes, Attributes> visited;
  const auto look = [&](std::vector<ShapeDescription>& shapes) {
    for (ShapeDescription& s : shapes) {
      visitAll(s.shape.parameters);
      Attributes& shared = s.shape.attributes;
      if (!shared || std::none_of(shared->begin(), shared->end(), isOperands)) continue;
      const auto [place, isNew] = visited.try_emplace(shared);
      if (isNew) {
        std::vector<ParsedParameter> own = *shared;
        visitAll(own);
        place->second = std::make_shared<const std::vector<ParsedParameter>>(std::move(own));
      }
      shared = place->second;
    }
  };
  look(scene.shapes);
  for (auto& [name, object] : scene.objects) look(object.shapes);
}

} // namespace

NestedObjects::Contents NestedObjects::contentsOf(const std::string& outer, int level, ErrorLog& log) {
  constexpr double UNDER_WAY = -1;
  if (level > MAX_LEVELS) return {};
  const auto [place, isNew] = contents.try_emplace(outer, Contents{UNDER_WAY, 0});
  if (!isNew) return place->second;
  Contents all;
  if (const auto found = inside.find(outer); found != inside.end())
    std::erase_if(found->second, [&](const InstanceDescription& inner) {
      const Contents deeper = contentsOf(inner.object, level + 1, log);
      if (deeper.count == UNDER_WAY) {
        log.error(inner.location, "object \"" + inner.object + "\" would contain itself");
        return true;
      }
      all.count += 1 + deeper.count;
      all.levels = std::max(all.levels, 1 + deeper.levels);
      return false;
    });
  return place->second = all;
}

template <class Visit>
void NestedObjects::forAllInside(const std::string& outer, const Mat4d& worldFromOuter,
                                 const Visit& visit) const {
  const auto found = inside.find(outer);
  if (found == inside.end()) return;
  for (const InstanceDescription& inner : found->second) {
    const Mat4d worldFromInner = worldFromOuter * inner.worldFromInstance;
    visit(inner, worldFromInner);
    forAllInside(inner.object, worldFromInner, visit);
  }
}

void NestedObjects::makeWhole(const std::string& name, SceneDescription& scene, ErrorLog& log) {
  const auto object = scene.objects.find(name);
  if (object == scene.objects.end()) return; // reported at its use
  ObjectDescription whole = object->second;
  forAllInside(name, Mat4d(1), [&](const InstanceDescription& i, const Mat4d& wholeFromInner) {
    const auto inner = scene.objects.find(i.object);
    if (inner == scene.objects.end()) {
      log.error(i.location, "there is no object named \"" + i.object + "\"");
      return;
    }
    for (ShapeDescription s : inner->second.shapes) {
      s.worldFromObject = wholeFromInner * s.worldFromObject;
      if (s.worldFromObjectLast) s.worldFromObjectLast = wholeFromInner * *s.worldFromObjectLast;
      whole.shapes.push_back(std::move(s));
    }
  });
  scene.objects.emplace(wholeName(name), std::move(whole));
}

void NestedObjects::expand(SceneDescription& scene, ErrorLog& log) {
  if (inside.empty()) return;
  for (const auto& [name, list] : inside) {
    if (list.empty()) continue;
    const SourceLocation where = list.front().location;
    const Contents all = contentsOf(name, 0, log);
    if (all.levels > MAX_LEVELS) {
      log.error(where, "objects are nested in \"" + name + "\" more than " + std::to_string(MAX_LEVELS) +
                           " levels deep");
      return;
    }
    if (all.count > double(MAX_INSTANCES)) {
      log.error(where,
                "too many objects are in \"" + name + "\": more than " + std::to_string(MAX_INSTANCES));
      return;
    }
  }
  std::set<std::string> wholes;
  const auto need = [&](const std::string& name) {
    if (inside.contains(name)) wholes.insert(name);
  };
  forOperands(scene, [&](const std::vector<std::string>& names) {
    for (const std::string& name : names) need(name);
  });
  for (const InstanceDescription& i : scene.instances)
    if (i.worldFromInstanceLast) need(i.object);
  for (const std::string& name : wholes) makeWhole(name, scene, log);
  forOperands(scene, [&](std::vector<std::string>& names) {
    for (std::string& name : names)
      if (wholes.contains(name)) name = wholeName(name);
  });

  const auto hasShapes = [&](const std::string& name) { // unknown objects are reported at their use
    const auto object = scene.objects.find(name);
    return object == scene.objects.end() || !object->second.shapes.empty() || !inside.contains(name);
  };
  std::vector<InstanceDescription> placed;
  double count = 0; // number of all instances, including objects without shapes
  for (InstanceDescription& outer : scene.instances) {
    if (outer.worldFromInstanceLast && wholes.contains(outer.object)) {
      outer.object = wholeName(outer.object);
      placed.push_back(std::move(outer));
      continue;
    }
    count += 1 + contentsOf(outer.object, 0, log).count;
    if (count > double(MAX_INSTANCES)) {
      log.error(outer.location, "too many instances: more than " + std::to_string(MAX_INSTANCES));
      break;
    }
    forAllInside(outer.object, outer.worldFromInstance,
                 [&](const InstanceDescription& inner, const Mat4d& worldFromInner) {
                   if (!hasShapes(inner.object)) return;
                   placed.push_back(inner);
                   placed.back().worldFromInstance = worldFromInner;
                 });
    if (hasShapes(outer.object)) placed.push_back(std::move(outer));
  }
  scene.instances = std::move(placed);
}

} // namespace recurse::sceneFile
