/** @file
 * The photon map: every photon of a pass in an index that answers fixed-radius and k-nearest queries, eight
 * photons at a time.
 *
 * It knows neither surfaces nor scenes. Lengths are in scene units; a slot is a photon's place in the map.
 *
 * The index is a balanced kd-tree whose nodes have eight children. Every split takes the median on the widest
 * axis of the tight bounds, and hands a multiple of the largest power of eight below the number of leaves to
 * the left. So all leaves but the last are full, the children of node i are nodes 8i+1…8i+8, and there are no
 * pointers. A query tests eight boxes or eight photons with a few AVX2 instructions.
 *
 * Complexities, for n photons of which a query finds m: build O(n log n), query O(log n + m).
 */
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <immintrin.h>

#include "recurse/core/vector.h"
#include "recurse/transport/photon.h"

#ifndef __AVX2__
#error "Recurse needs AVX2: build for x86-64-v3 or later"
#endif

namespace recurse {

/** Eight floats in a register. Comparisons give a bit mask, bit i for lane i. */
struct Float8 {
  __m256 v;

  Float8() = default;
  Float8(__m256 v) : v(v) {}
  Float8(float x) : v(_mm256_set1_ps(x)) {}
  /** From 8 floats on a 32-byte boundary. */
  static Float8 load(const float* p) { return _mm256_load_ps(p); }
  void store(float* p) const { _mm256_store_ps(p, v); }
  /** All bits set in the lanes of the mask. */
  static Float8 lanes(uint32_t mask) {
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    const __m256i on = _mm256_and_si256(_mm256_set1_epi32(static_cast<int>(mask)), bit);
    return _mm256_castsi256_ps(_mm256_cmpeq_epi32(on, bit));
  }
  float operator[](int lane) const {
    alignas(32) float x[8];
    store(x);
    return x[lane];
  }

  friend Float8 operator+(Float8 a, Float8 b) { return _mm256_add_ps(a.v, b.v); }
  friend Float8 operator-(Float8 a, Float8 b) { return _mm256_sub_ps(a.v, b.v); }
  friend Float8 operator*(Float8 a, Float8 b) { return _mm256_mul_ps(a.v, b.v); }
  friend Float8 operator/(Float8 a, Float8 b) { return _mm256_div_ps(a.v, b.v); }
  friend Float8 operator&(Float8 a, Float8 b) { return _mm256_and_ps(a.v, b.v); }
  Float8& operator+=(Float8 b) { return *this = *this + b; }
  friend Float8 min(Float8 a, Float8 b) { return _mm256_min_ps(a.v, b.v); }
  friend Float8 max(Float8 a, Float8 b) { return _mm256_max_ps(a.v, b.v); }
  friend Float8 sqrt(Float8 a) { return _mm256_sqrt_ps(a.v); }
  friend Float8 abs(Float8 a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.v); }
  friend Float8 copysign(Float8 a, Float8 b) {
    const __m256 sign = _mm256_set1_ps(-0.0f);
    return _mm256_or_ps(_mm256_andnot_ps(sign, a.v), _mm256_and_ps(sign, b.v));
  }
  /** a where the bits of `lanes` are set, otherwise b. */
  friend Float8 select(Float8 lanes, Float8 a, Float8 b) { return _mm256_blendv_ps(b.v, a.v, lanes.v); }
  friend Float8 less(Float8 a, Float8 b) { return _mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ); }
  friend Float8 lessEqual(Float8 a, Float8 b) { return _mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ); }
  friend Float8 equal(Float8 a, Float8 b) { return _mm256_cmp_ps(a.v, b.v, _CMP_EQ_OQ); }
  /** The sign bits as a mask. */
  friend uint32_t bits(Float8 a) { return static_cast<uint32_t>(_mm256_movemask_ps(a.v)); }
  friend float least(Float8 a) {
    const __m128 four = _mm_min_ps(_mm256_castps256_ps128(a.v), _mm256_extractf128_ps(a.v, 1));
    const __m128 two = _mm_min_ps(four, _mm_movehl_ps(four, four));
    return _mm_cvtss_f32(_mm_min_ss(two, _mm_movehdup_ps(two)));
  }
  /** The sum of the lanes, in a fixed order. */
  friend float sum(Float8 a) {
    const __m128 four = _mm_add_ps(_mm256_castps256_ps128(a.v), _mm256_extractf128_ps(a.v, 1));
    const __m128 two = _mm_add_ps(four, _mm_movehl_ps(four, four));
    return _mm_cvtss_f32(_mm_add_ss(two, _mm_movehdup_ps(two)));
  }
};

