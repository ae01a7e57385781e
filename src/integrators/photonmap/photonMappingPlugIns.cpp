/** @file
 * photonmap and sppm: the parameters of Recurse's estimate of radiance.
 */
#include <algorithm>

#include "integrators/photonmap/photonMapping.h"
#include "recurse/core/io/text.h"
#include "recurse/model/scene/plugIns.h"
#include "transport/integrator/maxDepthParameter.h"

namespace recurse {

namespace {

/** Maximum search radius [scene units]. Rays that search for the rim of a surface start at this distance,
 * which must fit single precision in scenes of any size. */
constexpr double MAX_RADIUS = 1e17;

// Words of parameters, in the order of the enumerations.
using Words = std::vector<std::string>;
Words kernels() { return {"constant", "cone", "epanechnikov"}; }
Words indices() { return {"kdtree", "flann"}; }
Words mechanisms() {
  return {"nothing", "lightlearning", "shadowopenings", "splitting", "judgedradii", "mergeweights"};
}

template <class Enum> Enum enumeratorOf(const Parameters& p, const char* name, const Words& words) {
  return Enum(std::find(words.begin(), words.end(), p.string(name)) - words.begin());
}

/** Settings that photonmap and sppm share. */
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
  s.kernel = enumeratorOf<Kernel>(p, "kernel", kernels());
  s.index = enumeratorOf<PhotonIndexKind>(p, "photonindex", indices());
  s.alpha = p.real("alpha");
  s.beams = p.string("volumephotons") == "beams";
  s.without = enumeratorOf<Mechanism>(p, "without", mechanisms());
  s.nearest = p.hasValue("gatherphotons") ? p.integer("gatherphotons") : 0;
  return s;
}

std::vector<ParameterSpec> densityEstimateParameters() {
  return {
      integerParameter("gatherphotons", "",
                       "number of nearest photons of a density estimate in the first pass. By default 50 to "
                       "100 for one pass, by the size of a pixel; 8 to 40 for many passes, then adapted to "
                       "local noise and blur. With a radius alone: all photons within it")
          .range(1, 1e6),
      realParameter(
          "alpha", "0.666666667",
          "reduction of the radius in progressive renders: the radius of pass i is about i^((alpha-1)/2) "
          "times the first; between 0 (fastest) and 1 (constant). The error decreases fastest with 2/3")
          .range(0.01, 1),
      realParameter(
          "radius", "",
          "radius of a density estimate [scene units]; by default chosen from the density of photons")
          .range(0, MAX_RADIUS)
          .positive(),
      realParameter("flatness", "0.2",
                    "height of the search region divided by its radius: small values avoid light leaks "
                    "around corners, large values find photons on curved surfaces")
          .range(1e-3, 1),
      booleanParameter("edges", "true",
                       "boundary correction: divide by the area of surface within the radius, which rays "
                       "measure near edges, walls and on curved surfaces, and in media by the enclosed "
                       "volume. false: divide by the whole disc, which darkens edges"),
      stringParameter("kernel", "epanechnikov", "weight of photons by distance").oneOf(kernels()),
      stringParameter("photonindex", "kdtree",
                      "search structure of the photons; flann is slower, and only for comparison")
          .oneOf(indices())};
}

std::vector<ParameterSpec> transportParameters() {
  return {
      maxDepthParameter("a camera path, and of a photon"),
      stringParameter("direct", "shadowrays",
                      "estimator of direct light: shadow rays, or photons as for all other light")
          .oneOf({"shadowrays", "photons"}),
      booleanParameter("guided", "true",
                       "emit photons by a learned mixture of the lights' own sampling and of boxes around "
                       "surfaces and openings that camera paths meet; unbiased"),
      integerParameter("lightsamples", "1", "shadow rays at each diffuse surface").range(1, 1e6),
      realParameter("weightlimit", "0.001",
                    "threshold of ray splitting: at glass, paths follow reflection and refraction while the "
                    "weight of each is larger; else Russian roulette chooses one")
          .range(1e-6, 1),
      stringParameter("volumephotons", "points",
                      "storage of light in media: points of scattering, or photon beams along flights, in "
                      "homogeneous media only; beams are sharper in thin media, and slower")
          .oneOf({"points", "beams"}),
      realParameter("followroughness", "0.2",
                    "roughness threshold: a sharper lobe than that of a metal of this roughness is sampled "
                    "by a ray as for mirrors, although its path class is D; a broader lobe uses the photon "
                    "map, with MIS of both near the threshold. 0: always the photon map")
          .range(0, 10),
      integerParameter("finalgather", "-1",
                       "final gathering: number of rays from the first non-delta surface of a path; the "
                       "photon map is read where they end, and at the first surface for caustics only. 0: "
                       "none; -1: with many passes, one ray where its error is smaller than that of the map")
          .range(-1, 1e5),
      booleanParameter(
          "shareirradiance", "true",
          "final gather rays read cached irradiance; false: each makes a density estimate of its own. Path "
          "classes and surfaces that are not diffuse and flat always use density estimates"),
      stringParameter("without", "nothing",
                      "for studies of one mechanism, switch it off: lights chosen by position, openings for "
                      "shadow rays, splitting of strong photons, radii chosen by error, MIS weights of "
                      "photons and rays")
          .oneOf(mechanisms())};
}

/** Adds the parameters that photonmap and sppm share. */
std::vector<ParameterSpec> parameters(std::vector<ParameterSpec> all) {
  for (const auto& shared : {densityEstimateParameters(), transportParameters()})
    all.insert(all.end(), shared.begin(), shared.end());
  return all;
}

} // namespace

