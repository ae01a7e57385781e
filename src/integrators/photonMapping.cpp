/** @file
 * Recurse's estimate of radiance: emitted light, plus the photon maps' estimate at non-delta surfaces, plus
 * mirror and refracted light, recursively. Direct light comes from shadow rays, or from photons like all
 * other light. Where the map of indirect light would show its noise, the path goes on and reads it at the
 * next surface.
 */
#include <algorithm>
#include <utility>

#include "recurse/model/plugIns.h"
#include "recurse/transport/causticWeights.h"
#include "recurse/transport/directLight.h"
#include "recurse/transport/gatherShare.h"
#include "recurse/transport/irradianceCache.h"
#include "recurse/transport/photonPass.h"

namespace recurse {

namespace {

struct PhotonMappingSettings : PhotonPassSettings {
  int passes = 0; ///< see Integrator::passes
  int lightSamples = 1;
  bool shareIrradiance = true; ///< the rays of final gathers read irradiance found out once near each place
  int finalGather = -1;        ///< rays from the first non-delta surface of a path; -1: one, where that pays
  float weightLimit = 0.03f;
};

/** A camera path on its way. */
struct PathState {
  CameraRay ray;
  CameraState camera;
  Nesting nesting;
  Rgb throughput{1};
  float etaScale = 1; ///< undoes the 1/η² inside glass
  int depth = 0;      ///< scattering events so far
  int nonDelta = 0;   ///< those by non-delta lobes
  // Since the last of these:
  float distance = 0;   ///< travelled [scene units]
  bool delta = false;   ///< by mirrors and glass
  float share = 1;      ///< of the indirect light there that is for this path to find
  BsdfRay bsdfRay;      ///< weighs light that is met at once against shadow rays
  MergeRatio merge;     ///< weighs light that is met by mirrors and glass against caustic photons
  float lightShare = 1; ///< of emission that is met, where photons bring all light

  /** The path after a scattering event. */
  PathState after(const Hit& hit, const Scatter& s) const {
    PathState next = *this;
    next.nesting.scatters(hit, -ray.direction, s.direction);
    next.throughput *= s.weight;
    next.etaScale *= square(s.eta);
    static_cast<Ray&>(next.ray) = spawn(hit.point, s.direction);
    if (s.specular()) {
      next.delta = true;
      next.merge.leave(s.direction, hit.point);
    }
    return next;
  }
};

class PhotonMapping final : public Integrator {
 public:
  explicit PhotonMapping(const PhotonMappingSettings& settings) : settings(settings), photons(settings) {}

  int passes(int /*samplesPerPixel*/) const override { return settings.passes; }

  bool passHasOneTime() const override { return true; }

  void prepare(const Scene& scene, const PathClasses&) override {
    learned = {};
    if (!settings.directLight) learned = lights.learn(scene);
  }

  ForwardStatistics forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                            const ForwardControl& control) override {
    ForwardStatistics statistics = photons.run(scene, classes, pass, control);
    statistics.counts.add(std::exchange(learned, {}));
    recordSampler = Sampler(pass.seed, pass.index, 0);
    const bool oneClass = classes.lightStateCount() == 1; // else some photons count and some do not
    const bool shared = settings.finalGather > 0 && settings.shareIrradiance && oneClass;
    irradiances.reset(shared ? photons.indirect().cache.size() : 0);
    causticIrradiances.reset(shared ? photons.caustics().cache.size() : 0);
    if (pass.index == 0) {
      shares.readAll();
      if (mayGoOn() && settings.nearest == 0 && settings.radius == 0 && !photons.useless())
        shares.learn(photons.indirect().cache, irradianceSampler(scene, classes), statistics.counts);
    }
    return statistics;
  }

  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler,
                PathRadiance& out) const override {
    PathState path;
    path.ray = ray;
    path.camera = out.pathClasses().cameraStart();
    path.nesting = nestingAt(scene, ray, out.counts);
    trace(scene, path, sampler, out);
  }

  std::vector<EstimatorDomain> domains() const override;

 private:
  /** Whether paths decide by themselves where to read the map of indirect light. */
  bool mayGoOn() const { return settings.finalGather < 0 && photons.isProgressive(); }

