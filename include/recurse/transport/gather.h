/** @file
 * The one density estimate of the program: radiance that leaves a surface point because of the photons around
 * it (Jensen 1996, "Global Illumination using Photon Maps", equation 4, with a kernel).
 */
#pragma once

#include "recurse/model/scatteringPoint.h"
#include "recurse/transport/boundaryCorrection.h"
#include "recurse/transport/gatherWeighting.h"
#include "recurse/transport/integrator.h"
#include "recurse/transport/kernel.h"

namespace recurse {

struct GatherSettings {
  Kernel kernel = Kernel::EPANECHNIKOV;
  int nearest = 0;           ///< photons looked for; 0: all within the radius
  float radius = 0;          ///< of the search, or its limit where `nearest` is given [scene units]
  float flatness = 0.2f;     ///< of the search region, see GatherRegion
  GatherWeighting weighting; ///< with rays that follow sharp lobes; by default there are none
  /** Photons share their paths with camera rays by mergeWeights.h: `merging` is per unit of the kernel's
   * area, `rest` the weight of photons whose ratio is not known. */
  bool weighedAgainstRays = false;
  float merging = 0, rest = 1;
};

/** What an estimate went by. */
struct GatherResult {
  float radius = 0;  ///< of the support that was used
  int found = 0;     ///< photons in it
  float merging = 0; ///< see GatherSettings; for the kernel's area
};

/**
 * Adds the radiance towards unit `eye` from the photons near a point with non-delta lobes, times
 * `throughput`. `cameraState` has read the D at the point. A support smaller than `footprint` (the pixel's
 * width there) is widened to it: detail below a pixel is only noise. With `surroundings` the area is that of
 * the surfaces in the support, see coveredFraction(), and one of which too little is surface is made smaller.
 */
GatherResult gather(const PhotonMap& map, const GatherSettings& settings, const ScatteringPoint& scattering,
                    const SurfacePoint& point, const Vec3f& eye, float footprint, const Rgb& throughput,
                    CameraState cameraState, PathRadiance& out, BoundaryCorrection* boundary = nullptr);

/** Irradiance [W/m²] of a Lambertian surface by the same estimate, photons weighed for a kernel of
 * `settings.radius`, from the side that the unit geometric normal points to. `error` bounds that of the
 * position. */
Rgb irradiance(const PhotonMap& map, const GatherSettings& settings, const Vec3f& position,
               const Vec3f& normal, float error, BoundaryCorrection* boundary, TransportCounts& counts);

} // namespace recurse
