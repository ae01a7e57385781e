/** @file
 * Subpaths from both ends: light paths of a pass, which are stored and splatted; camera paths, with hits,
 * shadow rays, connections to one light path, and merges with all of them.
 */
#include "integrators/bidirectional/bidirectional.h"

#include <algorithm>
#include <chrono>
#include <numeric>

#include "recurse/core/threads/interrupt.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/core/threads/processorTime.h"
#include "recurse/core/threads/resources.h"
#include "recurse/transport/integrator/lightPathRecorder.h"
#include "transport/density/storedPhotons.h"
#include "transport/direct/cameraPaths.h"
#include "transport/direct/directLight.h"
#include "transport/emission/emissionSampler.h"
#include "transport/forward/photonGuidance.h"
#include "transport/forward/shoot.h"
#include "transport/learning/lightLearning.h"
#include "transport/paths/recordedWalk.h"
#include "transport/paths/walker.h"

namespace recurse {

namespace {

constexpr uint64_t BATCH = 4096;
/** Default merge radius in the first pass [pixels], which averages the photons of a few pixels. */
constexpr double MERGE_PIXELS = 1.5;

/** Probes the surfaces around vertices of camera paths. Merges close to them need no probe rays of their own,
 * which would be most of the rays. The vertices take the place of photons in the cache. */
RadiusCache probeSurfaces(const Scene& scene, TransportCounts& counts) try {
  if (scene.moves()) return {}; // merges at other times could not use them
  constexpr int ACROSS = 64, MAX_DEPTH = 4, NEAREST = 12;
  constexpr uint64_t STREAM = 0x4d45524745ull;
  PhotonMap map;
  map.build(collectAtCameraVertices<Photon>(
      scene, ACROSS, MAX_DEPTH, STREAM, counts,
      [](std::vector<Photon>& found, const CameraSubpath&, const CameraVertex& vertex) {
        if (!vertex.isConnectable()) return;
        Photon& photon = found.emplace_back();
        photon.position = vertex.point().position;
        photon.direction = packDirection(vertex.wi);
      }));
  GatherSettings search;
  search.nearest = NEAREST;
  search.radius = scene.bounds().radius;
  RadiusCache surfaces;
  surfaces.build(scene, map, 0, {}, search, 0, LightDetail::SMOOTH, {}, counts, false);
  return surfaces;
} catch (const Interrupted&) {
  return {}; // merges then probe the surfaces around them
}

} // namespace

ParameterSpec guidedStartsParameter() {
  return booleanParameter("guided", "false",
                          "learn which starts of light paths reach what the camera sees; helps "
                          "where light enters through small openings or from a far lamp");
}

TransportCounts Bidirectional::prepare(const Scene& scene, const PathClasses&) {
  lightPaths = settings.lightPaths > 0 ? double(settings.lightPaths)
                                       : double(scene.film().width) * double(scene.film().height);
  if (scene.lights().size() == 0) lightPaths = 0;
  splatted = settings.splats && scene.camera().isConnectable() && lightPaths > 0;
  TransportCounts counts;
  surfaces = settings.merges && lightPaths > 0 ? probeSurfaces(scene, counts) : RadiusCache();
  if (settings.shadowRays) counts.add(learnLights(scene, lights));
  return counts;
}

double Bidirectional::mergeRadius(double footprint) const {
  return radiusScale * (settings.radius > 0 ? double(settings.radius) : MERGE_PIXELS * footprint);
}

WeightedPath Bidirectional::weightedPath(double radius, double distance) const {
  // Photons within one degree of the first surface count as correlated (Grittmann et al. 2021).
  constexpr double ONE_DEGREE = 0.017455;
  WeightedPath path;
  path.splats = splatted ? lightPaths : 0;
  path.connections = settings.connections && lightPaths > 0 ? 1 : 0;
  path.photons = settings.merges ? lightPaths : 0;
  path.mergeArea = double(PI) * square(radius);
  path.correlationArea = settings.correlated ? double(PI) * square(distance * ONE_DEGREE) : 0;
  return path;
}

void Bidirectional::completePath(const Scene& scene, WeightedPath& path, const LightEnd& end,
                                 const ShadowRayStart& shadowRayStart) const {
  path.lightIsIntersectable = settings.hits && end.isIntersectable();
  path.light = end.geometry();
  if (settings.shadowRays)
    path.shadowRays = shadowRayDensity(scene, lights, shadowRayStart, end, path.vertices);
  countMerges(path);
}

/** Light paths of one batch, with their splats. */
class Bidirectional::LightWalk {
 public:
  LightWalk(const Bidirectional& owner, const Scene& scene, const PathClasses& classes,
            TransportCounts& counts, Splatter* splatter, float time, LightSubpaths& out)
      : owner(owner), scene(scene), classes(classes), counts(counts), splatter(splatter), time(time),
        out(out), walker(scene, classes, counts, owner.settings.maxDepth) {}

