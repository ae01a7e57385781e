/** @file
 * Camera paths of the bidirectional estimators: hits, shadow rays, connections to one light path, and merges
 * with the photons of all light paths.
 */
#include <algorithm>
#include <bit>
#include <map>

#include "integrators/bidirectional/bidirectional.h"
#include "recurse/transport/integrator/lightPathRecorder.h"
#include "transport/density/boundaryCorrection.h"
#include "transport/direct/directLight.h"
#include "transport/paths/recordedCamera.h"
#include "transport/paths/walker.h"
#include "transport/photonmap/photonMapQuery.h"

namespace recurse {

/** One camera path and the techniques applied to it. Its vertices are x_1 … x_s. */
class Bidirectional::CameraWalk {
 public:
  CameraWalk(const Bidirectional& owner, const Scene& scene, const CameraRay& ray, Sampler& sampler,
             PathRadiance& out)
      : owner(owner), scene(scene), classes(out.pathClasses()), sampler(sampler), out(out),
        camera(scene, ray), walker(scene, classes, out.counts, owner.settings.maxDepth),
        path(startCameraSubpath(scene, classes, ray, out.counts)), vertices(1), record(out.recorder) {
    path.pdf = camera.pdf;
    path.parallel = camera.parallel;
    const std::vector<StoredPath>& paths = owner.subpaths.paths;
    if (!owner.settings.connections || paths.empty()) return;
    const auto i = static_cast<size_t>(double(sampler.next1D()) * double(paths.size()));
    light = &paths[std::min(i, paths.size() - 1)];
  }

  void run() {
    while (walker.next(path, vertex, sampler, [&](const Hit* hit) { addEmission(hit); })) {
      arrive();
      if (vertex.isConnectable()) {
        if (owner.settings.shadowRays) addShadowRay();
        if (light)
          for (uint32_t t = 1; t <= light->count && !out.abandoned(); ++t) addConnection(*light, t);
        if (owner.settings.merges) addPhotons();
      }
      if (out.abandoned()) return;
      const std::optional<Scatter> step = walker.scatter(path, vertex, sampler);
      if (!step) return;
      record.leave(vertex, *step, path.throughput);
      vertices.back().delta = path.delta;
      vertices[vertices.size() - 2].fromLight =
          path.delta ? vertex.toPrevious : vertex.pdfPrevious(path.ray.direction);
      if (!path.delta) radiusKnown = true;
      leave(passesPane(scene, *vertex.scattering, *step));
    }
  }

 private:
  void arrive() {
    const double distance = double(glm::distance(vertex.point().position, path.from));
    if (vertices.size() == 1) firstDistance = distance;
    seenAlong += distance;
    if (!radiusKnown) radius = owner.mergeRadius(camera.footprint(seenAlong));
    vertices.push_back({vertex.pdf, 1});
    record.arrive(vertex);
  }

  /** Records a light path, unless this walk has done so. Returns the index of its start. */
  int recordLightPath(const StoredPath& from) {
    std::vector<RecordedLightVertex>& list = out.recorder->lightVertices;
    const auto [entry, isNew] = recordedPaths.try_emplace(&from, static_cast<int>(list.size()));
    if (isNew)
      owner.recordLightPath(scene, classes, static_cast<size_t>(&from - owner.subpaths.paths.data()), list);
    return entry->second;
  }

  /** Records the weights of all techniques for the latest source. */
  void recordWeights(const WeightedPath& full) const {
    std::vector<RecordedWeight>& list = out.recorder->weights;
    RecordedSource& s = out.recorder->source;
    s.firstWeight = list.size();
    const size_t k = full.edges();
    for (const TechniqueWeight& one : techniqueWeights(full)) {
      const PathTechnique technique = one.isMerge          ? PathTechnique::MERGE
                                      : one.index == k     ? PathTechnique::HIT
                                      : one.index == k - 1 ? PathTechnique::LIGHT_SAMPLE
                                      : one.index == 0     ? PathTechnique::SPLAT
                                                           : PathTechnique::CONNECTION;
      list.push_back(
          {technique, static_cast<int>(std::min(one.index, k - 1)), static_cast<float>(one.weight)});
    }
    s.weightCount = list.size() - s.firstWeight;
  }