/** Eight vectors. */
struct Vec3f8 {
  Float8 x, y, z;
};

/** Eight directions, not normalised: points of the octahedron. The arithmetic is that of unpackDirection. */
inline Vec3f8 unpackOctahedron(const uint32_t* packed) {
  const __m256i p = _mm256_load_si256(reinterpret_cast<const __m256i*>(packed));
  const __m256i low = _mm256_and_si256(p, _mm256_set1_epi32(0xffff));
  const Float8 u = Float8(_mm256_cvtepi32_ps(low)) * Float8(1 / 32767.0f) - Float8(1);
  const Float8 v = Float8(_mm256_cvtepi32_ps(_mm256_srli_epi32(p, 16))) * Float8(1 / 32767.0f) - Float8(1);
  const Float8 z = Float8(1) - abs(u) - abs(v);
  const Float8 fold = max(Float8(0) - z, Float8(0));
  return {u - copysign(fold, u), v - copysign(fold, v), z};
}

/** Eight unit directions from eight packed ones on a 32-byte boundary; the same floats as unpackDirection. */
inline Vec3f8 unpackDirections(const uint32_t* packed) {
  const Vec3f8 d = unpackOctahedron(packed);
  const Float8 scale = Float8(1) / sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
  return {d.x * scale, d.y * scale, d.z * scale};
}

/** For each mask of eight lanes the lanes in it, packed; what comes after them is of no account. */
struct PhotonLaneLists {
  alignas(64) uint8_t lanes[256][8] = {};
  alignas(64) uint8_t lanesDown[256][8] = {};

  constexpr PhotonLaneLists() {
    for (int mask = 0; mask < 256; ++mask) {
      int up = 0, down = 0;
      for (int i = 0; i < 8; ++i) {
        if (mask >> i & 1) lanes[mask][up++] = static_cast<uint8_t>(i);
        if (mask >> (7 - i) & 1) lanesDown[mask][down++] = static_cast<uint8_t>(7 - i);
      }
    }
  }
  /** Writes base + lane for every lane in the mask, and something up to the eighth place. */
  void ascending(uint32_t mask, uint32_t base, uint32_t* out) const { write(lanes[mask], base, out); }
  void descending(uint32_t mask, uint32_t base, uint32_t* out) const { write(lanesDown[mask], base, out); }

 private:
  static void write(const uint8_t* list, uint32_t base, uint32_t* out) {
    const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(list));
    const __m256i sum =
        _mm256_add_epi32(_mm256_cvtepu8_epi32(bytes), _mm256_set1_epi32(static_cast<int>(base)));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), sum);
  }
};
inline constexpr PhotonLaneLists PHOTON_LANE_LISTS;

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

/**
 * Where photons are searched: a spheroid around a surface point, flattened along the normal.
 *
 * With v = photon − center, h = v·normal and w = max(0, 1/flatness² − 1), the distance of a photon is
 * D² = |v|² + w h², and a photon lies in the region where D² < radius². On the tangent plane D is the plain
 * distance; along the normal the region ends at flatness · radius. The flattening is part of the metric,
 * rather than a slab beside it, so that the k nearest photons are exactly those that a fixed-radius query
 * finds at the distance of the k-th: both kinds of query mean the same set, whatever the upper bound.
 *
 * Where !bothSides, a photon counts only if its surface faces the same way to within 60°, so that neither the
 * other side of a thin wall nor a wall round the corner lends its light. Half-spaces clip the region: a
 * photon counts where v·normal > limit for all of them. Photons that do not count are left out before
 * anything is counted.
 */