  /** Follows a path to the end: emitted light, and at each surface what its lobes bring. */
  void trace(const Scene& scene, PathState path, Sampler& sampler, PathRadiance& out) const {
    BsdfArena arena;
    Hit hit;
    for (;;) {
      if (!intersect(scene, path.ray, hit, out.counts)) {
        addEnvironment(scene, path, out);
        return;
      }
      path.ray.width += path.ray.spread * hit.t;
      path.distance += hit.t;
      if (hit.areaLight) addEmission(scene, path, hit, out);
      if (path.share == 0 && hit.material && !(hit.material->lobes() & DELTA_LOBES)) return;
      arena.reset();
      const Bsdf* bsdf = bsdfAt(scene, hit, path.ray.direction, footprint(path.ray), path.nesting, arena);
      if (!bsdf) {
        static_cast<Ray&>(path.ray) = spawn(hit.point, path.ray.direction);
        continue;
      }
      if (path.depth == settings.maxDepth) {
        out.counts.truncatedThroughput += double(maxComponent(path.throughput));
        return;
      }
      ++path.depth;
      const ScatteringPoint scattering(*bsdf, hit.point);
      if (scattering.hasNonDelta()) addNonDelta(scene, path, hit, scattering, sampler, out);
      if (!followDelta(scene, path, hit, scattering, sampler, out)) return;
    }
  }

  // ------------------------------------------------------------------------------------------ emitted light

  void addEmission(const Scene& scene, const PathState& path, const Hit& hit, PathRadiance& out) const {
    const Vec3f& direction = path.ray.direction;
    Rgb radiance = emittedRadiance(scene, lights, hit, direction, directWeights(path), settings.lightSamples);
    if (path.nonDelta > 0 && path.delta && !settings.directLight && !isBlack(radiance)) {
      MergeRatio merge = path.merge;
      merge.arrive(direction, hit.point);
      radiance *= merge.cameraWeight(
          hit.areaLight->pdfLe({hit.point.position, -direction, hit.point.geometricNormal, hit.primitive}),
          scene.lights().probability(hit.lightIndex));
    }
    addLight(path, radiance, out);
  }

  void addEnvironment(const Scene& scene, const PathState& path, PathRadiance& out) const {
    if (scene.environment().empty()) return;
    const Vec3f& direction = path.ray.direction;
    if (path.nonDelta == 0 || !path.delta || settings.directLight) {
      addLight(path,
               environmentRadiance(scene, lights, direction, directWeights(path), settings.lightSamples),
               out);
      return;
    }
    for (size_t i = 0; i < scene.environment().size(); ++i) {
      const EnvironmentLight& light = *scene.environment()[i];
      const float weight = path.merge.cameraWeight(light.pdfLe({path.ray.origin, -direction, Vec3f(0), 0}),
                                                   scene.lights().probability(scene.environmentIndices()[i]));
      addLight(path, light.radiance(direction) * weight, out);
    }
  }

  /** What light that is met shares with shadow rays: nothing from the camera on or after mirrors and glass.
   */
  BsdfRay directWeights(const PathState& path) const {
    return path.nonDelta == 0 || path.delta || settings.directLight ? BsdfRay() : path.bsdfRay;
  }

  void addLight(const PathState& path, const Rgb& radiance, PathRadiance& out) const {
    const float share = settings.directLight ? path.lightShare : 1;
    if (share > 0 && !isBlack(radiance))
      out.add(out.pathClasses().lightStart(), path.camera, path.throughput * radiance * share);
  }

  // ---------------------------------------------------------------------------------------- mirrors, glass

