/** @file
 * Grouping of shapes into named objects.
 */
#pragma once

#include <map>

#include "recurse/model/scene/scene.h"

namespace recurse {

/** The parameter "name" of a directive; empty without. */
std::string givenName(const ParsedDirective& directive);

/** All parts of an instance are one object. */
class ObjectNamer {
 public:
  ObjectNamer(ObjectNames& names, const SceneDescription& scene) : names(names), scene(scene) {}
  /** Object index of a shape. `instance`: the instance that it is a part of, or null. Call after
   * objectAtTop() for all parts at the top level; the parts of one instance come consecutively. */
  uint32_t objectOf(const ShapeDescription* shape, const InstanceDescription* instance);
  /** Object index of a shape at the top level, where lamps of instances are too. */
  uint32_t objectAtTop(const ShapeDescription* shape, const InstanceDescription* instance);

 private:
  ObjectNames& names;
  const SceneDescription& scene;
  std::map<const InstanceDescription*, uint32_t> atTop; ///< for shapes of instances at the top level: lamps
  const InstanceDescription* last = nullptr;
  uint32_t lastObject = 0;
};

} // namespace recurse
