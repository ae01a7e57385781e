/** @file
 * The photon map: a balanced kd-tree whose nodes have eight children, so that a query tests eight boxes or
 * eight photons at once. All leaves but the last are full; the children of node i are 8i+1…8i+8. Build takes
 * O(n log n), a query that finds m photons O(log n + m). Lengths are in scene units; a slot is the index of a
 * photon in the map. The templates are defined in photonMapQuery.h, which their callers include.
 */
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "recurse/core/threads/largeArray.h"
#include "transport/photonmap/gatherRegion.h"
#include "transport/photonmap/photonBlock.h"

namespace recurse {

enum class PhotonIndexKind {
  KDTREE, ///< the eight-wide tree described above
  FLANN   ///< FLANN's KDTreeSingleIndex: slow, for comparison
};
/** Result of a query: blocks in increasing order of slots. */
struct FoundPhotons {
  LargeArray<Float8> distance2; ///< infinite in lanes that were not found
  LargeArray<uint32_t> block;   ///< first slot / 8
  size_t blocks = 0;            ///< length of both arrays in use
  size_t count = 0;             ///< number of photons found
  void clear() { blocks = count = 0; }
  void add(uint32_t blockIndex, Float8 d2, uint32_t mask) {
    if (blocks == std::min(distance2.capacity(), block.capacity())) grow();
    block[blocks] = blockIndex;
    distance2[blocks++] = d2;
    count += static_cast<size_t>(std::popcount(mask));
  }
  void grow();
};

/**
 * Working memory of queries and the result of the last one; one for each thread. The last query is the
 * initial guess of the next: a coherent order makes queries faster, but never changes their results.
 */
class PhotonScratch {
 private:
  friend class PhotonMap;
  FoundPhotons found;
  std::vector<uint64_t> ties;
  Vec3f lastCenter{0};
  float lastRadius = -1; ///< negative: no usable previous query
  int lastCount = 0;
};

/** Number and extent of the photons that a k-nearest query found. */
struct NearestPhotons {
  int count = 0;     ///< photons found: k, or fewer if the region has fewer
  float radius2 = 0; ///< D² of the farthest photon found; 0 if none was
};

class PhotonMap {
 public:
  /**
   * Replaces the contents by these photons, given in the order of emission. Photons with a non-finite
   * position or power are refused and counted. The result does not depend on the number of threads. Buffers
   * are reused. Throws Error for 2^32 - 64 photons or more.
   */
  void build(std::span<const Photon> photons, PhotonIndexKind kind = PhotonIndexKind::KDTREE);
  /** Keeps the optical lengths of the photons' paths [scene units], given in the order of emission like the
   * photons of the last build(); for transient renders. */
  void setLengths(std::span<const float> byEmission);

  /** Photons in the map; their slots are 0 … size() − 1. */
  size_t size() const { return photonCount; }
  bool empty() const { return photonCount == 0; }
  /** Number of photons that the last build() refused. */
  size_t refused() const { return refusedCount; }
  /** Memory of the map [bytes], including the buffers that are kept for the next build. */
  size_t memoryBytes() const;
  /** Tight bounding box of the photons [scene units]. */
  const Bounds3f& bounds() const { return box; }

  /**
   * Calls visitor(const PhotonBlock&) for all photons in the region, in increasing order of slots. Safe to
   * call from any thread. A query without flattening and with bothSides has no cost for either.
   */
  template <class Visitor> void visitWithin(const GatherRegion& region, Visitor&& visitor) const;
  /**
   * Accumulates over all photons in the region: calls add(state, const PhotonBlock&), which changes the
   * state, and returns the last state. Faster than a visitor that captures its sums, since the state is a
   * local copy that the compiler can keep in registers.
   */
  template <class State, class Add>
  State accumulateWithin(const GatherRegion& region, State state, Add&& add) const;

  /**
   * Finds the k photons of the region nearest to its centre. Ties are resolved in favour of photons emitted
   * first. The result is kept in the scratch memory for visitNearest().
   */
  NearestPhotons nearest(const GatherRegion& region, int k, PhotonScratch& scratch) const;
  /** Slot of the photon nearest to the centre, on either side of its surface; the lowest slot among ties. The
   * map must not be empty. Much faster than nearest() for one photon. */
  size_t nearestSlot(const Vec3f& center) const;
  /** Calls visitor(const PhotonBlock&) for the result of the last nearest(), in increasing order of slots. */
  template <class Visitor> void visitNearest(const PhotonScratch& scratch, Visitor&& visitor) const;
  /** Accumulates over the result of the last nearest(); see accumulateWithin(). */
  template <class State, class Add>
  State accumulateNearest(const PhotonScratch& scratch, State state, Add&& add) const;

  using BoxVisitor = std::function<void(int level, const Bounds3f& box, size_t photons)>;
  /** Calls visit(level, box, photons) for the boxes of the tree with less than `levels` splits into two parts
   * above them, each box before its parts, the parts in increasing order of slots. */
  void visitBoxes(int levels, const BoxVisitor& visit) const;

