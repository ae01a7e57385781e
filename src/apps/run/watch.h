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
 * Calls render(first, loaded) until Ctrl-C: with `first` for a picture that is soon there, then without, then
 * again from the first when a file has changed, which also ends a render that is under way. `loaded` is to be
 * called by render with the scene's files as soon as these are known, of several scenes for each. What a
 * render throws is told, and the next change waited for.
 */
ExitStatus watchScene(
    const std::string& scene,
    const std::function<void(bool first, const std::function<void(const std::vector<std::string>&)>& loaded)>&
        render);

} // namespace recurse::apps
