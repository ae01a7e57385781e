/** @file
 * The reader of scene files: the pbrt-v4 text format, as it is described at
 * https://pbrt.org/fileformat-v4, and as real files use it.
 */
#pragma once

#include <string>

#include "recurse/scene/directives/sceneDescription.h"

namespace recurse {

/**
 * Reads a scene file and what it includes (plain or gzip-compressed). Everything wrong with the syntax is
 * reported to `diagnostics`, several errors in one run; the description then holds what could be understood.
 * Throws Error when the top file itself cannot be read. Tracks have the numbers of `frame`.
 */
SceneDescription loadScene(const std::string& fileName, Diagnostics& diagnostics, double frame = 0);

/** The same from text; `name` stands for the file name in messages, files are relative to `directory`. */
SceneDescription parseScene(const std::string& text, const std::string& name, const std::string& directory,
                            Diagnostics& diagnostics);

} // namespace recurse
