/** @file
 * Recurse's estimate of radiance: emitted light, plus the photon map's estimate at diffuse surfaces, plus
 * mirror and refracted light, recursively. Direct light comes from shadow rays, or from the map like
 * everything else. Sharp rough lobes are followed too, and share the light with the map (lobeSharing.h).
 */
#include <algorithm>
#include <chrono>

#include "recurse/core/text.h"
#include "recurse/model/plugIns.h"
#include "recurse/transport/directLight.h"
#include "recurse/transport/placeIrradiance.h"
#include "recurse/transport/searchChoice.h"
#include "recurse/transport/searchField.h"
#include "recurse/transport/shoot.h"

namespace recurse {

namespace {

struct PhotonMappingSettings {
  uint64_t photons = 0; ///< in each pass; 0: chosen
  int passes = 0;       ///< see Integrator::passes; -1: left to the number of samples
  double alpha = 0;     ///< see radiusScale
  int nearest = 0;      ///< 0: all photons within the radius, or chosen where there is none
  double radius = 0;    ///< 0: found out from the photons' density
  int maxDepth = -1;
  bool shadowRays = true, guided = true;
  bool edges = true; ///< estimates know where surfaces end
  int lightSamples = 1;
  bool shareIrradiance = true; ///< a final gather reads irradiance found out once near each place
  int finalGather = 0; ///< rays from the first diffuse surface of an eye path; 0: it reads the map itself
  float weightLimit = 0.03f;
  float flatness = 0.2f;
  LobeSharing sharing;
  Kernel kernel = Kernel::EPANECHNIKOV;
  PhotonIndexKind index = PhotonIndexKind::KDTREE;
};

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class PhotonMapping final : public Integrator {
 public:
  explicit PhotonMapping(const PhotonMappingSettings& settings) : settings(settings) {}

  int passes(int samplesPerPixel) const override {
    if (settings.passes >= 0) return settings.passes;
    return samplesPerPixel > 0 ? 1 : 0;
  }

  void prepare(const Scene& scene, const PathClasses&) override {
    if (settings.shadowRays) lights.learn(scene);
  }

  ForwardStatistics forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                            const ForwardControl& control) override {
    ForwardStatistics statistics;
    progressive = !pass.only;
    atPlaces = Sampler(pass.seed, pass.index, 0);
    scale = radiusScale(pass.index, settings.alpha);
    auto start = std::chrono::steady_clock::now();
    ShootSettings shoot;
    shoot.photons = settings.photons;
    if (shoot.photons == 0)
      shoot.photons = progressive ? std::max(uint64_t(scene.film().width) * uint64_t(scene.film().height),
                                             LEAST_PROGRESSIVE_PHOTONS)
                                  : ONE_MAP_PHOTONS;
    shoot.maxDepth = settings.maxDepth;
    shoot.direct = !settings.shadowRays;
    if (pass.index == 0) {
      guidance = {};
      if (settings.guided && settings.finalGather == 0) // what a final gather reads lies all over the scene
        guidance = learn(scene, classes, pass.seed, shoot, control, statistics);
    }
    shoot.guide = &guidance.emission;
    shoot.targets = guidance.targets;
    ShotPhotons shot = shootPhotons(scene, classes, pass, shoot, control);
    statistics.counts = shot.counts;
    statistics.photonsEmitted = shot.emitted;
    statistics.photonsStored = shot.stored.size();
    statistics.shootSeconds = secondsSince(start);
    start = std::chrono::steady_clock::now();
    map.build(shot.stored, settings.index);
    if (settings.finalGather > 0) {
      std::vector<Photon> some;
      std::copy_if(shot.stored.begin(), shot.stored.end(), std::back_inserter(some),
                   [](const Photon& p) { return p.caustic; });
      caustics.build(some, settings.index);
    }
    statistics.photonsRefused = map.refused();
    statistics.balanceSeconds = secondsSince(start);
    statistics.mapBytes = map.memoryBytes() + caustics.memoryBytes();
    if (pass.index == 0) {
      const GatherSettings wished{
          settings.kernel, settings.nearest, static_cast<float>(settings.radius), settings.flatness, {}};
      choice = chooseSearch(scene, map, probeEye(scene, 24, 0, settings.sharing, statistics.counts), wished,
                            progressive, !settings.shadowRays, statistics);
      if (progressive || settings.edges) {
        // Dark places have hardly any photons that would tell of them.
        const double across = std::sqrt(double(scene.film().crop.area())) / 4;
        const std::vector<SeenPlace> seen = probeEye(scene, static_cast<int>(std::clamp(across, 4.0, 128.0)),
                                                     2, settings.sharing, statistics.counts);
        const bool judged = progressive && settings.nearest == 0 && settings.radius == 0;
        for (const auto& [known, photons] : {std::pair(&field, &map), std::pair(&causticField, &caustics)})
          known->build(scene, *photons, seen, choice.settings, judged ? settings.alpha : 0,
                       statistics.counts);
      }
    }
    const bool alike = classes.lightStateCount() == 1; // otherwise some photons count and some do not
    shared.reset(settings.finalGather > 0 && settings.shareIrradiance && alike ? field.size() : 0);
    return statistics;
  }

