/** @file
 * The one density estimate of the program: radiance that leaves a surface point because of the photons around
 * it (Jensen 1996, "Global Illumination using Photon Maps", equation 4, with a kernel).
 */
#pragma once

#include "recurse/model/scatteringPoint.h"
#include "recurse/transport/integrator.h"
#include "recurse/transport/kernel.h"
#include "recurse/transport/lobeSharing.h"
#include "recurse/transport/surroundings.h"

namespace recurse {

struct GatherSettings {
  Kernel kernel = Kernel::EPANECHNIKOV;
  int nearest = 0;       ///< photons looked for; 0: all within the radius
  float radius = 0;      ///< of the search, or its limit where `nearest` is given [scene units]
  float flatness = 0.2f; ///< of the search region, see GatherRegion
  LobeSharing sharing;   ///< with rays that follow sharp lobes; by default there are none
};

/** What an estimate went by. */
struct GatherResult {
  float radius = 0; ///< of the disc that was used
  int found = 0;    ///< photons in it
};

/**
 * Adds the radiance towards unit `eye` from the photons near a point with non-delta lobes, times
 * `throughput`. `eyeState` has read the D at the point. A disc smaller than `footprint` (the pixel's width
 * there) is widened to it: detail below a pixel is only noise. With `surroundings` the area is that of the
 * surfaces in the disc, see fitToSurface(), and a disc of which too little is surface is made smaller.
 */
GatherResult gather(const PhotonMap& map, const GatherSettings& settings, const ScatteringPoint& scattering,
                    const SurfacePoint& point, const Vec3f& eye, float footprint, const Rgb& throughput,
                    EyeState eyeState, PathRadiance& out, Surroundings* surroundings = nullptr);

/** Irradiance [W/m²] by the same estimate, from the side that the unit geometric normal points to. `error`
 * bounds that of the position. */
Rgb irradiance(const PhotonMap& map, const GatherSettings& settings, const Vec3f& position,
               const Vec3f& normal, float error, Surroundings* surroundings, TransportCounts& counts);

} // namespace recurse
