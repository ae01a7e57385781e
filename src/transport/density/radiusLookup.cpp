/** @file
 * Lookup in the radius cache: records near a point that are on the same surface.
 */
#include "transport/density/radiusCache.h"

#include "recurse/core/threads/parallel.h"

namespace recurse {

void RadiusCache::findNeighbours() {
  neighbours.resize(records.size());
  parallelFor(records.size(), [&](size_t i) {
    thread_local PhotonScratch scratch;
    auto& others = neighbours[i];
    others.fill(static_cast<uint32_t>(i));
    index.nearest(regionInIndex(records[i].position, records[i].normal), NEIGHBOURS + 1, scratch);
    size_t count = 0;
    index.visitNearest(scratch, [&](const PhotonBlock& block) {
      for (uint32_t slots = block.mask; slots != 0; slots &= slots - 1) {
        const size_t slot = block.first + static_cast<size_t>(std::countr_zero(slots));
        if (slot != i && count < NEIGHBOURS) others[count++] = static_cast<uint32_t>(slot);
      }
    });
    if (count == 0) return;
    std::array<float, NEIGHBOURS> distances;
    for (size_t j = 0; j < count; ++j)
      distances[j] = glm::distance(records[i].position, records[others[j]].position);
    const size_t chosen = std::min<size_t>(2, count - 1); // the third
    std::nth_element(distances.begin(), distances.begin() + ptrdiff_t(chosen),
                     distances.begin() + ptrdiff_t(count));
    records[i].spacing = distances[chosen];
  });
}

CachedRadius RadiusCache::at(const Vec3f& position, const Vec3f& normal) const {
  thread_local PhotonScratch scratch;
  if (index.empty()) return {limit, nullptr, INFINITE, 0};
  const auto isSameSurface = [&](const Record& record) { return record.isOnSurfaceOf(position, normal); };
  const auto resultOf = [&](size_t slot, bool same) {
    const Record& record = records[slot];
    return CachedRadius{record.radius, same ? &record.around : nullptr,
                        glm::distance(position, record.position), slot};
  };
  const size_t nearest = index.nearestSlot(regionInIndex(position, normal).center, scratch);
  CachedRadius best = resultOf(nearest, isSameSurface(records[nearest]));
  const auto consider = [&](size_t slot) {
    const bool same = isSameSurface(records[slot]);
    if (best.known && !same) return;
    const CachedRadius other = resultOf(slot, same);
    if ((same && !best.known) || other.away < best.away) best = other;
  };
  if (!best.known)
    for (const uint32_t slot : neighbours[nearest]) consider(slot);
  if (!best.known) { // all may be on the next layer
    constexpr int MAX_COUNT = 32;
    index.nearest(regionInIndex(position, normal), MAX_COUNT, scratch);
    index.visitNearest(scratch, [&](const PhotonBlock& block) {
      for (uint32_t slots = block.mask; slots != 0; slots &= slots - 1)
        consider(block.first + static_cast<size_t>(std::countr_zero(slots)));
    });
  }
  if (best.known) {
    // Chooses a random neighbour by a hash, which hides borders between records.
    uint64_t hash = 0;
    Vec3f offset;
    for (int i = 0; i < 3; ++i) {
      hash = hashCombine(hash, std::bit_cast<uint32_t>(position[i]));
      offset[i] = 2 * unitFloat(static_cast<uint32_t>(hash >> 32)) - 1;
    }
    offset = (offset - normal * glm::dot(offset, normal)) * records[best.index].spacing;
    const auto distance2 = [&](size_t i) { return lengthSquared(position + offset - records[i].position); };
    const size_t slot = *std::ranges::min_element(neighbours[best.index], {}, distance2);
    if (distance2(slot) < distance2(best.index) && isSameSurface(records[slot])) best = resultOf(slot, true);
  }
  // Far from the record, the distance to the k-th photon is unknown: the radius is at least `away`.
  best.radius = std::min(limit, std::max(best.radius, best.away));
  return best;
}

} // namespace recurse