  void backward(const Scene& scene, const EyeRay& ray, Sampler& sampler, PathRadiance& out) const override {
    trace(scene,
          {.ray = ray,
           .throughput = Rgb(1),
           .etaScale = 1,
           .eye = out.pathClasses().eyeStart(),
           .depth = 0,
           .nesting = nestingAt(scene, ray, out.counts)},
          nullptr, sampler, out);
  }

  std::vector<EstimatorDomain> domains() const override {
    const std::string rays = std::to_string(settings.lightSamples);
    const bool gathers = settings.finalGather > 0;
    std::vector<EstimatorDomain> all = {
        {"emission", "LS*E", "none: met by eye rays through mirrors and glass", ""}};
    if (settings.shadowRays) {
      all.push_back(
          {"shadow rays", "LDS*E", rays + " for each diffuse surface an eye ray meets", "direct light"});
      all.push_back({"BSDF rays", "LDS*E",
                     gathers ? "those of the final gather" : "one for each diffuse surface an eye ray meets",
                     "direct light"});
    }
    if (gathers) {
      all.push_back({"caustic photons", settings.shadowRays ? "LS+DS*E" : "LS*DS*E",
                     "one estimate for each diffuse surface an eye ray meets", ""});
      all.push_back({"final gather", "L(S|D)*DS*DS*E",
                     std::to_string(settings.finalGather) +
                         " rays for each diffuse surface an eye ray meets; what they meet is estimated by "
                         "shadow rays and photon map",
                     ""});
      return all;
    }
    const std::string indirect = settings.shadowRays ? "L(S|D)+DS*E" : "L(S|D)*DS*E";
    const std::string group = settings.sharing.ever() ? "rough lobes" : "";
    all.push_back({"photon map", indirect, "one estimate for each diffuse surface an eye ray meets", group});
    if (settings.sharing.ever())
      all.push_back({"followed lobes", indirect,
                     "the BSDF ray goes on where a lobe is sharp; what arrives is estimated by all of these",
                     group});
    return all;
  }

 private:
  // One map for the whole picture has to be good by itself; of many maps the mean has to be, and quickly
  // many.
  static constexpr uint64_t ONE_MAP_PHOTONS = 1000000, LEAST_PROGRESSIVE_PHOTONS = 65536;
  /** An eye path on its way. */
  struct Walk {
    EyeRay ray;
    Rgb throughput;
    float etaScale; ///< undoes the 1/η² inside glass
    EyeState eye;
    int depth;                ///< scattering events so far
    bool gathers = true;      ///< the first diffuse surface may send a final gather
    bool lightCounts = true;  ///< emission that is met; false where photons bring it
    float gatherDistance = 0; ///< of the final gather's ray, to its first surface
    Nesting nesting{};
    LitPlace place{}; ///< the last diffuse surface, where lights were sampled
  };

