/** @file
 * Objects that stand in other objects: ObjectInstance between ObjectBegin and ObjectEnd.
 */
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "recurse/scene/directives/sceneDescription.h"
#include "scene/text/errorLog.h"

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
  /** Instances that stand in an object, however deep. */
  struct Contents {
    double count = 0;
    int levels = 0; ///< of instances, one in the other
  };
  /** An object's contents; an error where it would stand in itself. `level`: of instances around it. */
  Contents contentsOf(const std::string& outer, int level, ErrorLog& log);
  /** Calls visit(instance, worldFromInstance) for each of them. */
  template <class Visit>
  void forAllInside(const std::string& outer, const Mat4d& worldFromOuter, const Visit& visit) const;
  void makeWhole(const std::string& name, SceneDescription& scene, ErrorLog& log);

  std::map<std::string, std::vector<InstanceDescription>> inside;
  std::map<std::string, Contents> contents;
};

} // namespace recurse::sceneFile
