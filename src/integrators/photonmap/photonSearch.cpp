/** @file
 * Search radii, learned in the first pass, and the weights of photon searches against camera rays.
 */
#include "integrators/photonmap/photonPass.h"

#include <cfloat>

#include "recurse/core/io/text.h"

namespace recurse {

void PhotonPass::learnRadii(const Scene& scene, const PathClasses& classes, const LightSampler& shadowRays,
                            float time, ForwardStatistics& statistics) {
  const float counted = static_cast<float>(emitted);
  const LightSampler* sampled = settings.directLight ? nullptr : &shadowRays;
  const RayAlternative toIndirect{counted, sampled};
  constexpr float FIREFLY = 1e6f; // relative value that about one sample of an image exceeds
  const RayAlternative toCaustics{counted, sampled, FIREFLY};
  const GatherSettings requested{
      settings.kernel, settings.nearest, static_cast<float>(settings.radius), settings.flatness, {}};
  const auto seen = probeCamera(scene, 24, 0, settings.weighting, statistics.counts);
  // Records at visible points cover dark regions, which have few photons.
  const double resolution = std::sqrt(double(scene.film().whole().area())) / 4;
  const auto manySeen = probeCamera(scene, static_cast<int>(std::clamp(resolution, 4.0, 128.0)), 2,
                                    settings.weighting, statistics.counts);
  const bool judged = progressive && settings.nearest == 0 && settings.radius == 0;
  const size_t stored = causticLayer.map.size() + indirectLayer.map.size();
  tooFew = stored * MIN_STORED < emitted || stored < MIN_MAP;
  skipsEmission = manySeen.empty() && stored + mediaPhotons.size() == 0;
  const bool areAllWanted = classes.lightStateCount() == 1; // else possibly none, e.g. for class LDE
  const bool isMapUsed = !manySeen.empty();                 // else a note says so
  if (tooFew && isMapUsed && areAllWanted && emitted > 0 && mediaPhotons.size() == 0 &&
      scene.lights().size() > 0)
    statistics.warnings.push_back(
        stored == 0 && !settings.directLight
            ? "no photon was stored: surfaces receive direct light only, which shadow rays sample, or the "
              "lights miss them"
            : formatted(
                  "only %zu of %llu photons (%.3g %%) were stored on surfaces: paths sample indirect light "
                  "instead, and caustics of small lights are noisy. Emit more photons (--photons), and check "
                  "that the lights are inside of the scene and do not point away",
                  stored, static_cast<unsigned long long>(emitted), 100 * double(stored) / double(emitted)));
  for (PhotonLayer* layer : {&indirectLayer, &causticLayer}) {
    ForwardStatistics discarded;
    const bool isCaustic = layer == &causticLayer;
    // With photons of direct light the layer also contains shadows.
    const LightDetail detail = isCaustic && !settings.directLight ? LightDetail::FINE : LightDetail::SMOOTH;
    layer->choice = chooseGather(scene, layer->map, seen, requested, progressive, settings.directLight,
                                 isCaustic ? discarded : statistics);
    if (!progressive && !settings.edges) continue;
    layer->cache.build(scene, layer->map, time, manySeen, layer->choice.settings, judged ? settings.alpha : 0,
                       detail, isCaustic ? toCaustics : toIndirect, statistics.counts,
                       settings.without != Mechanism::JUDGED_RADII);
  }
  causticRays = judged ? causticVarianceAt(manySeen) : 0;
}

double PhotonPass::causticVarianceAt(std::span<const VisiblePoint> seen) const {
  double sum = 0;
  for (const VisiblePoint& visible : seen) {
    const auto at = [&](const PhotonLayer& layer) {
      const CachedRadius near = layer.cache.at(visible.point.position, visible.point.geometricNormal);
      return near.known ? &layer.cache.record(near.index) : nullptr;
    };
    const RadiusCache::Record *caustic = at(causticLayer), *other = at(indirectLayer);
    if (!caustic || !(caustic->raysVariance > 0)) continue;
    const double all = double(caustic->lit) + (other ? double(other->irradiance) : 0);
    sum += double(caustic->raysVariance) / square(all);
  }
  return seen.empty() ? 0 : sum / double(seen.size());
}

PhotonQuery PhotonPass::query(const PhotonLayer& layer, const SurfacePoint& point, const Vec3f& wi) const {
  PhotonQuery here{layer.choice.settings, {}};
  if (progressive || settings.edges) here.cached = layer.cache.at(point.position, point.normalTowards(wi));
  if (progressive) here.settings = searchWithin(layer, here.cached.radius);
  if (&layer == &causticLayer && !settings.directLight) {
    here.settings.weighedAgainstRays = true;
    here.settings.mergeDensity = static_cast<float>(emitted);
    constexpr float ALL_TO_PHOTONS = 1e15f;
    if (settings.without == Mechanism::MERGE_WEIGHTS) here.settings.mergeDensity = ALL_TO_PHOTONS;
  } else {
    here.settings.weighting = settings.weighting;
  }
  if (layer.cache.size() > 0) here.expected = layer.cache.record(here.cached.index).lit;
  return here;
}

void PhotonPass::weighAgainstRays(PhotonQuery& query, float footprint) const {
  GatherSettings& gather = query.settings;
  gather.weighedAgainstRays = settings.without != Mechanism::MERGE_WEIGHTS;
  gather.mergeDensity = gather.unknownWeight = 0;
  if (tooFew || indirectLayer.cache.size() == 0) return;
  // Without a record of similar normal, as on strongly curved surfaces, the nearest record is used.
  const RadiusCache::Record& record = indirectLayer.cache.record(query.cached.index);
  const double independent = independence(double(gather.radius / std::max(footprint, FLT_MIN)));
  gather.mergeDensity = static_cast<float>(double(emitted) * independent);
  const auto variance = double(record.variance);
  if (!std::isfinite(variance) || !(variance > 0)) return; // no photons there in the first pass
  gather.errors = {double(record.raysVariance), variance / independent};
  gather.unknownWeight = gather.errors.photonWeight(1);
}

float PhotonPass::rayWeight(const Scene& scene, MergeRatio merge, const LightHit& found) const {
  if (found.hit) merge.arrive(-found.emitted.direction, found.hit->point);
  return merge.cameraWeight(pdfLe(found.index, *found.light, found.emitted), probability(scene, found.index));
}

float PhotonPass::arrivals(const Scene& scene, uint32_t light, const LePdf& pdf, float cosine, float distance,
                           float chosen) const {
  return arrivalDensity(scene.lights()[light].kind(), pdf, distance, cosine, probability(scene, light),
                        chosen);
}

GatherSettings PhotonPass::searchWithin(const PhotonLayer& layer, float firstRadius) const {
  GatherSettings now = layer.choice.settings;
  if (!progressive) return now;
  now.nearest = 0;
  if (layer.choice.settings.nearest > 0) now.radius = firstRadius;
  now.radius *= radiusOverFirst;
  return now;
}

} // namespace recurse
