/** @file
 * The estimator of Recurse, for the plug-ins that offer it under their names.
 */
#pragma once

#include "recurse/transport/photonPass.h"

namespace recurse {

struct PhotonMappingSettings : PhotonPassSettings {
  int passes = 0;    ///< see Integrator::passes
  bool trial = true; ///< of path tracing, which is taken where it errs less
  int lightSamples = 1;
  bool shareIrradiance = true; ///< the rays of final gathers read irradiance found out once near each place
  int finalGather = -1;        ///< rays from the first non-delta surface of a path; -1: one, where that pays
  float weightLimit = 0.03f;
};

/** Emitted light, plus the photon maps' estimate at non-delta surfaces, plus mirror and refracted light,
 * recursively. */
std::unique_ptr<Integrator> makePhotonMapping(const PhotonMappingSettings& settings);

} // namespace recurse
