/** @file
 * Estimates by photon maps at the vertices of a camera path of the photon mapping estimator.
 */
#include "integrators/photonmap/photonMapping.h"

namespace recurse {

void PhotonMapping::weighIndirect(const PathState& path, PhotonQuery& query) const {
  GatherSettings& gather = query.settings;
  gather.leavesLightToRays =
      mayGoOn() && settings.nearest == 0 && settings.radius == 0 && !settings.directLight;
  if (path.nonDelta == 0 && gather.leavesLightToRays) {
    photons.weighAgainstRays(query, path.walk.width);
    return;
  }
  if (mayGoOn() && photons.hasTooFewPhotons()) {
    gather.unknownWeight = 0;
  } else if (path.nonDelta == 0) {
    gather.unknownWeight = settings.finalGather > 0 ? 0 : 1;
  } else {
    // A surface closer than the blur of the map would see it, and needs rays instead.
    const float blur = photons.isProgressive() ? gather.radius : photons.indirect().choice.typicalRadius;
    gather.unknownWeight = path.distance < blur ? 0 : 1;
  }
}

GatherResult PhotonMapping::addPhotons(const Scene& scene, const PhotonLayer& layer,
                                       const IrradianceCache& cache, const PhotonQuery& query,
                                       const CameraVertex& vertex, const PathState& path,
                                       const Sampler& sampler, PathRadiance& out) const {
  const ScatteringPoint& scattering = *vertex.scattering;
  const SurfacePoint& point = vertex.point();
  const Vec3f& wi = vertex.wi;
  const bool isCaustic = &layer == &photons.caustics();
  const auto beginEstimate = [&] {
    if (out.recorder) out.recorder->beginEstimate(path.recordedVertex, isCaustic);
  };
  if (hasRecord(cache, query, scattering, point, path)) {
    beginEstimate();
    const GatherSettings search = atRecord(layer, query);
    const Rgb e = cache.at(query.cached.index, out.counts, [&](TransportCounts& counts) {
      const RadiusCache::Record& record = layer.cache.record(query.cached.index);
      BoundaryCorrection boundary{scene, recordSampler.fork(static_cast<uint32_t>(query.cached.index)),
                                  &record.around};
      return irradiance(layer.map, search,
                        {.center = record.position, .normal = record.normal, .time = record.time},
                        record.error, settings.edges ? &boundary : nullptr, counts);
    });
    if (!isBlack(e))
      out.add(LightState(0), path.walk.state,
              path.sharedThroughput() * e * scattering.value(wi, point.normalTowards(wi)));
    GatherResult weights;
    weights.mergeDensity = mergeDensityWithin(search.mergeDensity, square(search.radius));
    weights.unknownWeight = search.unknownWeight;
    if (out.recorder) out.recorder->endEstimate(search.radius, 0);
    return weights;
  }
  const float footprint = path.walk.width * photons.scale();
  beginEstimate();
  BoundaryCorrection boundary = correctionAt(scene, sampler.fork(DeltaScatters::MAX_COUNT + 1), query.cached);
  const GatherResult result =
      gather(layer.map, query.settings, scattering, point, wi, footprint, path.sharedThroughput(),
             path.walk.state, out, settings.edges ? &boundary : nullptr, &sampler, path.walk.optical);
  if (out.recorder) out.recorder->endEstimate(result.radius, result.found);
  KernelRadii& radii = isCaustic ? out.counts.causticRadii : out.counts.otherRadii;
  radii.add(result.radius, path.walk.width);
  return result;
}

bool PhotonMapping::hasRecord(const IrradianceCache& cache, const PhotonQuery& query,
                              const ScatteringPoint& scattering, const SurfacePoint& point,
                              const PathState& path) const {
  constexpr float MAX_DISTANCE = 0.5f; // relative to the record's radius
  const CachedRadius& near = query.cached;
  return cache.size() > 0 && path.nonDelta > 0 && near.known &&
         near.away <= MAX_DISTANCE * photons.scale() * near.radius && (scattering.lobes() & LAMBERTIAN) &&
         !(scattering.lobes() & TRANSMISSION) && point.shadingNormal == point.geometricNormal;
}

GatherSettings PhotonMapping::atRecord(const PhotonLayer& layer, const PhotonQuery& query) const {
  GatherSettings search = photons.searchWithin(layer, layer.cache.record(query.cached.index).radius);
  search.weighedAgainstRays = query.settings.weighedAgainstRays;
  search.mergeDensity = query.settings.mergeDensity;
  search.unknownWeight = query.settings.unknownWeight;
  return search;
}

} // namespace recurse
