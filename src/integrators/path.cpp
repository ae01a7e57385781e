/** @file
 * The unbiased path tracer: shadow rays at every vertex, multiple importance sampling, Russian roulette. It
 * is the truth that the photon map is compared with.
 */
#include "recurse/model/plugIns.h"
#include "recurse/transport/directLight.h"

namespace recurse {

namespace {

class Path final : public Integrator {
 public:
  Path(int maxDepth, int lightSamples) : maxDepth(maxDepth), lightSamples(lightSamples) {}

  void backward(const Scene& scene, const EyeRay& eyeRay, Sampler& sampler,
                PathRadiance& out) const override {
    const PathClasses& classes = out.pathClasses();
    EyeRay ray = eyeRay;
    Rgb throughput(1);
    float etaScale = 1; // undoes the 1/η² inside glass, which is no reason to end a walk
    EyeState eye = classes.eyeStart();
    BsdfRay last;
    Hit hit;
    BsdfArena arena;
    for (int depth = 0;;) {
      if (!intersect(scene, ray, hit, out.counts)) {
        if (!scene.environment().empty())
          out.add(classes.lightStart(), eye,
                  throughput * environmentRadiance(scene, ray.direction, last, lightSamples));
        return;
      }
      if (hit.areaLight)
        out.add(classes.lightStart(), eye,
                throughput * emittedRadiance(scene, hit, ray.direction, last, lightSamples));
      ray.width += ray.spread * hit.t;
      arena.reset();
      const Bsdf* bsdf = bsdfAt(hit, footprint(ray), arena);
      if (!bsdf) {
        static_cast<Ray&>(ray) = spawn(hit.point, ray.direction);
        continue;
      }
      if (depth == maxDepth) {
        out.counts.weightCut += double(maxComponent(throughput));
        return;
      }
      ++depth;
      const ScatteringPoint scattering(*bsdf, hit.point);
      const Vec3f wi = -ray.direction;
      const EyeState eyeD = classes.step(eye, PathEvent::D), eyeS = classes.step(eye, PathEvent::S);
      const LobeSet allowed = LobeSet((classes.dead(eyeD) ? NO_LOBE : DIFFUSE_LOBES) |
                                      (classes.dead(eyeS) ? NO_LOBE : DELTA_LOBES));
      if (scattering.lobes() & allowed & DIFFUSE_LOBES)
        addSampledLight(scene, scattering, hit.point, wi, throughput, eyeD, lightSamples, allowed, sampler,
                        out);

      const std::optional<Scatter> s = scattering.scatter(wi, Transport::RADIANCE, sampler, allowed);
      if (!s) return;
      throughput *= s->weight;
      if (isBlack(throughput)) return;
      eye = s->specular() ? eyeS : eyeD;
      etaScale *= square(s->eta);
      if (depth > ROULETTE_FREE_DEPTH &&
          !survives(maxComponent(throughput) * etaScale, depth, sampler, throughput))
        return;
      last = {hit.point.position, s->pdf, !s->specular()};
      static_cast<Ray&>(ray) = spawn(hit.point, s->direction);
      if (!s->specular()) ray.width = ray.spread = 0; // what a pixel sees from here on is not known
    }
  }

  std::vector<EstimatorDomain> domains() const override {
    return {{"emission", "LS*E", "none: met by eye rays through mirrors and glass", ""},
            {"emission after scattering", "LS+D(S|D)*E", "none: met by the rays that go on", ""},
            {"shadow rays", "LD(S|D)*E", std::to_string(lightSamples) + " for each diffuse vertex",
             "direct light"},
            {"BSDF rays", "LD(S|D)*E", "none: the rays that go on", "direct light"}};
  }

 private:
  /** Short walks are not gambled with: most of the light is there. */
  static constexpr int ROULETTE_FREE_DEPTH = 2;
  int maxDepth;
  int lightSamples;
};

} // namespace

void registerPath(PlugIns& plugIns) {
  const auto add = [&](const char* name, const char* summary, std::vector<ParameterSpec> more) {
    more.insert(
        more.begin(),
        {integerParameter("maxdepth", "-1", "most scattering events of a path; -1: no limit").range(-1, 1e9),
         integerParameter("lightsamples", "1", "shadow rays at each diffuse vertex").range(1, 1e6)});
    plugIns.integrators.add(
        {{.name = name, .summary = summary, .parameters = std::move(more), .examples = {""}},
         [](const Parameters& p, const NoContext&) {
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
  const ParameterSpec lights =
      ignoredParameter(ParameterType::STRING, "lightsampler", "lights are chosen by power");
  add("path", "The unbiased path tracer with shadow rays and multiple importance sampling.",
      {real("rrthreshold"), boolean("regularize"), lights});
  add("volpath", other, {real("rrthreshold"), boolean("regularize"), lights});
  add("simplepath", other, {boolean("samplebsdf"), boolean("samplelights")});
  add("bdpt", other, {boolean("regularize"), boolean("visualizestrategies"), boolean("visualizeweights")});
  add("mlt", other,
      {integer("bootstrapsamples"), integer("chains"), integer("mutationsperpixel"),
       real("largestepprobability"), real("sigma"), boolean("regularize")});
  add("lightpath", other, {});
}

} // namespace recurse