  /** Goes on by the delta lobes: every branch of a path from the camera while it is worth it, one by roulette
   * after. False where the path ends. */
  bool followDelta(const Scene& scene, PathState& path, const Hit& hit, const ScatteringPoint& scattering,
                   Sampler& sampler, PathRadiance& out) const {
    path.camera = out.pathClasses().step(path.camera, PathEvent::S);
    if (!scattering.hasDelta() || out.pathClasses().dead(path.camera)) return false;
    path.merge.arrive(path.ray.direction, hit.point);
    std::array<Scatter, DeltaScatters::MAX_COUNT> all;
    const int count = scattering.deltaScatters(-path.ray.direction, Transport::RADIANCE, all);
    float worth[DeltaScatters::MAX_COUNT], total = 0, least = INFINITE;
    for (int i = 0; i < count; ++i) {
      const Scatter& s = all[size_t(i)];
      worth[i] = maxComponent(path.throughput * s.weight) * square(s.eta) * path.etaScale;
      total += worth[i];
      if (worth[i] > 0) least = std::min(least, worth[i]);
    }
    if (!(total > 0)) return false;
    int next = 0;
    if (path.nonDelta == 0 && least >= settings.weightLimit && path.depth <= LONG_WALK) {
      for (int i = 1; i < count; ++i) {
        Sampler branch = sampler.fork(static_cast<uint32_t>(i));
        trace(scene, path.after(hit, all[size_t(i)]), branch, out);
      }
    } else {
      float u = count > 1 ? sampler.next1D() * total : 0;
      while (next + 1 < count && u >= worth[next]) u -= worth[next++];
      if (!(worth[next] > 0)) return false;
      path.throughput *= total / worth[next];
      // A long walk by its full weight: it may be thousands of events from falling below the limit.
      const float chance = path.depth > LONG_WALK ? total : total / settings.weightLimit;
      if (!russianRoulette(std::min(1.0f, chance), path.depth, sampler, path.throughput)) return false;
    }
    path = path.after(hit, all[size_t(next)]);
    return true;
  }

  // -------------------------------------------------------------------------------------- non-delta lobes

  /** Light that non-delta lobes send along the path: direct, by photons, and by a ray that goes on. */
  void addNonDelta(const Scene& scene, PathState path, const Hit& hit, const ScatteringPoint& scattering,
                   Sampler& sampler, PathRadiance& out) const {
    path.camera = out.pathClasses().step(path.camera, PathEvent::D);
    path.throughput *= std::exchange(path.share, 1);
    if (out.pathClasses().dead(path.camera) || !goesOn(path, sampler)) return;
    const Vec3f wi = -path.ray.direction;
    LightSampleContext context;
    if (!settings.directLight) {
      context = lightSampleContext(lights, hit.point, wi);
      addSampledLight(scene, lights, context, scattering, hit, path.nesting, wi, path.throughput, path.camera,
                      settings.lightSamples, NON_DELTA_LOBES, NO_PANES, sampler, out);
    }
    const PhotonLayer& caustics = photons.caustics();
    const float merging =
        addPhotons(scene, caustics, causticIrradiances, photons.query(caustics, hit.point, wi), scattering,
                   hit.point, path, sampler, out);
    PhotonQuery indirect = photons.query(photons.indirect(), hit.point, wi);
    indirect.settings.share = gatherShare(path, indirect);
    if (indirect.settings.share > 0)
      addPhotons(scene, photons.indirect(), irradiances, indirect, scattering, hit.point, path, sampler, out);

    const int rays = path.nonDelta == 0 ? std::max(settings.finalGather, 1) : 1;
    ++path.nonDelta;
    path.throughput /= static_cast<float>(rays);
    for (int i = 0; i < rays && !out.abandoned(); ++i) {
      Sampler branch = sampler.fork(DeltaScatters::MAX_COUNT + 2 + static_cast<uint32_t>(i));
      const std::optional<Scatter> s = scattering.scatterNonDelta(wi, Transport::RADIANCE, branch);
      if (!s) continue;
      PathState next = path.after(hit, *s);
      next.ray.width = next.ray.spread = 0; // what a pixel sees from here on is not known
      next.distance = 0;
      next.delta = false;
      // Photons around a Lambertian surface are all added up.
      next.lightShare = scattering.lobes() & LAMBERTIAN ? 0 : settings.weighting.followed(s->pdf);
      next.share = 1 - indirect.settings.share * (1 - next.lightShare);
      next.bsdfRay = {context, s->pdf, true};
      next.merge = MergeRatio(merging, s->pdf, s->direction, hit.point);
      if (next.share > 0 || mayMeetLight(scene)) trace(scene, next, branch, out);
    }
  }

  /** Roulette at a non-delta surface, with the part of the light that is left to the path. */
  bool goesOn(PathState& path, Sampler& sampler) const {
    constexpr int FREE = 2; // surfaces before which most of the light is found
    const float worth = maxComponent(path.throughput) * path.etaScale;
    const float chance = path.nonDelta >= FREE ? worth : worth / settings.weightLimit;
    return russianRoulette(std::min(1.0f, chance), path.depth, sampler, path.throughput);
  }

  bool mayMeetLight(const Scene& scene) const {
    return !settings.directLight && scene.contents().areaLights + scene.contents().environmentLights > 0;
  }

