/** @file
 * Light of a scene that an integrator cannot find.
 */
#pragma once

#include <string>
#include <vector>

#include "apps/load/loadedScene.h"
#include "recurse/pathclasses/pathClasses.h"

namespace recurse::apps {

/** Expression of the paths of these classes, in this scene, that the integrator never finds; empty if it can
 * find all of them. */
std::string missedPaths(const LoadedScene& loaded, const std::vector<PathClass>& classes);

} // namespace recurse::apps
