/** @file
 * Tree of photons. Whether a search visits the far side of a split plane is a gap in photonMapper.cpp.
 */
#include "frame/photonTree.h"

#include <algorithm>

#include "frame/photonMapper.h"

namespace course::photon {

namespace {

/** Axis along which the photons extend farthest. */
int longestAxis(std::span<const Photon> photons) {
  Vec3f low = photons.front().position, high = low;
  for (const Photon& photon : photons) {
    low = glm::min(low, photon.position);
    high = glm::max(high, photon.position);
  }
  return widestAxis(high - low);
}

} // namespace

/** State of a search: a heap with the farthest photon on top. */
struct PhotonTree::Search {
  Vec3f point, normal;
  size_t limit = 0; ///< most photons in the heap
  float radius2 = 0;
  std::vector<NearPhoton> heap;

  static bool isNearer(const NearPhoton& a, const NearPhoton& b) { return a.distance2 < b.distance2; }

  void add(const Photon& photon) {
    const float distance2 = lengthSquared(photon.position - point);
    if (!(distance2 < radius2) || !(glm::dot(photon.normal, normal) > 0)) return;
    if (heap.size() == limit) {
      std::pop_heap(heap.begin(), heap.end(), isNearer);
      heap.pop_back();
    }
    heap.push_back({photon.power, distance2});
    std::push_heap(heap.begin(), heap.end(), isNearer);
    if (heap.size() == limit) radius2 = heap.front().distance2;
  }
};

void PhotonTree::build(std::vector<Photon> all) {
  photons = std::move(all);
  sort(photons);
}

void PhotonTree::sort(std::span<Photon> part) {
  if (part.size() < 2) return;
  const int axis = longestAxis(part);
  const size_t middle = part.size() / 2;
  std::nth_element(part.begin(), part.begin() + long(middle), part.end(),
                   [axis](const Photon& a, const Photon& b) { return a.position[axis] < b.position[axis]; });
  part[middle].axis = axis;
  sort(part.first(middle));
  sort(part.subspan(middle + 1));
}

NearPhotons PhotonTree::nearest(const Vec3f& point, const Vec3f& normal, size_t count,
                                float maxRadius) const {
  Search state{point, normal, count + 1, square(maxRadius), {}};
  search(photons, state);
  NearPhotons found{std::move(state.heap), state.radius2};
  if (found.photons.size() > count) { // the farthest one limits the sphere
    std::pop_heap(found.photons.begin(), found.photons.end(), Search::isNearer);
    found.photons.pop_back();
  }
  return found;
}

void PhotonTree::search(std::span<const Photon> part, Search& state) const {
  if (part.empty()) return;
  const size_t middle = part.size() / 2;
  const Photon& split = part[middle];
  const float planeDistance = state.point[split.axis] - split.position[split.axis];
  const std::span<const Photon> below = part.first(middle), above = part.subspan(middle + 1);
  search(planeDistance < 0 ? below : above, state);
  state.add(split);
  if (visitsFarSide(planeDistance, state.radius2)) search(planeDistance < 0 ? above : below, state);
}

} // namespace course::photon
