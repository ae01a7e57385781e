/** @file
 * The rank that deals out the work.
 */
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "mpi/worker.h"
#include "recurse/transport/render.h"

namespace recurse::apps {

/** As recurse::render(), which began at `start`, while all others follow(); `names` are those of the ranks.
 */
RenderStatistics lead(Worker& worker, const std::vector<std::string>& names, const RenderSettings& settings,
                      Film& film, Clock::time_point start, const std::atomic<bool>& stop,
                      const std::function<void(const RenderProgress&)>& progress);

} // namespace recurse::apps
