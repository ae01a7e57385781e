/** @file
 * Building the photon map, and its k-nearest query.
 */
#include "recurse/transport/photonMapQuery.h"

#include <algorithm>
#include <atomic>
#include <cstring>

#include <tbb/parallel_invoke.h>

#include "recurse/core/error.h"
#include "recurse/core/parallel.h"

namespace recurse {

void FoundPhotons::grow() {
  const size_t wanted = std::max<size_t>(64, 2 * blocks);
  distance2.reserve(wanted, true);
  block.reserve(distance2.size(), true);
}

// ---------------------------------------------------------------------------------------------- building

namespace {

/** A range of keys is split by two tasks as long as it has at least so many. */
constexpr size_t PARALLEL_KEYS = 8192;
constexpr size_t CHUNK = 16384;

/**
 * What the tree is built from: x, y, z and the bits of the photon's index. They are moved as one register.
 * They lie where the payload will be, of which every photon takes as many bytes.
 */
struct Keys {
  float* data;

  static constexpr size_t FLOATS = 4;
  __m128 load(size_t i) const { return _mm_load_ps(data + FLOATS * i); }
  void store(size_t i, __m128 key) const { _mm_store_ps(data + FLOATS * i, key); }
  float coordinate(size_t i, int axis) const { return data[FLOATS * i + static_cast<size_t>(axis)]; }

  Bounds3f bounds(size_t first, size_t last) const {
    __m128 lower = _mm_set1_ps(INFINITE), upper = _mm_set1_ps(-INFINITE);
    __m128 lower2 = lower, upper2 = upper;
    size_t i = first;
    for (; i + 1 < last; i += 2) {
      const __m128 a = load(i), b = load(i + 1);
      lower = _mm_min_ps(lower, a);
      upper = _mm_max_ps(upper, a);
      lower2 = _mm_min_ps(lower2, b);
      upper2 = _mm_max_ps(upper2, b);
    }
    if (i < last) {
      lower = _mm_min_ps(lower, load(i));
      upper = _mm_max_ps(upper, load(i));
    }
    alignas(16) float l[4], u[4];
    _mm_store_ps(l, _mm_min_ps(lower, lower2));
    _mm_store_ps(u, _mm_max_ps(upper, upper2));
    Bounds3f box;
    box.lower = Vec3f(l[0], l[1], l[2]);
    box.upper = Vec3f(u[0], u[1], u[2]);
    return box;
  }

  /** Moves the keys that come before the pivot to the front; returns their end. Takes no branches. */
  template <bool OR_EQUAL> size_t partition(size_t first, size_t last, int axis, float pivot) const {
    size_t end = first;
    for (size_t i = first; i < last; ++i) {
      const __m128 key = load(i);
      const float x = coordinate(i, axis);
      store(i, load(end));
      store(end, key);
      end += (OR_EQUAL ? x <= pivot : x < pivot) ? 1 : 0;
    }
    return end;
  }

  /**
   * Reorders [first, last) so that no key before `middle` lies beyond one from `middle` on. Quickselect
   * whose pivots come from the order statistics of a sample, just outside of where the wanted rank should
   * be (Floyd & Rivest 1975): so nearly all keys are moved one and a half times. Equal keys cost nothing
   * more.
   */
  void select(size_t first, size_t middle, size_t last, int axis) const {
    constexpr size_t SMALL = 24, MAX_COUNT = 512;
    float sample[MAX_COUNT];
    bool high = true;
    while (first < middle && middle < last) {
      const size_t n = last - first;
      if (n <= SMALL) {
        insertionSort(first, last, axis);
        return;
      }
      // About n^(2/3), so that the sample's own order statistics cost little.
      const size_t wanted = n >= 32768 ? MAX_COUNT : n >= 4096 ? 191 : n >= 1024 ? 95 : n >= 256 ? 35 : 15;
      const size_t step = n / wanted;
      for (size_t i = 0; i < wanted; ++i) sample[i] = coordinate(first + i * step + step / 2, axis);
      const double rank = static_cast<double>(middle - first) / static_cast<double>(n);
      const double place = rank * static_cast<double>(wanted);
      const double spread =
          n < 256 ? 0 : 1.3 * std::sqrt(static_cast<double>(wanted) * rank * (1 - rank)) + 1;
      const double at = std::clamp(place + (high ? spread : -spread), 0.0, static_cast<double>(wanted - 1));
      high = !high;
      float* const nth = sample + static_cast<size_t>(at);
      std::nth_element(sample, nth, sample + wanted);
      const float pivot = *nth;
      const size_t end = partition<false>(first, last, axis, pivot);
      if (middle <= end) {
        last = end;
        continue;
      }
      // The pivot and its equals may be all that there is: then this is the step that gets on.
      first = end;
      if (end - first == 0 || 8 * (last - end) > n) {
        const size_t equalEnd = partition<true>(end, last, axis, pivot);
        if (middle <= equalEnd) return;
        first = equalEnd;
      }
    }
  }

