/** @file
 * Common parameters of shapes, lights and materials: names, opacity, bumps, normal maps.
 */
#pragma once

namespace recurse {

struct PlugIns;

/** Adds `name` to shapes and lights, `alpha` to shapes, `displacement` (bumps) and `normalmap` to all
 * materials but "interface", of the plug-ins that are registered already. */
void addSurfaceParameters(PlugIns& plugIns);

} // namespace recurse
