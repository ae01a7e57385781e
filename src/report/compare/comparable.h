/** @file
 * Check that two pictures can be compared.
 */
#pragma once

#include "recurse/core/image/image.h"

namespace recurse {

/** Throws Error where the pictures differ in size or have no R, G and B; `what` names the second, with a
 * verb: "reference has". */
void requireComparable(const Image& a, const Image& b, const char* what);

} // namespace recurse
