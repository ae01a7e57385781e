/** @file
 * Caustic photons at the vertices of a path tracer.
 */
#include "recurse/transport/causticPhotons.h"

#include "recurse/transport/gather.h"

namespace recurse {

float CausticPhotons::add(const Scene& scene, const SurfacePoint& point, const Vec3f& wi,
                          const ScatteringPoint& scattering, const Rgb& throughput, CameraState camera,
                          float width, const Sampler& sampler, PathRadiance& out) const {
  constexpr uint32_t FORK = 0x4341; // not to be confused with others of the same sampler
  if (!scattering.keepsPhotons()) return 0;
  const PhotonQuery query = photons.query(photons.caustics(), point, wi, scattering.lobes());
  BoundaryCorrection boundary{scene, sampler.fork(FORK), query.place.known, query.place.away};
  return gather(photons.caustics().map, query.settings, scattering, point, wi, width * photons.scale(),
                throughput, camera, out, photons.hasEdges() ? &boundary : nullptr)
      .merging;
}

} // namespace recurse
