/** @file
 * photonmap and sppm: the parameters of Recurse's estimate of radiance.
 */
#include "integrators/photonmap/photonMapping.h"
#include "recurse/core/io/text.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** Maximum search radius [scene units]. Rays that search for the rim of a surface start at this distance,
 * which must fit single precision in scenes of any size. */
constexpr double MAX_RADIUS = 1e17;

constexpr std::pair<const char*, Mechanism> MECHANISMS[] = {{"nothing", Mechanism::NONE},
                                                            {"lightlearning", Mechanism::LIGHT_LEARNING},
                                                            {"shadowopenings", Mechanism::SHADOW_OPENINGS},
                                                            {"guide", Mechanism::GUIDE},
                                                            {"targets", Mechanism::TARGETS},
                                                            {"portals", Mechanism::PORTALS},
                                                            {"aim", Mechanism::AIM},
                                                            {"sparselight", Mechanism::SPARSE_LIGHT},
                                                            {"splitting", Mechanism::SPLITTING},
                                                            {"judgedradii", Mechanism::JUDGED_RADII},
                                                            {"mergeweights", Mechanism::MERGE_WEIGHTS}};

std::vector<std::string> mechanismNames() {
  std::vector<std::string> names;
  for (const auto& [name, mechanism] : MECHANISMS) names.emplace_back(name);
  return names;
}

/** Parameters that photonmap and sppm share. */
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
  s.beams = p.string("volumephotons") == "beams";
  for (const auto& [name, mechanism] : MECHANISMS)
    if (p.string("without") == name) s.without = mechanism;
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
                        "edges, walls and on curved surfaces, and in media by what lies inside of them; "
                        "false: by the whole disc's, which is darker there"),
       integerParameter("lightsamples", "1", "shadow rays at each diffuse surface").range(1, 1e6),
       realParameter(
           "weightlimit", "0.03",
           "both branches at glass are followed while their weights are above this; below, one by roulette")
           .range(1e-6, 1),
       stringParameter(
           "volumephotons", "points",
           "how light in media is kept: as points where it scatters, or as beams along its "
           "flights, which only homogeneous media have; in thin ones beams show finer detail, and "
           "take longer")
           .oneOf({"points", "beams"}),
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
           .oneOf({"kdtree", "flann"}),
       stringParameter(
           "without", "nothing",
           "for studies of what a mechanism earns, leave one out: lights chosen by place, openings for "
           "shadow "
           "rays, learned emission of photons, spheres that they are sent to, openings that they start at, "
           "aim "
           "of far lamps, sparse light left to rays, splitting of strong photons, radii by judged errors, "
           "weights of photons against rays")
           .oneOf(mechanismNames())});
  return more;
}

} // namespace

std::vector<ParameterSpec> photonMappingParameters() {
  return parameters(
      {integerParameter("photons", "",
                        "photons emitted in each pass, if `passes` is given too; by default 1000000 "
                        "for one pass, and for "
                        "many one for each pixel, from 65536 to 262144. Alone it is the size of one "
                        "classic map, which a "
                        "progressive render does not go by")
           .range(1, 2e9),
       integerParameter("passes", "",
                        "photon maps, each with new photons, smaller radius and its share of the samples; 0: "
                        "one for each sample, the default; 1: the classic method with one map")
           .range(0, 1e9)});
}

PhotonMappingSettings photonMappingSettings(const Parameters& p) {
  PhotonMappingSettings s = common(p);
  if (p.hasValue("passes") && p.integer("passes") > 0) s.passes = Passes::fixed(p.integer("passes"));
  if (p.hasValue("photons") && p.hasValue("passes")) s.photons = static_cast<uint64_t>(p.integer("photons"));
  return s;
}

void registerPhotonMapping(PlugIns& plugIns) {
  std::vector<ParameterSpec> all = photonMappingParameters();
  all.push_back(booleanParameter(
      "causticsonly", "false", "photons of caustics only, beside a path tracer that brings all other light"));
  plugIns.integrators.add(
      {{.name = "photonmap",
        .summary = "Recurse's estimate: emitted light, the photon map at diffuse surfaces, mirror and "
                   "refracted light recursively.",
        .parameters = all,
        .examples = {"",
                     "\"integer passes\" 1 \"integer photons\" 20000 \"string direct\" \"photons\" \"float "
                     "radius\" .1",
                     "\"integer passes\" 1 \"integer photons\" 20000 \"integer finalgather\" 4",
                     "\"bool causticsonly\" true"}},
       [](const Parameters& p, const NoContext&) -> std::unique_ptr<Integrator> {
         const PhotonMappingSettings s = photonMappingSettings(p);
         if (!p.boolean("causticsonly")) return makePhotonMapping(s);
         if (s.directLight)
           p.warn("direct", "shadow rays bring direct light beside photons of caustics only");
         return makeCausticPaths(s);
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
         return makePhotonMapping(s);
       }});
}

} // namespace recurse
