/** @file
 * What is known of a place before photons are searched there: how far a progressive density estimate looks,
 * before any shrinking, and how far the surface has no edge. It is independent of the photons of the pass
 * that uses it, so that those are counted without bias.
 */
#pragma once

#include <bit>

#include "transport/density/gather.h"
#include "transport/density/supportErrors.h"
#include "transport/direct/lightSampler.h"
#include "transport/emission/cameraProbe.h"

namespace recurse {

/**
 * The radius of a progressive estimate in pass `index` (0, 1, …) over that of the first pass, after Knaus and
 * Zwicker, "Progressive Photon Mapping: A Probabilistic Approach" (2011), equation 15: the squares of
 * successive radii are as (i + alpha) : (i + 1). A pass depends on no other, so any machine may do it. alpha
 * in (0, 1]: 1 never shrinks.
 */
float radiusScale(uint32_t index, double alpha);

/** Known before a search at a point. */
struct CachedRadius {
  float radius = 0;                     ///< of the first pass
  const Neighbourhood* known = nullptr; ///< of a place near by that looks the same way and is seen, if any
  float away = 0;                       ///< the distance to that place
  size_t index = 0;                     ///< of the place whose radius it is
};

class RadiusCache {
 public:
  /** Takes at places all over a first photon map, and at places that are seen, the distance to the k-th
   * photon, and at most search.radius, and what the surface is like around them. k = search.nearest; 0:
   * search.radius everywhere. With alpha > 0, that of radiusScale(), the distance is a first guess: where
   * discs of another area promise less error over many passes, they are taken; and what a search is worth is
   * found out by `rays`; without `choosesAreas` the errors are found and the first guess stays. The geometric
   * normals of `seen` point to where they are seen from. The map is not
   * needed afterwards. */
  void build(const Scene& scene, const PhotonMap& first, std::span<const VisiblePoint> seen,
             const GatherSettings& search, double alpha, LightDetail detail, const RayAlternative& rays,
             TransportCounts& counts, bool choosesAreas = true);
  /** How far to look at a point with this geometric normal: the radius of one of the places around, which the
   * point's coordinates choose like a random number so that no borders between places are seen, and no less
   * than the way to it. */
  CachedRadius at(const Vec3f& position, const Vec3f& normal) const;

  size_t size() const { return places.size(); }
  struct Place {
    Vec3f position{0}, normal{0};
    float error = 0;        ///< of the position
    bool bothSides = false; ///< as of GatherRegion
    float radius = 0;
    float spacing = 0;   ///< distance to the third nearest of the other places
    float footprint = 0; ///< how wide a pixel is there [scene units]; 0: not known to be seen
    /** Of the irradiance, its channels added up, in the first pass: its value [W/m²], variance, and what the
     * square of the bias weighs beside it over many passes [W²/m⁴]. The variance is infinite where no photon
     * tells. */
    float irradiance = 0, variance = INFINITE, bias2 = 0;
    GatherWorth worth;
    Neighbourhood around;
  };
  const Place& place(size_t i) const { return places[i]; }

 private:
  std::vector<Place> places; ///< in the order of the index's slots
  /** The places, lifted off their surfaces by far more than the scene's width: so the nearest is one whose
   * surface faces the same way, and the two sides of a thin wall are far apart. */
  PhotonMap index;
  float limit = 0, lift = 0;
  /** Around where a place at the point would be in the index. */
  GatherRegion regionInIndex(const Vec3f& position, const Vec3f& normal) const {
    GatherRegion region;
    region.center = position + lift * normal;
    region.bothSides = true;
    return region;
  }
};

} // namespace recurse
