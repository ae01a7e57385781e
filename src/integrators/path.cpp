/** @file
 * The unbiased path tracer: shadow rays at every vertex, multiple importance sampling, Russian roulette. It
 * is the truth that the photon map is compared with.
 */
#include <utility>

#include "recurse/core/inPlace.h"
#include "recurse/model/plugIns.h"
#include "recurse/transport/directLight.h"
#include "recurse/transport/plainPath.h"

namespace recurse {

namespace {

/** An eye path under way. */
struct Walk {
  CameraPath* path;
  Rgb throughput;
  float etaScale; ///< undoes the 1/η² inside glass, which is no reason to end a walk
  int depth;
  CameraState eye;
  float width, spread; ///< of the ray's footprint
  float wavelength;    ///< as in Subpath
  Nesting nesting;
  BsdfRay last;
  bool isScattered; ///< by a non-delta lobe
};

/** Where a walk scatters. */
struct Vertex {
  Walk* walk;
  const Hit* hit;
  Vec3f wi;
  std::optional<ScatteringPoint> scattering;
  CameraState cameraD, cameraS;
  LobeSet allowed;
  bool sampleLight;
  LightSampleContext place; ///< of the lights, where they are sampled
};

/** A shadow ray under way. */
struct Shadow {
  const Vertex* vertex;
  const LiSample* light;
  Rgb radiance;
};

/** N of T, in no state at first. */
template <class T> class Raw {
 public:
  T& operator[](size_t i) { return *std::launder(reinterpret_cast<T*>(bytes) + i); }
  T* data() { return reinterpret_cast<T*>(bytes); }

 private:
  static_assert(std::is_trivially_destructible_v<T>);
  alignas(T) std::byte bytes[CAMERA_BATCH * sizeof(T)];
};

class Path final : public Integrator {
 public:
  Path(int maxDepth, int lightSamples) : maxDepth(maxDepth), lightSamples(lightSamples) {}

  void prepare(const Scene& scene, const PathClasses&) override { learned = guide.learn(scene); }

  ForwardStatistics forward(const Scene&, const PathClasses&, const Pass&, const ForwardControl&) override {
    ForwardStatistics statistics;
    statistics.counts = std::exchange(learned, {});
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
    if (scene.hasMedia()) { // paths wait for so many things that there is nothing to be done for many at once
      for (CameraPath& p : paths)
        tracePlainPath(scene, p.ray, guide, {maxDepth, lightSamples}, p.sampler, *p.out);
      return;
    }
    while (!paths.empty()) {
      const size_t count = std::min(paths.size(), CAMERA_BATCH);
      Batch batch(*this, scene, paths.first(count));
      batch.run();
      paths = paths.subspan(count);
    }
  }

  std::vector<EstimatorDomain> domains() const override { return plainPathDomains(lightSamples); }
  bool supportsMedia(const Scene&) const override { return true; }

 private:
  /**
   * Paths that go step by step together. One path is a chain of operations that wait for each other; the
   * loops here run over paths that do not, and the scene gets its rays many at a time.
   */
  class Batch {
   public:
    Batch(const Path& path, const Scene& scene, std::span<CameraPath> paths)
        : settings(path), scene(scene), classes(paths[0].out->pathClasses()), counts(paths[0].out->counts),
          alive(paths.size()) {
      for (size_t i = 0; i < alive; ++i) {
        Walk& w = walks[i];
        w.path = &paths[i];
        w.throughput = Rgb(1);
        w.etaScale = 1;
        w.depth = 0;
        w.eye = classes.cameraStart();
        w.width = paths[i].ray.width;
        w.spread = paths[i].ray.spread;
        w.wavelength = 0;
        w.last.weighted = false;
        w.isScattered = false;
        makeAt(w.nesting, [&] { return nestingAt(scene, paths[i].ray, counts); });
        active[i] = &w;
        rays[i] = paths[i].ray;
      }
    }

    void run() {
      const PathRadiance& any = *walks[0].path->out; // all are abandoned together
      for (auto coherence = Scene::Coherence::COHERENT; alive > 0; coherence = Scene::Coherence::NONE) {
        counts.rays += alive;
        scene.intersectBatch({rays.data(), alive}, coherence, {hits.data(), alive});
        arrive();
        for (int i = 0; i < settings.lightSamples && !any.abandoned(); ++i) sampleLights();
        goOn();
      }
    }

