/** @file
 * The render loop: forward and backward passes of an integrator into a film, until the sample count, the time
 * limit, the error target or an interrupt.
 */
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>

#include "recurse/render/renderSettings.h"
#include "recurse/transport/integrator/integrator.h"

namespace recurse {

/** Copies the film's counts of samples and saturated splats to the statistics, and adds a warning of
 * pixels without a sample. */
void countSamples(const Film& film, RenderStatistics& statistics);

/** Adds a warning where all frames of a transient render are black. `log` gets it too; may be empty. */
void warnOfDarkFrames(const Film& film, const PathClasses& classes, RenderStatistics& statistics,
                      const std::function<void(const std::string&)>& log);

/**
 * Renders into the film, which has the scene's crop window and a layer for each of `classes`. It is empty, or
 * the film of the resume point of an interrupted render. Returns early when `stop` becomes true; the film
 * then holds all samples taken. Bit-identical for any number of threads and interruptions unless it ends
 * early. `log` gets notes and warnings, which are in the statistics, too; both functions may be empty. Throws
 * Error where the integrator cannot render the scene, and for a resume point of several processes.
 */
RenderStatistics render(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                        const RenderSettings& settings, Film& film, const std::atomic<bool>& stop,
                        const std::function<void(const RenderProgress&)>& progress,
                        const std::function<void(const std::string&)>& log);

/** Runs only the first forward pass: `notes` of the statistics describe the choices of the integrator. */
RenderStatistics runFirstForwardPass(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                                     const RenderSettings& settings);

} // namespace recurse
