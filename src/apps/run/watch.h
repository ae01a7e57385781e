/** @file
 * `--watch`: renders again whenever a file of the scene changes.
 */
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "recurse/core/io/error.h"

namespace recurse::apps {

/**
 * Calls render(first, loaded) until Ctrl-C: with `first` for a quick picture, then without. A changed file
 * ends the running render, and the loop begins again with `first`. The render has to call `loaded` with the
 * scene's files as soon as these are known, for each scene that it loads. Errors of a render are printed, and
 * the next change is awaited; only Error (BAD_USAGE) is thrown.
 */
ExitStatus watchScene(
    const std::string& scene,
    const std::function<void(bool first, const std::function<void(const std::vector<std::string>&)>& loaded)>&
        render);

} // namespace recurse::apps
