/** @file
 * Visible points of a grid of camera rays, found before an image is rendered.
 */
#pragma once

#include <vector>

#include "transport/emission/visibleRegion.h"
#include "transport/paths/walk.h"
#include "transport/weights/gatherWeighting.h"

namespace recurse {

/** First point of a camera path on a surface that gathers photons. */
struct VisiblePoint {
  SurfacePoint point;     ///< surface point whose geometric normal points to the viewer
  float footprint = 0;    ///< width of a pixel there [scene units]
  bool transmits = false; ///< whether its BSDF has a transmission lobe
};

/** Visible points of a grid of `resolution`² camera paths over the image. They follow the strongest delta
 * lobe of a surface, and sample a rough lobe that `weighting` leaves to rays. Paths without a point are
 * omitted.
 */
std::vector<VisiblePoint> probeCamera(const Scene& scene, int resolution, uint64_t seed,
                                      const GatherWeighting& weighting, TransportCounts& counts);

/** Region around the visible points, and around camera rays in media, that photons are guided to. */
VisibleRegion probeRegion(const Scene& scene, const GatherWeighting& weighting, TransportCounts& counts);

} // namespace recurse
