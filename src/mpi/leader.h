/** @file
 * The rank that deals out the work.
 */
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "mpi/worker.h"
#include "recurse/render/render.h"

namespace recurse::apps {

/** As recurse::render(), which began at `start`, while all others follow(); `names` are those of the ranks.
 * `log` gets a warning where a rank is waited for that is silent. */
RenderStatistics lead(Worker& worker, const std::vector<std::string>& names, const RenderSettings& settings,
                      Film& film, Clock::time_point start, const std::atomic<bool>& stop,
                      const std::function<void(const RenderProgress&)>& progress,
                      const std::function<void(const std::string&)>& log);

} // namespace recurse::apps
