/** @file
 * Which shapes are one object, and what it is called.
 */
#pragma once

#include <map>

#include "recurse/model/scene/scene.h"

namespace recurse {

/** All parts of an instance are one object. */
class ObjectNamer {
 public:
  explicit ObjectNamer(ObjectNames& names) : names(names) {}
  /** Of a shape; `instance`: the one that it is a part of, or null. Parts of the top level come first, and
   * those of one instance one after the other. */
  uint32_t objectOf(const ShapeDescription* shape, const InstanceDescription* instance);
  /** The same for a shape at the top level. */
  uint32_t objectAtTop(const ShapeDescription* shape, const InstanceDescription* instance);

 private:
  ObjectNames& names;
  std::map<const InstanceDescription*, uint32_t> atTop; ///< instances with parts there: lamps
  const InstanceDescription* last = nullptr;
  uint32_t lastObject = 0;
};

} // namespace recurse
