/** @file
 * Estimators with photon maps, for the plug-ins that offer them under their names.
 */
#pragma once

#include "integrators/photonmap/photonPass.h"
#include "recurse/scene/parameters/parameters.h"

namespace recurse {

struct PhotonMappingSettings : PhotonPassSettings {
  Passes passes = Passes::perSample();
  int lightSamples = 1;
  bool shareIrradiance = true; ///< the rays of final gathers read irradiance cached at records
  int finalGather = -1;        ///< rays from the first non-delta surface of a path; -1: one, where that pays
  float weightLimit = 0.03f;
};

/** Integrator with photon maps, which also gives access to its photons, to judge their benefit. */
class PhotonMapper : public Integrator {
 public:
  /** Photons of the latest forward(). */
  virtual const PhotonPass& photonPass() const = 0;
  /** Calls `use` with the photons of `other`, a pass after the first, and then restores the photons. */
  virtual ForwardStatistics withPass(const Pass& other, const Scene& scene, const PathClasses& classes,
                                     const ForwardControl& control, const std::function<void()>& use) = 0;
};

/** Photon mapping: emitted light, plus the photon maps' estimate at non-delta surfaces, plus mirror and
 * refracted light, recursively. `lights` has learned the scene and must outlive the integrator; null: the
 * integrator learns its own light sampler. */
std::unique_ptr<PhotonMapper> makePhotonMapping(const PhotonMappingSettings& settings,
                                                const LightSampler* lights = nullptr);
/** Path tracing with photons of caustics alone; paths find all other light. `teacher`: see
 * PhotonPass::learnFrom(); null: the first pass learns. */
std::unique_ptr<PhotonMapper> makeCausticPaths(const PhotonMappingSettings& settings,
                                               const LightSampler* lights = nullptr,
                                               const PhotonPass* teacher = nullptr);

/** Whether the medium around the scene is emissive and unbounded, so that no photons can start in it;
 * integrators with photon maps do not support such scenes. */
bool hasMediaWithoutEnd(const Scene& scene);

/** Parameters of photonmap that other plug-ins share. */
std::vector<ParameterSpec> photonMappingParameters();
PhotonMappingSettings photonMappingSettings(const Parameters& parameters);

} // namespace recurse
