/** @file
 * The render loop: passes of the forward and backward parts of an integrator into a film, until the samples,
 * the time or the person's patience are used up.
 */
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>

#include "recurse/render/renderSettings.h"
#include "recurse/transport/integrator/integrator.h"

namespace recurse {

/** What the film tells: the samples of all pixels, and a warning where some have none. */
void countSamples(const Film& film, RenderStatistics& statistics);

/**
 * Renders into the film, which is empty or, for a render that goes on, the one of that moment. Returns early
 * when `stop` becomes true; the film then holds what there is. Bit for bit the same for any number of threads
 * and interruptions unless it ends early.
 */
RenderStatistics render(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                        const RenderSettings& settings, Film& film, const std::atomic<bool>& stop,
                        const std::function<void(const RenderProgress&)>& progress,
                        const std::function<void(const std::string&)>& log);

/** Makes the first pass and takes no sample: `notes` of the statistics say what the integrator has chosen. */
RenderStatistics shootFirstPass(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                                const RenderSettings& settings);

} // namespace recurse
