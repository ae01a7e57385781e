/** @file
 * Objects that stand in other objects: ObjectInstance between ObjectBegin and ObjectEnd.
 */
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "recurse/scene/sceneDescription.h"
#include "scene/errorLog.h"

namespace recurse::sceneFile {

class NestedObjects {
 public:
  /** `inner` stands in the space of the object `outer`. */
  void add(const std::string& outer, InstanceDescription inner) { inside[outer].push_back(std::move(inner)); }

  /**
   * Gives each inner object the places that the outer one has, so that its shapes are built once. Where the
   * outer object moves, or is an operand of a solid, it is made whole instead, with copies of the shapes.
   */
  void expand(SceneDescription& scene, ErrorLog& log);

 private:
  /** How many instances stand in an object, however deep; an error where it would stand in itself. */
  double countInside(const std::string& outer, ErrorLog& log);
  /** All of them, in the space of this object. */
  const std::vector<InstanceDescription>& allInside(const std::string& outer);
  void makeWhole(const std::string& name, SceneDescription& scene, ErrorLog& log);

  std::map<std::string, std::vector<InstanceDescription>> inside, flattened;
  std::map<std::string, double> counts;
};

} // namespace recurse::sceneFile
