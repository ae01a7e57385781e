/** @file
 * Path tracer that advances many paths together, one step at a time.
 */
#include "integrators/path/pathTracing.h"

#include "recurse/core/threads/inPlace.h"
#include "recurse/core/threads/processorTime.h"
#include "recurse/transport/integrator/lightPathRecorder.h"
#include "transport/direct/directLight.h"
#include "transport/learning/guideTraining.h"
#include "transport/learning/lightLearning.h"

namespace recurse {

namespace {

/** Camera path between two vertices. */
struct BatchPath {
  CameraPath* camera;
  Rgb throughput;
  float etaScale; ///< undoes the 1/η² inside glass, for Russian roulette only
  int depth;
  CameraState state;
  float width, spread; ///< footprint of the ray, see Subpath
  float wavelength;    ///< see Subpath
  OpticalPath optical; ///< see Subpath
  Nesting nesting;
  BsdfRay bsdfRay;
  bool isScattered; ///< has passed a non-delta vertex
  int recordedStep; ///< step by which the ray left, see PathRecorder
};

/** Vertex at which a path scatters. */
struct Vertex {
  BatchPath* path;
  const Hit* hit;
  Vec3f wi;
  std::optional<ScatteringPoint> scattering;
  CameraState cameraD, cameraS;
  LobeSet allowed;
  bool sampleLight;
  LightSampleContext context; ///< context of light sampling, if sampleLight
  int recorded;               ///< index of the vertex, see PathRecorder
};

/** Shadow ray before its occlusion test. */
struct Shadow {
  const Vertex* vertex;
  const LiSample* light;
  ChosenLight chosen;
  Rgb radiance;
};

/** Uninitialised array of CAMERA_BATCH elements. */
template <class T> class Raw {
 public:
  T& operator[](size_t i) { return *std::launder(reinterpret_cast<T*>(bytes) + i); }
  T* data() { return reinterpret_cast<T*>(bytes); }

 private:
  static_assert(std::is_trivially_destructible_v<T>);
  alignas(T) std::byte bytes[CAMERA_BATCH * sizeof(T)]; // NOLINT: of pointers, too
};

class PathTracing final : public Integrator {
 public:
  PathTracing(const PlainPathSettings& settings, const LightSampler* lights, bool guided)
      : maxDepth(settings.maxDepth), lightSamples(settings.lightSamples), guided(guided),
        training({settings.maxDepth, settings.lightSamples}), lightSampler(lights ? *lights : ownLights) {}

  TransportCounts prepare(const Scene& scene, const PathClasses&) override {
    return &lightSampler == &ownLights ? learnLights(scene, ownLights) : TransportCounts();
  }

  Passes passes(int) const override { return guided ? Passes::doubling() : Passes::oneMap(); }

  ForwardStatistics forward(const Scene& scene, const PathClasses&, const Pass& pass,
                            const ForwardControl& control) override {
    ForwardStatistics statistics;
    if (guided) {
      const ProcessorTimer timer(statistics.learningSeconds);
      training.prepare(scene, lightSampler, pass, control, statistics.counts);
      statistics.guide = training.statistics();
    }
    return statistics;
  }

  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                PathRadiance& out) const override {
    CameraPath one(sampler, out);
    one.ray = ray;
    backwardBatch(scene, {&one, 1});
    sampler = one.sampler;
  }

  void backwardBatch(const Scene& scene, std::span<CameraPath> paths) const override {
    if (scene.hasMedia()) { // in media, steps are too dependent for batches to be of use
      for (CameraPath& p : paths)
        tracePlainPath(scene, p.ray, lightSampler, {maxDepth, lightSamples, activeGuide()}, p.sampler,
                       *p.out);
      return;
    }
    while (!paths.empty()) {
      const size_t count = std::min(paths.size(), CAMERA_BATCH);
      Batch batch(*this, scene, paths.first(count));
      batch.run();
      paths = paths.subspan(count);
    }
  }