 private:
  void insertionSort(size_t first, size_t last, int axis) const {
    for (size_t i = first + 1; i < last; ++i) {
      const __m128 key = load(i);
      const float x = coordinate(i, axis);
      size_t j = i;
      for (; j > first && coordinate(j - 1, axis) > x; --j) store(j, load(j - 1));
      store(j, key);
    }
  }
};

bool isFinite(const Photon& p) { return recurse::isFinite(p.position) && recurse::isFinite(p.power); }

} // namespace

struct PhotonMap::Builder {
  PhotonMap& map;
  std::span<const Photon> photons;
  Keys keys;
  size_t count = 0;

  /** Copies the positions of the finite photons into the keys; returns how many. */
  size_t takePositions() {
    const size_t chunks = (photons.size() + CHUNK - 1) / CHUNK;
    std::atomic<bool> allFinite{true};
    parallelFor(chunks, [&](size_t chunk) {
      const size_t end = std::min(photons.size(), (chunk + 1) * CHUNK);
      bool good = true;
      for (size_t i = chunk * CHUNK; i < end; ++i) {
        const Vec3f& p = photons[i].position;
        keys.store(i, _mm_setr_ps(p.x, p.y, p.z, std::bit_cast<float>(static_cast<uint32_t>(i))));
        good &= isFinite(photons[i]);
      }
      if (!good) allFinite.store(false, std::memory_order_relaxed);
    });
    if (allFinite) return photons.size();
    size_t end = 0;
    for (size_t i = 0; i < photons.size(); ++i)
      if (isFinite(photons[i])) keys.store(end++, keys.load(i));
    return end;
  }

  size_t keyAt(size_t leaf) const { return std::min(count, leaf * LEAF_SIZE); }

  /** Distributes keys over the children [first, last) of a node; `box` is tight around them. */
  void divide(int level, size_t node, size_t first, size_t last, const Bounds3f& box) const {
    const size_t leavesPerChild = size_t(1) << 3 * (map.levelCount - 1 - level);
    const size_t begin = node * 8 * leavesPerChild;
    if (last - first == 1) {
      Node& n = map.nodes[levelBegin(level) + node];
      for (int axis = 0; axis < 3; ++axis) {
        n.lower[axis][first] = box.lower[axis];
        n.upper[axis][first] = box.upper[axis];
      }
      if (level + 1 < map.levelCount) descend(level + 1, node * 8 + first, box);
      return;
    }
    const size_t middle = first + (last - first + 1) / 2;
    const size_t keyFirst = keyAt(begin + first * leavesPerChild);
    const size_t keyMiddle = keyAt(begin + middle * leavesPerChild);
    const size_t keyLast = keyAt(begin + last * leavesPerChild);
    keys.select(keyFirst, keyMiddle, keyLast, widestAxis(box.diagonal()));
    const auto left = [&] { divide(level, node, first, middle, keys.bounds(keyFirst, keyMiddle)); };
    const auto right = [&] { divide(level, node, middle, last, keys.bounds(keyMiddle, keyLast)); };
    if (keyLast - keyFirst >= PARALLEL_KEYS) {
      tbb::parallel_invoke(left, right);
    } else {
      left();
      right();
    }
  }

