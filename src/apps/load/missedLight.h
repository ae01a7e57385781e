/** @file
 * Light of a scene that an integrator cannot find.
 */
#pragma once

#include <string>
#include <vector>

#include "apps/load/loadedScene.h"
#include "recurse/pathclasses/pathClasses.h"

namespace recurse::apps {

/** The paths of these classes, in this scene, that the integrator never finds, as an expression; empty where
 * there are none. */
std::string missedPaths(const LoadedScene& loaded, const std::vector<PathClass>& classes);

} // namespace recurse::apps
