/** @file
 * Training of the guide by photons and camera paths. Their numbers and random numbers are independent of the
 * crop window, the threads and the processes.
 */
#pragma once

#include "recurse/model/bsdf/scatteringPoint.h"
#include "transport/direct/lightSampler.h"
#include "transport/emission/emissionMixture.h"
#include "transport/forward/shootSettings.h"
#include "transport/guiding/guideField.h"
#include "transport/paths/pathVertex.h"

namespace recurse {

/**
 * Records of the photons of `pass` that rays of camera paths find better than shadow rays: all indirect
 * light, and caustics where a ray can hit their light. The flux that arrives in a cell
 * from a bin of directions is the integral of L cos over both, so that fluxes are the masses of a density
 * proportional to L cos. `shoot` says how many photons start, and where.
 */
std::vector<GuideRecord> photonRecords(const Scene& scene, const Pass& pass, const ShootSettings& shoot,
                                       const ForwardControl& control, TransportCounts& counts);

struct GuideTrainingSettings {
  int maxDepth = -1;    ///< maximum scattering events of a path; -1: no limit
  int lightSamples = 1; ///< shadow rays at each vertex
};

/**
 * Guide of a render, with its training. Stage k precedes pass k + 1 of Passes::doubling(). Its camera paths
 * are a fraction of the number in all passes before, and follow the guide of stage k - 1, or in stage 0 a
 * guide by its photons alone. They also show how much the guide gains: a guide that does not repay its time
 * is not followed, and soon no longer trained. The guide of a pass depends only on the scene, the seed and
 * the pass.
 */
class GuideTraining {
 public:
  explicit GuideTraining(const GuideTrainingSettings& settings) : settings(settings) {}

  /** Trains the guide up to the stage of a pass, for camera paths whose direct light is sampled by `lights`.
   * Pass 0 only clears the guide, so that the first image is not delayed. A stopped stage has no effect. */
  void prepare(const Scene& scene, const LightSampler& lights, const Pass& pass,
               const ForwardControl& control, TransportCounts& counts);

  /** Current guide; null: BSDF sampling everywhere. */
  const GuideField* guide() const { return isFollowed ? &field : nullptr; }
  /** Learned directions at a surface point on the side of unit `wi`, followed or not; empty before the first
   * stage. */
  LearnedDirections directionsAt(const SurfacePoint& point, const Vec3f& wi) const {
    LearnedDirections out = field.learnedAt(point.position, point.normalTowards(wi));
    out.isSampled = out.guide && isFollowed;
    return out;
  }
  /** Empty before the first stage. */
  std::optional<GuideStatistics> statistics() const;

 private:
  std::vector<GuideRecord> photonsOfStage(const Scene& scene, const Pass& pass, double count,
                                          const ForwardControl& control, TransportCounts& counts);

  GuideTrainingSettings settings;
  double gain = 1;          ///< see GuideStatistics; of the latest stage
  bool isFollowed = false;  ///< the guide repays its time
  int stage = -1;           ///< last completed stage; -1: none
  EmissionMixture emission; ///< learned before the first stage, for the photons of all stages
  std::vector<GuideRecord> records;
  GuideField field;
};

/** Guide cell at a surface point on the side of unit `wi`; null: BSDF sampling only. */
inline const GuideCell* guideAt(const GuideField& guide, const SurfacePoint& point, const Vec3f& wi) {
  return guide.find(point.position, point.normalTowards(wi));
}

/** Mixes the guide into the sampling of the next direction of a camera path, at a surface or in a medium. */
inline void followGuide(const GuideField& guide, CameraVertex& vertex) {
  if (vertex.medium)
    vertex.guide = guide.find(vertex.point().position, Vec3f(0));
  else
    vertex.scattering->follow(guideAt(guide, vertex.point(), vertex.wi));
}

} // namespace recurse