  /** Follows an eye ray through mirrors and glass: every branch while it is worth it, one by roulette after.
   * `met` is what the ray is known to meet, whose emission has been dealt with; or null. */
  void trace(const Scene& scene, Walk walk, const Hit* met, Sampler& sampler, PathRadiance& out) const {
    const PathClasses& classes = out.pathClasses();
    Hit hit;
    BsdfArena arena;
    for (;; met = nullptr) {
      EyeRay& ray = walk.ray;
      Rgb& throughput = walk.throughput;
      EyeState& eye = walk.eye;
      int& depth = walk.depth;
      Nesting& nesting = walk.nesting;
      if (met) {
        hit = *met;
      } else {
        if (!intersect(scene, ray, hit, out.counts)) {
          if (!scene.environment().empty() && walk.lightCounts)
            out.add(classes.lightStart(), eye,
                    throughput *
                        environmentRadiance(scene, lights, ray.direction, {}, settings.lightSamples));
          return;
        }
        if (hit.areaLight && walk.lightCounts)
          out.add(classes.lightStart(), eye,
                  throughput * emittedRadiance(scene, lights, hit, ray.direction, {}, settings.lightSamples));
      }
      ray.width += ray.spread * hit.t;
      arena.reset();
      const Bsdf* bsdf = bsdfAt(scene, hit, ray.direction, footprint(ray), nesting, arena);
      if (!bsdf) {
        static_cast<Ray&>(ray) = spawn(hit.point, ray.direction);
        continue;
      }
      if (depth == settings.maxDepth) {
        out.counts.weightCut += double(maxComponent(throughput));
        return;
      }
      ++depth;
      const ScatteringPoint scattering(*bsdf, hit.point);
      const Vec3f wi = -ray.direction;
      const EyeState eyeD = classes.step(eye, PathEvent::D);
      if (scattering.hasDiffuse() && !classes.dead(eyeD)) {
        Walk diffuse = walk;
        diffuse.eye = eyeD;
        if (settings.shadowRays) diffuse.place = litPlace(lights, hit.point, wi);
        if (settings.shadowRays)
          addSampledLight(scene, lights, diffuse.place, scattering, hit, nesting, wi, throughput, eyeD,
                          settings.lightSamples, DIFFUSE_LOBES, sampler, out);
        Search here = searchAt(field, hit.point, wi);
        // A surface that a gather ray finds close by is not seen through a map that is blurred over more than
        // the distance: it gathers for itself.
        const bool close = !walk.gathers && walk.gatherDistance > 0 &&
                           walk.gatherDistance < (progressive ? here.settings.radius : choice.typicalRadius);
        if (settings.finalGather > 0 && (walk.gathers || close)) {
          const int rays = walk.gathers ? settings.finalGather : 1;
          for (int i = 0; i < rays; ++i) {
            Sampler branch = sampler.fork(DeltaScatters::MOST + 2 + static_cast<uint32_t>(i));
            gatherRay(scene, scattering, hit, diffuse, 1 / static_cast<float>(rays), branch, out);
          }
          estimate(scene, caustics, searchAt(causticField, hit.point, wi), scattering, hit.point, diffuse,
                   sampler, out);
        } else {
          here.settings.sharing = settings.sharing;
          followLobe(scene, scattering, hit, diffuse, sampler, out);
          if (!addShared(scene, here.place, scattering, hit.point, diffuse, out))
            estimate(scene, map, here, scattering, hit.point, diffuse, sampler, out);
        }
      }
      eye = classes.step(eye, PathEvent::S);
      if (!scattering.hasDelta() || classes.dead(eye)) return;

      std::array<Scatter, DeltaScatters::MOST> all;
      const int count = scattering.deltaScatters(wi, Transport::RADIANCE, all);
      float worth[DeltaScatters::MOST], total = 0, least = INFINITE;
      for (int i = 0; i < count; ++i) {
        const Scatter& s = all[size_t(i)];
        worth[i] = maxComponent(throughput * s.weight) * square(s.eta) * walk.etaScale;
        total += worth[i];
        if (worth[i] > 0) least = std::min(least, worth[i]);
      }
      if (!(total > 0)) return;
      int next = 0;
      if (least >= settings.weightLimit && depth <= LONG_WALK) {
        for (int i = 1; i < count; ++i) {
          Sampler branch = sampler.fork(static_cast<uint32_t>(i));
          trace(scene, after(walk, hit, all[size_t(i)]), nullptr, branch, out);
        }
      } else {
        float u = count > 1 ? sampler.next1D() * total : 0;
        while (next + 1 < count && u >= worth[next]) u -= worth[next++];
        if (!(worth[next] > 0)) return;
        throughput *= total / worth[next];
        // A long walk by its full weight: it may be thousands of events from falling below the limit.
        const float chance = depth > LONG_WALK ? total : total / settings.weightLimit;
        if (!survives(std::min(1.0f, chance), depth, sampler, throughput)) return;
      }
      walk = after(walk, hit, all[size_t(next)]);
    }
  }

