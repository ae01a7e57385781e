/** @file
 * Training of the guide by photons and camera paths. Its size and random numbers do not depend on the crop
 * window, the threads or the processes.
 */
#pragma once

#include "recurse/model/bsdf/scatteringPoint.h"
#include "transport/direct/lightSampler.h"
#include "transport/emission/emissionGuide.h"
#include "transport/guiding/guideField.h"

namespace recurse {

struct GuideTrainingSettings {
  int maxDepth = -1;    ///< most scattering events of a path; -1: no limit
  int lightSamples = 1; ///< shadow rays at each vertex
  bool caustics = true; ///< rays have to find caustics: no photon map has them
};

/**
 * The guide of a render and what it learns from. Stage k precedes pass k + 1 of Passes::doubling(); its
 * camera paths are a fraction of those of the passes before, and follow the guide of stage k - 1. The guide
 * of a pass depends on the scene, the seed and the pass alone.
 */
class GuideTraining {
 public:
  explicit GuideTraining(const GuideTrainingSettings& settings) : settings(settings) {}

  /** Learns what the guide of a pass has to know, for camera paths whose direct light is sampled by `lights`.
   * Nothing before pass 1, so that the first picture does not wait. Nothing changes when it is stopped. */
  void prepare(const Scene& scene, const LightSampler& lights, const Pass& pass,
               const ForwardControl& control, TransportCounts& counts);

  /** Null: BSDF sampling everywhere. */
  const GuideField* guide() const { return field.cellsOn() > 0 ? &field : nullptr; }

 private:
  std::vector<GuideRecord> photonsOfStage(const Scene& scene, const LightSampler& lights, const Pass& pass,
                                          double count, const ForwardControl& control,
                                          TransportCounts& counts);

  GuideTrainingSettings settings;
  int stage = -1;         ///< the last one
  EmissionGuide emission; ///< of training photons, from the first stage
  std::vector<GuideRecord> records;
  GuideField field;
};

/** The guide's cell for a surface point that is seen from unit `wi`; null: BSDF sampling alone. */
inline const GuideCell* guideAt(const GuideField& guide, const SurfacePoint& point, const Vec3f& wi) {
  return guide.find(point.position, point.normalTowards(wi));
}

} // namespace recurse
