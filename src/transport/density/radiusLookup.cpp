/** @file
 * Lookup in the radius cache: records near a point that are on the same surface.
 */
#include "transport/density/radiusCache.h"

#include <algorithm>
#include <utility>

#include "recurse/core/threads/parallel.h"

namespace recurse {

void RadiusCache::findNeighbours() {
  neighbours.resize(records.size());
  parallelFor(records.size(), [&](size_t i) {
    thread_local PhotonScratch scratch;
    Record& record = records[i];
    const auto distance2 = [&](uint32_t slot) {
      return lengthSquared(record.position - records[slot].position);
    };
    std::vector<uint32_t> found;
    const bool hasLayers = std::isfinite(std::min(record.around.clearance, record.around.depth));
    index.nearest(regionInIndex(record.position, record.normal), (hasLayers ? 4 : 1) * NEIGHBOURS + 1,
                  scratch);
    index.visitNearest(scratch, [&](const PhotonBlock& block) {
      for (uint32_t slots = block.mask; slots != 0; slots &= slots - 1) {
        const size_t slot = block.first + static_cast<size_t>(std::countr_zero(slots));
        if (slot != i) found.push_back(static_cast<uint32_t>(slot));
      }
    });
    std::ranges::sort(found, {}, [&](uint32_t slot) { return std::pair(distance2(slot), slot); });
    auto& others = neighbours[i];
    others.fill(static_cast<uint32_t>(i));
    const size_t count = std::min(found.size(), NEIGHBOURS);
    if (count == 0) return;
    std::copy_n(found.begin(), count, others.begin());
    record.spacing = std::sqrt(distance2(found[std::min<size_t>(2, count - 1)]));
    // The last neighbour leads to the nearest record of another surface.
    const auto other = std::ranges::find_if(found, [&](uint32_t slot) {
      return !record.isOnSurfaceOf(records[slot].position, records[slot].normal);
    });
    if (other != found.end() && size_t(other - found.begin()) >= NEIGHBOURS) others.back() = *other;
  });
}

CachedRadius RadiusCache::at(const Vec3f& position, const Vec3f& normal) const {
  if (index.empty()) return {limit, nullptr, INFINITE, 0};
  const auto isKnown = [&](size_t slot) { return records[slot].isOnSurfaceOf(position, normal); };
  const size_t nearest = index.nearestSlot(regionInIndex(position, normal).center);
  size_t best = nearest;
  bool known = isKnown(nearest);
  const auto consider = [&](size_t slot) {
    const auto away2 = [&](size_t i) { return lengthSquared(position - records[i].position); };
    if ((known && !(away2(slot) < away2(best))) || !isKnown(slot)) return;
    best = slot;
    known = true;
  };
  if (!known)
    for (const uint32_t slot : neighbours[nearest]) consider(slot);
  if (!known) // all of these may be on the next layer
    for (const uint32_t beside : neighbours[nearest])
      for (const uint32_t slot : neighbours[beside]) consider(slot);
  // The density of photons is unknown over smaller distances than that to the nearest record.
  const float least = glm::distance(position, records[best].position);
  if (known) {
    // Chooses a random neighbour by a hash, which hides borders between records.
    uint64_t hash = 0;
    Vec3f offset;
    for (int i = 0; i < 3; ++i) {
      hash = hashCombine(hash, std::bit_cast<uint32_t>(position[i]));
      offset[i] = 2 * unitFloat(static_cast<uint32_t>(hash >> 32)) - 1;
    }
    offset = (offset - normal * glm::dot(offset, normal)) * records[best].spacing;
    const auto distance2 = [&](size_t i) { return lengthSquared(position + offset - records[i].position); };
    const size_t slot = *std::ranges::min_element(neighbours[best], {}, distance2);
    if (distance2(slot) < distance2(best) && isKnown(slot)) best = slot;
  }
  const Record& record = records[best];
  return {std::min(limit, std::max(record.radius, least)), known ? &record.around : nullptr,
          glm::distance(position, record.position), best};
}

} // namespace recurse