  /** Sets the source of a contribution that joins the camera path, in unit `direction`, with a vertex of a
   * light path. */
  void recordJoin(PathTechnique technique, const StoredPath& from, uint32_t t, const Vec3f& direction,
                  double weight) {
    RecordedSource& s = out.recorder->source;
    const int estimate = technique == PathTechnique::MERGE ? s.estimate : NOT_RECORDED;
    s = {.technique = technique, .vertex = record.vertex(), .step = record.step(), .estimate = estimate};
    s.lightVertex = recordLightPath(from) + static_cast<int>(t);
    s.end = vertexOf(from, t).point.position;
    s.weight = static_cast<float>(weight);
    s.vertexPdf = static_cast<float>(vertex.pdfDirection(direction));
    s.vertexPdfReverse = static_cast<float>(vertex.pdfReverse(direction));
  }

  /** Records the start of the shadow ray that competes with the next hit of the walk. */
  void leave(bool straight) {
    last = vertex.point();
    if (straight) {
      if (passed++ == 0) firstPane = last;
      return;
    }
    passed = 0;
    lit = last;
    towardsBeforeLit = vertex.wi;
    isLit = !path.delta;
  }
  ShadowRayStart shadowRayStart() const {
    return {isLit ? &lit : nullptr, towardsBeforeLit, passed, &firstPane, &last};
  }

  /** Adds the emission of the surface `hit`, or of the environment lights if it is null. */
  void addEmission(const Hit* hit) {
    if (owner.settings.hits)
      forLightHits(scene, owner.lights, hit, path.ray, {}, 1, nullptr,
                   [&](const LightHit& found) { addHit(found); });
  }

  /** Adds technique C_k: a hit of the light. */
  void addHit(const LightHit& found) {
    double weight = 1;
    std::optional<WeightedPath> full;
    if (vertices.size() > 1) {
      const LightEnd end = lightEnd(scene, owner.emission(), found.index, found.emitted, last);
      copyVertices();
      x.back().fromLight = end.pdfNext;
      x.push_back({path.pdf * directionToEnd(end, path.from), end.pdf});
      full = weighted(end, shadowRayStart());
      weight = hitWeight(*full);
    }
    if (out.recorder) {
      recordHit(*out.recorder, record.step(), found, {});
      RecordedSource& s = out.recorder->source;
      s.vertex = record.vertex();
      s.weight = static_cast<float>(weight);
      s.pdf = path.delta ? 0 : static_cast<float>(path.pdf);
      if (full) recordWeights(*full);
    }
    out.add(classes.lightStart(found.index), path.state,
            path.throughput * found.radiance * static_cast<float>(weight), path.optical.at(found.beyond));
  }

  /** Adds technique C_k-1: a shadow ray. */
  void addShadowRay() {
    if (!lightIsSampled(scene, classes, vertex.afterD)) return;
    const SampledLight choice(scene.lights(), owner.lights,
                              lightSampleContext(owner.lights, vertex.point(), vertex.wi), sampler);
    const std::optional<LiSample> sample = choice.sampleLi(vertex.point());
    if (!sample || !(sample->pdf > 0)) return;
    const Vec3f direction = sample->direction;
    const float pdf = choice.chosen.probability * sample->pdf;
    const Rgb radiance =
        vertex.throughput * vertex.scattering->evaluate(vertex.wi, direction) * sample->radiance / pdf;
    if (isBlack(radiance)) return;
    panes.clear();
    PaneSteps steps{classes, vertex.afterD};
    const Rgb free =
        transmittance(scene, vertex.hit, vertex.wi, *sample, path.nesting,
                      panesLeft(owner.settings.maxDepth, vertex.depth), out.counts, [&](const Hit& pane) {
                        panes.push_back(pane.point);
                        steps(pane);
                      });
    if (isBlack(free)) return;
    double next = vertex.pdfDirection(direction);
    copyVertices();
    x[x.size() - 2].fromLight = vertex.pdfPrevious(direction);
    ShadowRayStart start{&vertex.point(), vertex.wi, panes.size(), panes.data(), &vertex.point()};
    for (const SurfacePoint& pane : panes) {
      x.back().fromLight = areaPerSolidAngle(pane.position, *start.lastPane, direction);
      x.push_back({next * areaPerSolidAngle(start.lastPane->position, pane, direction), 1, true});
      next = 1;
      start.lastPane = &pane;
    }
    const LightEnd end =
        lightEnd(scene, owner.emission(), choice.chosen.index, sample->emitted(), *start.lastPane);
    x.back().fromLight = end.pdfNext;
    x.push_back({next * directionToEnd(end, start.lastPane->position), end.pdf});
    const WeightedPath full = weighted(end, start);
    if (!(full.shadowRays > 0)) return;
    const auto weight = static_cast<float>(connectionWeight(full, full.edges() - 1));
    if (out.recorder) {
      recordLightSample(*out.recorder, record.vertex(), *sample, pdf,
                        static_cast<float>(vertex.pdfDirection(direction)),
                        static_cast<float>(vertex.pdfReverse(direction)), weight);
      out.recorder->source.panes = static_cast<int>(panes.size());
      recordWeights(full);
    }
    out.add(classes.lightStart(choice.chosen.index), steps.state, radiance * free * weight,
            lengthToLight(scene, path.optical, *vertex.scattering, vertex.wi, vertex.point(), *sample));
  }

