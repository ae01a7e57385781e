/** @file
 * Nested objects: ObjectInstance between ObjectBegin and ObjectEnd.
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
  /** Adds an instance in the space of the object `outer`. */
  void add(const std::string& outer, InstanceDescription inner) { inside[outer].push_back(std::move(inner)); }

  /**
   * Instantiates inner objects at every instance of the outer one, so that their shapes are built once. An
   * outer object that moves, or is an operand of a solid, becomes one object with copies of the shapes.
   */
  void expand(SceneDescription& scene, ErrorLog& log);

 private:
  /** Instances nested in an object at any depth. */
  struct Contents {
    double count = 0;
    int levels = 0; ///< depth of the nested instances
  };
  /** Contents of an object; an error where it contains itself. `level`: number of enclosing instances. */
  Contents contentsOf(const std::string& outer, int level, ErrorLog& log);
  /** Calls visit(instance, worldFromInstance) for each instance nested in `outer`. */
  template <class Visit>
  void forAllInside(const std::string& outer, const Mat4d& worldFromOuter, const Visit& visit) const;
  void makeWhole(const std::string& name, SceneDescription& scene, ErrorLog& log);

  std::map<std::string, std::vector<InstanceDescription>> inside;
  std::map<std::string, Contents> contents;
};

} // namespace recurse::sceneFile
