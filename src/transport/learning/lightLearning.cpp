/** @file
 * Arrivals of light at surfaces, for the choice of lights.
 */
#include "transport/learning/lightLearning.h"

#include <algorithm>

#include "recurse/core/threads/interrupt.h"
#include "transport/direct/cameraPaths.h"
#include "transport/emission/emissionSampler.h"

namespace recurse {

namespace {

/** Sampler streams of the learning, distinct from all others. */
constexpr uint64_t ARRIVAL_STREAM = 0x4c4947485453ull, LOOK_STREAM = 0x4c4f4f4b53ull;

struct Found {
  LightArrivals arrivals;
  TransportCounts counts;
};

/** Adds an arrival from unit `wi` or, at surfaces that transmit, on both sides. */
void keep(const Hit& hit, const Vec3f& wi, uint32_t leaf, LightArrivals& arrivals) {
  const Vec3f& normal = hit.point.geometricNormal;
  const bool outside = glm::dot(normal, wi) > 0, both = hit.material->lobes() & TRANSMISSION;
  if (outside || both) arrivals.add(hit.point.position, normal, leaf);
  if (!outside || both) arrivals.add(hit.point.position, -normal, leaf);
}

/** Follows photons, straight through thin panes as shadow rays, to their first non-delta surface. */
void shoot(const Scene& scene, const LightTree& tree, size_t first, size_t end, Found& found) {
  const PathClasses allPaths;
  Walker<LightState> walker(scene, allPaths, found.counts, -1, InMedia::IGNORE);
  LightVertex vertex;
  const auto follow = [&](LightStart& start, Sampler& sampler) {
    while (walker.next(start.path, vertex, sampler)) {
      if (vertex.scattering->hasNonDelta())
        return keep(vertex.hit, vertex.wi, tree.rank[start.end.index], found.arrivals);
      const auto s = walker.scatter(start.path, vertex, sampler);
      if (!s || !passesPane(scene, *vertex.scattering, *s)) return;
    }
  };
  for (size_t i = first; i < end; ++i) {
    Sampler sampler(0, ARRIVAL_STREAM, static_cast<uint32_t>(i));
    const float time = scene.moves() ? scene.camera().timeAt(sampler.next1D()) : 0;
    std::optional<LightStart> start = startLightSubpath(scene, allPaths, time, sampler, found.counts);
    if (start) follow(*start, sampler);
  }
}

/** Finds a light that reaches a vertex of a camera path, by shadow rays. */
void look(const Scene& scene, const LightSampler& sampler, const CameraVertex& vertex, const Nesting& nesting,
          Sampler& random, LightArrivals& arrivals, TransportCounts& counts) {
  constexpr int TRIALS = 6;
  const LightTree& tree = sampler.lightTree();
  const Hit& hit = vertex.hit;
  const Vec3f normal = hit.point.normalTowards(vertex.wi);
  const bool both = hit.material->lobes() & TRANSMISSION;
  // Reservoir sampling of one trial by its irradiance. If trials were by power alone, the sky, which may be
  // hidden, would take nearly all of them.
  std::optional<uint32_t> kept;
  double sum = 0;
  for (int i = 0; i < TRIALS; ++i) {
    auto pick = double(random.next1D());
    const Vec2f u = random.next2D();
    const double keeps = double(random.next1D());
    const bool byPower = i % 2 == 0;
    const double clusters = byPower ? 1 : double(tree.clusters.size());
    const double which = std::floor(pick * clusters);
    pick = pick * clusters - which;
    const auto [leaf, probability] =
        tree.choose(byPower ? tree.root() : tree.clusters[size_t(which)], hit.point.position, pick);
    const std::optional<LiSample> light =
        sampler.sampleLi(scene.lights()[tree.order[leaf]], hit.point.time, hit.point.position,
                         std::min(static_cast<float>(pick), ONE_MINUS_EPSILON), u);
    double e = light ? irradianceBy(*light, normal, both) * clusters / probability : 0;
    if (e > 0)
      e *= double(
          maxComponent(transmittance(scene, hit, vertex.wi, *light, nesting, panesLeft(-1, 0), counts)));
    sum += e;
    if (keeps * sum < e) kept = leaf;
  }
  if (kept) keep(hit, vertex.wi, *kept, arrivals);
}

} // namespace

TransportCounts learnLights(const Scene& scene, LightSampler& lights, bool withPortals) try {
  TransportCounts counts = lights.prepare(scene, withPortals);
  const LightTree& tree = lights.lightTree();
  if (tree.empty()) return counts;
  // Limited by the number of pixels, so that learning takes a small fraction of the render time.
  constexpr size_t MIN_COUNT = 4096, MAX_COUNT = 131072, BATCH = 1024, LOOKS = 4;
  const size_t photons = std::clamp(size_t(scene.film().whole().area()), MIN_COUNT, MAX_COUNT);
  std::vector<Found> found(photons / BATCH);
  parallelFor(found.size(), [&](size_t b) { shoot(scene, tree, b * BATCH, (b + 1) * BATCH, found[b]); });
  const auto follow = [&](LightArrivals& arrivals, CameraSubpath& path, CameraWalker& walker,
                          Sampler& sampler, TransportCounts& pathCounts) {
    CameraVertex vertex;
    while (walker.next(path, vertex, sampler)) {
      if (vertex.scattering->hasNonDelta())
        return look(scene, lights, vertex, path.nesting, sampler, arrivals, pathCounts);
      if (!walker.scatter(path, vertex, sampler)) return;
    }
  };
  const std::vector<LightArrivals> seen =
      followCameraPaths(scene, static_cast<int>(std::sqrt(double(photons / LOOKS))), MAX_BRANCHING_DEPTH,
                        LOOK_STREAM, counts, LightArrivals(), follow);
  LightArrivals all;
  const auto append = [&](const LightArrivals& some) {
    for (size_t side = 0; side < SIGNED_AXES; ++side)
      all.bySide[side].insert(all.bySide[side].end(), some.bySide[side].begin(), some.bySide[side].end());
  };
  for (const LightArrivals& some : seen) append(some);
  for (const Found& f : found) {
    append(f.arrivals);
    counts.add(f.counts);
  }
  lights.learn(scene.lights(), all);
  return counts;
} catch (const Interrupted&) {
  lights = {};
  return {};
}

} // namespace recurse
