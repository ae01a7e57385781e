/** @file
 * Rank that distributes the work.
 */
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "mpi/worker.h"
#include "recurse/render/render.h"

namespace recurse::apps {

/** Leads a render that began at `start`, like recurse::render(), while all other ranks follow(). `names` are
 * the names of ranks. `log` gets a warning when a silent rank delays the render. */
RenderStatistics lead(Worker& worker, const std::vector<std::string>& names, const RenderSettings& settings,
                      Film& film, Clock::time_point start, const std::atomic<bool>& stop,
                      const std::function<void(const RenderProgress&)>& progress,
                      const std::function<void(const std::string&)>& log);

} // namespace recurse::apps