  void trace(Sampler sampler, RecordedWalk& record) {
    if (!owner.keepsLightPaths()) out.clear();
    StoredPath& stored = out.paths.emplace_back();
    stored.first = out.vertices.size();
    const std::optional<LightStart> start =
        startLightSubpath(scene, classes, time, sampler, counts, &owner.starts);
    if (!start) return;
    stored.end = start->end;
    LightSubpath path = start->path;
    record.start(path);
    while (walker.next(path, vertex, sampler, record.escape(path, scene))) {
      store(stored, path.optical.length);
      record.arrive(path, vertex, vertex.isConnectable() && owner.keepsLightPaths());
      if (splatter && vertex.isConnectable())
        splat(stored, path, sampler.fork(static_cast<uint32_t>(vertex.depth)));
      const std::optional<Scatter> step = walker.scatter(path, vertex, sampler);
      if (!step) return;
      record.leave(vertex, *step);
      StoredVertex& last = out.vertices.back();
      last.delta = path.delta;
      last.straight = passesPane(scene, *vertex.scattering, *step);
      const double back = path.delta ? vertex.toPrevious : vertex.pdfPrevious(path.ray.direction);
      (stored.count > 1 ? out.vertices[out.vertices.size() - 2].fromCamera : stored.fromCamera) = back;
    }
  }

 private:
  void store(StoredPath& path, float length) {
    if (classes.isTransient()) out.lengths.push_back(length);
    StoredVertex& v = out.vertices.emplace_back();
    v.point = vertex.point();
    v.material = vertex.hit.material;
    v.wi = vertex.wi;
    v.throughput = vertex.throughput;
    v.fromLight = vertex.pdf;
    v.toPrevious = vertex.toPrevious;
    v.state = vertex.state;
    v.afterD = vertex.afterD;
    v.connectable = vertex.isConnectable();
    ++path.count;
  }

  /** Adds technique C_0: splats the last vertex to the camera. */
  void splat(const StoredPath& path, const LightSubpath& subpath, Sampler sampler) {
    if (classes.join(vertex.afterD, classes.cameraStart()) == 0) return;
    const SurfacePoint& point = vertex.point();
    const auto lens = scene.camera().sampleWi(point.position, sampler.next2D(), time);
    if (!lens || !(lens->pdf > 0)) return;
    const Ray ray{lens->position, -lens->direction, INFINITE, time};
    const CameraEnd end(scene, ray);
    if (!end.connectable) return;
    const Rgb contribution = vertex.throughput * vertex.scattering->evaluateFlux(vertex.wi, lens->direction) *
                             (lens->importance / lens->pdf);
    if (isBlack(contribution)) return;
    if (!visible(scene, vertex.hit, vertex.wi,
                 visibilityTarget(lens->position, lens->direction, lens->distance), subpath.nesting, counts))
      return;
    const double distance = double(lens->distance);
    x.assign(1, {});
    out.appendDensities(path, path.count, x);
    x[1].fromCamera = end.pdfAt(lens->position, point, lens->direction);
    x[2].fromCamera = vertex.pdfPrevious(lens->direction);
    WeightedPath weighted = owner.weightedPath(owner.mergeRadius(end.footprint(distance)), distance);
    weighted.vertices = x;
    owner.completePath(scene, weighted, path.end, out.shadowRayStart(path, path.count, lens->direction));
    splatter->add(vertex.afterD, classes.cameraStart(), lens->film,
                  contribution * static_cast<float>(connectionWeight(weighted, 0)),
                  leaving(subpath.optical, *vertex.scattering, vertex.wi, lens->direction).at(lens->distance),
                  counts);
  }