  /** The part of the indirect light at the end of the path that is read from the map. */
  float gatherShare(const PathState& path, const PhotonQuery& query) const {
    if (mayGoOn() && photons.useless()) return 0;
    if (path.nonDelta == 0) return settings.finalGather > 0 ? 0 : mayGoOn() ? shares.at(query.place) : 1;
    // A map that is blurred over more than the distance is not to be seen by a surface close by.
    const float blur =
        photons.isProgressive() ? query.settings.radius : photons.indirect().choice.typicalRadius;
    return path.distance < blur ? 0 : 1;
  }

  // ---------------------------------------------------------------------------------------------- photons

  /** Adds what photons of a layer bring at a point. Returns their weight against rays that find the same
   * light. */
  float addPhotons(const Scene& scene, const PhotonLayer& layer, const IrradianceCache& cache,
                   const PhotonQuery& query, const ScatteringPoint& scattering, const SurfacePoint& point,
                   const PathState& path, const Sampler& sampler, PathRadiance& out) const {
    const Vec3f wi = -path.ray.direction;
    if (isShared(cache, query, scattering, point, path)) {
      const GatherSettings search = atRecord(layer, query);
      const Rgb e = cache.at(query.place.index, out.counts, [&](TransportCounts& counts) {
        const RadiusCache::Place& place = layer.cache.place(query.place.index);
        BoundaryCorrection boundary{scene, recordSampler.fork(static_cast<uint32_t>(query.place.index)),
                                    &place.around};
        return irradiance(layer.map, search, place.position, place.normal, place.error,
                          settings.edges ? &boundary : nullptr, counts);
      });
      if (!isBlack(e))
        out.add(LightState(0), path.camera,
                path.throughput * e * scattering.value(wi, point.normalTowards(wi)));
      return search.merging * PI * square(search.radius);
    }
    BoundaryCorrection boundary{scene, sampler.fork(DeltaScatters::MAX_COUNT + 1), query.place.known,
                                query.place.away};
    return gather(layer.map, query.settings, scattering, point, wi, path.ray.width * photons.scale(),
                  path.throughput, path.camera, out, settings.edges ? &boundary : nullptr)
        .merging;
  }

  /** Whether many rays ask for the irradiance at the record near by, and the photons' directions make no
   * difference. */
  bool isShared(const IrradianceCache& cache, const PhotonQuery& query, const ScatteringPoint& scattering,
                const SurfacePoint& point, const PathState& path) const {
    constexpr float NEAR = 0.5f; // of the radius
    const CachedRadius& near = query.place;
    return cache.size() > 0 && path.nonDelta > 0 && near.known &&
           near.away <= NEAR * photons.scale() * near.radius && (scattering.lobes() & LAMBERTIAN) &&
           !(scattering.lobes() & TRANSMISSION) && point.shadingNormal == point.geometricNormal;
  }

  /** How photons are searched at the record itself. */
  GatherSettings atRecord(const PhotonLayer& layer, const PhotonQuery& query) const {
    GatherSettings search = photons.searchWithin(layer, layer.cache.place(query.place.index).radius);
    search.weighedAgainstRays = query.settings.weighedAgainstRays;
    search.merging = query.settings.merging;
    return search;
  }

  /** Paths from records, as those that go on from there. */
  GatherShare::SampleIrradiance irradianceSampler(const Scene& scene, const PathClasses& classes) const {
    return [&](const RadiusCache::Place& place, Sampler& sampler, TransportCounts& counts) {
      SurfacePoint point;
      point.position = place.position;
      point.error = Vec3f(place.error);
      point.geometricNormal = place.normal;
      PathState path;
      path.camera = classes.step(classes.cameraStart(), PathEvent::D);
      path.nonDelta = 1;
      path.throughput = Rgb(PI);
      static_cast<Ray&>(path.ray) =
          spawn(point, Frame(place.normal).toWorld(cosineHemisphere(sampler.next2D())));
      PathRadiance sum(classes, counts);
      Hit hit;
      if (intersectPosition(scene, path.ray, hit, counts) && !hit.areaLight) trace(scene, path, sampler, sum);
      return sum.total().r + sum.total().g + sum.total().b;
    };
  }