  static Walk after(Walk walk, const Hit& hit, const Scatter& s) {
    walk.nesting.scatters(hit, -walk.ray.direction, s.direction);
    walk.throughput *= s.weight;
    walk.etaScale *= square(s.eta);
    static_cast<Ray&>(walk.ray) = spawn(hit.point, s.direction);
    return walk;
  }

  /**
   * One ray by the non-delta lobes of a point. It may meet a light, which shadow rays look for as well
   * (LDS*E, with the weight that they leave). Where the lobe is sharp the walk goes on from what the ray
   * meets, with the weight that the photon map leaves at the point; `walk` has read the D there.
   */
  void followLobe(const Scene& scene, const ScatteringPoint& scattering, const Hit& from, const Walk& walk,
                  Sampler& sampler, PathRadiance& out) const {
    const bool looksForLight = settings.shadowRays && mayMeetLight(scene, walk.eye, out);
    const bool mayFollow = settings.sharing.ever() && !(scattering.lobes() & LAMBERTIAN);
    if (!looksForLight && !mayFollow) return;
    const std::optional<Scatter> s =
        scattering.scatterDiffuse(-walk.ray.direction, Transport::RADIANCE, sampler);
    if (!s) return;
    const float share = mayFollow ? settings.sharing.followed(s->pdf) : 0;
    if (!looksForLight && share == 0) return;
    Walk next = after(walk, from, *s);
    next.gathers = false;
    next.lightCounts = true;
    next.gatherDistance = 0;
    Hit hit;
    // Without shadow rays the photon map has direct light too, and the ray its share of that.
    if (!meetSurface(scene, next, {walk.place, s->pdf, settings.shadowRays}, settings.shadowRays ? 1 : share,
                     hit, out) ||
        share == 0)
      return;
    next.throughput *= share;
    if (!survives(std::min(1.0f, maxComponent(next.throughput) * next.etaScale / settings.weightLimit),
                  next.depth, sampler, next.throughput))
      return;
    Sampler branch = sampler.fork(DeltaScatters::MOST);
    trace(scene, next, &hit, branch, out);
  }

  /**
   * A ray of a final gather, with the part `share` of all there are at the point. It brings light of at least
   * two diffuse surfaces (L(S|D)*DS*DS*E) and, together with shadow rays, direct light; what comes from a
   * light by mirrors and glass is for the caustic photons.
   */
  void gatherRay(const Scene& scene, const ScatteringPoint& scattering, const Hit& from, const Walk& walk,
                 float share, Sampler& sampler, PathRadiance& out) const {
    const std::optional<Scatter> s =
        scattering.scatterDiffuse(-walk.ray.direction, Transport::RADIANCE, sampler);
    if (!s) return;
    Walk next = after(walk, from, *s);
    next.throughput *= share;
    next.gathers = next.lightCounts = false;
    Hit hit;
    if (!meetSurface(scene, next, {walk.place, s->pdf, settings.shadowRays}, settings.shadowRays ? 1 : 0, hit,
                     out))
      return;
    next.gatherDistance = glm::length(hit.point.position - from.point.position);
    const float worth = maxComponent(next.throughput) * next.etaScale / (settings.weightLimit * share);
    if (next.depth > LONG_WALK || worth < 1)
      if (!survives(std::min(1.0f, worth), next.depth, sampler, next.throughput)) return;
    trace(scene, next, &hit, sampler, out);
  }

