/** @file
 * Radii of progressive estimates.
 */
#include "recurse/transport/radiusField.h"

#include "recurse/core/parallel.h"

namespace recurse {

float radiusScale(uint32_t index, double alpha) {
  // The product over i = 1 … index of (i + alpha) / (i + 1), by gamma functions.
  const double n = double(index);
  return static_cast<float>(
      std::exp(0.5 * (std::lgamma(n + 1 + alpha) - std::lgamma(1 + alpha) - std::lgamma(n + 2))));
}

void RadiusField::build(const PhotonMap& first, int nearest, float limit) {
  this->limit = limit;
  constexpr size_t EVERY = 4, AT_ONCE = 256;
  std::vector<Photon> found((first.size() + EVERY - 1) / EVERY);
  parallelFor((found.size() + AT_ONCE - 1) / AT_ONCE, [&](size_t part) {
    PhotonScratch scratch;
    GatherRegion region;
    region.bothSides = true;
    region.flatness = 1; // photons do not know their surface
    region.radius = limit;
    for (size_t i = part * AT_ONCE; i < std::min(found.size(), (part + 1) * AT_ONCE); ++i) {
      region.center = first.position(i * EVERY);
      const NearestPhotons n = first.nearest(region, nearest, scratch);
      found[i].position = region.center;
      found[i].power = Rgb(n.count == nearest ? std::sqrt(n.radius2) : limit);
    }
  });
  places.build(found);
}

float RadiusField::at(const Vec3f& position) const {
  if (places.empty()) return limit;
  thread_local PhotonScratch scratch;
  GatherRegion region;
  region.center = position;
  region.bothSides = true;
  region.flatness = 1;
  region.radius = limit;
  const NearestPhotons n = places.nearest(region, 1, scratch);
  if (n.count == 0) return limit;
  float known = limit;
  places.visitNearest(scratch, [&](const PhotonBlock& block) {
    for (uint32_t rest = block.mask; rest != 0; rest &= rest - 1)
      known = block.power(std::countr_zero(rest)).r;
  });
  // Where the place is far, there is no telling how far the k-th photon is; as far as the place, at least.
  return std::min(limit, std::max(known, std::sqrt(n.radius2)));
}

} // namespace recurse
