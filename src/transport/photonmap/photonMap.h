/** @file
 * The photon map: a balanced kd-tree whose nodes have eight children, so that a query tests eight boxes or
 * eight photons at once. All leaves but the last are full; the children of node i are 8i+1…8i+8. Build takes
 * O(n log n), a query that finds m photons O(log n + m). Lengths are in scene units; a slot is a photon's
 * place in the map. Who calls its templates includes photonMapQuery.h.
 */
#pragma once

#include <bit>
#include <cstdint>
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
  FLANN   ///< FLANN's KDTreeSingleIndex: slow, and there to compare with
};
constexpr const char* photonIndexName(PhotonIndexKind kind) {
  return kind == PhotonIndexKind::KDTREE ? "kdtree" : "flann";
}
/** The index of that name; nothing for an unknown one. */
constexpr std::optional<PhotonIndexKind> parsePhotonIndex(std::string_view name) {
  if (name == "kdtree") return PhotonIndexKind::KDTREE;
  if (name == "flann") return PhotonIndexKind::FLANN;
  return std::nullopt;
}

/** What a query found: blocks in increasing order of slots. */
struct FoundPhotons {
  LargeArray<Float8> distance2; ///< infinite in lanes that were not found
  LargeArray<uint32_t> block;   ///< first slot / 8
  size_t blocks = 0;            ///< how many of the two
  size_t count = 0;             ///< photons
  void clear() { blocks = count = 0; }
  void add(uint32_t blockIndex, Float8 d2, uint32_t mask) {
    if (blocks == distance2.size()) grow();
    block[blocks] = blockIndex;
    distance2[blocks++] = d2;
    count += static_cast<size_t>(std::popcount(mask));
  }
  void grow();
};

/**
 * Working memory for queries and what the last one found; one for each thread. Where the next query begins
 * is guessed from the last one: a coherent order makes queries faster, and never changes what they find.
 */
class PhotonScratch {
 public:
  PhotonScratch() = default;

 private:
  friend class PhotonMap;
  FoundPhotons found;
  std::vector<uint64_t> ties;
  Vec3f lastCenter{0};
  float lastRadius = -1; ///< negative: nothing to go by
  int lastCount = 0;
  size_t lastSlot = 0; ///< that nearestSlot() found
  float lastNearest = 0;
};

/** The outcome of a k-nearest query. */
struct NearestPhotons {
  int count = 0;     ///< found: k, or fewer if the region has fewer
  float radius2 = 0; ///< D² of the farthest one found; 0 if none was
};

class PhotonMap {
 public:
  PhotonMap();
  ~PhotonMap();
  PhotonMap(PhotonMap&&) noexcept;
  PhotonMap& operator=(PhotonMap&&) noexcept;

  /**
   * Replaces the contents by these photons, in the order of emission. Photons whose position or power is not
   * finite are refused and counted. The result depends on the photons only, not on the number of threads.
   * Buffers are reused. Throws Error for 2^32 - 64 photons or more.
   */
  void build(std::span<const Photon> photons, PhotonIndexKind kind = PhotonIndexKind::KDTREE);

  PhotonIndexKind kind() const { return indexKind; }
  /** Photons in the map; their slots are 0 … size() − 1. */
  size_t size() const { return photonCount; }
  bool empty() const { return photonCount == 0; }
  /** Photons that were given to build() but are not in the map. */
  size_t refused() const { return refusedCount; }
  /** All memory that the map holds on to, buffers for the next build included. */
  size_t memoryBytes() const;
  /** Tight. */
  const Bounds3f& bounds() const { return box; }

  /**
   * Calls visitor(const PhotonBlock&) for all photons in the region, in increasing order of slots. May be
   * called from any thread. A query without flattening and with bothSides pays for neither.
   */
  template <class Visitor> void visitWithin(const GatherRegion& region, Visitor&& visitor) const;
  /**
   * The same for sums: calls add(state, const PhotonBlock&), which changes the state, and returns the last
   * state. Faster than a visitor with sums outside, which the compiler must keep in memory: the state is a
   * copy that nobody else knows, so it lives in registers. For speed again, neighbouring blocks in which
   * nothing was found may come as well, with an empty mask: `add` should need no branch for them.
   */
  template <class State, class Add>
  State accumulateWithin(const GatherRegion& region, State state, Add&& add) const;

  /**
   * Finds the k photons of the region that are nearest to its centre; of equally distant ones, those emitted
   * first. They stay in the scratch for visitNearest().
   */
  NearestPhotons nearest(const GatherRegion& region, int k, PhotonScratch& scratch) const;
  /** The slot of the photon nearest to the centre, whatever side it arrived from; among equally distant ones
   * the lowest. The map must not be empty. Much faster than nearest() for one photon. */
  size_t nearestSlot(const Vec3f& center, PhotonScratch& scratch) const;
  /** Calls visitor(const PhotonBlock&) for what the last nearest() found, in increasing order of slots. */
  template <class Visitor> void visitNearest(const PhotonScratch& scratch, Visitor&& visitor) const;
  /** Its counterpart for sums; see accumulateWithin(). */
  template <class State, class Add>
  State accumulateNearest(const PhotonScratch& scratch, State state, Add&& add) const;

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
  float reverseRatio(size_t slot) const { return hasReverseRatios ? reverseRatios[slot] : 0; }
  /** Where the photon stood in what was given to build(). */
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

  /** The region, as the tests of eight photons at a time want it. */
  template <bool FLAT, bool SIDED, bool CLIPPED> struct Query;
  template <class F> decltype(auto) withQuery(const GatherRegion& region, F&& f) const;
  struct Hits;
  template <bool EMPTY_TOO, class Q, class Flush> void walk(const Q& query, Flush&& flush) const;
  template <bool EMPTY_TOO, class State, class Add>
  State accumulate(const GatherRegion& region, State state, Add&& add) const;
  template <class Visitor> void visit(const FoundPhotons& found, Visitor&& visitor) const;
  /** The first node of a level, as if all levels above were full: 1 + 8 + 64 + …. */
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

  size_t leafBeside(const Query<false, false, false>& query) const;
  float densityBound(const Vec3f& center, int k) const;
  static RankBracket bracketNearest(const FoundPhotons& found, size_t wanted, float upper);
  uint64_t nearestKey(float d2, size_t slot) const;
  uint64_t lastNearestKey(size_t wanted, const RankBracket& bracket, PhotonScratch& scratch) const;
  void keepNearest(int k, PhotonScratch& scratch, float upper, NearestPhotons& result) const;
  void buildFlann();
  void dropFlann();
  size_t flannBytes() const;
  void findWithinFlann(const GatherRegion& region, FoundPhotons& found) const;
  void findNearestFlann(const GatherRegion& region, int k, FoundPhotons& found) const;

  PhotonIndexKind indexKind = PhotonIndexKind::KDTREE;
  size_t photonCount = 0, refusedCount = 0;
  size_t leafCount = 0;
  int levelCount = 0; ///< levels of nodes; the children of the last are leaves
  Bounds3f box;
  LargeArray<Node> nodes;
  LargeArray<Leaf> leaves;
  LargeArray<PhotonPayload> payload;
  LargeArray<uint8_t> pathStates;
  LargeArray<float> reverseRatios; ///< in use where not all are 0
  bool hasReverseRatios = false;
  LargeArray<uint32_t> emission;
  std::unique_ptr<Flann> flann;
};

} // namespace recurse