  const Bidirectional& owner;
  const Scene& scene;
  const PathClasses& classes;
  TransportCounts& counts;
  Splatter* splatter;
  float time;
  LightSubpaths& out;
  Walker<LightState> walker;
  LightVertex vertex;
  std::vector<WeightedVertex> x;
};

ForwardStatistics Bidirectional::forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                                         const ForwardControl& control) {
  ForwardStatistics statistics;
  current = pass;
  radiusScale = double(recurse::radiusScale(pass.index, settings.alpha));
  subpaths.clear();
  photonVertices.clear();
  if (lightPaths == 0) return statistics;
  if (settings.guided && pass.index == 0) {
    const ProcessorTimer timer(statistics.learningSeconds);
    starts = learnEmission(scene, classes, pass.seed, settings.maxDepth, control, statistics.counts);
  }
  const auto start = std::chrono::steady_clock::now();
  const auto count = static_cast<uint64_t>(lightPaths);
  const size_t batches = (count + BATCH - 1) / BATCH;
  std::vector<LightSubpaths> parts(batches);
  std::vector<TransportCounts> counts(batches);
  std::vector<size_t> bytes(batches);
  Splatter* splatter = splatted ? control.splatter : nullptr;
  LightPathRecorder* const recorder = control.lightPaths;
  std::vector<std::vector<RecordedLightVertex>> records(recorder ? batches : 0);
  if (recorder) recorder->beginPass(count);
  const auto traceBatch = [&](size_t b) {
    if (control.stopped()) return;
    LightWalk walks(*this, scene, classes, counts[b], splatter, pass.time, parts[b]);
    for (uint64_t i = b * BATCH; i < std::min(count, (b + 1) * BATCH); ++i) {
      RecordedWalk record(recorder && recorder->isRecorded(i) ? &records[b] : nullptr,
                          1 / static_cast<float>(lightPaths));
      walks.trace(lightPathSampler(pass, i), record);
    }
    bytes[b] = parts[b].memoryBytes();
    if (!keepsLightPaths()) parts[b] = {};
  };
  const size_t first = std::min((batches + 7) / 8, FIRST_BATCHES);
  parallelFor(first, traceBatch);
  if (keepsLightPaths())
    requireMemory(std::to_string(count) + " light paths",
                  2 * double(std::accumulate(bytes.begin(), bytes.end(), size_t(0))) * double(batches) /
                      double(first));
  parallelFor(batches - first, [&](size_t b) { traceBatch(first + b); });
  if (splatter) splatter->addPaths(count);
  for (const auto& record : records) recorder->append(record);
  if (keepsLightPaths())
    for (LightSubpaths& batch : parts) {
      subpaths.append(batch);
      batch = {};
    }
  for (const TransportCounts& c : counts) statistics.counts.add(c);
  statistics.shootSeconds = secondsSince(start);
  statistics.photonsEmitted = count;
  if (settings.merges) buildPhotons();
  statistics.photonsStored = settings.merges ? photons.size() : subpaths.vertices.size();
  statistics.photonsRefused = photons.refused();
  statistics.balanceSeconds = secondsSince(start) - statistics.shootSeconds;
  statistics.mapBytes = keepsLightPaths() ? subpaths.memoryBytes() + photons.memoryBytes()
                                          : *std::max_element(bytes.begin(), bytes.end());
  return statistics;
}

void Bidirectional::recordLightPath(const Scene& scene, const PathClasses& classes, size_t number,
                                    std::vector<RecordedLightVertex>& record) const {
  TransportCounts counts;
  LightSubpaths aside;
  RecordedWalk walk(&record, 1 / static_cast<float>(lightPaths));
  LightWalk(*this, scene, classes, counts, nullptr, current.time, aside)
      .trace(lightPathSampler(current, number), walk);
}

void Bidirectional::buildPhotons() {
  std::vector<Photon> found;
  for (size_t p = 0; p < subpaths.paths.size(); ++p) {
    const StoredPath& path = subpaths.paths[p];
    // Photons straight from a light are left to shadow rays.
    for (uint32_t t = 2; t <= path.count; ++t) {
      const StoredVertex& v = subpaths.vertices[path.first + t - 1];
      if (!v.connectable) continue;
      const float bent = absDot(v.wi, v.point.shadingNormal) / absDot(v.wi, v.point.geometricNormal);
      const std::optional<Photon> photon = photonAt(v.point, v.wi, v.throughput * bent, v.state.byte);
      if (!photon) continue;
      found.push_back(*photon);
      photonVertices.push_back({static_cast<uint32_t>(p), t});
    }
  }
  photons.build(found);
}

void Bidirectional::visitPhotons(const std::function<void(const StoredPhoton&)>& visit) const {
  for (const StoredVertex& v : subpaths.vertices)
    if (v.connectable)
      visit({v.point.position, v.wi, v.point.normalTowards(v.wi),
             v.throughput / static_cast<float>(lightPaths), v.state});
}

void Bidirectional::visitPhotonBoxes(int levels, const std::function<void(const PhotonBox&)>& visit) const {
  visitMapBoxes(photons, false, levels, visit);
}

std::vector<EstimatorDomain> Bidirectional::domains() const {
  std::vector<EstimatorDomain> all;
  const auto add = [&](bool used, const char* estimator, const char* expression, const char* cost,
                       bool hitsLights = false, bool onlyPanes = false) {
    if (used) all.push_back({estimator, expression, cost, "all light", hitsLights, onlyPanes});
  };
  add(settings.hits, "emission", "L(S|D)*E", "none: found by rays of camera paths", true);
  add(settings.shadowRays, "shadow rays", "LD(S|D)*E", "one for each diffuse vertex of a camera path");
  add(settings.shadowRays, "shadow rays through panes", "LS+D(S|D)*E", "included in shadow rays", false,
      true);
  add(settings.connections, "connections", "L(S|D)*DD(S|D)*E",
      "one shadow ray for each pair of a diffuse vertex of the camera path and one of the light path");
  add(settings.splats, "splats", "L(S|D)*DE",
      "one shadow ray from each diffuse vertex of a light path to the camera");
  add(settings.merges, "photons", "L(S|D)+D(S|D)*E",
      "one density estimate for each diffuse vertex of a camera path");
  return all;
}

} // namespace recurse
