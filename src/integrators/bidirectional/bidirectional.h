/** @file
 * Estimators with subpaths from both ends: bidirectional path tracing (Veach and Guibas 1995), light tracing,
 * and vertex connection and merging (Georgiev et al. 2012), as subsets of the same techniques.
 */
#pragma once

#include "integrators/bidirectional/lightSubpaths.h"
#include "recurse/scene/parameters/parameters.h"
#include "transport/density/radiusCache.h"
#include "transport/photonmap/photonMap.h"

namespace recurse {

/** Techniques in use; bidirectionalWeights.h defines them. */
struct BidirectionalSettings {
  int maxDepth = -1;       ///< maximum scattering events of a path; -1: no limit
  uint64_t lightPaths = 0; ///< number in each pass; 0: one for each pixel of the film
  bool hits = true, shadowRays = true, connections = true, splats = true, merges = false;
  float radius = 0;       ///< merge radius in the first pass [scene units]; 0: 1.5 pixels
  double alpha = 2.0 / 3; ///< alpha of the progressive radius reduction, see radiusScale()
  bool correlated = true; ///< weights account for the correlation of merged photons
  bool guided = false;    ///< light paths start by a learned mixture
};

/** Parameter "guided" of bidirectional integrators. */
ParameterSpec guidedStartsParameter();

/** Bidirectional integrator. Each pass has its own light paths and serves one sample of each pixel. */
class Bidirectional : public Integrator {
 public:
  explicit Bidirectional(const BidirectionalSettings& settings) : settings(settings) {}

  Passes passes(int) const override { return Passes::perSample(); }
  bool splats() const override { return settings.splats; }
  bool passHasOneTime() const override { return true; }
  TransportCounts prepare(const Scene& scene, const PathClasses& classes) override;
  ForwardStatistics forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                            const ForwardControl& control) override;
  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler, PathRadiance& out) const override;
  /** Visits the vertices of light paths that camera paths can be joined with. */
  void visitPhotons(const std::function<void(const StoredPhoton&)>& visit) const override;
  std::string photonName() const override { return "vertices of light paths"; }
  void visitPhotonBoxes(int levels, const std::function<void(const PhotonBox&)>& visit) const override;
  bool supportsFibres() const override { return false; }
  bool supportsTransient(const Scene&) const override { return true; }
  std::vector<EstimatorDomain> domains() const override;

 private:
  class LightWalk;
  class CameraWalk;
  /** Light vertex that a photon represents. */
  struct PhotonVertex {
    uint32_t path, number; ///< number: index on its light path; 1: next to the light
  };

  /** Starts of the light paths. */
  EmissionSettings emission() const {
    EmissionSettings settings;
    settings.mixture = &starts;
    return settings;
  }
  void buildPhotons();
  /** Follows light path `number` of the current pass again, and appends its vertices to `record`. */
  void recordLightPath(const Scene& scene, const PathClasses& classes, size_t number,
                       std::vector<RecordedLightVertex>& record) const;
  bool keepsLightPaths() const { return settings.connections || settings.merges; }
  /** Merge radius of a path whose first non-delta vertex has this pixel footprint [scene units]. */
  double mergeRadius(double footprint) const;
  /** Path for the weights, without the data of its vertices. `distance`: of its first vertex from the camera
   * [scene units]. */
  WeightedPath weightedPath(double mergeRadius, double distance) const;
  /** Completes it with the data that depend on the vertices: shadow rays and merges. */
  void completePath(const Scene& scene, WeightedPath& path, const LightEnd& end,
                    const ShadowRayStart& shadowRayStart) const;
  bool isTooLong(size_t events) const {
    return settings.maxDepth >= 0 && events > static_cast<size_t>(settings.maxDepth);
  }

  BidirectionalSettings settings;
  LightSampler lights;
  EmissionMixture starts; ///< not active unless `guided`
  RadiusCache surfaces;   ///< surface geometry for merges; its radii are not used
  double lightPaths = 0;  ///< number in each pass
  bool splatted = false;  ///< light paths are connected to the camera
  // State of the current pass:
  Pass current;
  LightSubpaths subpaths;
  PhotonMap photons;
  std::vector<PhotonVertex> photonVertices; ///< by PhotonMap::emissionIndex()
  double radiusScale = 1;
};

} // namespace recurse
