/** @file
 * Photons of a map, one by one, for whoever shows them.
 */
#pragma once

#include <functional>

#include "recurse/transport/integrator/integrator.h"
#include "transport/photonmap/photonMap.h"

namespace recurse {

/** Calls visit(photon) for each photon of a map; `caustic`: it is one of caustics. */
inline void visitMap(const PhotonMap& map, bool caustic,
                     const std::function<void(const StoredPhoton&)>& visit) {
  for (size_t slot = 0; slot < map.size(); ++slot)
    visit({map.position(slot), map.direction(slot), unpackDirection(map.packedNormal(slot)), map.power(slot),
           LightState(map.pathState(slot)), caustic});
}

} // namespace recurse