std::vector<ParameterSpec> photonMappingParameters() {
  return parameters(
      {integerParameter(
           "photons", "",
           "number of photons emitted in each pass, if `passes` is set too; by default 1000000 "
           "for one pass, and for many passes one for each pixel, from 65536 to 262144, and up to "
           "4 times as many where few of them are stored. Without `passes` it is the size of a "
           "single map, and a progressive render ignores it")
           .range(1, 2e9),
       integerParameter("passes", "",
                        "number of photon maps, each with new photons, a smaller radius and its part of the "
                        "samples; 0: one for each sample (default); 1: one classic photon map")
           .range(0, 1e9)});
}

PhotonMappingSettings photonMappingSettings(const Parameters& p) {
  PhotonMappingSettings s = common(p);
  if (p.hasValue("passes") && p.integer("passes") > 0) s.passes = Passes::fixed(p.integer("passes"));
  if (p.hasValue("photons") && p.hasValue("passes")) s.photons = static_cast<uint64_t>(p.integer("photons"));
  return s;
}

PhotonMappingSettings onlyCaustics(PhotonMappingSettings settings) {
  settings.causticsOnly = true;
  settings.directLight = false;
  settings.finalGather = -1;
  return settings;
}

void registerPhotonMapping(PlugIns& plugIns) {
  std::vector<ParameterSpec> all = photonMappingParameters();
  all.push_back(booleanParameter(
      "causticsonly", "false",
      "use photons for caustics only; rays find all other light. In media that scatter or emit "
      "light, `path` takes its place"));
  plugIns.integrators.add(
      {{.name = "photonmap",
        .summary = "Photon mapping: emitted light and the photon map at diffuse surfaces; mirrors and glass "
                   "are followed recursively.",
        .parameters = all,
        .examples = {"",
                     "\"integer passes\" 1 \"integer photons\" 20000 \"string direct\" \"photons\" \"float "
                     "radius\" .1",
                     "\"integer passes\" 1 \"integer photons\" 20000 \"integer finalgather\" 4",
                     "\"bool causticsonly\" true"}},
       [](const Parameters& p, const NoContext&) -> std::unique_ptr<Integrator> {
         const PhotonMappingSettings s = photonMappingSettings(p);
         if (!p.boolean("causticsonly")) return std::make_unique<PhotonMapping>(s);
         if (s.directLight)
           p.warn("direct", "with \"causticsonly\", shadow rays always estimate direct light");
         return std::make_unique<PhotonMapping>(onlyCaustics(s));
       }});
  plugIns.integrators.add(
      {{.name = "sppm",
        .summary =
            "photonmap with the parameters of sppm in pbrt files: progressive, one pass for each sample.",
        .parameters =
            parameters({integerParameter("photonsperiteration", "-1",
                                         "number of photons emitted in each pass; -1: one for each pixel, "
                                         "from 65536 to 262144, and up "
                                         "to 4 times as many where few of them are stored")
                            .range(-1, 2e9),
                        integerParameter("photons", "", "the name of \"photons\" in photonmap").range(1, 2e9),
                        ignoredParameter(ParameterType::INTEGER, "seed", "the sampler's seed is used"),
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