  Vec3f position(size_t slot) const {
    const Leaf& leaf = leaves[slot / LEAF_SIZE];
    const size_t i = slot % LEAF_SIZE;
    return {leaf.x[i], leaf.y[i], leaf.z[i]};
  }
  Rgb power(size_t slot) const {
    const PhotonPayload& p = payload[slot / 8];
    return {p.red[slot % 8], p.green[slot % 8], p.blue[slot % 8]};
  }
  PackedDirection packedDirection(size_t slot) const { return {payload[slot / 8].direction[slot % 8]}; }
  PackedDirection packedNormal(size_t slot) const {
    return {leaves[slot / LEAF_SIZE].normal[slot % LEAF_SIZE]};
  }
  Vec3f direction(size_t slot) const { return unpackDirection(packedDirection(slot)); }
  uint8_t pathState(size_t slot) const { return pathStates[slot]; }
  /** Whether setLengths() has followed the last build(). */
  bool hasLengths() const { return !lengths.empty(); }
  float length(size_t slot) const { return lengths[slot]; }
  /** Index of the photon in the span that build() was given. */
  uint32_t emissionIndex(size_t slot) const { return emission[slot]; }

 private:
  static constexpr size_t LEAF_SIZE = 32;
  static constexpr int LEAF_BLOCKS = LEAF_SIZE / 8;
  static constexpr int MAX_LEVELS = 10;

  struct Node {
    alignas(32) float lower[3][8];
    alignas(32) float upper[3][8];
  };
  struct Leaf {
    alignas(32) float x[LEAF_SIZE], y[LEAF_SIZE], z[LEAF_SIZE];
    alignas(32) uint32_t normal[LEAF_SIZE]; ///< packed
  };
  struct Builder;
  struct Flann;
  struct RankBracket;

  /** The region in the form that tests of eight photons at once use. */
  template <bool FLAT, bool SIDED, bool CLIPPED> struct Query;
  template <class F> decltype(auto) withQuery(const GatherRegion& region, F&& f) const;
  struct Hits;
  template <class Q> void dropRejected(const Q& query, Hits& hits) const;
  template <class Q, class Flush> void walk(const Q& query, Flush&& flush) const;
  template <class Visitor> void visit(const FoundPhotons& found, Visitor&& visitor) const;
  /** Index of the first node of a level, with all levels above it full: 1 + 8 + 64 + … */
  static constexpr size_t levelBegin(int level) { return ((size_t(1) << 3 * level) - 1) / 7; }
  size_t lastLevelBegin() const { return levelBegin(levelCount - 1); }
  PhotonBlock makeBlock(uint32_t block, uint32_t mask, Float8 d2) const {
    const size_t first = size_t(block) * 8;
    return {block * 8,
            mask,
            d2,
            payload.data() + block,
            pathStates.data() + first,
            hasReverseRatios ? reverseRatios.data() + first : nullptr,
            leaves[block / LEAF_BLOCKS].normal + block % LEAF_BLOCKS * 8};
  }

  /** Children [first, last) of a node. */
  struct Part {
    int level = 0;
    size_t node = 0, first = 0, last = 0;
  };
  size_t leavesPerChild(int level) const { return size_t(1) << 3 * (levelCount - 1 - level); }
  size_t childCount(int level, size_t node) const;
  void visitBoxes(Part range, int split, int levels, const BoxVisitor& visit) const;
  size_t leafBeside(const Query<false, false, false>& query) const;
  float densityBound(const Vec3f& center, int k) const;
  static RankBracket bracketNearest(const FoundPhotons& found, size_t wanted, float upper);
  uint64_t nearestKey(float d2, size_t slot) const;
  uint64_t lastNearestKey(size_t wanted, const RankBracket& bracket, PhotonScratch& scratch) const;
  void keepNearest(int k, PhotonScratch& scratch, float upper, NearestPhotons& result) const;
  void buildFlann();
  size_t flannBytes() const;
  /** Finds the `most` photons nearest to the centre of a region; 0: all in the region. */
  void findFlann(const GatherRegion& region, size_t most, FoundPhotons& found) const;

  PhotonIndexKind indexKind = PhotonIndexKind::KDTREE;
  size_t photonCount = 0, refusedCount = 0;
  size_t leafCount = 0;
  int levelCount = 0; ///< levels of inner nodes; the children of the last are leaves
  Bounds3f box;
  LargeArray<Node> nodes;
  LargeArray<Leaf> leaves;
  LargeArray<PhotonPayload> payload;
  LargeArray<uint8_t> pathStates;
  LargeArray<float> reverseRatios; ///< in use unless all are 0
  bool hasReverseRatios = false;
  LargeArray<uint32_t> emission;
  std::vector<float> lengths;   ///< optical lengths of the photons' paths, by slot; empty: not kept
  std::shared_ptr<Flann> flann; ///< null for the other index
};

} // namespace recurse
