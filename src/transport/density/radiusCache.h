/** @file
 * Cache of gather radii and surface geometry by position: the radius of a progressive density estimate in its
 * first pass, and how far the surface has no edge. It is learned from the photons of the first pass. In all
 * other passes it is independent of the photons, so that it does not bias their density estimate.
 */
#pragma once

#include "transport/density/gather.h"
#include "transport/density/supportErrors.h"
#include "transport/direct/lightSampler.h"
#include "transport/emission/cameraProbe.h"

namespace recurse {

/**
 * Radius of a progressive estimate in pass `index` (0, 1, …) over the radius of the first pass (Knaus and
 * Zwicker 2011, "Progressive Photon Mapping: A Probabilistic Approach", equation 15): the squares of
 * successive radii are as (i + alpha) : (i + 1). A pass depends on no other pass, so any machine may render
 * it. alpha is in (0, 1]: 1 never shrinks.
 */
float radiusScale(uint32_t index, double alpha);

/** Result of a lookup, known before photons are searched. */
struct CachedRadius {
  float radius = 0;                     ///< radius of the first pass [scene units]
  const Neighbourhood* known = nullptr; ///< at a record near by on the same surface; null: there is none
  float away = 0;                       ///< distance to the record of `known`, or else to the nearest
  size_t index = 0;                     ///< index of the record that the radius is from; 0 without records
};

/** Correction for an estimate at the point of a lookup. Where surfaces move, nothing is known of those around
 * a record, which was made at another time. */
inline BoundaryCorrection correctionAt(const Scene& scene, const Sampler& sampler, const CachedRadius& near) {
  return {scene, sampler, scene.moves() ? nullptr : near.known, near.away};
}

class RadiusCache {
 public:
  /** Creates records at photons of a first map, which have `time`, and at visible points; none if the map is
   * empty. The radius of a record is the distance to the k-th photon, k = search.nearest, at most
   * search.radius, or search.radius if k = 0; coveredFraction() may reduce it. With k > 0 and alpha > 0, see
   * radiusScale(), the errors of this support are estimated, and if `choosesAreas` a support of a different
   * area replaces it where the expected error over many passes is less. With rays.lights, the variance of
   * rays and direct light are estimated too. Geometric normals of `seen` must point to the viewer. The map is
   * not used afterwards. */
  void build(const Scene& scene, const PhotonMap& first, float time, std::span<const VisiblePoint> seen,
             const GatherSettings& search, double alpha, LightDetail detail, const RayAlternative& rays,
             TransportCounts& counts, bool choosesAreas = true);
  /** Looks up the radius at a point with this geometric normal. The record is chosen among the nearest and
   * its neighbours by a hash of the position, which hides borders between records. The radius is at least the
   * distance to the record that was found first, within the limit of the search. Without records it is
   * search.radius. */
  CachedRadius at(const Vec3f& position, const Vec3f& normal) const;

  size_t size() const { return records.size(); }
  struct Record {
    Vec3f position{0}, normal{0};
    float error = 0;        ///< bound of the position error
    float time = 0;         ///< Ray::time at which the surface was found
    bool bothSides = false; ///< see GatherRegion
    float radius = 0;
    float spacing = 0; ///< distance to the third nearest neighbouring record
    /** Irradiance in the first pass, summed over channels, as means over records near by: value [W/m²],
     * and variance [W²/m⁴], which is infinite if the errors are unknown. */
    float irradiance = 0, variance = INFINITE;
    float raysVariance = 0; ///< variance of the same estimate by a ray [W²/m⁴]; 0: unknown
    float lit = 0;          ///< irradiance by photons and direct light [W/m²]; 0: unknown
    Neighbourhood around;

    /** Whether a point with this geometric normal is on the surface of the record: on a different side, on
     * the next layer or behind a wall, the record says nothing of it. */
    bool isOnSurfaceOf(const Vec3f& point, const Vec3f& pointNormal) const {
      constexpr float COHERENT = 0.9f;
      if (!(glm::dot(normal, pointNormal) > COHERENT) || !around.sees(point)) return false;
      const float above = glm::dot(point - position, normal);
      if (lengthSquared(point - position) < square(around.flat))
        return std::abs(above) <= FLATTEST * around.flat + 4 * around.relief + 16 * error;
      return above < std::min(around.clearance, around.heightKnown()) &&
             -above < std::min(around.depth, around.heightKnown());
    }
  };
  const Record& record(size_t i) const { return records[i]; }

 private:
  static constexpr size_t NEIGHBOURS = 8;
  std::vector<Record> records; ///< in the order of the slots of `index`
  std::vector<std::array<uint32_t, NEIGHBOURS>>
      neighbours; ///< records near each record, see findNeighbours()
  /** Positions of the records, displaced along their normals by their median radius, so that the two sides of
   * a thin wall are two such radii apart. A larger displacement would mix the walls of a room. The nearest
   * may still be on a different surface. */
  PhotonMap index;
  float limit = 0, lift = 0;

  /** Finds the nearest records of each, at least one of them on another surface if there is one close by. A
   * lookup on the next layer of a stack then ends on its own layer after two steps from neighbour to
   * neighbour. */
  void findNeighbours();
  /** Region around the displaced position of a record at the point. */
  GatherRegion regionInIndex(const Vec3f& position, const Vec3f& normal) const {
    return {.center = position + lift * normal, .bothSides = true};
  }
};

} // namespace recurse