struct GatherRegion {
  struct HalfSpace {
    Vec3f normal{0};
    float limit = 0; ///< negative where the centre is inside
    bool has(const Vec3f& v) const { return glm::dot(v, normal) > limit; }
  };
  static constexpr size_t MAX_CLIPS = 6;

  Vec3f center{0};
  Vec3f normal{0, 0, 1};   ///< unit, geometric, on the side that photons must arrive from
  float radius = INFINITE; ///< on the tangent plane [scene units]; may be infinite for k-nearest
  float flatness = 1;      ///< half axis along the normal ÷ radius, at least 1e-6; from 1 on: a sphere
  bool bothSides = false;  ///< photons may arrive from either side (transmitting surfaces)
  size_t clipCount = 0;
  std::array<HalfSpace, MAX_CLIPS> clips{}; ///< the first clipCount of them

  /** Whether no half-space takes the point center + v away. */
  bool unclipped(const Vec3f& v) const {
    return std::all_of(clips.begin(), clips.begin() + clipCount,
                       [&](const HalfSpace& clip) { return clip.has(v); });
  }
  /** D² of center + v. */
  float distance2(const Vec3f& v) const {
    const float h = glm::dot(v, normal);
    return lengthSquared(v) + std::max(0.0f, 1 / square(flatness) - 1) * square(h);
  }
};

/** The payload of eight slots: what an estimate needs of a photon beyond its place. */
struct PhotonPayload {
  alignas(32) float red[8];
  alignas(32) float green[8];
  alignas(32) float blue[8];
  alignas(32) uint32_t direction[8]; ///< packed; towards where the photon came from
};

/** Eight neighbouring slots, some of which a query found. */
struct PhotonBlock {
  uint32_t first;               ///< slot of lane 0; a multiple of 8
  uint32_t mask;                ///< bit i: lane i was found; not 0 unless said otherwise
  Float8 distance2;             ///< D² of GatherRegion; only lanes in the mask have a meaning
  const PhotonPayload* payload; ///< all eight lanes may be read
  const uint8_t* pathStates;    ///< eight of them
  const float* reverseRatios;   ///< eight of them, see Photon; null where all are 0

  Float8 red() const { return Float8::load(payload->red); }
  Float8 green() const { return Float8::load(payload->green); }
  Float8 blue() const { return Float8::load(payload->blue); }
  Rgb power(int lane) const { return {payload->red[lane], payload->green[lane], payload->blue[lane]}; }
  /** Unit directions towards where the photons came from. */
  Vec3f8 directions() const { return unpackDirections(payload->direction); }
  Vec3f direction(int lane) const { return unpackDirection({payload->direction[lane]}); }
  /** x in the lanes that were found, 0 elsewhere. */
  Float8 found(Float8 x) const { return x & Float8::lanes(mask); }
};

/** Room for n objects that are not constructed, kept for reuse; large ones lie on huge pages. */
template <class T> class PhotonArray {
 public:
  PhotonArray() = default;
  PhotonArray(PhotonArray&& o) noexcept : room(std::move(o.room)), capacity(std::exchange(o.capacity, 0)) {}
  PhotonArray& operator=(PhotonArray&& o) noexcept {
    room = std::move(o.room);
    capacity = std::exchange(o.capacity, 0);
    return *this;
  }
  T* data() const { return room.get(); }
  T& operator[](size_t i) const { return room.get()[i]; }
  size_t bytes() const { return capacity * sizeof(T); }
  size_t size() const { return capacity; }
  /** Makes room for n objects. What was there is kept only if `keep`. */
  void reserve(size_t n, bool keep = false);

 private:
  struct Release {
    void operator()(void* p) const { std::free(p); }
  };
  std::unique_ptr<T, Release> room;
  size_t capacity = 0;
};
/** Memory on a 64-byte boundary, on huge pages where it is large. Rounds `bytes` up. */
void* allocatePhotonMemory(size_t& bytes);

