/** @file
 * Construction of the photon map.
 */
#include "transport/photonmap/photonMap.h"

#include <algorithm>
#include <atomic>

#include <tbb/parallel_invoke.h>

#include "recurse/core/io/error.h"
#include "recurse/core/threads/parallel.h"

namespace recurse {

void FoundPhotons::grow() {
  const size_t wanted = std::max<size_t>(64, 2 * blocks);
  distance2.reserve(wanted, true);
  block.reserve(wanted, true);
}

// ---------------------------------------------------------------------------------------------- building

namespace {

/** Minimum number of keys for which a range is split by two parallel tasks. */
constexpr size_t PARALLEL_KEYS = 8192;
constexpr size_t CHUNK = 16384;

/**
 * Sort keys of the tree: x, y, z and the bits of the photon's index, moved as one register. Stored in the
 * memory of the payload, which takes the same number of bytes for each photon.
 */
struct Keys {
  float* data;

  static constexpr size_t FLOATS = 4;
  Float4 load(size_t i) const { return Float4::load(data + FLOATS * i); }
  void store(size_t i, Float4 key) const { key.store(data + FLOATS * i); }
  float coordinate(size_t i, int axis) const { return data[FLOATS * i + static_cast<size_t>(axis)]; }
  uint32_t index(size_t i) const { return std::bit_cast<uint32_t>(data[FLOATS * i + 3]); }

  Bounds3f bounds(size_t first, size_t last) const {
    Float4 lower(INFINITE), upper(-INFINITE);
    Float4 lower2 = lower, upper2 = upper;
    size_t i = first;
    for (; i + 1 < last; i += 2) {
      const Float4 a = load(i), b = load(i + 1);
      lower = min(lower, a);
      upper = max(upper, a);
      lower2 = min(lower2, b);
      upper2 = max(upper2, b);
    }
    if (i < last) {
      lower = min(lower, load(i));
      upper = max(upper, load(i));
    }
    alignas(16) float l[4], u[4];
    min(lower, lower2).store(l);
    max(upper, upper2).store(u);
    Bounds3f box;
    box.lower = Vec3f(l[0], l[1], l[2]);
    box.upper = Vec3f(u[0], u[1], u[2]);
    return box;
  }

  /** Moves the keys before the pivot to the front, without branches. Returns their end. */
  template <bool OR_EQUAL> size_t partition(size_t first, size_t last, int axis, float pivot) const {
    size_t end = first;
    for (size_t i = first; i < last; ++i) {
      const Float4 key = load(i);
      const float x = coordinate(i, axis);
      store(i, load(end));
      store(end, key);
      end += (OR_EQUAL ? x <= pivot : x < pivot) ? 1 : 0;
    }
    return end;
  }

