/** @file
 * Tree traversal of the photon map. Included by callers of the templates of PhotonMap.
 */
#pragma once

#include "transport/photonmap/photonMap.h"

namespace recurse {

/**
 * Query with exact bounds and no tolerances. Rounding is monotonic, and boxes and photons are compared by the
 * same operations in the same order: a box that contains a photon of the region is never culled.
 */
template <bool FLAT, bool SIDED, bool CLIPPED> struct PhotonMap::Query {
  static constexpr bool SELECTIVE = SIDED || CLIPPED; ///< photons within the radius may be rejected
  Float8 cx, cy, cz;
  float nx, ny, nz;
  float flattening; ///< w of the region's metric, see GatherRegion
  float radius2;    ///< D², of GatherRegion; may shrink during a walk
  float reach;      ///< at least the radius: the square of any value not below it is not below radius2
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

  /** Scalar D² of a point, with the same operations in the same order as the eight-wide version. */
  float distance2(const Vec3f& p) const {
    const float x = p.x - first(cx), y = p.y - first(cy), z = p.z - first(cz);
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
  /** Lanes whose photons pass the half-spaces, and whose surface faces the same way as the region. */
  uint32_t selected(const float* px, const float* py, const float* pz, const uint32_t* normals) const {
    uint32_t mask = 0xff;
    if constexpr (SIDED) {
      const Vec3f8 n = unpackOctahedron(normals); // not of unit length
      const Float8 cosine = n.x * Float8(nx) + n.y * Float8(ny) + n.z * Float8(nz);
      const Float8 length2 = n.x * n.x + n.y * n.y + n.z * n.z;
      mask = bits(less(Float8(0), cosine)) &
             bits(less(length2 * Float8(square(GatherRegion::MIN_COSINE)), cosine * cosine));
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
  /** Lower bounds of distance2() over the points of the boxes. */
  Float8 boxDistance2(const Node& node) const {
    const auto axis = [&](int i, Float8 c) {
      return max(max(Float8::load(node.lower[i]) - c, c - Float8::load(node.upper[i])), Float8(0));
    };
    const Float8 x = axis(0, cx), y = axis(1, cy), z = axis(2, cz);
    const Float8 d2 = x * x + y * y + z * z;
    if constexpr (!FLAT) return d2;
    const Float8 h = boxHeight(node);
    return d2 + Float8(flattening) * (h * h);
  }
  /** Distances of the boxes from the tangent plane; 0 where they intersect it. */
  Float8 boxHeight(const Node& node) const {
    const auto corner = [&](bool upper) {
      const auto axis = [&](int i, float n, Float8 c) {
        return (Float8::load((n > 0) == upper ? node.upper[i] : node.lower[i]) - c) * Float8(n);
      };
      return axis(0, nx, cx) + axis(1, ny, cy) + axis(2, nz, cz);
    };
    return max(max(corner(false), Float8(0) - corner(true)), Float8(0));
  }
  uint32_t reaches(const Node& node) const { return bits(less(boxDistance2(node), Float8(radius2))); }
  /** Children whose boxes may overlap the cube around the region: cheaper than reaches(), but less tight. */
  uint32_t mayReach(const Node& node) const {
    const auto axis = [&](int i, Float8 c) {
      return max(Float8::load(node.lower[i]) - c, c - Float8::load(node.upper[i]));
    };
    return bits(less(max(max(axis(0, cx), axis(1, cy)), axis(2, cz)), Float8(reach)));
  }
};

template <class F> decltype(auto) PhotonMap::withQuery(const GatherRegion& region, F&& f) const {
  const bool flat = region.flatness < 1;
  if (region.clipCount > 0) // rare, and then the flattening costs little
    return region.bothSides ? f(Query<true, false, true>(region)) : f(Query<true, true, true>(region));
  if (region.bothSides)
    return flat ? f(Query<true, false, false>(region)) : f(Query<false, false, false>(region));
  return flat ? f(Query<true, true, false>(region)) : f(Query<false, true, false>(region));
}

/** Blocks that a walk has found but not yet flushed. Bounded in number, so that they fit on the stack. */
struct PhotonMap::Hits {
  static constexpr size_t MAX_COUNT = 128;
  Float8 distance2[MAX_COUNT];
  uint32_t block[MAX_COUNT], mask[MAX_COUNT];
  size_t count = 0;
};

/** Removes photons that the normals and half-spaces of the query reject. */
template <class Q> inline void PhotonMap::dropRejected(const Q& query, Hits& hits) const {
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

/**
 * Calls flush(hits) with blocks in increasing order of slots, as often as needed. The flush may shrink
 * query.radius2; hits found before it does are within the old radius.
 *
 * Nodes, leaves and blocks are compacted into work lists by branchless code, which always writes and advances
 * only past accepted entries: a mispredicted branch costs as much as the tests of two leaves.
 */
template <class Q, class Flush> void PhotonMap::walk(const Q& query, Flush&& flush) const {
  if (photonCount == 0) return;
  constexpr size_t MAX_LEAVES = 32;
  uint32_t nodeStack[7 * MAX_LEVELS + 2 * 8]; // up to eight may be written beyond the end
  uint32_t leafList[MAX_LEAVES + 2 * 8];
  size_t nodesLeft = 0, leavesFound = 0;
  Hits hits;
  const auto flushHits = [&] {
    if constexpr (Q::SELECTIVE) dropRejected(query, hits);
    flush(hits);
    hits.count = 0;
  };
  const auto testLeaves = [&] {
    for (size_t l = 0; l < leavesFound; ++l) {
      if (hits.count > Hits::MAX_COUNT - LEAF_BLOCKS) flushHits();
      const Leaf& leaf = leaves[leafList[l]];
      const Float8 radius2(query.radius2);
      for (uint32_t i = 0; i < LEAF_BLOCKS; ++i) {
        const Float8 d2 = query.distance2(leaf.x + 8 * i, leaf.y + 8 * i, leaf.z + 8 * i);
        const uint32_t mask = bits(less(d2, radius2));
        hits.block[hits.count] = leafList[l] * LEAF_BLOCKS + i;
        hits.distance2[hits.count] = d2;
        hits.mask[hits.count] = mask;
        hits.count += mask != 0;
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
        // The first child is visited next without a detour by the stack: latency of the chain of nodes on the
        // way down bounds the speed of a query.
        LANE_LISTS.descending(mask, 8 * node + 1, nodeStack + nodesLeft);
        nodesLeft += static_cast<size_t>(std::popcount(mask)) - 1;
        node = 8 * node + 1 + static_cast<uint32_t>(std::countr_zero(mask));
        continue;
      }
    } else {
      const uint32_t mask = query.reaches(nodes[node]);
      LANE_LISTS.ascending(mask, 8 * (node - lastLevel), leafList + leavesFound);
      leavesFound += static_cast<size_t>(std::popcount(mask));
      if (leavesFound > MAX_LEAVES) testLeaves();
    }
    if (nodesLeft == 0) break;
    node = nodeStack[--nodesLeft];
  }
  testLeaves();
  flushHits();
}

template <class Visitor> void PhotonMap::visit(const FoundPhotons& found, Visitor&& visitor) const {
  for (size_t i = 0; i < found.blocks; ++i) {
    const Float8 d2 = found.distance2[i];
    visitor(makeBlock(found.block[i], bits(less(d2, Float8(INFINITE))), d2));
  }
}

template <class State, class Add>
State PhotonMap::accumulateWithin(const GatherRegion& region, State state, Add&& add) const {
  if (indexKind == PhotonIndexKind::FLANN) {
    FoundPhotons found;
    findFlann(region, 0, found);
    visit(found, [&](const PhotonBlock& block) { add(state, block); });
    return state;
  }
  // Single call site of `add` for all kinds of queries, so that the compiler inlines it.
  const auto flush = [&](const Hits& hits) {
    State local = state;
    for (size_t i = 0; i < hits.count; ++i)
      add(local, makeBlock(hits.block[i], hits.mask[i], hits.distance2[i]));
    state = local;
  };
  withQuery(region, [&](const auto& query) { walk(query, flush); });
  return state;
}

template <class Visitor> void PhotonMap::visitWithin(const GatherRegion& region, Visitor&& visitor) const {
  struct Nothing {};
  accumulateWithin(region, Nothing(), [&](Nothing&, const PhotonBlock& block) { visitor(block); });
}

template <class Visitor> void PhotonMap::visitNearest(const PhotonScratch& scratch, Visitor&& visitor) const {
  visit(scratch.found, visitor);
}

template <class State, class Add>
State PhotonMap::accumulateNearest(const PhotonScratch& scratch, State state, Add&& add) const {
  visit(scratch.found, [&](const PhotonBlock& block) { add(state, block); });
  return state;
}

/** Whether the region contains a photon. */
inline bool anyWithin(const PhotonMap& map, const GatherRegion& region) {
  return map.accumulateWithin(region, 0u, [](uint32_t& any, const PhotonBlock& block) { any |= block.mask; });
}

/** Irradiance by the photons in a region, as if its whole disc were surface, summed over channels [W/m²]. */
inline float irradianceWithin(const PhotonMap& map, const GatherRegion& region) {
  const Float8 power = map.accumulateWithin(region, Float8(0), [](Float8& all, const PhotonBlock& block) {
    all += (block.red() + block.green() + block.blue()) & Float8::lanes(block.mask);
  });
  return sum(power) * INV_PI / square(region.radius);
}

} // namespace recurse
