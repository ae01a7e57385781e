/** @file
 * Photons as a list, for density estimates in Python.
 */
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "recurse/model/scene/scene.h"
#include "recurse/pathclasses/pathExpression.h"

namespace recurse::python {

/** Photon at a scattering point of a medium, or at a surface that scatters by anything but a mirror or smooth
 * glass. */
struct PhotonRecord {
  static constexpr size_t MAX_EVENTS = 16;
  std::array<double, 3> position;        ///< in world space
  std::array<float, 3> direction;        ///< unit, towards the previous vertex
  std::array<float, 3> normal;           ///< geometric, unit, on the side of `direction`; 0 in a medium
  std::array<float, 3> power;            ///< red, green, blue [W]; in a medium, the scattered part
  std::array<char, MAX_EVENTS + 1> path; ///< L and the events before this point, the first MAX_EVENTS
  std::array<char, 1> event;             ///< at this point: D, in a medium V
  int32_t pathClass; ///< index of the first class with the path from here to the camera; -1: none
};

/** Parameters of a list of photons. */
struct PhotonRequest {
  uint64_t emitted = 0; ///< number of light paths
  uint64_t seed = 0;
  int maxDepth = -1; ///< largest number of scattering events of a path; -1: unlimited
  std::vector<PathAutomaton> classes;
};

/** Lists all photons that the light paths store, in the order of emission, identical for any number of
 * threads. */
std::vector<PhotonRecord> listPhotons(const Scene& scene, const PhotonRequest& request);

} // namespace recurse::python
