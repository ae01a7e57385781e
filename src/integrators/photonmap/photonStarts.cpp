/** @file
 * Starts of photons that trial photons have shown to be useful, and their densities.
 */
#include "integrators/photonmap/photonPass.h"

#include "recurse/core/io/text.h"
#include "transport/emission/cameraProbe.h"

namespace recurse {

EmissionSettings PhotonPass::emission() const {
  EmissionSettings starts;
  starts.mixture = &guidance.emission;
  starts.outside = outside;
  starts.outsideTransmittance = outsideTransmittance;
  return starts;
}

LePdf PhotonPass::pdfLe(uint32_t index, const Light& light, const LeRay& ray) const {
  return emission().pdfLe(index, light, ray);
}

float PhotonPass::probability(const Scene& scene, uint32_t light) const {
  return emission().table(scene).probability(light);
}

void PhotonPass::learnGuidance(const Scene& scene, const PathClasses& classes, uint64_t seed,
                               const ShootSettings& shoot, const ForwardControl& control,
                               ForwardStatistics& statistics) {
  region = probeRegion(scene, settings.weighting, statistics.counts);
  // A search for the nearest photons of one map needs photons of nearly equal power.
  guidance =
      recurse::learnGuidance(scene, classes, seed, shoot, region, control, statistics.counts, progressive);
  if (settings.without == Mechanism::SPLITTING) guidance.splitPower = INFINITE;
  if (guidance.emission.active())
    statistics.notes.push_back(formatted("%.0f %% of the photons are aimed at visible surfaces and openings",
                                         100 * guidance.emission.boxPart()));
}

} // namespace recurse
