/** @file
 * Visit of all photons of a map, and of the boxes of its tree, for display.
 */
#pragma once

#include <functional>

#include "recurse/transport/integrator/integrator.h"
#include "transport/photonmap/photonMap.h"

namespace recurse {

/** Calls visit(photon) for each photon of a map; `caustic`: flag of photons in a caustic map. */
inline void visitMap(const PhotonMap& map, bool caustic,
                     const std::function<void(const StoredPhoton&)>& visit) {
  for (size_t slot = 0; slot < map.size(); ++slot)
    visit({map.position(slot), map.direction(slot), unpackDirection(map.packedNormal(slot)), map.power(slot),
           LightState(map.pathState(slot)), caustic});
}

/** Calls visit(box) for the boxes of the map's tree, see Integrator::visitPhotonBoxes(). */
inline void visitMapBoxes(const PhotonMap& map, bool caustic, int levels,
                          const std::function<void(const PhotonBox&)>& visit) {
  map.visitBoxes(levels, [&](int level, const Bounds3f& box, size_t photons) {
    visit({box, level, photons, caustic});
  });
}

} // namespace recurse