  void descend(int level, size_t node, const Bounds3f& box) const {
    const size_t leavesPerChild = size_t(1) << 3 * (map.levelCount - 1 - level);
    const size_t begin = node * 8 * leavesPerChild;
    const size_t children =
        std::min<size_t>(8, (map.leafCount - begin + leavesPerChild - 1) / leavesPerChild);
    Node& n = map.nodes[levelBegin(level) + node];
    for (size_t i = children; i < 8; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        n.lower[axis][i] = INFINITE;
        n.upper[axis][i] = -INFINITE;
      }
    }
    divide(level, node, 0, children, box);
    if (level + 1 == map.levelCount)
      for (size_t i = 0; i < children; ++i) writeLeaf(begin + i);
  }

  /** Replaces the keys of a leaf, which are in their final order, by the payload. */
  void writeLeaf(size_t leaf) const {
    const size_t first = keyAt(leaf), n = keyAt(leaf + 1) - first;
    alignas(32) __m128 key[LEAF_SIZE];
    uint32_t index[LEAF_SIZE];
    for (size_t i = 0; i < n; ++i) {
      key[i] = keys.load(first + i);
      index[i] = static_cast<uint32_t>(_mm_extract_epi32(_mm_castps_si128(key[i]), 3));
      _mm_prefetch(reinterpret_cast<const char*>(&photons[index[i]].position), _MM_HINT_T0);
      _mm_prefetch(reinterpret_cast<const char*>(&photons[index[i]].pathState), _MM_HINT_T0);
    }
    Leaf& l = map.leaves[leaf];
    for (size_t i = 0; i < LEAF_SIZE; ++i) {
      alignas(16) float p[4] = {INFINITE, INFINITE, INFINITE, 0};
      if (i < n) _mm_store_ps(p, key[i]);
      l.x[i] = p[0];
      l.y[i] = p[1];
      l.z[i] = p[2];
    }
    for (size_t i = 0; i < LEAF_SIZE; ++i) {
      const size_t slot = leaf * LEAF_SIZE + i;
      const Photon photon = i < n ? photons[index[i]] : Photon();
      PhotonPayload& p = map.payload[slot / 8];
      p.red[slot % 8] = photon.power.r;
      p.green[slot % 8] = photon.power.g;
      p.blue[slot % 8] = photon.power.b;
      p.direction[slot % 8] = photon.direction.bits;
      l.normal[i] = photon.normal.bits;
      map.pathStates[slot] = photon.pathState;
      if (map.hasReverseRatios) map.reverseRatios[slot] = photon.reverseRatio;
      map.emission[slot] = i < n ? index[i] : 0;
    }
  }
};

void PhotonMap::build(std::span<const Photon> photons, PhotonIndexKind kind) {
  static_assert(sizeof(PhotonPayload) == 8 * Keys::FLOATS * sizeof(float));
  if (photons.size() >= (size_t(1) << 32) - 2 * LEAF_SIZE) throw Error("too many photons for one photon map");
  indexKind = kind;
  const size_t mostLeaves = (photons.size() + LEAF_SIZE - 1) / LEAF_SIZE;
  payload.reserve(mostLeaves * LEAF_BLOCKS);
  Builder builder{*this, photons, {reinterpret_cast<float*>(payload.data())}};
  photonCount = builder.count = builder.takePositions();
  refusedCount = photons.size() - photonCount;
  leafCount = (photonCount + LEAF_SIZE - 1) / LEAF_SIZE;
  leaves.reserve(leafCount);
  pathStates.reserve(leafCount * LEAF_SIZE);
  hasReverseRatios =
      std::any_of(photons.begin(), photons.end(), [](const Photon& p) { return p.reverseRatio != 0; });
  if (hasReverseRatios) reverseRatios.reserve(leafCount * LEAF_SIZE);
  emission.reserve(leafCount * LEAF_SIZE);
  box = builder.keys.bounds(0, photonCount);

  if (kind == PhotonIndexKind::FLANN) {
    levelCount = 0;
    const size_t chunks = (leafCount * LEAF_SIZE + CHUNK - 1) / CHUNK, chunkLeaves = CHUNK / LEAF_SIZE;
    parallelFor(chunks, [&](size_t chunk) {
      const size_t end = std::min(leafCount, (chunk + 1) * chunkLeaves);
      for (size_t leaf = chunk * chunkLeaves; leaf < end; ++leaf) builder.writeLeaf(leaf);
    });
    buildFlann();
    return;
  }
  dropFlann();
  if (photonCount == 0) return;
  levelCount = 1;
  while (size_t(1) << 3 * levelCount < leafCount) ++levelCount;
  nodes.reserve(lastLevelBegin() + (leafCount + 7) / 8);
  builder.descend(0, 0, box);
}