template <class T> void PhotonArray<T>::reserve(size_t n, bool keep) {
  static_assert(std::is_trivially_copyable_v<T>);
  if (n <= capacity) return;
  // The second request is likely to be followed by a third, a little larger.
  size_t bytes = (capacity == 0 ? n : n + n / 16) * sizeof(T);
  std::unique_ptr<T, Release> old = std::move(room);
  if (!keep) old.reset();
  room.reset(static_cast<T*>(allocatePhotonMemory(bytes)));
  if (keep) std::copy_n(old.get(), capacity, room.get());
  capacity = bytes / sizeof(T);
}

/** What a query found: blocks in increasing order of slots. */
struct FoundPhotons {
  PhotonArray<Float8> distance2; ///< infinite in lanes that were not found
  PhotonArray<uint32_t> block;   ///< first slot / 8
  size_t blocks = 0;             ///< how many of the two
  size_t count = 0;              ///< photons
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
            hasReverseRatios ? reverseRatios.data() + first : nullptr};
  }

  size_t leafBeside(const Query<false, false, false>& query) const;
  float densityBound(const Vec3f& center, int k) const;
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
  PhotonArray<Node> nodes;
  PhotonArray<Leaf> leaves;
  PhotonArray<PhotonPayload> payload;
  PhotonArray<uint8_t> pathStates;
  PhotonArray<float> reverseRatios; ///< in use where not all are 0
  bool hasReverseRatios = false;
  PhotonArray<uint32_t> emission;
  std::unique_ptr<Flann> flann;
};

/**
 * Rounding is monotonic, and boxes and photons are compared by the same operations in the same order: a box
 * is never left out that has a photon in the region. So nothing here has a tolerance.
 */
template <bool FLAT, bool SIDED, bool CLIPPED> struct PhotonMap::Query {
  static constexpr bool SELECTIVE = SIDED || CLIPPED; ///< not every photon that is near enough counts
  Float8 cx, cy, cz;
  float nx, ny, nz;
  float flattening; ///< w of GatherRegion
  float radius2;    ///< may shrink during a walk
  float reach;      ///< at least the radius: whatever is not less has a square that is not less than radius2
  const GatherRegion& region;

  explicit Query(const GatherRegion& r)
      : cx(r.center.x), cy(r.center.y), cz(r.center.z), nx(r.normal.x), ny(r.normal.y), nz(r.normal.z),
        flattening(FLAT && r.flatness < 1 ? 1 / (r.flatness * r.flatness) - 1 : 0), region(r) {
    setRadius2(r.radius * r.radius);
  }
  void setRadius2(float r2) {
    radius2 = r2;
    reach = std::sqrt(r2) * (1 + roundingBound(8));
  }

  /** D² of single precision, operation by operation as for eight. */
  float distance2(const Vec3f& p) const {
    const float x = p.x - _mm256_cvtss_f32(cx.v), y = p.y - _mm256_cvtss_f32(cy.v),
                z = p.z - _mm256_cvtss_f32(cz.v);
    const float d2 = x * x + y * y + z * z;
    if constexpr (!FLAT) return d2;
    const float h = x * nx + y * ny + z * nz;
    return d2 + flattening * (h * h);
  }
  Float8 distance2(const float* px, const float* py, const float* pz) const {
    const Float8 x = Float8::load(px) - cx, y = Float8::load(py) - cy, z = Float8::load(pz) - cz;
    const Float8 d2 = x * x + y * y + z * z;
    if constexpr (!FLAT) return d2;
    const Float8 h = x * Float8(nx) + y * Float8(ny) + z * Float8(nz);
    return d2 + Float8(flattening) * (h * h);
  }
  /** Lanes whose photons lie on a surface that faces the same way and are not clipped away. */
  uint32_t selected(const float* px, const float* py, const float* pz, const uint32_t* normals) const {
    uint32_t mask = 0xff;
    if constexpr (SIDED) {
      const Vec3f8 n = unpackOctahedron(normals); // not of unit length
      const Float8 cosine = n.x * Float8(nx) + n.y * Float8(ny) + n.z * Float8(nz);
      const Float8 length2 = n.x * n.x + n.y * n.y + n.z * n.z;
      constexpr float MIN_COSINE = 0.5f;
      mask = bits(less(Float8(0), cosine)) &
             bits(less(length2 * Float8(MIN_COSINE * MIN_COSINE), cosine * cosine));
    }
    if constexpr (CLIPPED) {
      const Float8 x = Float8::load(px) - cx, y = Float8::load(py) - cy, z = Float8::load(pz) - cz;
      for (size_t i = 0; i < region.clipCount; ++i) {
        const auto& [n, limit] = region.clips[i];
        mask &= bits(less(Float8(limit), x * Float8(n.x) + y * Float8(n.y) + z * Float8(n.z)));
      }
    }
    return mask;
  }
  bool selected(const Vec3f& position, PackedDirection normal) const {
    alignas(32) const float x[8] = {position.x}, y[8] = {position.y}, z[8] = {position.z};
    alignas(32) const uint32_t packed[8] = {normal.bits};
    return (selected(x, y, z, packed) & 1) != 0;
  }
  Float8 boxDistance2(const Node& node) const {
    const auto axis = [&](int i, Float8 c) {
      return max(max(Float8::load(node.lower[i]) - c, c - Float8::load(node.upper[i])), Float8(0));
    };
    const Float8 x = axis(0, cx), y = axis(1, cy), z = axis(2, cz);
    return x * x + y * y + z * z;
  }
  uint32_t reaches(const Node& node) const { return bits(less(boxDistance2(node), Float8(radius2))); }
  /** The same for the cube around the region: sooner known, though not as sharp. */
  uint32_t mayReach(const Node& node) const {
    const auto axis = [&](int i, Float8 c) {
      return max(Float8::load(node.lower[i]) - c, c - Float8::load(node.upper[i]));
    };
    return bits(less(max(max(axis(0, cx), axis(1, cy)), axis(2, cz)), Float8(reach)));
  }
};

