/** @file
 * The density estimate of all integrators: radiance that leaves a surface point due to the photons around it
 * (Jensen 1996, "Global Illumination using Photon Maps", equation 4, with a kernel).
 */
#pragma once

#include <algorithm>

#include "recurse/model/bsdf/scatteringPoint.h"
#include "recurse/transport/integrator/integrator.h"
#include "transport/density/boundaryCorrection.h"
#include "transport/paths/opticalPath.h"
#include "transport/photonmap/kernel.h"
#include "transport/weights/gatherWeighting.h"
#include "transport/weights/mergeWeights.h"

namespace recurse {

/** Variances of irradiance in the first pass [W²/m⁴]: by a ray, and by photons. They determine the weight of
 * photons whose ratio to rays is unknown. */
struct GatherErrors {
  double byRays = 0, variance = 0;
  /** Weight of photons in a support with this fraction of the area within GatherSettings::radius. */
  float photonWeight(double areaFraction) const {
    // Minimum fraction of the error that rays have, and photons; below, the second estimate costs more than
    // it gains.
    constexpr double ONLY_RAYS = 0.35;
    const double rays = areaFraction * byRays;
    const double share = rays > 0 ? rays / (rays + variance) : 0;
    return static_cast<float>(std::clamp((share - ONLY_RAYS) / (1 - 2 * ONLY_RAYS), 0.0, 1.0));
  }
};

struct GatherSettings {
  Kernel kernel = Kernel::EPANECHNIKOV;
  int nearest = 0;           ///< number of photons searched for; 0: all within the radius
  float radius = 0;          ///< search radius, or its maximum if `nearest` is set [scene units]
  float flatness = 0.2f;     ///< flatness of the search region, see GatherRegion
  GatherWeighting weighting; ///< against rays that follow sharp lobes; default: no such rays
  /** Whether photons share their paths with camera rays by the MIS weights of mergeWeights.h. `mergeDensity`:
   * merge density of unit kernel area. `unknownWeight`: weight of photons whose ratio is unknown; of all
   * photons if they are not weighed. */
  bool weighedAgainstRays = false;
  float mergeDensity = 0, unknownWeight = 1;
  /** Whether the caller's rays add the light that photons lack. The unknown weight then depends on the
   * support: it follows from `errors` if photons are weighed; else it is `unknownWeight` times the support's
   * fraction of the area within `radius`, so that no photon is brighter than over that area. Requires
   * `radius` > 0. */
  bool leavesLightToRays = false;
  /** Irradiance by all light at a record near the point, summed over channels [W/m²]. If the photons of a
   * support have much less, Russian roulette decides whether it is estimated; 0: it always is. */
  float expected = 0;
  GatherErrors errors = {};
  float unknownWeightWithin(float radius2) const {
    if (!leavesLightToRays) return unknownWeight;
    const float areaFraction = std::min(1.0f, radius2 / square(radius));
    return weighedAgainstRays ? errors.photonWeight(double(areaFraction)) : unknownWeight * areaFraction;
  }
};

/** Support and weights that an estimate used. */
struct GatherResult {
  float radius = 0;        ///< radius of the support [scene units]
  int found = 0;           ///< number of photons in the support
  float mergeDensity = 0;  ///< merge density of the kernel's whole area, see MergeRatio
  float unknownWeight = 1; ///< see GatherSettings::unknownWeightWithin()
};

/**
 * Adds the radiance towards unit `eye` from the photons near a point with non-delta lobes, times
 * `throughput`. `cameraState`: state after the D event. A support smaller than `footprint` (pixel width) is
 * widened to it: detail below a pixel is only noise. With `boundary` the estimate divides by the area of
 * surface in the support, see coveredFraction(); supports with too little surface are reduced.
 * With `sampler`, which does not advance, the estimate evaluates a BSDF that is not Lambertian for a random
 * few of many photons, and remains unbiased; in a map with lengths it evaluates all. `optical`: optical path
 * of the camera up to the point, for a map with lengths.
 */
GatherResult gather(const PhotonMap& map, const GatherSettings& settings, const ScatteringPoint& scattering,
                    const SurfacePoint& point, const Vec3f& eye, float footprint, const Rgb& throughput,
                    CameraState cameraState, PathRadiance& out, BoundaryCorrection* boundary = nullptr,
                    const Sampler* sampler = nullptr, const OpticalPath& optical = {});

/** Irradiance [W/m²] of a Lambertian surface by the same estimate, at the centre of `region` on the side of
 * its normal. Photons are weighted for a kernel of `settings.radius`. `error`: bound of the error of the
 * position. */
Rgb irradiance(const PhotonMap& map, const GatherSettings& settings, const GatherRegion& region, float error,
               BoundaryCorrection* boundary, TransportCounts& counts);

} // namespace recurse
