/** @file
 * FLANN's kd-tree as an alternative index of the photon map. The photons keep their order of emission; only
 * FLANN's own data is added. All acceptance tests use the same arithmetic as the eight-wide tree, so both
 * indices find the same sets of photons.
 */
#include "transport/photonmap/photonMapQuery.h"

#include <algorithm>

#include <flann/algorithms/dist.h>
#include <flann/algorithms/kdtree_single_index.h>

namespace recurse {

namespace {

/**
 * Upper bound [scene units²] with slack for FLANN, which updates the distance to a box incrementally, so that
 * rounding may exceed the exact one. Photons are accepted by their own exact distance.
 */
float slackened(float distance2) { return distance2 * 1.0001f + std::numeric_limits<float>::min(); }

struct FlannHit {
  float distance2;
  uint32_t slot;
  bool operator<(const FlannHit& o) const {
    return distance2 < o.distance2 || (distance2 == o.distance2 && slot < o.slot);
  }
};

/** Groups hits into blocks of eight slots, in increasing order of slots. */
void makeBlocks(std::vector<FlannHit>& hits, FoundPhotons& found) {
  std::sort(hits.begin(), hits.end(), [](const FlannHit& a, const FlannHit& b) { return a.slot < b.slot; });
  found.clear();
  for (size_t i = 0; i < hits.size();) {
    const uint32_t block = hits[i].slot / 8;
    alignas(32) float d2[8];
    std::fill(d2, d2 + 8, INFINITE);
    uint32_t mask = 0;
    for (; i < hits.size() && hits[i].slot / 8 == block; ++i) {
      d2[hits[i].slot % 8] = hits[i].distance2;
      mask |= 1u << hits[i].slot % 8;
    }
    found.add(block, Float8::load(d2), mask);
  }
}

/** Result set that accepts the photons of the region: all of them, or the k nearest by a heap. */
template <class Map, class Query> class RegionResult : public flann::ResultSet<float> {
 public:
  RegionResult(const Map& map, const Query& query, size_t most) : map(map), query(query), most(most) {}
  bool full() const override { return true; }
  void addPoint(float, size_t index) override {
    const float d2 = query.distance2(map.position(index));
    if (!(d2 < query.radius2) || !query.selected(map.position(index), map.packedNormal(index))) return;
    const FlannHit hit{d2, static_cast<uint32_t>(index)};
    if (most == 0) {
      hits.push_back(hit);
      return;
    }
    if (hits.size() == most) {
      if (!(hit < hits.front())) return;
      std::pop_heap(hits.begin(), hits.end());
      hits.back() = hit;
    } else {
      hits.push_back(hit);
    }
    std::push_heap(hits.begin(), hits.end());
  }
  float worstDist() const override {
    return slackened(most != 0 && hits.size() == most ? hits.front().distance2 : query.radius2);
  }
  std::vector<FlannHit> hits;

 private:
  const Map& map;
  const Query& query;
  const size_t most; ///< 0: no limit
};

} // namespace

struct PhotonMap::Flann {
  using Index = flann::KDTreeSingleIndex<flann::L2_3D<float>>;
  std::vector<float> points; ///< referenced by the index
  std::unique_ptr<Index> index;
};

void PhotonMap::buildFlann() {
  flann = std::make_shared<Flann>();
  flann->points.resize(3 * photonCount);
  for (size_t i = 0; i < photonCount; ++i) {
    const Vec3f p = position(i);
    std::copy_n(&p.x, 3, &flann->points[3 * i]);
  }
  if (photonCount == 0) return; // FLANN crashes on an empty set
  const flann::Matrix<float> matrix(flann->points.data(), photonCount, 3);
  flann->index = std::make_unique<Flann::Index>(matrix, flann::KDTreeSingleIndexParams());
  flann->index->buildIndex();
}

size_t PhotonMap::flannBytes() const {
  if (!flann) return 0;
  // Memory of the tree, of our points, and of FLANN's reordered copy with a pointer to each point.
  const size_t tree = flann->index ? static_cast<size_t>(flann->index->usedMemory()) : 0;
  return tree + flann->points.capacity() * sizeof(float) + photonCount * (3 * sizeof(float) + sizeof(float*));
}

void PhotonMap::findFlann(const GatherRegion& region, size_t most, FoundPhotons& found) const {
  found.clear();
  if (photonCount == 0) return;
  withQuery(region, [&](const auto& query) {
    RegionResult result(*this, query, most);
    flann->index->findNeighbors(result, &region.center.x, flann::SearchParams());
    makeBlocks(result.hits, found);
  });
}

} // namespace recurse