template <class F> decltype(auto) PhotonMap::withQuery(const GatherRegion& region, F&& f) const {
  const bool flat = region.flatness < 1;
  if (region.clipCount > 0) // seldom, and then the flattening costs little
    return region.bothSides ? f(Query<true, false, true>(region)) : f(Query<true, true, true>(region));
  if (region.bothSides)
    return flat ? f(Query<true, false, false>(region)) : f(Query<false, false, false>(region));
  return flat ? f(Query<true, true, false>(region)) : f(Query<false, true, false>(region));
}

/** Blocks that a walk has found and not yet handed on. Their number is bounded, so they lie on the stack. */
struct PhotonMap::Hits {
  static constexpr size_t MAX_COUNT = 128;
  Float8 distance2[MAX_COUNT];
  uint32_t block[MAX_COUNT], mask[MAX_COUNT];
  size_t count = 0;
};

/**
 * Calls flush(hits) with blocks in increasing order of slots, as often as needed. The flush may shrink
 * query.radius2; hits that were found before then lie within the old one.
 *
 * Nodes, leaves and blocks are each put on a list for the next step, by code that always writes and then
 * advances by what counts: a mispredicted branch costs as much as the tests of two leaves. To wait for what
 * counts costs something as well: with EMPTY_TOO blocks may come that have an empty mask.
 */