   private:
    /** Emission met, and the surfaces. */
    void arrive() {
      arena.reset();
      vertexCount = 0;
      size_t passed = 0;
      for (size_t i = 0; i < alive; ++i) {
        Walk& w = *active[i];
        Hit& hit = hits[i];
        const Vec3f direction = rays[i].direction;
        if (hit.t == INFINITE) {
          if (!scene.environment().empty())
            addEmission(w,
                        environmentRadiance(scene, settings.guide, direction, w.last, settings.lightSamples));
          continue;
        }
        if (hit.areaLight)
          addEmission(w,
                      emittedRadiance(scene, settings.guide, hit, direction, w.last, settings.lightSamples));
        w.width += w.spread * hit.t;
        drawWavelength(scene, w.wavelength, w.path->sampler, hit);
        const Bsdf* bsdf =
            bsdfAt(scene, hit, direction, {direction, w.width * w.path->ray.sampleSpacing}, w.nesting, arena);
        if (!bsdf) {
          active[passed] = &w;
          makeAt(rays[passed++], [&] { return spawn(hit.point, direction); });
          continue;
        }
        if (w.depth == settings.maxDepth) {
          counts.truncatedThroughput += double(maxComponent(w.throughput));
          continue;
        }
        ++w.depth;
        Vertex& v = vertices[vertexCount++];
        v.walk = &w;
        v.hit = &hit;
        v.wi = -direction;
        makeAt(v.scattering, [&] { return std::optional<ScatteringPoint>(std::in_place, *bsdf, hit.point); });
        v.cameraD = classes.step(w.eye, PathEvent::D);
        v.cameraS = classes.step(w.eye, PathEvent::S);
        v.allowed = LobeSet((classes.dead(v.cameraD) ? NO_LOBE : NON_DELTA_LOBES) |
                            (classes.dead(v.cameraS) ? NO_LOBE : DELTA_LOBES));
        v.sampleLight = (v.scattering->lobes() & v.allowed & NON_DELTA_LOBES) != 0 &&
                        lightIsSampled(scene, classes, v.cameraD);
        v.place = v.sampleLight ? lightSampleContext(settings.guide, hit.point, v.wi) : LightSampleContext();
      }
      alive = passed;
    }

    void addEmission(const Walk& w, const Rgb& radiance) const {
      if (w.isScattered)
        w.path->out->add(classes.lightStart(), w.eye, w.throughput * radiance);
      else
        w.path->out->addSeen(w.eye, w.throughput * radiance);
    }

    /** One shadow ray for each vertex. */
    void sampleLights() {
      const LightTable& table = scene.lights();
      size_t lit = 0;
      for (size_t i = 0; i < vertexCount; ++i)
        if (vertices[i].sampleLight) shadows[lit++].vertex = &vertices[i];
      for (size_t i = 0; i < lit; ++i)
        makeAt(choices[i], [&] {
          const Vertex& v = *shadows[i].vertex;
          return SampledLight(table, settings.guide, v.place, v.walk->path->sampler);
        });
      for (size_t i = 0; i < lit; ++i)
        makeAt(lights[i], [&] { return choices[i].sampleLi(shadows[i].vertex->hit->point); });
      size_t count = 0;
      for (size_t i = 0; i < lit; ++i) {
        if (!lights[i]) continue;
        const Vertex& v = *shadows[i].vertex;
        const Rgb radiance =
            unshadowedRadiance(*v.scattering, v.wi, v.walk->throughput, *lights[i],
                               choices[i].chosen.probability, settings.lightSamples, v.allowed);
        if (isBlack(radiance)) continue;
        ++counts.rays;
        makeAt(shadowRays[count], [&] { return shadowRay(v.hit->point, *lights[i]); });
        if (shadowRays[count].direction == Vec3f(0)) { // no way between, and nothing in it
          v.walk->path->out->add(classes.lightStart(), v.cameraD, radiance);
          continue;
        }
        shadows[count].vertex = &v;
        shadows[count].light = &*lights[i];
        shadows[count].radiance = radiance;
        ++count;
      }
      scene.occludedBatch({shadowRays.data(), count}, {blocked.data(), count});
      for (size_t i = 0; i < count; ++i) {
        const Vertex& v = *shadows[i].vertex;
        if (!blocked[i]) {
          v.walk->path->out->add(classes.lightStart(), v.cameraD, shadows[i].radiance);
          continue;
        }
        const Transmittance free =
            throughPanes(scene, shadowRays[i], *v.hit, v.wi, *shadows[i].light, v.walk->nesting,
                         panesLeft(settings.maxDepth, v.walk->depth), counts);
        if (!isBlack(free.value))
          v.walk->path->out->add(afterPanes(classes, free.panes), v.cameraD,
                                 shadows[i].radiance * free.value);
      }
    }

