/** @file
 * Reader of scene files: the pbrt-v4 text format, as described at https://pbrt.org/fileformat-v4, and as used
 * by real files.
 */
#pragma once

#include <string>

#include "recurse/scene/directives/sceneDescription.h"

namespace recurse {

/**
 * Reads a scene file and its includes (plain or gzip-compressed). Syntax errors are reported to
 * `diagnostics`, several in one run; the description then holds all directives that could be parsed. Throws
 * Error when the top file cannot be read. Tracks have their values at `frame`. The camera is the one named
 * `camera`, or the first if `camera` is empty or none has this name.
 */
SceneDescription loadScene(const std::string& fileName, Diagnostics& diagnostics, double frame = 0,
                           const std::string& camera = {});

/** Parses the text of a whole scene at frame 0, with errors like loadScene(). `name` is its file name in
 * messages; files are relative to `directory`. */
SceneDescription parseScene(const std::string& text, const std::string& name, const std::string& directory,
                            Diagnostics& diagnostics, const std::string& camera = {});

} // namespace recurse