  /**
   * Reorders [first, last) so that no key before `middle` is greater than one from `middle` on. Quickselect
   * with pivots from the order statistics of a sample, just outside of the expected position of the required
   * rank (Floyd & Rivest 1975). Most keys are moved only one and a half times. Equal keys have no extra
   * cost.
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
      // About n^(2/3) samples, so that selecting the pivot from them costs little.
      const size_t wanted = n >= 32768 ? MAX_COUNT : n >= 4096 ? 191 : n >= 1024 ? 95 : n >= 256 ? 35 : 15;
      const size_t step = n / wanted;
      for (size_t i = 0; i < wanted; ++i) sample[i] = coordinate(first + i * step + step / 2, axis);
      const double rank = static_cast<double>(middle - first) / static_cast<double>(n);
      const double wantedRank = rank * static_cast<double>(wanted);
      const double spread =
          n < 256 ? 0 : 1.3 * std::sqrt(static_cast<double>(wanted) * rank * (1 - rank)) + 1;
      const double at =
          std::clamp(wantedRank + (high ? spread : -spread), 0.0, static_cast<double>(wanted - 1));
      high = !high;
      float* const nth = sample + static_cast<size_t>(at);
      std::nth_element(sample, nth, sample + wanted);
      const float pivot = *nth;
      const size_t end = partition<false>(first, last, axis, pivot);
      if (middle <= end) {
        last = end;
        continue;
      }
      // If no key is less than the pivot, only moving its equals too makes progress.
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
      const Float4 key = load(i);
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

  /** Copies the positions of the finite photons into the keys. Returns their number. */
  size_t takePositions() const {
    const size_t chunks = (photons.size() + CHUNK - 1) / CHUNK;
    std::atomic<bool> allFinite{true};
    parallelFor(chunks, [&](size_t chunk) {
      const size_t end = std::min(photons.size(), (chunk + 1) * CHUNK);
      bool good = true;
      for (size_t i = chunk * CHUNK; i < end; ++i) {
        const Vec3f& p = photons[i].position;
        keys.store(i, Float4(p.x, p.y, p.z, std::bit_cast<float>(static_cast<uint32_t>(i))));
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

  /** Distributes the keys to the children [first, last) of a node; `box` is their tight bounding box. */
  void divide(int level, size_t node, size_t first, size_t last, const Bounds3f& box) const {
    const size_t leavesPerChild = map.leavesPerChild(level), begin = node * 8 * leavesPerChild;
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
    const size_t children = map.childCount(level, node);
    Node& n = map.nodes[levelBegin(level) + node];
    for (size_t i = children; i < 8; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        n.lower[axis][i] = INFINITE;
        n.upper[axis][i] = -INFINITE;
      }
    }
    divide(level, node, 0, children, box);
    if (level + 1 == map.levelCount)
      for (size_t i = 0; i < children; ++i) writeLeaf(node * 8 + i);
  }

  /** Replaces the keys of a leaf, already in their final order, by the payload. */
  void writeLeaf(size_t leaf) const {
    const size_t first = keyAt(leaf), n = keyAt(leaf + 1) - first;
    Float4 key[LEAF_SIZE];
    uint32_t index[LEAF_SIZE];
    for (size_t i = 0; i < n; ++i) {
      key[i] = keys.load(first + i);
      index[i] = keys.index(first + i);
      __builtin_prefetch(&photons[index[i]].position);
      __builtin_prefetch(&photons[index[i]].pathState);
    }
    Leaf& l = map.leaves[leaf];
    for (size_t i = 0; i < LEAF_SIZE; ++i) {
      alignas(16) float p[4] = {INFINITE, INFINITE, INFINITE, 0};
      if (i < n) key[i].store(p);
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
  if (photons.size() >= (size_t(1) << 32) - 2 * LEAF_SIZE)
    throw Error("too many photons for one photon map: emit fewer (--photons)");
  indexKind = kind;
  lengths.clear();
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
    parallelFor(leafCount, [&](size_t leaf) { builder.writeLeaf(leaf); });
    buildFlann();
    return;
  }
  flann.reset();
  if (photonCount == 0) return;
  levelCount = 1;
  while (size_t(1) << 3 * levelCount < leafCount) ++levelCount;
  nodes.reserve(lastLevelBegin() + (leafCount + 7) / 8);
  builder.descend(0, 0, box);
}

void PhotonMap::setLengths(std::span<const float> byEmission) {
  lengths.resize(photonCount);
  for (size_t slot = 0; slot < photonCount; ++slot) lengths[slot] = byEmission[emission[slot]];
}

size_t PhotonMap::childCount(int level, size_t node) const {
  const size_t leaves = leavesPerChild(level);
  return std::min<size_t>(8, (leafCount - node * 8 * leaves + leaves - 1) / leaves);
}

void PhotonMap::visitBoxes(int levels, const BoxVisitor& visit) const {
  if (photonCount > 0 && levelCount > 0 && levels > 0)
    visitBoxes({0, 0, 0, childCount(0, 0)}, 0, levels, visit);
}

void PhotonMap::visitBoxes(Part range, int split, int levels, const BoxVisitor& visit) const {
  while (range.last - range.first == 1 && range.level + 1 < levelCount) {
    const size_t child = range.node * 8 + range.first;
    range = {range.level + 1, child, 0, childCount(range.level + 1, child)};
  }
  const Node& node = nodes[levelBegin(range.level) + range.node];
  Bounds3f bounds;
  for (size_t i = range.first; i < range.last; ++i) {
    bounds.add(Vec3f(node.lower[0][i], node.lower[1][i], node.lower[2][i]));
    bounds.add(Vec3f(node.upper[0][i], node.upper[1][i], node.upper[2][i]));
  }
  const size_t leaves = leavesPerChild(range.level);
  const auto slotAt = [&](size_t child) {
    return std::min(photonCount, (range.node * 8 + child) * leaves * LEAF_SIZE);
  };
  visit(split, bounds, slotAt(range.last) - slotAt(range.first));
  if (range.last - range.first == 1 || split + 1 == levels) return;
  const size_t middle = range.first + (range.last - range.first + 1) / 2; // as in Builder::divide()
  visitBoxes({range.level, range.node, range.first, middle}, split + 1, levels, visit);
  visitBoxes({range.level, range.node, middle, range.last}, split + 1, levels, visit);
}

size_t PhotonMap::memoryBytes() const {
  return nodes.bytes() + leaves.bytes() + payload.bytes() + pathStates.bytes() + reverseRatios.bytes() +
         emission.bytes() + lengths.capacity() * sizeof(float) + flannBytes();
}

} // namespace recurse
