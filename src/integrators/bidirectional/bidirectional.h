/** @file
 * Estimators that make paths from both ends: bidirectional path tracing (Veach and Guibas 1995), light
 * tracing, and vertex connection and merging (Georgiev et al. 2012), as sets of the same techniques.
 */
#pragma once

#include "integrators/bidirectional/lightSubpaths.h"
#include "transport/photonmap/photonMap.h"

namespace recurse {

/** Which techniques there are; bidirectionalWeights.h says what they do. */
struct BidirectionalSettings {
  int maxDepth = -1;       ///< most scattering events of a path; -1: no limit
  uint64_t lightPaths = 0; ///< in each pass; 0: one for each pixel of the film
  bool hits = true, shadowRays = true, connections = true, splats = true, merges = false;
  float radius = 0;       ///< of merges in the first pass [scene units]; 0: that of a few pixels
  double alpha = 2.0 / 3; ///< how fast the radius shrinks, see radiusScale()
  bool correlated = true; ///< weights know that photons found from many places are not independent
};

/** Each pass has light paths of its own and serves one sample of each pixel. */
class Bidirectional : public Integrator {
 public:
  explicit Bidirectional(const BidirectionalSettings& settings) : settings(settings) {}

  Passes passes(int) const override { return Passes::perSample(); }
  bool splats() const override { return settings.splats; }
  bool passHasOneTime() const override { return true; }
  void prepare(const Scene& scene, const PathClasses& classes) override;
  ForwardStatistics forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                            const ForwardControl& control) override;
  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler, PathRadiance& out) const override;
  bool supportsFibres() const override { return false; }
  std::vector<EstimatorDomain> domains() const override;

 private:
  class LightWalk;
  class CameraWalk;
  /** A light vertex among the photons. */
  struct PhotonVertex {
    uint32_t path, number; ///< number 1 is next to the light
  };

  void buildPhotons();
  bool keepsLightPaths() const { return settings.connections || settings.merges; }
  /** Radius of merges of paths whose first vertex off mirrors and glass is seen by a pixel so wide. */
  double mergeRadius(double footprint) const;
  /** A path for the weights, as far as it does not depend on its vertices. `distance`: of the first from the
   * camera. */
  WeightedPath weightedPath(double mergeRadius, double distance) const;
  /** What depends on the vertices: shadow rays and merges. */
  void completePath(const Scene& scene, WeightedPath& path, const LightEnd& end,
                    const ShadowRayStart& shadowRayStart) const;
  bool isTooLong(size_t events) const {
    return settings.maxDepth >= 0 && events > static_cast<size_t>(settings.maxDepth);
  }

  BidirectionalSettings settings;
  LightSampler lights;
  double lightPaths = 0; ///< in each pass
  bool splatted = false; ///< paths are connected to the camera
  // Of the pass:
  LightSubpaths subpaths;
  PhotonMap photons;
  std::vector<PhotonVertex> photonVertices; ///< by PhotonMap::emissionIndex()
  double radiusScale = 1;
};

} // namespace recurse