  bool learnsDirections() const override { return guided; }
  LearnedDirections directionsAt(const SurfacePoint& point, const Vec3f& wi) const override {
    return training.directionsAt(point, wi);
  }

  std::vector<EstimatorDomain> domains() const override { return plainPathDomains(lightSamples); }
  bool supportsMedia(const Scene&) const override { return true; }
  bool supportsTransient(const Scene& scene) const override { return !scene.hasEmissiveMedia(); }

 private:
  /**
   * Paths that advance together, one step at a time. A single path is a chain of dependent operations; the
   * loops here run over independent paths, and the scene traces many rays at once.
   */
  class Batch {
   public:
    Batch(const PathTracing& path, const Scene& scene, std::span<CameraPath> paths)
        : settings(path), scene(scene), classes(paths[0].out->pathClasses()), counts(paths[0].out->counts),
          alive(paths.size()) {
      for (size_t i = 0; i < alive; ++i) {
        BatchPath& w = batchPaths[i];
        w.camera = &paths[i];
        w.throughput = Rgb(1);
        w.etaScale = 1;
        w.depth = 0;
        w.state = classes.cameraStart();
        w.width = paths[i].ray.width;
        w.spread = paths[i].ray.spread;
        w.wavelength = 0;
        w.bsdfRay.weighted = false;
        w.isScattered = false;
        w.recordedStep = CAMERA_STEP;
        makeAt(w.nesting, [&] { return nestingAt(scene, paths[i].ray, counts); });
        w.optical = {0, indexAtStart(scene, classes, paths[i].ray, w.nesting, counts)};
        active[i] = &w;
        rays[i] = paths[i].ray;
      }
    }

    void run() {
      const PathRadiance& any = *batchPaths[0].camera->out; // all are abandoned together
      for (auto coherence = Scene::Coherence::COHERENT; alive > 0; coherence = Scene::Coherence::NONE) {
        counts.rays += alive;
        scene.intersectBatch({rays.data(), alive}, coherence, {hits.data(), alive});
        arrive();
        for (int i = 0; i < settings.lightSamples && !any.abandoned(); ++i) sampleLights();
        scatter();
      }
    }

   private:
    /** Adds emission that rays hit, and sets up the vertices. */
    void arrive() {
      arena.reset();
      vertexCount = 0;
      size_t passed = 0;
      for (size_t i = 0; i < alive; ++i) {
        BatchPath& w = *active[i];
        Hit& hit = hits[i];
        const Vec3f direction = rays[i].direction;
        if (hit.t == INFINITE) {
          addEmission(w, nullptr, rays[i]);
          continue;
        }
        w.optical.travel(hit.t);
        if (hit.areaLight) addEmission(w, &hit, rays[i]);
        w.width += w.spread * hit.t;
        drawWavelength(scene, w.wavelength, w.camera->sampler, hit);
        const Bsdf* bsdf = bsdfAt(scene, hit, direction, {direction, w.width * w.camera->ray.sampleSpacing},
                                  w.nesting, arena);
        if (!bsdf) {
          active[passed] = &w;
          rays[passed++] = rayBehind(rays[i], hit);
          continue;
        }
        if (w.depth == settings.maxDepth) {
          counts.truncatedThroughput += double(maxComponent(w.throughput));
          continue;
        }
        ++w.depth;
        Vertex& v = vertices[vertexCount++];
        v.path = &w;
        v.hit = &hit;
        v.wi = -direction;
        makeAt(v.scattering, [&] { return std::optional<ScatteringPoint>(std::in_place, *bsdf, hit.point); });
        v.recorded = NOT_RECORDED;
        if (PathRecorder* recorder = w.camera->out->recorder)
          v.recorded =
              recorder->addVertex(w.recordedStep, hit, direction, v.scattering->lobes(), w.throughput);
        if (const GuideField* guide = settings.activeGuide())
          v.scattering->follow(guideAt(*guide, hit.point, v.wi));
        const SurfaceKind kind = surfaceKind(classes, hit);
        v.cameraD = classes.step(w.state, PathEvent::D, kind);
        v.cameraS = classes.step(w.state, PathEvent::S, kind);
        v.allowed = LobeSet((classes.dead(v.cameraD) ? NO_LOBE : NON_DELTA_LOBES) |
                            (classes.dead(v.cameraS) ? NO_LOBE : DELTA_LOBES));
        v.sampleLight = (v.scattering->lobes() & v.allowed & NON_DELTA_LOBES) != 0 &&
                        lightIsSampled(scene, classes, v.cameraD);
        v.context =
            v.sampleLight ? lightSampleContext(settings.lightSampler, hit.point, v.wi) : LightSampleContext();
      }
      alive = passed;
    }

