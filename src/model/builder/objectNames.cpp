/** @file
 * Names of objects and materials.
 */
#include "model/builder/objectNames.h"

#include <charconv>
#include <filesystem>

namespace recurse {

namespace {

/** Name of a shape outside of objects: the given one, else its file, else its kind. */
std::string nameOf(const ShapeDescription& s) {
  if (const std::string name = givenName(s.shape); !name.empty()) return name;
  for (const ParsedParameter& p : s.shape.parameters)
    if (p.name == "filename" && p.strings.size() == 1)
      return std::filesystem::path(p.strings[0]).stem().string();
  return s.shape.type;
}

/** Number at the end of a name such as `tree.2`, behind `tree.`; 0 for a name that no copy can have. */
uint32_t copyNumber(const std::string& name) {
  const size_t digits = name.rfind('.') + 1; // 0 without a point
  uint32_t number = 0;
  std::from_chars(name.data() + digits, name.data() + name.size(), number);
  const bool isCopy = digits > 0 && number > 1 && name.substr(digits) == std::to_string(number);
  return isCopy ? number : 0;
}

} // namespace

std::string givenName(const ParsedDirective& directive) {
  const auto lastIn = [](const std::vector<ParsedParameter>& all) -> std::string {
    for (auto p = all.rbegin(); p != all.rend(); ++p)
      if (p->name == "name" && p->strings.size() == 1) return p->strings[0];
    return {};
  };
  const std::string own = lastIn(directive.parameters);
  return own.empty() && directive.attributes ? lastIn(*directive.attributes) : own;
}

uint32_t ObjectNames::add(const std::string& name) {
  const auto [found, isNew] = known.try_emplace(name, uint32_t(names.size()));
  if (isNew) {
    names.push_back(name);
    copies.push_back(0);
    if (const uint32_t number = copyNumber(name)) taken[name.substr(0, name.rfind('.'))].insert(number);
  }
  objects.push_back({found->second, ++copies[found->second]});
  return uint32_t(objects.size() - 1);
}

std::string ObjectNames::operator[](uint32_t object) const {
  const Object& o = objects[object];
  const std::string& name = names[o.name];
  if (o.copy == 1) return name;
  uint32_t number = o.copy;
  if (const auto others = taken.find(name); others != taken.end())
    for (const uint32_t other : others->second) { // in ascending order
      if (other > number) break;
      ++number;
    }
  return name + "." + std::to_string(number);
}

std::string Scene::materialName(const Material* material) const {
  const auto found = materialNames.find(material);
  return found == materialNames.end() ? "" : found->second;
}

uint32_t ObjectNamer::objectOf(const ShapeDescription* shape, const InstanceDescription* instance) {
  if (!instance) return names.add(nameOf(*shape));
  const auto known = atTop.find(instance);
  if (known != atTop.end()) return known->second;
  if (instance != last) {
    const auto object = scene.objects.find(instance->object);
    lastObject = names.add(object == scene.objects.end() ? instance->object : object->second.name);
  }
  last = instance;
  return lastObject;
}

uint32_t ObjectNamer::objectAtTop(const ShapeDescription* shape, const InstanceDescription* instance) {
  const uint32_t object = objectOf(shape, instance);
  if (instance) atTop[instance] = object;
  return object;
}

} // namespace recurse