size_t PhotonMap::memoryBytes() const {
  return nodes.bytes() + leaves.bytes() + payload.bytes() + pathStates.bytes() + reverseRatios.bytes() +
         emission.bytes() + flannBytes();
}

// --------------------------------------------------------------------------------------------- k nearest

/**
 * A guess at the D² of the k-th nearest photon, on the high side: as if the photons of the smallest node
 * around the centre that has enough of them were spread evenly over the two widest extents of its box.
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
    const size_t leavesPerChild = size_t(1) << 3 * (levelCount - 1 - level);
    const size_t first = (node * 8 + child) * leavesPerChild;
    const size_t photons = std::min(photonCount, (first + leavesPerChild) * LEAF_SIZE) - first * LEAF_SIZE;
    if (level > 0 && photons * 2 < static_cast<size_t>(k)) break;
    float size[3];
    for (int axis = 0; axis < 3; ++axis) size[axis] = n.upper[axis][child] - n.lower[axis][child];
    std::sort(size, size + 3);
    const float share = MARGIN * static_cast<float>(k) / static_cast<float>(photons);
    const float flat2 = share * size[2] * size[1] * INV_PI; // spread over an area
    const float line2 = square(0.5f * share * size[2]);     // or along a line
    bound = square(std::sqrt(std::max(flat2, line2)) + std::sqrt(d2[child]));
    node = node * 8 + child;
  }
  return bound;
}

/**
 * Keeps the k nearest of at least k candidates, all of them nearer than `upper`. The k-th distance is closed
 * in on by counting how many lie below a guess: interpolated first, because the number of photons on a
 * surface grows with D², then halving the floats that are left. The last few are put into order, by D² and
 * emission.
 */
