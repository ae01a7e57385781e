/** @file
 * Files that a model names outside of its own folder.
 */
#pragma once

#include <string>

#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** The parameter "outside" of importers: whether such files are read. */
ParameterSpec outsideParameter();

/** False where the importer with these parameters may not read the file for the model at `path`. Warns of a
 * file outside, unless such files are read as a matter of course. */
bool mayRead(const std::string& file, const std::string& path, const Parameters& p);

} // namespace recurse
