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
  Mat4d worldFromIndex{1}; ///< values are at whole numbers of the index space
};

/** Reads the first grid of this name. Empty where the file has none; `others` then has the names in the
 * file. Throws Error with the offset for damaged data or an unsupported kind. `file` is for messages. */
NanoVdbGrid readNanoVdb(const std::string& file, std::string_view bytes, const std::string& name,
                        std::vector<std::string>& others);

} // namespace recurse
