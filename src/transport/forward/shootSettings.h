/** @file
 * Settings of the forward pass: the number, starts and storage of photons; the photons stored.
 */
#pragma once

#include <tuple>
#include <vector>

#include "recurse/transport/integrator/lightPathRecorder.h"
#include "transport/direct/lightSampler.h"
#include "transport/emission/emissionSampler.h"
#include "transport/emission/visibleRegion.h"
#include "transport/media/photonBeams.h"
#include "transport/media/volumePhotons.h"
#include "transport/photonmap/photon.h"

namespace recurse {

/** Photons that walks store in media. Each medium stores either points or beams, so that nothing is counted
 * twice. */
struct KeptInMedia {
  std::vector<bool> byBeams;         ///< by index of the medium; empty: no beams
  float pointPart = 1, beamPart = 1; ///< fractions that are stored, at a power divided by the fraction

  bool isByBeams(uint16_t medium) const { return medium < byBeams.size() && byBeams[medium]; }
};

/** Photons that walks have stored, by kind, in the order of emission. Their powers are divided by the number
 * of photons emitted. */
struct StoredPhotons {
  std::vector<Photon> onSurfaces;
  std::vector<float> lengths; ///< optical lengths of the paths of `onSurfaces`; empty unless transient
  std::vector<VolumePhoton> inMedia;
  std::vector<PhotonBeam> beams;

  size_t size() const { return onSurfaces.size() + inMedia.size() + beams.size(); }
  auto lists() { return std::tie(onSurfaces, lengths, inMedia, beams); }
  void clear() {
    std::apply([](auto&... list) { (list.clear(), ...); }, lists());
  }
};

struct ShootSettings {
  uint64_t photons = 0; ///< number emitted in the pass
  int maxDepth =
      -1; ///< maximum number of scattering events, including the one of a stored photon; -1: no limit
  /** Whether photons straight from a light, thin panes included, are stored as well. Photons of emissive
   * media always are: no other technique samples their light. */
  bool direct = true;
  bool causticsOnly = false; ///< photons end at the first non-delta surface, and in media
  EmissionSettings emission;
  /** Light sampler of shadow rays, for Photon::reverseRatio; null: there are no shadow rays. */
  const LightSampler* shadowRays = nullptr;
  KeptInMedia inMedia;
  const VisibleRegion* region = nullptr; ///< region in which strong photons are split; null: none
  /** Approximate power of each photon after a split, times the number of photons emitted [W]. */
  float splitPower = INFINITE;
  LightPathRecorder* lightPaths = nullptr; ///< null: nothing is recorded
};

} // namespace recurse
