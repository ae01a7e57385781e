/** @file
 * Photons in a balanced kd-tree, and the search for the nearest ones (Jensen 2001, chapter 6).
 */
#pragma once

#include <span>
#include <vector>

#include "frame/course.h"

namespace course::photon {

/** Photon at a diffuse surface. */
struct Photon {
  Vec3f position;
  Vec3f normal; ///< of the surface, on the side of the photon
  Rgb power;    ///< flux [W]
  int axis = 0; ///< along which the tree is split here: 0 is x, 1 y, 2 z
};

/** Photon that a search has found. */
struct NearPhoton {
  Rgb power;           ///< [W]
  float distance2 = 0; ///< squared distance [length²]
};

/** Photons inside of a sphere. */
struct NearPhotons {
  std::vector<NearPhoton> photons;
  float radius2 = 0; ///< squared radius of the sphere [length²]
};

class PhotonTree {
 public:
  /** Sorts the photons into the tree. */
  void build(std::vector<Photon> all);
  size_t size() const { return photons.size(); }
  /** The `count` photons nearest to a point, in the sphere that reaches to the next one; or all within
   * maxRadius, if there are fewer. Photons of surfaces that face away from the normal are left out. */
  NearPhotons nearest(const Vec3f& point, const Vec3f& normal, size_t count, float maxRadius) const;

 private:
  struct Search;
  void sort(std::span<Photon> part);
  void search(std::span<const Photon> part, Search& search) const;

  std::vector<Photon> photons; ///< of each part of the array, the middle one splits it
};

} // namespace course::photon
