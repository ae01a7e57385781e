/** @file
 * Photons as a list, for estimates by hand.
 */
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "recurse/model/scene/scene.h"

namespace recurse::python {

/** A photon at a surface that scatters other than a mirror or smooth glass. */
struct PhotonRecord {
  static constexpr size_t MAX_EVENTS = 16;
  std::array<double, 3> position;        ///< in world space
  std::array<float, 3> direction;        ///< unit, towards where it came from
  std::array<float, 3> normal;           ///< geometric, unit, on the side that it came from
  std::array<float, 3> power;            ///< red, green, blue [W]
  std::array<char, MAX_EVENTS + 1> path; ///< L and the events before this surface, the first MAX_EVENTS
};

/** All photons that `emitted` light paths leave behind, in the order of emission; `maxDepth`: most surfaces
 * of a path, -1: any number. The same for any number of threads. */
std::vector<PhotonRecord> listPhotons(const Scene& scene, uint64_t emitted, uint64_t seed, int maxDepth);

} // namespace recurse::python