  PhotonMappingSettings settings;
  PhotonPass photons;
  LightSampler lights;
  TransportCounts learned; ///< what that took, until it has been told
  GatherShare shares;      ///< at the records of the indirect layer's cache, from the first pass
  /** At the records of the layers, of this pass; empty where no rays go on. */
  IrradianceCache irradiances, causticIrradiances;
  Sampler recordSampler{0, 0, 0};
};

std::vector<EstimatorDomain> PhotonMapping::domains() const {
  const std::string each = "one for each non-delta surface a path meets";
  std::vector<EstimatorDomain> all = {
      {"emission", "LS*E", "none: met by rays through mirrors and glass", "", true}};
  const std::string caustics = settings.directLight ? "LS*DS*E" : "LS+DS*E", indirect = "L(S|D)*DS*DS*E";
  if (!settings.directLight) {
    all.push_back({"shadow rays", "LDS*E",
                   std::to_string(settings.lightSamples) + " for each non-delta surface a path meets",
                   "direct light"});
    all.push_back({"BSDF rays", "LDS*E", each, "direct light", true});
  }
  const bool rays = !settings.directLight || settings.weighting.ever();
  all.push_back({"caustic photons", caustics, "one estimate for each non-delta surface a path meets",
                 rays ? "caustics" : ""});
  if (rays)
    all.push_back({"BSDF rays by mirrors and glass", caustics, "none: the BSDF rays", "caustics", true});
  const bool reads = settings.finalGather <= 0;
  const bool goOn = !reads || settings.weighting.ever() || (settings.finalGather < 0 && settings.passes != 1);
  const char* group = reads && goOn ? "indirect light" : "";
  if (reads) all.push_back({"photon map", indirect, "one estimate for the first non-delta surface", group});
  if (goOn)
    all.push_back(
        {"paths that go on", indirect,
         (reads ? "one" : std::to_string(settings.finalGather)) +
             std::string(" from the first non-delta surface; what arrives is estimated by all of these"),
         group});
  return all;
}

/** Rays that look for the rim of a surface start so far from it, and must fit single precision with scenes of
 * any size. */
constexpr double MAX_RADIUS = 1e17;

PhotonMappingSettings common(const Parameters& p) {
  PhotonMappingSettings s;
  s.radius = p.hasValue("radius") ? p.real("radius") : 0;
  s.maxDepth = p.integer("maxdepth");
  s.directLight = p.string("direct") == "photons";
  s.lightSamples = p.integer("lightsamples");
  s.weightLimit = static_cast<float>(p.real("weightlimit"));
  s.flatness = static_cast<float>(p.real("flatness"));
  s.guided = p.boolean("guided");
  s.edges = p.boolean("edges");
  s.finalGather = p.integer("finalgather");
  s.shareIrradiance = p.boolean("shareirradiance");
  s.weighting = GatherWeighting::belowRoughness(p.real("followroughness"));
  s.kernel = *parseKernel(p.string("kernel"));
  s.index = *parsePhotonIndex(p.string("photonindex"));
  s.alpha = p.real("alpha");
  s.nearest = p.hasValue("gatherphotons") ? p.integer("gatherphotons") : 0;
  return s;
}