  bool mayMeetLight(const Scene& scene, EyeState eye, const PathRadiance& out) const {
    const PathClasses& classes = out.pathClasses();
    return scene.contents().areaLights + scene.contents().environmentLights > 0 &&
           classes.join(classes.lightStart(), eye) != 0;
  }

  /** Follows the ray of `next` to a surface that scatters; false where there is none. Adds the part `counts`
   * of the light met on the way, with the weight that shadow rays leave to the ray. */
  bool meetSurface(const Scene& scene, Walk& next, const BsdfRay& own, float counts, Hit& hit,
                   PathRadiance& out) const {
    const PathClasses& classes = out.pathClasses();
    const Rgb direct = next.throughput * counts;
    next.ray.width = next.ray.spread = 0; // what a pixel sees from here on is not known
    for (;;) {
      if (!intersect(scene, next.ray, hit, out.counts)) {
        if (!scene.environment().empty() && counts > 0)
          out.add(classes.lightStart(), next.eye,
                  direct *
                      environmentRadiance(scene, lights, next.ray.direction, own, settings.lightSamples));
        return false;
      }
      if (hit.areaLight && counts > 0)
        out.add(classes.lightStart(), next.eye,
                direct * emittedRadiance(scene, lights, hit, next.ray.direction, own, settings.lightSamples));
      if (hit.material && hit.material->lobes() != NO_LOBE) return true;
      static_cast<Ray&>(next.ray) = spawn(hit.point, next.ray.direction); // a lamp without a body
    }
  }

  /** How photons are searched at a point. */
  struct Search {
    GatherSettings settings;
    SearchPlace place;
  };
  /** The only pass looks for the nearest photons, or within the radius it was given. One of many takes the
   * radius that the first pass found thereabouts, shrunk: its own photons have no say in it. */
  Search searchAt(const SearchField& known, const SurfacePoint& point, const Vec3f& wi) const {
    Search here{choice.settings, {}};
    if (!progressive && !settings.edges) return here;
    here.place = known.at(point.position, point.normalTowards(wi));
    if (progressive) here.settings = shrunk(here.place.radius);
    return here;
  }
  GatherSettings shrunk(float radius) const {
    GatherSettings now = choice.settings;
    now.nearest = 0;
    if (choice.settings.nearest > 0) now.radius = radius;
    now.radius *= scale;
    return now;
  }
  /** Adds what the photon map has at a place near by, of which many rays ask; false where there is none, or
   * where the photons' directions make a difference. `walk` has read the D at the point. */
  bool addShared(const Scene& scene, const SearchPlace& near, const ScatteringPoint& scattering,
                 const SurfacePoint& point, const Walk& walk, PathRadiance& out) const {
    constexpr float NEAR = 0.5f; // of the radius
    if (shared.size() == 0 || walk.gathers || !near.known || near.away > NEAR * scale * near.radius)
      return false;
    if (!(scattering.lobes() & LAMBERTIAN) || (scattering.lobes() & TRANSMISSION)) return false;
    if (point.shadingNormal != point.geometricNormal) return false;
    const Rgb e = shared.at(near.index, out.counts, [&](TransportCounts& counts) {
      const SearchField::Place& place = field.place(near.index);
      Surroundings surroundings{scene, atPlaces.fork(static_cast<uint32_t>(near.index)), &place.around};
      return irradiance(map, progressive ? shrunk(place.radius) : choice.settings, place.position,
                        place.normal, place.error, settings.edges ? &surroundings : nullptr, counts);
    });
    const Vec3f wi = -walk.ray.direction;
    if (!isBlack(e))
      out.add(LightState(0), walk.eye, walk.throughput * e * scattering.value(wi, point.normalTowards(wi)));
    return true;
  }
  /** Adds what a photon map has at a point; `walk` has read the D there. */
  void estimate(const Scene& scene, const PhotonMap& photons, const Search& here,
                const ScatteringPoint& scattering, const SurfacePoint& point, const Walk& walk,
                const Sampler& sampler, PathRadiance& out) const {
    Surroundings surroundings{scene, sampler.fork(DeltaScatters::MOST + 1), here.place.known,
                              here.place.away};
    gather(photons, here.settings, scattering, point, -walk.ray.direction, walk.ray.width * scale,
           walk.throughput, walk.eye, out, settings.edges ? &surroundings : nullptr);
  }

