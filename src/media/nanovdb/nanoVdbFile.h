/** @file
 * NanoVDB files (version 32, of OpenVDB 9 to 11): sparse grids of numbers, by name.
 */
#pragma once

#include <string>
#include <string_view>

#include "media/nanovdb/sparseGrid.h"
#include "recurse/core/math/vector.h"

namespace recurse {

struct NanoVdbGrid {
  SparseGrid values;
  Mat4d worldFromIndex{1}; ///< whole numbers are the places of values
};

/** The first grid of that name; empty() where the file has none, and then `others` are the names that it has.
 * Throws Error with the place for what is damaged or of a kind that is not read. `file` is for messages. */
NanoVdbGrid readNanoVdb(const std::string& file, std::string_view bytes, const std::string& name,
                        std::vector<std::string>& others);

} // namespace recurse
