/** @file
 * The one density estimate of the program: radiance that leaves a surface point because of the photons around
 * it (Jensen 1996, "Global Illumination using Photon Maps", equation 4, with a kernel).
 */
#pragma once

#include <algorithm>

#include "recurse/model/bsdf/scatteringPoint.h"
#include "recurse/transport/integrator/integrator.h"
#include "transport/density/boundaryCorrection.h"
#include "transport/photonmap/kernel.h"
#include "transport/weights/gatherWeighting.h"

namespace recurse {

/** Squared errors, by which the weight of photons is chosen whose ratio to rays is not known. */
struct GatherErrors {
  double byRays = 0, variance = 0, bias2 = 0;
  /** The photons' weight where a `part` of the area is left that the errors are for, with fewer photons. */
  float photonWeight(double part) const {
    // The rays' part of all: beyond, the second estimate costs more than it brings.
    constexpr double ONLY_RAYS = 0.35, ONLY_PHOTONS = 0.65;
    const double rays = part * byRays;
    const double share = rays > 0 ? rays / (rays + variance + part * bias2) : 0;
    return static_cast<float>(std::clamp((share - ONLY_RAYS) / (ONLY_PHOTONS - ONLY_RAYS), 0.0, 1.0));
  }
};

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
  /** The caller's rays bring what photons do not, and `rest` goes by the support that is used: by `errors`
   * where photons are weighed; else by its part of the area within `radius` (there is one), so that no photon
   * is brighter than over all of that. */
  bool leavesRestToRays = false;
  GatherErrors errors = {};
  float restWithin(float radius2) const {
    if (!leavesRestToRays) return rest;
    const float part = std::min(1.0f, radius2 / square(radius));
    return weighedAgainstRays ? errors.photonWeight(double(part)) : rest * part;
  }
};

/** What an estimate went by. */
struct GatherResult {
  float radius = 0;  ///< of the support that was used
  int found = 0;     ///< photons in it
  float merging = 0; ///< see GatherSettings; for the kernel's area
  float rest = 1;    ///< see GatherSettings; for the support that was used
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