  /** Where photons should start, so that they come down where the eye looks. */
  PhotonGuidance learn(const Scene& scene, const PathClasses& classes, uint64_t seed,
                       const ShootSettings& shoot, const ForwardControl& control,
                       ForwardStatistics& statistics) const {
    constexpr int PROBES = 96;
    const float spacing = std::sqrt(float(scene.film().crop.area())) / PROBES;
    VisibleRegion region;
    for (const SeenPlace& place : probeEye(scene, PROBES, 1, settings.sharing, statistics.counts))
      if (place.footprint > 0) region.add(place.point.position, place.footprint * std::max(spacing, 2.0f));
    PhotonGuidance learned = learnGuidance(scene, classes, seed, shoot, region, control, statistics.counts);
    if (learned.emission.active())
      statistics.notes.push_back(
          formatted("photons: sent where the eye looks, each worth %.3g times what it is worth without",
                    learned.emission.gain()));
    if (!learned.targets.empty())
      statistics.notes.push_back(
          formatted("photons: matt surfaces send more of them to %zu spheres where the eye looks",
                    learned.targets.size()));
    return learned;
  }

  PhotonMappingSettings settings;
  PhotonMap map, caustics;         ///< caustics: only with final gathering
  SearchChoice choice;             ///< from the first pass
  SearchField field, causticField; ///< from the first pass, for all
  PhotonGuidance guidance;         ///< learned before the first pass, for all
  LightGuide lights;
  PlaceIrradiance shared; ///< at the places of `field`, of this pass; empty unless final gathers use it
  bool progressive = false;
  Sampler atPlaces{0, 0, 0};
  float scale = 1; ///< radius of this pass over that of the first
};

PhotonMappingSettings common(const Parameters& p) {
  PhotonMappingSettings s;
  s.radius = p.hasValue("radius") ? p.real("radius") : 0;
  s.maxDepth = p.integer("maxdepth");
  s.shadowRays = p.string("direct") == "shadowrays";
  s.lightSamples = p.integer("lightsamples");
  s.weightLimit = static_cast<float>(p.real("weightlimit"));
  s.flatness = static_cast<float>(p.real("flatness"));
  s.guided = p.boolean("guided");
  s.edges = p.boolean("edges");
  s.finalGather = p.integer("finalgather");
  s.shareIrradiance = p.boolean("shareirradiance");
  s.sharing = LobeSharing::belowRoughness(p.real("followroughness"));
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
       integerParameter("finalgather", "0",
                        "rays that the first diffuse surface of an eye path sends to others, which read the "
                        "photon map in its place; there it is only read for caustics. Slower, and free of "
                        "blotches with few photons; 0: none")
           .range(0, 1e5),
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
            {integerParameter(
                 "photons", "",
                 "photons emitted in each pass; by default 1000000 for one pass, one for each pixel for many")
                 .range(1, 2e9),
             integerParameter(
                 "passes", "",
                 "photon maps, each with new photons, smaller radius and its share of the samples; 0: "
                 "one for each sample (default: 1, or with a time limit alone 0)")
                 .range(0, 1e9)}),
        .examples = {"", "\"integer photons\" 20000 \"string direct\" \"photons\" \"float radius\" .1",
                     "\"integer photons\" 20000 \"integer finalgather\" 4"}},
       [](const Parameters& p, const NoContext&) {
         PhotonMappingSettings s = common(p);
         if (p.hasValue("photons")) s.photons = static_cast<uint64_t>(p.integer("photons"));
         s.passes = p.hasValue("passes") ? p.integer("passes") : -1;
         return std::make_unique<PhotonMapping>(s);
       }});
  plugIns.integrators.add(
      {{.name = "sppm",
        .summary =
            "photonmap by the parameters that pbrt files give to sppm: progressive, a pass for each sample.",
        .parameters = parameters(
            {integerParameter("photonsperiteration", "-1",
                              "photons emitted in each pass; -1: one for each pixel, at least 65536")
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
