/** @file
 * The estimators with photon maps, for the plug-ins that offer them under their names.
 */
#pragma once

#include "integrators/photonmap/photonPass.h"
#include "recurse/scene/parameters/parameters.h"

namespace recurse {

struct PhotonMappingSettings : PhotonPassSettings {
  Passes passes = Passes::perSample();
  int lightSamples = 1;
  bool shareIrradiance = true; ///< the rays of final gathers read irradiance found out once near each place
  int finalGather = -1;        ///< rays from the first non-delta surface of a path; -1: one, where that pays
  float weightLimit = 0.03f;
};

/** An integrator that maps photons, and what tells whether they pay. */
class PhotonMapper : public Integrator {
 public:
  /** The photons of the latest forward(). */
  virtual const PhotonPass& photonPass() const = 0;
  /** Calls `use` with the photons of another pass than the first in the place of these. */
  virtual ForwardStatistics withPass(const Pass& other, const Scene& scene, const PathClasses& classes,
                                     const ForwardControl& control, const std::function<void()>& use) = 0;
};

/** Emitted light, plus the photon maps' estimate at non-delta surfaces, plus mirror and refracted light,
 * recursively. `lights` has learned the scene and must outlive the integrator; null: it learns its lights
 * itself. */
std::unique_ptr<PhotonMapper> makePhotonMapping(const PhotonMappingSettings& settings,
                                                const LightSampler* lights = nullptr);
/** Photons of caustics alone, beside a path tracer that finds all other light. */
std::unique_ptr<PhotonMapper> makeCausticPaths(const PhotonMappingSettings& settings,
                                               const LightSampler* lights = nullptr);

/** Whether the camera and the lights are in a medium without bounds that glows: photons cannot start there.
 */
bool hasMediaWithoutEnd(const Scene& scene);

/** The parameters of photonmap that others share. */
std::vector<ParameterSpec> photonMappingParameters();
PhotonMappingSettings photonMappingSettings(const Parameters& parameters);

} // namespace recurse