std::vector<ParameterSpec> parameters(std::vector<ParameterSpec> more) {
  more.insert(
      more.end(),
      {integerParameter(
           "gatherphotons", "",
           "photons nearest to a point that an estimate uses, in the first pass where there are "
           "many; by default 50 to 100 for one pass, by the width of a pixel; for many 8 to 40, and from "
           "there more or fewer, place by place, as the photons tell of noise and blur; a radius alone "
           "means all photons within it")
           .range(1, 1e6),
       realParameter("alpha", "0.666666667",
                     "how fast the radius of a progressive render shrinks from pass to pass: between 0, at "
                     "once, and 1, never; "
                     "the error falls fastest with 2/3")
           .range(0.01, 1),
       realParameter("radius", "",
                     "radius of the search [scene units]; by default found out from the photons")
           .range(0, MAX_RADIUS)
           .positive(),
       integerParameter("maxdepth", "-1",
                        "most scattering events of an eye path, and of a photon; -1: no limit")
           .range(-1, 1e9),
       stringParameter("direct", "shadowrays",
                       "where direct light comes from: shadow rays, or photons like all other light")
           .oneOf({"shadowrays", "photons"}),
       booleanParameter("guided", "true",
                        "send photons where the eye looks: learned from trial photons, without bias; used "
                        "where that pays"),
       booleanParameter("edges", "true",
                        "divide by the area of what is surface within a search, which rays find out near "
                        "edges, walls and on curved surfaces; false: by the whole disc's, which is darker "
                        "there"),
       integerParameter("lightsamples", "1", "shadow rays at each diffuse surface").range(1, 1e6),
       realParameter(
           "weightlimit", "0.03",
           "both branches at glass are followed while their weights are above this; below, one by roulette")
           .range(1e-6, 1),
       realParameter("flatness", "0.2",
                     "height of the search region over its radius: low keeps light from round "
                     "the corner out, high finds photons on curved surfaces")
           .range(1e-3, 1),
       realParameter("followroughness", "0.2",
                     "rough lobes sharper than that of a metal of this roughness are followed by a ray, as "
                     "mirrors are, though they are D in path classes; broader ones read the photon map; near "
                     "it both share, with weights that add up to one; 0: all read the map")
           .range(0, 10),
       integerParameter("finalgather", "-1",
                        "rays that the first non-delta surface of a path sends to others, which read the "
                        "photon map in its place; there it is only read for caustics. 0: none; -1: a "
                        "progressive render sends one where that errs less than the map")
           .range(-1, 1e5),
       booleanParameter("shareirradiance", "true",
                        "the rays of a final gather read irradiance that is found out once for many of them; "
                        "false: each adds up photons where it ends. Where path classes are asked for, or "
                        "surfaces are not matt and flat, each does so anyway"),
       stringParameter("kernel", "epanechnikov", "how photons count by distance")
           .oneOf({"constant", "cone", "epanechnikov"}),
       stringParameter("photonindex", "kdtree",
                       "index of the photons; flann is slower and there to compare with")
           .oneOf({"kdtree", "flann"})});
  return more;
}

} // namespace

void registerPhotonMapping(PlugIns& plugIns) {
  plugIns.integrators.add(
      {{.name = "photonmap",
        .summary = "Recurse's estimate: emitted light, the photon map at diffuse surfaces, mirror and "
                   "refracted light recursively.",
        .parameters = parameters(
            {integerParameter("photons", "",
                              "photons emitted in each pass, if `passes` is given too; by default 1000000 "
                              "for one pass, and for "
                              "many one for each pixel, from 65536 to 262144. Alone it is the size of one "
                              "classic map, which a "
                              "progressive render does not go by")
                 .range(1, 2e9),
             integerParameter(
                 "passes", "",
                 "photon maps, each with new photons, smaller radius and its share of the samples; 0: "
                 "one for each sample, the default; 1: the classic method with one map")
                 .range(0, 1e9)}),
        .examples = {"",
                     "\"integer passes\" 1 \"integer photons\" 20000 \"string direct\" \"photons\" \"float "
                     "radius\" .1",
                     "\"integer passes\" 1 \"integer photons\" 20000 \"integer finalgather\" 4"}},
       [](const Parameters& p, const NoContext&) {
         PhotonMappingSettings s = common(p);
         s.passes = p.hasValue("passes") ? p.integer("passes") : 0;
         if (p.hasValue("photons") && p.hasValue("passes"))
           s.photons = static_cast<uint64_t>(p.integer("photons"));
         return std::make_unique<PhotonMapping>(s);
       }});
  plugIns.integrators.add(
      {{.name = "sppm",
        .summary =
            "photonmap by the parameters that pbrt files give to sppm: progressive, a pass for each sample.",
        .parameters = parameters(
            {integerParameter("photonsperiteration", "-1",
                              "photons emitted in each pass; -1: one for each pixel, from 65536 to 262144")
                 .range(-1, 2e9),
             integerParameter("photons", "", "the same by photonmap's name").range(1, 2e9),
             ignoredParameter(ParameterType::INTEGER, "seed", "the sampler's seed counts"),
             ignoredParameter(ParameterType::BOOLEAN, "regularize", "not needed")}),
        .examples = {""}},
       [](const Parameters& p, const NoContext&) {
         PhotonMappingSettings s = common(p);
         const int n = p.hasValue("photons") ? p.integer("photons") : p.integer("photonsperiteration");
         s.photons = n > 0 ? static_cast<uint64_t>(n) : 0;
         return std::make_unique<PhotonMapping>(s);
       }});
}

} // namespace recurse
