/** @file
 * Photons as a list, for estimates by hand.
 */
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "recurse/model/scene/scene.h"
#include "recurse/pathclasses/pathExpression.h"

namespace recurse::python {

/** A photon at a point of a medium that scatters, or at a surface that scatters other than a mirror or smooth
 * glass. */
struct PhotonRecord {
  static constexpr size_t MAX_EVENTS = 16;
  std::array<double, 3> position;        ///< in world space
  std::array<float, 3> direction;        ///< unit, towards where it came from
  std::array<float, 3> normal;           ///< geometric, unit, on the side that it came from; 0 in a medium
  std::array<float, 3> power;            ///< red, green, blue [W]; in a medium, the part that is scattered
  std::array<char, MAX_EVENTS + 1> path; ///< L and the events before this point, the first MAX_EVENTS
  std::array<char, 1> event;             ///< at this point: D, in a medium V
  int32_t pathClass; ///< index of the first class with the path from here to the camera; -1: none
};

/** Which photons are asked for. */
struct PhotonRequest {
  uint64_t emitted = 0; ///< light paths
  uint64_t seed = 0;
  int maxDepth = -1; ///< most scattering events of a path; -1: any number
  std::vector<PathAutomaton> classes;
};

/** All photons that the light paths leave behind, in the order of emission. The same for any number of
 * threads. */
std::vector<PhotonRecord> listPhotons(const Scene& scene, const PhotonRequest& request);

} // namespace recurse::python
