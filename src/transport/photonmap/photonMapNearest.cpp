/** @file
 * Queries for the k nearest photons and for the single nearest photon.
 */
#include "transport/photonmap/photonMapQuery.h"

#include <algorithm>

namespace recurse {

/**
 * Estimate of the D² of the k-th nearest photon, on the high side. Assumes that the photons of the smallest
 * node around the centre with enough photons are spread evenly over the two widest extents of its box.
 */
float PhotonMap::densityBound(const Vec3f& center, int k) const {
  constexpr float MARGIN = 1.3f;
  GatherRegion region;
  region.center = center;
  const Query<false, false, false> query(region);
  size_t node = 0;
  float bound = INFINITE;
  for (int level = 0; level < levelCount; ++level) {
    const Node& n = nodes[levelBegin(level) + node];
    alignas(32) float d2[8];
    query.boxDistance2(n).store(d2);
    const size_t child = static_cast<size_t>(std::min_element(d2, d2 + 8) - d2);
    const size_t leafCountThere = leavesPerChild(level), first = (node * 8 + child) * leafCountThere;
    const size_t photons = std::min(photonCount, (first + leafCountThere) * LEAF_SIZE) - first * LEAF_SIZE;
    if (level > 0 && photons * 2 < static_cast<size_t>(k)) break;
    float size[3];
    for (int axis = 0; axis < 3; ++axis) size[axis] = n.upper[axis][child] - n.lower[axis][child];
    std::sort(size, size + 3);
    const float share = MARGIN * static_cast<float>(k) / static_cast<float>(photons);
    const float flat2 = share * size[2] * size[1] * INV_PI; // photons spread over an area
    const float line2 = square(0.5f * share * size[2]);     // photons spread along a line
    bound = square(std::sqrt(std::max(flat2, line2)) + std::sqrt(d2[child]));
    node = node * 8 + child;
  }
  return bound;
}

/** Bounds of the D² of the wanted-th nearest photon, as an invariant of the search:
 * countLow = #(D² <= low) < wanted <= #(D² <= high) = countHigh. */
struct PhotonMap::RankBracket {
  float low = -1, high = 0;
  size_t countLow = 0, countHigh = 0;
};

namespace {

/** Number of photons found with D² <= bound. */
size_t countUpTo(const FoundPhotons& found, float bound) {
  const Float8 b(bound);
  Uint32x8 counts(0);
  for (size_t i = 0; i < found.blocks; ++i) counts.countIn(lessEqual(found.distance2[i], b));
  uint32_t lanes[8];
  counts.store(lanes);
  size_t sum = 0;
  for (const uint32_t lane : lanes) sum += lane;
  return sum;
}

} // namespace

/** Narrows the bracket until it contains few photons, or by a few interpolations, since the number of photons
 * on a surface grows linearly with D². */
PhotonMap::RankBracket PhotonMap::bracketNearest(const FoundPhotons& found, size_t wanted, float upper) {
  constexpr size_t MAX_LEFT = 8;
  constexpr int INTERPOLATIONS = 6;
  RankBracket b;
  b.high = std::min(upper, std::numeric_limits<float>::max());
  b.countHigh = found.count;
  for (int step = 0; step < INTERPOLATIONS && b.countHigh - b.countLow > MAX_LEFT; ++step) {
    const float from = std::max(b.low, 0.0f);
    const float share =
        (static_cast<float>(wanted - b.countLow) - 0.5f) / static_cast<float>(b.countHigh - b.countLow);
    const float guess = from + (b.high - from) * share;
    if (!(guess > b.low && guess < b.high)) break;
    const size_t n = countUpTo(found, guess);
    (n >= wanted ? b.high : b.low) = guess;
    (n >= wanted ? b.countHigh : b.countLow) = n;
  }
  return b;
}

/** Sort key of a photon: by D², ties by the order of emission. */
uint64_t PhotonMap::nearestKey(float d2, size_t slot) const {
  return uint64_t(std::bit_cast<uint32_t>(d2)) << 32 | emission[slot];
}

/** Sort key of the wanted-th nearest of the photons found. */
uint64_t PhotonMap::lastNearestKey(size_t wanted, const RankBracket& bracket, PhotonScratch& scratch) const {
  const FoundPhotons& found = scratch.found;
  scratch.ties.clear();
  const Float8 above(bracket.low), upTo(bracket.high);
  for (size_t i = 0; i < found.blocks; ++i) {
    const Float8 d2 = found.distance2[i];
    uint32_t between = bits(less(above, d2) & lessEqual(d2, upTo));
    if (between == 0) continue;
    alignas(32) float x[8];
    d2.store(x);
    for (; between != 0; between &= between - 1) {
      const auto lane = static_cast<size_t>(std::countr_zero(between));
      scratch.ties.push_back(nearestKey(x[lane], size_t(found.block[i]) * 8 + lane));
    }
  }
  const auto last = scratch.ties.begin() + static_cast<ptrdiff_t>(wanted - bracket.countLow - 1);
  std::nth_element(scratch.ties.begin(), last, scratch.ties.end());
  return *last;
}

/** Keeps the k nearest of at least k candidates, all with D² below `upper`. */
void PhotonMap::keepNearest(int k, PhotonScratch& scratch, float upper, NearestPhotons& result) const {
  FoundPhotons& found = scratch.found;
  const auto wanted = static_cast<size_t>(k);
  const uint64_t lastKey = lastNearestKey(wanted, bracketNearest(found, wanted, upper), scratch);
  const float last = std::bit_cast<float>(static_cast<uint32_t>(lastKey >> 32));
  size_t kept = 0;
  for (size_t i = 0; i < found.blocks; ++i) {
    const Float8 d2 = found.distance2[i];
    const uint32_t block = found.block[i];
    uint32_t mask = bits(less(d2, Float8(last)));
    for (uint32_t equals = bits(equal(d2, Float8(last))); equals != 0; equals &= equals - 1) {
      const auto lane = static_cast<size_t>(std::countr_zero(equals));
      if (nearestKey(last, size_t(block) * 8 + lane) <= lastKey) mask |= 1u << lane;
    }
    if (mask == 0) continue;
    found.block[kept] = block;
    found.distance2[kept++] = select(Float8::lanes(mask), d2, Float8(INFINITE));
  }
  found.blocks = kept;
  found.count = wanted;
  result = {k, last};
}

namespace {

/** Largest D² of the photons found; 0 if none were. */
float farthest2(const FoundPhotons& found) {
  Float8 farthest(0);
  for (size_t i = 0; i < found.blocks; ++i) {
    const Float8 d2 = found.distance2[i];
    farthest = max(farthest, d2 & less(d2, Float8(INFINITE)));
  }
  float result = 0;
  for (int lane = 0; lane < 8; ++lane) result = std::max(result, farthest[lane]);
  return result;
}

} // namespace

NearestPhotons PhotonMap::nearest(const GatherRegion& region, int k, PhotonScratch& scratch) const {
  FoundPhotons& found = scratch.found;
  found.clear();
  NearestPhotons result;
  if (k <= 0 || photonCount == 0) return result;
  const auto wanted = static_cast<size_t>(k);
  if (indexKind == PhotonIndexKind::FLANN) {
    findFlann(region, wanted, found);
    return {static_cast<int>(found.count), farthest2(found)};
  }
  const size_t most = std::max<size_t>(4 * wanted, 256);
  withQuery(region, [&](auto query) {
    const float limit = query.radius2;
    float start = INFINITE;
    float step = INFINITE;
    if (scratch.lastRadius > 0 && scratch.lastCount == k) {
      // Bound by the triangle inequality, if the region accepts the last query's photons, too.
      step = glm::distance(region.center, scratch.lastCenter);
      start = square((scratch.lastRadius + step) * (1 + roundingBound(16)));
    }
    if (!(step < 0.25f * scratch.lastRadius)) start = std::min(start, densityBound(region.center, k));
    for (;;) {
      if (!(start > 0 && start < limit)) start = limit;
      query.setRadius2(start);
      found.clear();
      walk(query, [&](const Hits& hits) {
        for (size_t i = 0; i < hits.count; ++i) {
          const Float8 d2 = hits.distance2[i];
          const uint32_t mask = hits.mask[i] & bits(less(d2, Float8(query.radius2)));
          if (mask != 0) found.add(hits.block[i], select(Float8::lanes(mask), d2, Float8(INFINITE)), mask);
        }
        if (found.count < most) return;
        keepNearest(k, scratch, query.radius2, result);
        // Photons at the same distance may have a smaller key. Denormals would compare as zero.
        const float next = std::nextafter(result.radius2, INFINITE);
        query.setRadius2(std::min(query.radius2, std::max(next, std::numeric_limits<float>::min())));
      });
      if (found.count >= wanted || start == limit) break;
      const float share = static_cast<float>(wanted) / static_cast<float>(std::max<size_t>(1, found.count));
      start *= std::clamp(1.5f * share, 2.0f, 16.0f);
    }
    if (found.count > wanted) keepNearest(k, scratch, query.radius2, result);
  });
  if (found.count <= wanted) result = {static_cast<int>(found.count), farthest2(found)};
  scratch.lastCenter = region.center;
  scratch.lastCount = k;
  scratch.lastRadius = found.count < wanted ? -1 : std::sqrt(result.radius2);
  return result;
}

/** Leaf close to the centre, reached by descending to the nearest child of each node. */
size_t PhotonMap::leafBeside(const Query<false, false, false>& query) const {
  size_t node = 0;
  for (int level = 0; level < levelCount; ++level) {
    const Float8 d2 = query.boxDistance2(nodes[levelBegin(level) + node]);
    node = 8 * node + static_cast<size_t>(std::countr_zero(bits(equal(d2, Float8(least(d2))))));
  }
  return node;
}

size_t PhotonMap::nearestSlot(const Vec3f& center) const {
  GatherRegion region;
  region.center = center;
  region.bothSides = true;
  size_t slot = 0;
  if (indexKind == PhotonIndexKind::FLANN) {
    thread_local PhotonScratch scratch;
    nearest(region, 1, scratch);
    visitNearest(scratch, [&](const PhotonBlock& block) {
      slot = block.first + static_cast<size_t>(std::countr_zero(block.mask));
    });
    return slot;
  }
  Query<false, false, false> query(region);
  const Leaf& leaf = leaves[leafBeside(query)]; // any of its photons bounds the distance
  Float8 all(INFINITE);
  for (size_t i = 0; i < LEAF_SIZE; i += 8)
    all = min(all, query.distance2(leaf.x + i, leaf.y + i, leaf.z + i));
  float nearest = least(all);
  // Photons at the same distance may have a lower slot. Denormals would compare as zero.
  query.setRadius2(std::max(std::nextafter(nearest, INFINITE), std::numeric_limits<float>::min()));
  nearest = INFINITE;
  walk(query, [&](const Hits& hits) {
    for (size_t i = 0; i < hits.count; ++i) {
      const Float8 d2 = hits.distance2[i];
      const float here = least(d2);
      if (!(here < nearest)) continue;
      nearest = here;
      slot = size_t(hits.block[i]) * 8 + static_cast<size_t>(std::countr_zero(bits(equal(d2, Float8(here)))));
    }
  });
  return slot;
}

} // namespace recurse
