/** @file
 * Boundaries of media that do not close, which rays enter by and do not leave by.
 */
#pragma once

#include "model/builder/shapeGroups.h"

namespace recurse {

/**
 * Warns once of each pair of media whose boundary has an edge that neither the rest of the boundary, nor
 * another one, nor an opaque surface joins. Of very many edges only an even selection is looked at, the same
 * for any number of threads. The scene's trees must have been built.
 */
void warnOfOpenBoundaries(const Scene& scene, const ShapeGroups& shapes, const SceneMedia& media,
                          Diagnostics& diagnostics);

} // namespace recurse
