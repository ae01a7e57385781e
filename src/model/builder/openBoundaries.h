/** @file
 * Check for boundaries of media that do not close, which rays enter without leaving.
 */
#pragma once

#include "model/builder/shapeGroups.h"

namespace recurse {

/**
 * Warns once for each pair of media whose boundary has an open edge, which joins neither the rest of the
 * boundary, nor a different boundary, nor an opaque surface. Very many edges are tested by an even selection,
 * the same for any number of threads. The scene's trees must have been built.
 */
void warnOfOpenBoundaries(const Scene& scene, const ShapeGroups& shapes, const SceneMedia& media,
                          Diagnostics& diagnostics);

} // namespace recurse
