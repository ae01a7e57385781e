/** @file
 * What camera rays read the photon map at, before any picture is rendered.
 */
#pragma once

#include <vector>

#include "transport/emission/emissionGuide.h"
#include "transport/paths/walk.h"
#include "transport/weights/gatherWeighting.h"

namespace recurse {

/** A surface that is seen through mirrors and glass only, or at once. */
struct VisiblePoint {
  SurfacePoint point;     ///< its geometric normal points to where it is seen from
  float footprint = 0;    ///< how wide a pixel is there [scene units]
  bool transmits = false; ///< light from behind it is seen as well
};

/** The places that a grid of `across`² camera rays over the picture sees, by the strongest delta lobe at each
 * surface; rays that see none are left out. Rough lobes that `sharing` leaves to rays count as mirrors. */
std::vector<VisiblePoint> probeCamera(const Scene& scene, int across, uint64_t seed,
                                      const GatherWeighting& weighting, TransportCounts& counts);

/** What is seen at these places, as a region that light is to be sent to. */
VisibleRegion probeRegion(const Scene& scene, const GatherWeighting& weighting, TransportCounts& counts);

} // namespace recurse