    /** The next direction of each walk that has one. */
    void goOn() {
      for (size_t i = 0; i < vertexCount; ++i) {
        const Vertex& v = vertices[i];
        makeAt(scatters[i], [&] {
          return v.scattering->scatter(v.wi, Transport::RADIANCE, v.walk->path->sampler, v.allowed);
        });
      }
      for (size_t i = 0; i < vertexCount; ++i) {
        if (!scatters[i]) continue;
        const Scatter& s = *scatters[i];
        const Vertex& v = vertices[i];
        Walk& w = *v.walk;
        w.throughput *= s.weight;
        if (isBlack(w.throughput)) continue;
        w.eye = s.specular() ? v.cameraS : v.cameraD;
        w.etaScale *= square(s.eta);
        if (w.depth > ROULETTE_FREE_DEPTH &&
            !russianRoulette(maxComponent(w.throughput) * w.etaScale, w.depth, w.path->sampler, w.throughput))
          continue;
        if (!passesPane(scene, *v.scattering, s)) {
          w.last.from = v.place;
          w.last.pdf = s.pdf;
          w.last.weighted = !s.specular();
        }
        w.throughput *= dispersedColour(v.hit->point, s, w.wavelength);
        w.nesting.scatters(*v.hit, v.wi, s.direction);
        if (!s.specular()) {
          w.width = w.spread = 0; // what a pixel sees from here on is not known
          w.isScattered = true;
        }
        active[alive] = &w;
        makeAt(rays[alive++], [&] { return spawn(v.hit->point, s.direction); });
      }
    }

    const Path& settings;
    const Scene& scene;
    const PathClasses& classes;
    TransportCounts& counts;
    size_t alive, vertexCount = 0;
    BsdfArena arena;
    Raw<Walk> walks;
    Raw<Walk*> active; ///< the walks of `rays` and `hits`
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

  /** Short walks are not gambled with: most of the light is there. */
  static constexpr int ROULETTE_FREE_DEPTH = 2;
  int maxDepth;
  int lightSamples;
  LightSampler guide;
  TransportCounts learned; ///< what the guide took, until it has been told
};

} // namespace

void registerPath(PlugIns& plugIns) {
  static const std::string SAME_PICTURE = "the picture is the same in the end, what is hard to find is not";
  const auto add = [&](const char* name, const char* summary, std::vector<ParameterSpec> more) {
    more.insert(
        more.begin(),
        {integerParameter("maxdepth", "-1", "most scattering events of a path; -1: no limit").range(-1, 1e9),
         integerParameter("lightsamples", "1", "shadow rays at each diffuse vertex").range(1, 1e6)});
    plugIns.integrators.add(
        {{.name = name, .summary = summary, .parameters = std::move(more), .examples = {""}},
         [isOther = std::string(name) != "path"](const Parameters& p, const NoContext&) {
           if (isOther) p.warn("", "\"" + p.plugInName() + "\" is rendered by \"path\": " + SAME_PICTURE);
           return std::make_unique<Path>(p.integer("maxdepth"), p.integer("lightsamples"));
         }});
  };
  const char* other = "another name of path: the picture is the same, the way there is not";
  const auto real = [](const char* n) {
    return ignoredParameter(ParameterType::REAL, n, "path does not need it");
  };
  const auto integer = [](const char* n) {
    return ignoredParameter(ParameterType::INTEGER, n, "path does not need it");
  };
  const auto boolean = [](const char* n) {
    return ignoredParameter(ParameterType::BOOLEAN, n, "path does not need it");
  };
  const ParameterSpec lights = ignoredParameter(ParameterType::STRING, "lightsampler",
                                                "lights are chosen by what photons tell of each place");
  add("path", "The unbiased path tracer with shadow rays and multiple importance sampling.",
      {real("rrthreshold"), boolean("regularize"), lights});
  add("volpath", other, {real("rrthreshold"), boolean("regularize"), lights});
  add("randomwalk", other, {});
  add("simplevolpath", other, {});
  add("mlt", other,
      {integer("bootstrapsamples"), integer("chains"), integer("mutationsperpixel"),
       real("largestepprobability"), real("sigma"), boolean("regularize")});
}

} // namespace recurse