    /** Adds the emission of a surface, or of the environment lights if `hit` is null. */
    void addEmission(const BatchPath& w, const Hit* hit, const Ray& ray) const {
      PathRadiance& out = *w.camera->out;
      forLightHits(scene, settings.lightSampler, hit, ray, w.bsdfRay, settings.lightSamples, nullptr,
                   [&](const LightHit& found) {
                     if (out.recorder) recordHit(*out.recorder, w.recordedStep, found, w.bsdfRay);
                     const LightState light = classes.lightStart(found.index);
                     const float length = w.optical.at(found.beyond);
                     if (w.isScattered)
                       out.add(light, w.state, w.throughput * found.weighted, length);
                     else
                       out.addSeen(light, w.state, w.throughput * found.weighted, length);
                   });
    }

    /** Traces one shadow ray from each vertex. */
    void sampleLights() {
      const LightTable& table = scene.lights();
      size_t lit = 0;
      for (size_t i = 0; i < vertexCount; ++i)
        if (vertices[i].sampleLight) shadows[lit++].vertex = &vertices[i];
      for (size_t i = 0; i < lit; ++i)
        makeAt(choices[i], [&] {
          const Vertex& v = *shadows[i].vertex;
          return SampledLight(table, settings.lightSampler, v.context, v.path->camera->sampler);
        });
      for (size_t i = 0; i < lit; ++i)
        makeAt(lights[i], [&] { return choices[i].sampleLi(shadows[i].vertex->hit->point); });
      size_t count = 0;
      for (size_t i = 0; i < lit; ++i) {
        if (!lights[i]) continue;
        const Vertex& v = *shadows[i].vertex;
        const Rgb radiance =
            unshadowedRadiance(*v.scattering, v.wi, v.path->throughput, *lights[i],
                               choices[i].chosen.probability, settings.lightSamples, v.allowed);
        if (isBlack(radiance)) continue;
        ++counts.rays;
        makeAt(shadowRays[count], [&] { return shadowRay(v.hit->point, *lights[i]); });
        if (shadowRays[count].direction == Vec3f(0)) { // coincident: no occlusion
          addSampled(v, *lights[i], choices[i].chosen, v.cameraD, 0, radiance);
          continue;
        }
        shadows[count].vertex = &v;
        shadows[count].light = &*lights[i];
        shadows[count].chosen = choices[i].chosen;
        shadows[count].radiance = radiance;
        ++count;
      }
      scene.occludedBatch({shadowRays.data(), count}, {blocked.data(), count});
      for (size_t i = 0; i < count; ++i) {
        const Vertex& v = *shadows[i].vertex;
        if (!blocked[i]) {
          addSampled(v, *shadows[i].light, shadows[i].chosen, v.cameraD, 0, shadows[i].radiance);
          continue;
        }
        PaneSteps steps{classes, v.cameraD};
        const Rgb free = throughPanes(scene, shadowRays[i], *v.hit, v.wi, *shadows[i].light, v.path->nesting,
                                      panesLeft(settings.maxDepth, v.path->depth), counts, steps);
        if (!isBlack(free))
          addSampled(v, *shadows[i].light, shadows[i].chosen, steps.state, steps.panes,
                     shadows[i].radiance * free);
      }
    }

