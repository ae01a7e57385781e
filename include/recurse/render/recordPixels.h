/** @file
 * Records of the camera paths of selected pixels, identical to the paths of render().
 */
#pragma once

#include <atomic>
#include <functional>
#include <span>

#include "recurse/render/render.h"
#include "recurse/transport/integrator/pathRecorder.h"

namespace recurse {

/** Pixel of the film with the record of its samples. */
struct RecordedPixel {
  int x = 0, y = 0; ///< on the whole film, within the crop window
  PathRecorder record;
  /** Light of connections to the camera, which are not recorded: its value on the film of a render. */
  Rgb splats{0};
  /** Mean of the samples, weighted by the filter: the value on the film, if all samples are recorded and
   * there are no splats. */
  Rgb value() const;
};

/**
 * Records the first `count` samples of each pixel, or fewer if render() takes fewer with the same settings,
 * whose samples they are bit for bit. Time and error limits are ignored. The integrator must be new, and
 * keeps its last photon map, whose light paths are recorded by `lightPaths` unless it is null. `stop` ends
 * the recording early. Throws Error for a pixel outside of the crop window, and where the integrator cannot
 * render the scene.
 */
RenderStatistics recordPixels(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                              const RenderSettings& settings, int64_t count, std::span<RecordedPixel> pixels,
                              const std::atomic<bool>& stop,
                              const std::function<void(double fraction)>& progress = {},
                              LightPathRecorder* lightPaths = nullptr);

/**
 * Calls use(x, y, record) with the samples of each pixel of the crop window, at (x, y) on the whole film,
 * pass by pass: the samples of render() with the same settings, of which samplesPerPixel must be positive,
 * rendered into the film. Calls for different rows run at the same time; a record exists only during its
 * call. `stop` ends the visit early.
 */
void visitRecords(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                  const RenderSettings& settings, Film& film, const std::atomic<bool>& stop,
                  const std::function<void(int x, int y, const PathRecorder&)>& use);
/** Does the same without records: calls use(x, y, counts, seconds) with the work and the processor time for
 * the samples of a pass. */
void visitCosts(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                const RenderSettings& settings, Film& film, const std::atomic<bool>& stop,
                const std::function<void(int x, int y, const TransportCounts&, double seconds)>& use);

} // namespace recurse