  /** Adds technique C_s: a connection to y_t of the light path, t > 0. */
  void addConnection(const StoredPath& from, uint32_t t) {
    const StoredVertex& y = vertexOf(from, t);
    if (!y.connectable || owner.isTooLong(vertices.size() - 1 + t) ||
        classes.join(y.afterD, vertex.afterD) == 0)
      return;
    const Vec3f offset = y.point.position - vertex.point().position;
    const float distance2 = lengthSquared(offset);
    if (!(distance2 > 0)) return;
    const float distance = std::sqrt(distance2);
    const Vec3f direction = offset / distance;
    const Rgb here = vertex.throughput * vertex.scattering->evaluate(vertex.wi, direction);
    if (isBlack(here)) return;
    arena.reset();
    const Bsdf* bsdf = y.material->bsdfAt(y.point, arena);
    if (!bsdf) return;
    const ScatteringPoint there(*bsdf, y.point);
    const Rgb radiance = here * y.throughput * there.evaluateFlux(y.wi, -direction) / distance2;
    if (isBlack(radiance) || !visible(scene, vertex.hit, vertex.wi,
                                      visibilityTarget(y.point.rayOrigin(-direction), direction, distance),
                                      path.nesting, out.counts))
      return;
    const size_t s = vertices.size() - 1;
    const float pdfThere = there.pdf(y.wi, -direction), pdfReverseThere = there.pdf(-direction, y.wi);
    copyVertices();
    owner.subpaths.appendDensities(from, t, x);
    x[s - 1].fromLight = vertex.pdfPrevious(direction);
    x[s].fromLight = double(pdfThere) * areaPerSolidAngle(y.point.position, vertex.point(), direction);
    x[s + 1].fromCamera =
        vertex.pdfDirection(direction) * areaPerSolidAngle(vertex.point().position, y.point, direction);
    x[s + 1].delta = false;
    x[s + 2].fromCamera = double(pdfReverseThere) * y.toPrevious;
    const WeightedPath full = weighted(from.end, owner.subpaths.shadowRayStart(from, t, -direction));
    const double weight = connectionWeight(full, s);
    if (out.recorder) {
      recordJoin(PathTechnique::CONNECTION, from, t, direction, weight);
      out.recorder->source.lightVertexPdf = pdfThere;
      out.recorder->source.lightVertexPdfReverse = pdfReverseThere;
      recordWeights(full);
    }
    out.add(y.afterD, vertex.afterD, radiance * static_cast<float>(weight),
            leaving(path.optical, *vertex.scattering, vertex.wi, direction).at(distance) +
                owner.subpaths.length(from, t));
  }

  /** Adds technique M_s: merges with all photons within the radius. */
  void addPhotons() {
    const SurfacePoint& point = vertex.point();
    GatherRegion region{point.position,
                        point.normalTowards(vertex.wi),
                        static_cast<float>(radius),
                        GatherSettings().flatness,
                        (vertex.scattering->lobes() & TRANSMISSION) != 0,
                        point.time};
    ++out.counts.gathers;
    if (!anyWithin(owner.photons, region)) return;
    const CachedRadius surface = owner.surfaces.at(region.center, region.normal);
    BoundaryCorrection boundary = correctionAt(scene, sampler.fork(BOUNDARY_STREAM), surface);
    const float covered =
        coveredFraction(boundary, glm::length(point.error), Kernel::CONSTANT, region, out.counts);
    supportArea = double(PI) * square(double(region.radius)) * double(covered);
    int found = 0;
    if (out.recorder) out.recorder->beginEstimate(record.vertex(), false);
    owner.photons.visitWithin(region, [&](const PhotonBlock& block) {
      if (out.abandoned()) return;
      found += std::popcount(block.mask);
      for (uint32_t remainingMask = block.mask; remainingMask != 0; remainingMask &= remainingMask - 1) {
        const uint32_t slot = block.first + static_cast<uint32_t>(std::countr_zero(remainingMask));
        addPhoton(owner.photonVertices[owner.photons.emissionIndex(slot)]);
      }
    });
    if (out.recorder) out.recorder->endEstimate(region.radius, found);
  }

