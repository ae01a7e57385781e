/** @file
 * Light paths, and what they leave behind.
 */
#include "python/photonList.h"

#include "recurse/core/math/hash.h"
#include "recurse/core/threads/parallel.h"
#include "transport/emission/pathEnds.h"
#include "transport/paths/walker.h"

namespace recurse::python {

namespace {

/** Tells these photons from other samples of the same seed. */
constexpr uint64_t PHOTON_STREAM = 0x4c49535450484f54ull;
constexpr uint64_t BATCH = 4096;

template <class V> std::array<float, 3> floats(const V& v) { return {v[0], v[1], v[2]}; }

class PhotonShooter {
 public:
  PhotonShooter(const Scene& scene, uint64_t emitted, uint64_t seed, int maxDepth)
      : scene(scene), emitted(emitted), seed(seed), maxDepth(maxDepth) {}

  void shoot(uint64_t index, std::vector<PhotonRecord>& stored) const {
    Sampler sampler(seed, PHOTON_STREAM + (index >> 32), static_cast<uint32_t>(index));
    TransportCounts counts;
    const float time = scene.camera().timeAt(scene.moves() ? sampler.next2D().x : 0);
    const std::optional<LightStart> start = startLightSubpath(scene, classes, time, sampler, counts);
    if (!start) return;
    Walker<LightState> walker(scene, classes, counts, maxDepth);
    LightSubpath path = start->path;
    LightVertex vertex;
    std::string word = "L";
    while (walker.next(path, vertex, sampler)) {
      if (vertex.isConnectable() && !vertex.medium) stored.push_back(record(vertex, word));
      const std::optional<Scatter> step = walker.scatter(path, vertex, sampler);
      if (!step) return;
      word += vertex.medium ? 'V' : step->lobe & DELTA_LOBES ? 'S' : 'D';
    }
  }

 private:
  PhotonRecord record(const LightVertex& vertex, const std::string& word) const {
    const SurfacePoint& point = vertex.point();
    PhotonRecord out{};
    for (int i = 0; i < 3; ++i) out.position[size_t(i)] = scene.origin()[i] + double(point.position[i]);
    out.direction = floats(vertex.wi);
    out.normal = floats(point.normalTowards(vertex.wi));
    out.power = floats(vertex.throughput / float(emitted));
    std::copy_n(word.begin(), std::min(word.size(), out.path.size()), out.path.begin());
    return out;
  }

  const Scene& scene;
  PathClasses classes;
  uint64_t emitted, seed;
  int maxDepth;
};

} // namespace

std::vector<PhotonRecord> listPhotons(const Scene& scene, uint64_t emitted, uint64_t seed, int maxDepth) {
  if (scene.lights().size() == 0) return {};
  const PhotonShooter shooter(scene, emitted, seed, maxDepth);
  std::vector<std::vector<PhotonRecord>> batches((emitted + BATCH - 1) / BATCH);
  parallelFor(batches.size(), [&](size_t batch) {
    const uint64_t first = batch * BATCH, end = std::min(first + BATCH, emitted);
    for (uint64_t i = first; i < end; ++i) shooter.shoot(i, batches[batch]);
  });
  std::vector<PhotonRecord> out;
  for (std::vector<PhotonRecord>& batch : batches) {
    out.insert(out.end(), batch.begin(), batch.end());
    batch = {};
  }
  return out;
}

} // namespace recurse::python