    /** Adds the contribution of a shadow ray through `panes` thin panes. `state`: of the camera path up to
     * the light. */
    void addSampled(const Vertex& v, const LiSample& light, const ChosenLight& chosen, CameraState state,
                    int panes, const Rgb& radiance) const {
      PathRadiance& out = *v.path->camera->out;
      if (out.recorder) {
        recordLightSample(*out.recorder, v.recorded, *v.scattering, v.wi, light, chosen.probability,
                          settings.lightSamples, v.allowed);
        out.recorder->source.panes = panes;
      }
      out.add(classes.lightStart(chosen.index), state, radiance,
              lengthToLight(scene, v.path->optical, *v.scattering, v.wi, v.hit->point, light));
    }

    /** Samples the next direction of each path, with Russian roulette. */
    void scatter() {
      for (size_t i = 0; i < vertexCount; ++i) {
        const Vertex& v = vertices[i];
        makeAt(scatters[i], [&] {
          return v.scattering->scatter(v.wi, Transport::RADIANCE, v.path->camera->sampler, v.allowed);
        });
      }
      for (size_t i = 0; i < vertexCount; ++i) {
        if (!scatters[i]) continue;
        const Scatter& s = *scatters[i];
        const Vertex& v = vertices[i];
        BatchPath& w = *v.path;
        w.throughput *= s.weight;
        if (isBlack(w.throughput)) continue;
        w.state = s.specular() ? v.cameraS : v.cameraD;
        w.etaScale *= square(s.eta) * s.rouletteScale;
        w.optical.scatter(s.eta);
        if (!cameraRoulette(w.etaScale, w.depth, w.camera->sampler, w.throughput)) continue;
        if (!passesPane(scene, *v.scattering, s)) {
          w.bsdfRay.from = v.context;
          w.bsdfRay.pdf = s.pdf;
          w.bsdfRay.weighted = !s.specular();
        }
        w.throughput *= dispersedColour(v.hit->point, s, w.wavelength);
        w.nesting.scatters(*v.hit, v.wi, s.direction);
        if (!s.specular()) {
          w.width = w.spread = 0; // the footprint after a non-delta event is unknown
          w.isScattered = true;
        }
        if (PathRecorder* recorder = w.camera->out->recorder)
          w.recordedStep = recorder->addStep(recordedStep(
              v.recorded, s, w.throughput, v.scattering->pdf(s.direction, v.wi, ALL_LOBES, Transport::FLUX)));
        active[alive] = &w;
        makeAt(rays[alive++], [&] { return spawn(v.hit->point, s.direction); });
      }
    }

    const PathTracing& settings;
    const Scene& scene;
    const PathClasses& classes;
    TransportCounts& counts;
    size_t alive, vertexCount = 0;
    BsdfArena arena;
    Raw<BatchPath> batchPaths;
    Raw<BatchPath*> active; ///< paths that `rays` and `hits` belong to
    Raw<Ray> rays;
    Raw<Hit> hits;
    Raw<Vertex> vertices;
    Raw<SampledLight> choices;
    Raw<std::optional<LiSample>> lights;
    Raw<Shadow> shadows;
    Raw<Ray> shadowRays;
    Raw<uint8_t> blocked;
    Raw<std::optional<Scatter>> scatters;
  };

  /** Guide of the current pass; null where nothing was learned. */
  const GuideField* activeGuide() const { return training.guide(); }

  int maxDepth;
  int lightSamples;
  bool guided;
  GuideTraining training;
  LightSampler ownLights;
  const LightSampler& lightSampler;
};

} // namespace

std::unique_ptr<Integrator> makePathTracing(const PlainPathSettings& settings, const LightSampler* lights,
                                            bool guided) {
  return std::make_unique<PathTracing>(settings, lights, guided);
}

} // namespace recurse
