/** @file
 * Forward pass: photon tracing from the lights into a list, in the order of emission.
 */
#pragma once

#include "recurse/transport/integrator/integrator.h"
#include "transport/forward/shootSettings.h"

namespace recurse {

struct ShotPhotons : StoredPhotons {
  uint64_t emitted = 0;
  uint64_t emittedHere = 0; ///< emitted by this process, see PhotonSharing
  uint64_t storedHere = 0;  ///< stored by this process, media included
  TransportCounts counts;   ///< work of this process
};

/** Number of initial batches of light paths that predict the memory of all: enough to occupy all threads. */
constexpr size_t FIRST_BATCHES = 64;

/**
 * Traces photons from the starts of settings.emission. Surfaces with a non-delta lobe and media store
 * photons; these continue by Russian roulette on the scattered flux, which keeps powers nearly equal. The
 * lists do not depend on the number of threads. Photons that no path class can use are not followed.
 */
ShotPhotons shootPhotons(const Scene& scene, const PathClasses& classes, const Pass& pass,
                         const ShootSettings& settings, const ForwardControl& control);

} // namespace recurse
