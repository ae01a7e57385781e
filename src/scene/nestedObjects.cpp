/** @file
 * Objects in objects, as instances of the world.
 */
#include "scene/nestedObjects.h"

namespace recurse::sceneFile {

namespace {

/** Takes about 6 GB; a few directives could ask for any number. */
constexpr size_t MAX_INSTANCES = size_t(1) << 24;

std::string wholeName(const std::string& name) { return name + " and what stands in it"; }

/** Calls visit(names) for the operands of each solid. */
template <class Visit> void forOperands(SceneDescription& scene, const Visit& visit) {
  const auto look = [&](std::vector<ShapeDescription>& shapes) {
    for (ShapeDescription& s : shapes)
      for (ParsedParameter& p : s.shape.parameters)
        if (p.name == "operands") visit(p.strings);
  };
  look(scene.shapes);
  for (auto& [name, object] : scene.objects) look(object.shapes);
}

} // namespace

double NestedObjects::countInside(const std::string& outer, ErrorLog& log) {
  constexpr double UNDER_WAY = -1;
  const auto [place, isNew] = counts.try_emplace(outer, UNDER_WAY);
  if (!isNew) return place->second;
  double count = 0;
  if (const auto found = inside.find(outer); found != inside.end())
    std::erase_if(found->second, [&](const InstanceDescription& inner) {
      const double deeper = countInside(inner.object, log);
      if (deeper == UNDER_WAY)
        log.error(inner.location, "object \"" + inner.object + "\" would stand inside the object itself");
      else
        count += 1 + deeper;
      return deeper == UNDER_WAY;
    });
  return place->second = count;
}

const std::vector<InstanceDescription>& NestedObjects::allInside(const std::string& outer) {
  const auto [place, isNew] = flattened.try_emplace(outer);
  std::vector<InstanceDescription>& all = place->second; // stays where it is
  const auto found = inside.find(outer);
  if (!isNew || found == inside.end()) return all;
  for (const InstanceDescription& inner : found->second) {
    all.push_back(inner);
    for (InstanceDescription i : allInside(inner.object)) {
      i.worldFromInstance = inner.worldFromInstance * i.worldFromInstance;
      all.push_back(std::move(i));
    }
  }
  return all;
}

void NestedObjects::makeWhole(const std::string& name, SceneDescription& scene, ErrorLog& log) {
  const auto object = scene.objects.find(name);
  if (object == scene.objects.end()) return; // whoever uses it says so
  ObjectDescription whole = object->second;
  whole.name = wholeName(name);
  for (const InstanceDescription& i : allInside(name)) {
    const auto inner = scene.objects.find(i.object);
    if (inner == scene.objects.end()) {
      log.error(i.location, "there is no object named \"" + i.object + "\"");
      continue;
    }
    for (ShapeDescription s : inner->second.shapes) {
      s.worldFromObject = i.worldFromInstance * s.worldFromObject;
      if (s.worldFromObjectLast) s.worldFromObjectLast = i.worldFromInstance * *s.worldFromObjectLast;
      whole.shapes.push_back(std::move(s));
    }
  }
  scene.objects.emplace(whole.name, whole);
}

void NestedObjects::expand(SceneDescription& scene, ErrorLog& log) {
  if (inside.empty()) return;
  for (const auto& [name, list] : inside)
    if (countInside(name, log) > MAX_INSTANCES) {
      log.error(list.at(0).location,
                "too many objects stand in \"" + name + "\": more than " + std::to_string(MAX_INSTANCES));
      return;
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

  const auto hasShapes = [&](const std::string& name) { // what is unknown is told where it is used
    const auto object = scene.objects.find(name);
    return object == scene.objects.end() || !object->second.shapes.empty() || !inside.contains(name);
  };
  std::vector<InstanceDescription> placed;
  for (InstanceDescription& outer : scene.instances) {
    if (outer.worldFromInstanceLast && wholes.contains(outer.object)) {
      outer.object = wholeName(outer.object);
      placed.push_back(std::move(outer));
      continue;
    }
    const std::vector<InstanceDescription>& all = allInside(outer.object);
    if (placed.size() + all.size() >= MAX_INSTANCES) {
      log.error(outer.location, "too many instances: more than " + std::to_string(MAX_INSTANCES));
      break;
    }
    for (InstanceDescription i : all) {
      if (!hasShapes(i.object)) continue;
      i.worldFromInstance = outer.worldFromInstance * i.worldFromInstance;
      placed.push_back(std::move(i));
    }
    if (hasShapes(outer.object)) placed.push_back(std::move(outer));
  }
  scene.instances = std::move(placed);
}

} // namespace recurse::sceneFile
