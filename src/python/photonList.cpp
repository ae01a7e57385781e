/** @file
 * Light paths, and the photons that they store.
 */
#include "python/photonList.h"

#include <algorithm>

#include "python/recordArrays.h"
#include "recurse/core/math/hash.h"
#include "recurse/core/threads/parallel.h"
#include "transport/emission/emissionSampler.h"
#include "transport/paths/walker.h"

namespace recurse::python {

namespace {

/** Sampler stream of these photons. */
constexpr uint64_t PHOTON_STREAM = 0x4c49535450484f54ull;
constexpr uint64_t BATCH = 4096;

class PhotonShooter {
 public:
  PhotonShooter(const Scene& scene, const PhotonRequest& request) : scene(scene), request(request) {}

  void shoot(uint64_t index, std::vector<PhotonRecord>& stored) const {
    Sampler sampler(request.seed, PHOTON_STREAM + (index >> 32), static_cast<uint32_t>(index));
    TransportCounts counts;
    const float time = scene.camera().timeAt(scene.moves() ? sampler.next2D().x : 0);
    const std::optional<LightStart> start = startLightSubpath(scene, classes, time, sampler, counts);
    if (!start) return;
    Walker<LightState> walker(scene, classes, counts, request.maxDepth);
    LightSubpath path = start->path;
    LightVertex vertex;
    std::string word = "L";
    while (walker.next(path, vertex, sampler)) {
      if (vertex.isConnectable()) stored.push_back(record(vertex, word));
      const std::optional<Scatter> step = walker.scatter(path, vertex, sampler);
      if (!step) return;
      word += vertex.medium ? 'V' : step->lobe & DELTA_LOBES ? 'S' : 'D';
    }
  }

 private:
  PhotonRecord record(const LightVertex& vertex, const std::string& word) const {
    const SurfacePoint& point = vertex.point();
    PhotonRecord out{};
    out.position = worldPosition(scene, point.position);
    out.direction = floats(vertex.wi);
    if (!vertex.medium) out.normal = floats(point.normalTowards(vertex.wi));
    out.power = floats(vertex.throughput / float(request.emitted));
    std::copy_n(word.begin(), std::min(word.size(), out.path.size()), out.path.begin());
    out.event = {vertex.medium ? 'V' : 'D'};
    out.pathClass = classOf(word + out.event[0] + "E");
    return out;
  }
  int32_t classOf(const std::string& word) const {
    const auto accepts = [&](const PathAutomaton& c) { return c.accepts(word); };
    const auto found = std::find_if(request.classes.begin(), request.classes.end(), accepts);
    return found == request.classes.end() ? -1 : int32_t(found - request.classes.begin());
  }

  const Scene& scene;
  const PhotonRequest& request;
  PathClasses classes;
};

} // namespace

std::vector<PhotonRecord> listPhotons(const Scene& scene, const PhotonRequest& request) {
  if (scene.lights().size() == 0) return {};
  const uint64_t emitted = request.emitted;
  const PhotonShooter shooter(scene, request);
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