template <bool EMPTY_TOO, class Q, class Flush> void PhotonMap::walk(const Q& query, Flush&& flush) const {
  if (photonCount == 0) return;
  constexpr size_t MAX_LEAVES = 32;
  uint32_t nodeStack[7 * MAX_LEVELS + 2 * 8]; // eight may be written beyond the last
  uint32_t leafList[MAX_LEAVES + 2 * 8];
  size_t nodesLeft = 0, leavesFound = 0;
  Hits hits;
  constexpr bool TAKE_ALL = EMPTY_TOO && !Q::SELECTIVE;
  const auto finish = [&] {
    if constexpr (Q::SELECTIVE) {
      size_t kept = 0;
      for (size_t i = 0; i < hits.count; ++i) {
        const Leaf& leaf = leaves[hits.block[i] / LEAF_BLOCKS];
        const size_t at = hits.block[i] % LEAF_BLOCKS * 8;
        const uint32_t mask =
            hits.mask[i] & query.selected(leaf.x + at, leaf.y + at, leaf.z + at, leaf.normal + at);
        hits.block[kept] = hits.block[i];
        hits.distance2[kept] = hits.distance2[i];
        hits.mask[kept] = mask;
        kept += mask != 0;
      }
      hits.count = kept;
    }
    flush(hits);
    hits.count = 0;
  };
  const auto testLeaves = [&] {
    for (size_t l = 0; l < leavesFound; ++l) {
      if (hits.count > Hits::MAX_COUNT - LEAF_BLOCKS) finish();
      const Leaf& leaf = leaves[leafList[l]];
      const Float8 radius2(query.radius2);
      for (uint32_t i = 0; i < LEAF_BLOCKS; ++i) {
        const Float8 d2 = query.distance2(leaf.x + 8 * i, leaf.y + 8 * i, leaf.z + 8 * i);
        const uint32_t mask = bits(less(d2, radius2));
        hits.block[hits.count] = leafList[l] * LEAF_BLOCKS + i;
        hits.distance2[hits.count] = d2;
        hits.mask[hits.count] = mask;
        hits.count += TAKE_ALL || mask != 0;
      }
    }
    leavesFound = 0;
  };

  const auto lastLevel = static_cast<uint32_t>(lastLevelBegin());
  uint32_t node = 0;
  for (;;) {
    if (node < lastLevel) {
      const uint32_t mask = query.mayReach(nodes[node]);
      if (mask != 0) {
        // The first child comes last on the stack, and is not put there: the chain of nodes on the way down
        // is what a query waits for.
        PHOTON_LANE_LISTS.descending(mask, 8 * node + 1, nodeStack + nodesLeft);
        nodesLeft += static_cast<size_t>(std::popcount(mask)) - 1;
        node = 8 * node + 1 + static_cast<uint32_t>(std::countr_zero(mask));
        continue;
      }
    } else {
      const uint32_t mask = query.reaches(nodes[node]);
      PHOTON_LANE_LISTS.ascending(mask, 8 * (node - lastLevel), leafList + leavesFound);
      leavesFound += static_cast<size_t>(std::popcount(mask));
      if (leavesFound > MAX_LEAVES) testLeaves();
    }
    if (nodesLeft == 0) break;
    node = nodeStack[--nodesLeft];
  }
  testLeaves();
  finish();
}

template <class Visitor> void PhotonMap::visit(const FoundPhotons& found, Visitor&& visitor) const {
  for (size_t i = 0; i < found.blocks; ++i) {
    const Float8 d2 = found.distance2[i];
    visitor(makeBlock(found.block[i], bits(less(d2, Float8(INFINITE))), d2));
  }
}

template <bool EMPTY_TOO, class State, class Add>
State PhotonMap::accumulate(const GatherRegion& region, State state, Add&& add) const {
  if (indexKind == PhotonIndexKind::FLANN) {
    FoundPhotons found;
    findWithinFlann(region, found);
    visit(found, [&](const PhotonBlock& block) { add(state, block); });
    return state;
  }
  // One place that calls `add`, whatever the kind of query: so it is worth inlining.
  const auto flush = [&](const Hits& hits) {
    State local = state;
    for (size_t i = 0; i < hits.count; ++i)
      add(local, makeBlock(hits.block[i], hits.mask[i], hits.distance2[i]));
    state = local;
  };
  withQuery(region, [&](const auto& query) { walk<EMPTY_TOO>(query, flush); });
  return state;
}

template <class State, class Add>
State PhotonMap::accumulateWithin(const GatherRegion& region, State state, Add&& add) const {
  return accumulate<true>(region, state, add);
}

template <class Visitor> void PhotonMap::visitWithin(const GatherRegion& region, Visitor&& visitor) const {
  struct Nothing {};
  accumulate<false>(region, Nothing(), [&](Nothing&, const PhotonBlock& block) { visitor(block); });
}

template <class Visitor> void PhotonMap::visitNearest(const PhotonScratch& scratch, Visitor&& visitor) const {
  visit(scratch.found, visitor);
}

template <class State, class Add>
State PhotonMap::accumulateNearest(const PhotonScratch& scratch, State state, Add&& add) const {
  visit(scratch.found, [&](const PhotonBlock& block) { add(state, block); });
  return state;
}

} // namespace recurse