  void addPhoton(const PhotonVertex& photon) {
    const StoredPath& from = owner.subpaths.paths[photon.path];
    const uint32_t t = photon.number;
    const StoredVertex& y = vertexOf(from, t);
    if (owner.isTooLong(vertices.size() - 2 + t) || classes.join(y.state, vertex.afterD) == 0) return;
    const Rgb f = vertex.scattering->value(vertex.wi, y.wi);
    if (isBlack(f)) return;
    ++out.counts.photonsFound;
    // Photon density is per area of the geometric surface, unlike shading normals (Veach 1997, eq. 5.19), and
    // alpha divides the flux as in photonAt().
    const float area =
        absDot(y.wi, y.point.shadingNormal) / (absDot(y.wi, y.point.geometricNormal) * y.point.alpha);
    const Rgb radiance = vertex.throughput * f * y.throughput *
                         static_cast<float>(double(area) / (owner.lightPaths * supportArea));
    copyVertices();
    const size_t s = x.size() - 1;
    owner.subpaths.appendDensities(from, t - 1, x);
    x[s - 1].fromLight = vertex.pdfPrevious(y.wi);
    x[s].fromLight = y.fromLight;
    x[s + 1].fromCamera = vertex.pdfDirection(y.wi) * y.toPrevious;
    const WeightedPath full = weighted(from.end, owner.subpaths.shadowRayStart(from, t, vertex.wi));
    const double weight = mergeWeight(full, s);
    if (out.recorder) {
      recordJoin(PathTechnique::MERGE, from, t, y.wi, weight);
      recordWeights(full);
    }
    out.add(y.state, vertex.afterD, radiance * static_cast<float>(weight),
            path.optical.length +
                lengthNear(vertex.point().position, y.point.position, y.wi, owner.subpaths.length(from, t),
                           leaving(path.optical, *vertex.scattering, vertex.wi, y.wi).index));
  }

  const StoredVertex& vertexOf(const StoredPath& from, uint32_t number) const {
    return owner.subpaths.vertex(from, number);
  }
  /** Complete path with the vertices `x` and this light end. */
  WeightedPath weighted(const LightEnd& end, const ShadowRayStart& start) {
    WeightedPath full = owner.weightedPath(radius, firstDistance);
    full.vertices = x;
    if (!camera.connectable) full.splats = 0;
    owner.completePath(scene, full, end, start);
    return full;
  }

  /** Copies the vertices to a new path `x`. All but the last two are the same in all later paths. */
  void copyVertices() {
    x.resize(vertices.size());
    std::copy(vertices.begin() + std::ptrdiff_t(copied), vertices.end(), x.begin() + std::ptrdiff_t(copied));
    copied = vertices.size() - std::min<size_t>(vertices.size(), 2);
  }

  /** Number of the sampler fork for the rays of boundary correction. */
  static constexpr uint32_t BOUNDARY_STREAM = 1;

  const Bidirectional& owner;
  const Scene& scene;
  const PathClasses& classes;
  Sampler& sampler;
  PathRadiance& out;
  CameraEnd camera;
  CameraWalker walker;
  CameraSubpath path;
  CameraVertex vertex;
  const StoredPath* light = nullptr;    ///< light path for connections
  std::vector<WeightedVertex> vertices; ///< x_0 … x_s; densities of the light walk are known up to x_s-2
  std::vector<WeightedVertex> x;        ///< vertices of the current full path
  size_t copied = 0;                    ///< number of vertices in `x` that no longer change
  // State of the walk since the last possible shadow ray, see ShadowRayStart:
  SurfacePoint lit, firstPane, last;
  Vec3f towardsBeforeLit{0};
  size_t passed = 0; ///< number of panes since `lit`
  bool isLit = false;
  std::vector<SurfacePoint> panes; ///< panes that the current shadow ray passes
  double firstDistance = 0, seenAlong = 0, radius = 0;
  double supportArea = 0;                         ///< area within the kernel support around the vertex
  bool radiusKnown = false;                       ///< `radius` is fixed by the first non-delta vertex
  std::map<const StoredPath*, int> recordedPaths; ///< index of the start in the record
  RecordedCameraPath record;
  BsdfArena arena;
};

void Bidirectional::backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                             PathRadiance& out) const {
  if (!settings.hits && !settings.shadowRays && !settings.connections && !settings.merges) return;
  CameraWalk(*this, scene, ray, sampler, out).run();
}

} // namespace recurse
