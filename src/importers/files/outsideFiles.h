/** @file
 * Files that a model names outside of its own folder.
 */
#pragma once

#include <string>

#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** Parameter "outside" of importers: whether files outside of the model's folder are read. */
ParameterSpec outsideParameter();

/** Whether the importer with these parameters may read `file` for the model at `path`. Warns of a file
 * outside of the model's folder, unless "outside" is "read". */
bool mayRead(const std::string& file, const std::string& path, const Parameters& p);

} // namespace recurse
