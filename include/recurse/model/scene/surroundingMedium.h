/** @file
 * Medium around a place, by the surfaces that enclose it.
 */
#pragma once

#include <span>

#include "recurse/model/scene/scene.h"

namespace recurse {

/** True where neither light nor a medium passes. */
inline bool isOpaque(const Material* material) {
  return material && !(material->lobes() & (TRANSMISSION | REFRACTION));
}

/** True for the surface of a dielectric with a priority. */
inline bool isNested(const Hit& hit) { return hit.material && hit.material->nesting >= 0; }

/** Index of the medium on the side of a surface that a ray in `direction` comes from; of nested dielectrics,
 * the medium outside, as their inside has a medium of its own. */
inline uint16_t mediumBefore(const Hit& hit, const Vec3f& direction) {
  return isNested(hit) || glm::dot(direction, hit.point.geometricNormal) < 0 ? hit.media.outside
                                                                             : hit.media.inside;
}

/**
 * Index of the medium outside of nested dielectrics, at a place where all `rays` start. Each ray is the start
 * of a random walk, which opaque surfaces reflect and others let pass, to the first boundary of media that
 * light passes; the most frequent medium counts. Without a boundary it is the `named` medium, or if that is 0
 * the one that the surfaces on the way are in. Opaque sheets are no boundaries: they have no inside, though a
 * MediumInterface may give them one. The medium varies if walks end at boundaries in different media. Adds
 * the number of rays to `traced`.
 */
SurroundingMedium mediumAround(const Scene& scene, std::span<const Ray> rays, uint16_t named,
                               uint64_t& traced);

} // namespace recurse