void PhotonMap::keepNearest(int k, PhotonScratch& scratch, float upper, NearestPhotons& result) const {
  FoundPhotons& found = scratch.found;
  const auto wanted = static_cast<size_t>(k);
  const auto countUpTo = [&](float bound) {
    const Float8 b(bound);
    __m256i n = _mm256_setzero_si256();
    for (size_t i = 0; i < found.blocks; ++i)
      n = _mm256_sub_epi32(n, _mm256_castps_si256(lessEqual(found.distance2[i], b).v));
    alignas(32) uint32_t lanes[8];
    _mm256_store_si256(reinterpret_cast<__m256i*>(lanes), n);
    size_t sum = 0;
    for (const uint32_t lane : lanes) sum += lane;
    return sum;
  };
  // Invariant: countLow = #(D² <= low) < wanted <= #(D² <= high) = countHigh.
  float low = -1, high = std::min(upper, std::numeric_limits<float>::max());
  size_t countLow = 0, countHigh = found.count;
  constexpr size_t FEW = 8;
  constexpr int INTERPOLATIONS = 6;
  for (int step = 0; countHigh - countLow > FEW; ++step) {
    float guess;
    if (step < INTERPOLATIONS) {
      const float from = std::max(low, 0.0f);
      const float share =
          (static_cast<float>(wanted - countLow) - 0.5f) / static_cast<float>(countHigh - countLow);
      guess = from + (high - from) * share;
      if (!(guess > low && guess < high)) continue;
    } else {
      // Floats that are not negative are ordered as their bits.
      const uint32_t lowBits = low < 0 ? 0 : std::bit_cast<uint32_t>(low) + 1;
      const uint32_t highBits = std::bit_cast<uint32_t>(high);
      if (lowBits >= highBits) break; // all equal
      guess = std::bit_cast<float>(lowBits + (highBits - lowBits) / 2);
    }
    const size_t n = countUpTo(guess);
    if (n >= wanted) {
      high = guess;
      countHigh = n;
    } else {
      low = guess;
      countLow = n;
    }
  }

  const auto key = [&](float d2, size_t slot) {
    return uint64_t(std::bit_cast<uint32_t>(d2)) << 32 | emission[slot];
  };
  scratch.ties.clear();
  const Float8 above(low), upTo(high);
  for (size_t i = 0; i < found.blocks; ++i) {
    const Float8 d2 = found.distance2[i];
    uint32_t between = bits(less(above, d2) & lessEqual(d2, upTo));
    if (between == 0) continue;
    alignas(32) float x[8];
    d2.store(x);
    for (; between != 0; between &= between - 1) {
      const auto lane = static_cast<size_t>(std::countr_zero(between));
      scratch.ties.push_back(key(x[lane], size_t(found.block[i]) * 8 + lane));
    }
  }
  const auto kth = scratch.ties.begin() + static_cast<ptrdiff_t>(wanted - countLow - 1);
  std::nth_element(scratch.ties.begin(), kth, scratch.ties.end());
  const uint64_t lastKey = *kth;
  const float last = std::bit_cast<float>(static_cast<uint32_t>(lastKey >> 32));

  size_t kept = 0;
  for (size_t i = 0; i < found.blocks; ++i) {
    const Float8 d2 = found.distance2[i];
    const uint32_t block = found.block[i];
    uint32_t mask = bits(less(d2, Float8(last)));
    for (uint32_t equals = bits(equal(d2, Float8(last))); equals != 0; equals &= equals - 1) {
      const auto lane = static_cast<size_t>(std::countr_zero(equals));
      if (key(last, size_t(block) * 8 + lane) <= lastKey) mask |= 1u << lane;
    }
    if (mask == 0) continue;
    found.block[kept] = block;
    found.distance2[kept++] = select(Float8::lanes(mask), d2, Float8(INFINITE));
  }
  found.blocks = kept;
  found.count = wanted;
  result = {k, last};
}

