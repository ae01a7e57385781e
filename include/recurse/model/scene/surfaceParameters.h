/** @file
 * Parameters of every shape and every material besides its own: opacity, bumps, normal maps.
 */
#pragma once

namespace recurse {

struct PlugIns;

/** Gives every shape `alpha`, and every material `displacement` and `normalmap`. */
void addSurfaceParameters(PlugIns& plugIns);

} // namespace recurse
