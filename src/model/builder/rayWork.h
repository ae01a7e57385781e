/** @file
 * Time that rays of a scene take, foretold before there are any.
 */
#pragma once

#include "model/builder/shapeGroups.h"

namespace recurse {

/** False after an error: one ray for each pixel of the film would take longer than work may take, through
 * many surfaces at one place or a shape of many parts that overlap. */
bool allowsRayWork(const ShapeGroups& shapes, const FilmSettings& film, Diagnostics& diagnostics);

} // namespace recurse