NearestPhotons PhotonMap::nearest(const GatherRegion& region, int k, PhotonScratch& scratch) const {
  FoundPhotons& found = scratch.found;
  found.clear();
  NearestPhotons result;
  if (k <= 0 || photonCount == 0) return result;
  if (indexKind == PhotonIndexKind::FLANN) {
    findNearestFlann(region, k, found);
    result.count = static_cast<int>(found.count);
    for (size_t i = 0; i < found.blocks; ++i)
      for (int lane = 0; lane < 8; ++lane)
        if (found.distance2[i][lane] < INFINITE)
          result.radius2 = std::max(result.radius2, found.distance2[i][lane]);
    return result;
  }
  const auto wanted = static_cast<size_t>(k);
  const size_t most = std::max<size_t>(4 * wanted, 256);
  withQuery(region, [&](auto query) {
    const float limit = query.radius2;
    float start = INFINITE;
    float step = INFINITE;
    if (scratch.lastRadius > 0 && scratch.lastCount == k) {
      // As far as the last query's photons count here, too, k of them are within this distance.
      step = glm::distance(region.center, scratch.lastCenter);
      start = square((scratch.lastRadius + step) * (1 + roundingBound(16)));
    }
    if (!(step < 0.25f * scratch.lastRadius)) start = std::min(start, densityBound(region.center, k));
    for (;;) {
      if (!(start > 0 && start < limit)) start = limit;
      query.setRadius2(start);
      found.clear();
      walk<false>(query, [&](const Hits& hits) {
        for (size_t i = 0; i < hits.count; ++i) {
          const Float8 d2 = hits.distance2[i];
          const uint32_t mask = hits.mask[i] & bits(less(d2, Float8(query.radius2)));
          if (mask != 0) found.add(hits.block[i], select(Float8::lanes(mask), d2, Float8(INFINITE)), mask);
        }
        if (found.count < most) return;
        keepNearest(k, scratch, query.radius2, result);
        // Equally distant ones may still come first. Denormals would count as zero.
        const float next = std::nextafter(result.radius2, INFINITE);
        query.setRadius2(std::min(query.radius2, std::max(next, std::numeric_limits<float>::min())));
      });
      if (found.count >= wanted || start == limit) break;
      const float share = static_cast<float>(wanted) / static_cast<float>(std::max<size_t>(1, found.count));
      start *= std::clamp(1.5f * share, 2.0f, 16.0f);
    }
    if (found.count > wanted) keepNearest(k, scratch, query.radius2, result);
  });
  if (found.count <= wanted) {
    Float8 farthest(0);
    for (size_t i = 0; i < found.blocks; ++i) {
      const Float8 d2 = found.distance2[i];
      farthest = max(farthest, d2 & less(d2, Float8(INFINITE)));
    }
    for (int lane = 0; lane < 8; ++lane) result.radius2 = std::max(result.radius2, farthest[lane]);
    result.count = static_cast<int>(found.count);
  }
  scratch.lastCenter = region.center;
  scratch.lastCount = k;
  scratch.lastRadius = found.count < wanted ? -1 : std::sqrt(result.radius2);
  return result;
}

/** A leaf close to the centre: of each node the nearest child. */
size_t PhotonMap::leafBeside(const Query<false, false, false>& query) const {
  size_t node = 0;
  for (int level = 0; level < levelCount; ++level) {
    const Float8 d2 = query.boxDistance2(nodes[levelBegin(level) + node]);
    node = 8 * node + static_cast<size_t>(std::countr_zero(bits(equal(d2, Float8(least(d2))))));
  }
  return node;
}

size_t PhotonMap::nearestSlot(const Vec3f& center, PhotonScratch& scratch) const {
  GatherRegion region;
  region.center = center;
  region.bothSides = true;
  size_t slot = 0;
  if (indexKind == PhotonIndexKind::FLANN) {
    nearest(region, 1, scratch);
    visitNearest(scratch, [&](const PhotonBlock& block) {
      slot = block.first + static_cast<size_t>(std::countr_zero(block.mask));
    });
    return slot;
  }
  Query<false, false, false> query(region);
  float nearest = INFINITE;
  // Any photon bounds the distance: the one that the last query found, or those of a leaf close by.
  constexpr float NEAR = 2;
  if (scratch.lastSlot < photonCount) nearest = query.distance2(position(scratch.lastSlot));
  if (!(nearest < square(NEAR * scratch.lastNearest))) {
    const Leaf& leaf = leaves[leafBeside(query)];
    Float8 all(nearest);
    for (size_t i = 0; i < LEAF_SIZE; i += 8)
      all = min(all, query.distance2(leaf.x + i, leaf.y + i, leaf.z + i));
    nearest = least(all);
  }
  // Equally distant ones may come first. Denormals would count as zero.
  query.setRadius2(std::max(std::nextafter(nearest, INFINITE), std::numeric_limits<float>::min()));
  nearest = INFINITE;
  walk<true>(query, [&](const Hits& hits) {
    for (size_t i = 0; i < hits.count; ++i) {
      const Float8 d2 = hits.distance2[i];
      const float here = least(d2);
      if (!(here < nearest)) continue;
      nearest = here;
      slot = size_t(hits.block[i]) * 8 + static_cast<size_t>(std::countr_zero(bits(equal(d2, Float8(here)))));
    }
  });
  scratch.lastSlot = slot;
  scratch.lastNearest = std::sqrt(nearest);
  return slot;
}

} // namespace recurse
