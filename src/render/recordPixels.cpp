/** @file
 * Records of the samples of pixels, pass by pass.
 */
#include "recurse/render/recordPixels.h"

#include <algorithm>
#include <ctime>

#include "recurse/core/io/error.h"
#include "recurse/core/threads/parallel.h"
#include "render/sampleRenderer.h"

namespace recurse {

namespace {

void requireWithin(const PixelBounds& bounds, std::span<const RecordedPixel> pixels) {
  for (const RecordedPixel& p : pixels)
    if (p.x < bounds.x0 || p.x >= bounds.x1 || p.y < bounds.y0 || p.y >= bounds.y1)
      throw Error("pixel " + std::to_string(p.x) + "," + std::to_string(p.y) +
                      " is outside of the picture of " + std::to_string(bounds.x0) + "," +
                      std::to_string(bounds.y0) + " to " + std::to_string(bounds.x1 - 1) + "," +
                      std::to_string(bounds.y1 - 1),
                  ExitStatus::BAD_USAGE);
}

} // namespace

Rgb RecordedPixel::value() const {
  Rgbd sum(0);
  double weights = 0;
  for (const RecordedSample& s : record.samples()) {
    sum += Rgbd(s.total) * double(s.filterWeight);
    weights += double(s.filterWeight);
  }
  return weights != 0 ? Rgb(sum / weights) : BLACK;
}

RenderStatistics recordPixels(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                              const RenderSettings& settings, int64_t count, std::span<RecordedPixel> pixels,
                              const std::atomic<bool>& stop,
                              const std::function<void(double fraction)>& progress,
                              LightPathRecorder* lightPaths) {
  requireWithin(scene.film().crop, pixels);
  Film film(scene.film().crop, classes.layerCount());
  SampleRenderer renderer(scene, integrator, classes, settings, film, {});
  const int64_t end = std::min(count, renderer.samples());
  ForwardControl control;
  control.stop = &stop;
  control.lightPaths = lightPaths;
  for (int64_t pass = 0; renderer.passBegin(pass) < end; ++pass) {
    const int64_t first = renderer.passBegin(pass), last = std::min(renderer.passEnd(pass), end);
    if (lightPaths) lightPaths->beginPass(0); // for passes without light paths
    if (!renderer.shootPass(pass, false, control)) break;
    for (RecordedPixel& p : pixels)
      renderer.statistics.counts.add(
          renderer.recordSamples(p.x, p.y, uint64_t(first), uint64_t(last), p.record));
    if (progress) progress(double(last) / double(end));
  }
  return renderer.statistics;
}

namespace {

/** Processor time of this thread [s]: other work of the machine does not count. */
double threadSeconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

/** Calls renderPixel(renderer, x, y, first, last) for the samples of each pixel, pass by pass. */
template <class RenderPixel>
void visitSamples(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                  const RenderSettings& settings, Film& film, const std::atomic<bool>& stop,
                  const RenderPixel& renderPixel) {
  SampleRenderer renderer(scene, integrator, classes, settings, film, {});
  const int64_t end = renderer.samples();
  const PixelBounds& crop = scene.film().crop;
  ForwardControl control;
  control.stop = &stop;
  for (int64_t pass = 0; renderer.passBegin(pass) < end; ++pass) {
    const int64_t first = renderer.passBegin(pass), last = std::min(renderer.passEnd(pass), end);
    if (!renderer.shootPass(pass, true, control)) return;
    parallelFor(size_t(crop.height()), [&](size_t row) {
      const int y = crop.y0 + static_cast<int>(row);
      for (int x = crop.x0; x < crop.x1 && !stop; ++x)
        renderPixel(renderer, x, y, uint64_t(first), uint64_t(last));
    });
  }
}

} // namespace

void visitRecords(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                  const RenderSettings& settings, Film& film, const std::atomic<bool>& stop,
                  const std::function<void(int x, int y, const PathRecorder&)>& use) {
  visitSamples(scene, integrator, classes, settings, film, stop,
               [&](const SampleRenderer& renderer, int x, int y, uint64_t first, uint64_t last) {
                 PathRecorder record;
                 renderer.recordSamples(x, y, first, last, record);
                 use(x, y, record);
               });
}

void visitCosts(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                const RenderSettings& settings, Film& film, const std::atomic<bool>& stop,
                const std::function<void(int x, int y, const TransportCounts&, double seconds)>& use) {
  visitSamples(scene, integrator, classes, settings, film, stop,
               [&](const SampleRenderer& renderer, int x, int y, uint64_t first, uint64_t last) {
                 const double start = threadSeconds();
                 const TransportCounts counts = renderer.renderSamples(x, y, first, last, nullptr);
                 use(x, y, counts, threadSeconds() - start);
               });
}

} // namespace recurse
