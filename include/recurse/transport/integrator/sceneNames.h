/** @file
 * Names of a scene's lamps and surfaces for path expressions.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/model/scene/scene.h"
#include "recurse/pathclasses/pathClasses.h"

namespace recurse {

class Integrator;

/** Names for path classes: lights by their number in the light table, then media by their index less one;
 * objects by Hit::object, each with its common and its numbered name; materials by Material::number. The N-th
 * lamp of Scene::lamps(), from 1, is called `light-N` if it has no name, the N-th medium `medium-N`; names
 * that are taken get "_" at their end. A medium that emits nothing has the names of the first source. A light
 * without a name follows the media if the integrator adds light of no lamp; null: none does. */
PathNames pathNames(const Scene& scene, const Integrator* integrator = nullptr);

/** Path classes whose expressions may name lamps and surfaces of the scene, for renders by the integrator as
 * for pathNames(). Throws Error like PathClasses. */
PathClasses sceneClasses(std::vector<PathClass> classes, const Scene& scene,
                         const Integrator* integrator = nullptr);

/** Light sources of one name. */
struct LampGroup {
  std::string name;  ///< in path expressions
  std::string place; ///< kind and place in the file, such as `point, scene.pbrt:12`
  double power = 0;  ///< sum over its lights [W], in the strongest channel; 0, unknown, for media
  bool isMedium = false;
};

/** All light sources by their names, in the order of the scene: lamps, then emissive media. */
std::vector<LampGroup> lampGroups(const Scene& scene);

} // namespace recurse
