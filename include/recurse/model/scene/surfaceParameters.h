/** @file
 * Common parameters of all shapes and all materials: opacity, bumps, normal maps.
 */
#pragma once

namespace recurse {

struct PlugIns;

/** Adds `alpha` to every shape, `displacement` and `normalmap` to every material. */
void addSurfaceParameters(PlugIns& plugIns);

} // namespace recurse
