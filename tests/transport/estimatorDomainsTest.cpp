/** @file
 * Assignment of paths to estimators: the domains of every integrator with every combination of its options
 * are disjoint and cover all paths that it claims, and weights of estimators that share paths sum to one.
 */
#include "classRendering.h"

#include "recurse/transport/integrator/estimatorDomains.h"
#include "transport/direct/directLight.h"
#include "transport/learning/lightLearning.h"
#include "transport/weights/gatherWeighting.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Paths that the domains must cover: the claims of the integrator, with paths in media if it estimates any
 * of these. */
std::string whatToCover(const Integrator& integrator) {
  if (const std::string claims = integrator.claims(); !claims.empty()) return claims;
  const std::vector<EstimatorDomain> domains = integrator.domains();
  const PathAutomaton surface = PathAutomaton::compile("surface");
  for (const EstimatorDomain& d : domains)
    if (!PathAutomaton::compile(d.expression).subsetOf(surface)) return "all";
  return "surface";
}

std::string nameOf(const Way& way) { return way.integrator + way.parameters; }

/** All ways without those whose domains and paths to cover are the same as for an earlier one. */
std::vector<Way> waysWithDistinctDomains() {
  std::vector<Way> ways;
  std::set<std::string> known;
  for (const Way& way : everyWay()) {
    const auto integrator = integratorFrom(way.integrator, way.parameters);
    std::string domains = whatToCover(*integrator) + "\n";
    for (const EstimatorDomain& d : integrator->domains())
      domains +=
          d.estimator + "\t" + d.expression + "\t" + d.sharedGroup + (d.onlyPanes ? "\tonly panes\n" : "\n");
    if (known.insert(domains).second) ways.push_back(way);
  }
  return ways;
}

} // namespace

TEST(EstimatorDomains, AreDisjointAndCoverAllPathsWhateverTheOptions) {
  size_t combinations = 0;
  for (const Way& way : everyWay()) {
    const auto integrator = integratorFrom(way.integrator, way.parameters);
    const DomainReport report = checkDomains(integrator->domains(), whatToCover(*integrator));
    EXPECT_TRUE(report.sound()) << nameOf(way) << "\n" << report.text();
    ++combinations;
  }
  // Options are included, not only integrators.
  EXPECT_GT(combinations, plugIns().integrators.entries().size());
}

TEST(EstimatorDomains, LobesAreSharedOnlyWhereTheyAreFollowed) {
  const auto shared = integratorFrom("photonmap", "\"integer passes\" 1")->domains();
  const auto alone =
      integratorFrom("photonmap", "\"integer passes\" 1 \"float followroughness\" 0")->domains();
  EXPECT_EQ(shared.back().estimator, "continued paths");
  EXPECT_EQ(shared.size(), alone.size() + 1);
  EXPECT_EQ(shared.back().expression,
            alone.back().expression); // paths that the map leaves to rays, a subset of its paths
  EXPECT_TRUE(alone.back().sharedGroup.empty());
  EXPECT_TRUE(checkDomains(alone, "surface").sound());
}

TEST(GatherWeighting, WeightsAddUpToOneAndChangeWithoutSteps) {
  EXPECT_FALSE(GatherWeighting::belowRoughness(0).ever());
  EXPECT_EQ(GatherWeighting().followed(1e30f), 0);
  for (const double alpha : {1e-3, 0.2, 1.0}) {
    const GatherWeighting s = GatherWeighting::belowRoughness(alpha);
    // Lobe of a metal of this roughness in the direction of the normal: D / 4 at its centre.
    EXPECT_NEAR(s.density * 4 * M_PI * alpha * alpha, 1, 1e-5);
    EXPECT_NEAR(s.followed(s.density), 0.5, 1e-6);
    float before = 0;
    for (double e = -3; e <= 3; e += 1 / 64.) {
      const float pdf = s.density * float(std::exp2(e)), w = s.followed(pdf);
      EXPECT_EQ(w + s.gathered(pdf), 1);
      EXPECT_GE(w, before);
      EXPECT_LT(w, before + 0.02f);
      if (e <= -1) {
        EXPECT_EQ(w, 0);
      }
      if (e >= 1) {
        EXPECT_EQ(w, 1);
      }
      before = w;
    }
  }
}

/** Partition by set algebra on the automata, independent of the code that explains the findings. */
TEST(EstimatorDomains, PartitionByAutomata) {
  for (const Way& way : waysWithDistinctDomains()) {
    const auto integrator = integratorFrom(way.integrator, way.parameters);
    const std::vector<EstimatorDomain> domains = integrator->domains();
    PathAutomaton covered = PathAutomaton::compile("S", PathAutomaton::Empty::ALLOWED);
    ASSERT_TRUE(covered.isEmpty());
    for (size_t i = 0; i < domains.size(); ++i) {
      const PathAutomaton paths = PathAutomaton::compile(domains[i].expression);
      for (size_t j = 0; j < i; ++j) {
        if (!domains[i].sharedGroup.empty() && domains[i].sharedGroup == domains[j].sharedGroup) continue;
        EXPECT_TRUE(paths.intersect(PathAutomaton::compile(domains[j].expression)).isEmpty())
            << nameOf(way) << ": " << domains[i].estimator << " and " << domains[j].estimator;
      }
      if (!domains[i].onlyPanes) covered = covered.unite(paths);
    }
    EXPECT_TRUE(PathAutomaton::compile(whatToCover(*integrator)).subsetOf(covered)) << nameOf(way);
  }
}

TEST(EstimatorDomains, EstimatorsOfPanesAloneCoverNothing) {
  std::vector<EstimatorDomain> domains = {{"emission", "LS*E", "", ""},
                                          {"shadow rays", "LD(S|D)*E", "", ""},
                                          {"shadow rays through panes", "LS+D(S|D)*E", "", ""}};
  EXPECT_TRUE(checkDomains(domains, "surface").sound());
  domains.back().onlyPanes = true;
  const DomainReport report = checkDomains(domains, "surface");
  EXPECT_TRUE(report.overlaps.empty());
  EXPECT_FALSE(report.uncovered.empty());
  EXPECT_EQ(report.uncoveredExpression, missedOfDeltaLights(domains));
  domains.push_back(domains.front());
  domains.back().expression = "LS+DE";
  EXPECT_EQ(checkDomains(domains, "surface").overlaps.size(), 1u); // overlap with the estimator of panes
}

/** The check of soundness is not vacuous: it rejects every list with a single defect. */
TEST(EstimatorDomains, SpoiltListsAreFoundOut) {
  for (const Way& way : waysWithDistinctDomains()) {
    const auto integrator = integratorFrom(way.integrator, way.parameters);
    const std::vector<EstimatorDomain> domains = integrator->domains();
    const std::string covers = whatToCover(*integrator);
    for (size_t i = 0; i < domains.size(); ++i) {
      std::vector<EstimatorDomain> twice = domains;
      twice.push_back(domains[i]);
      twice.back().sharedGroup = "";
      EXPECT_FALSE(checkDomains(twice, covers).overlaps.empty()) << nameOf(way) << domains[i].estimator;
      if (!domains[i].sharedGroup.empty()) continue;
      std::vector<EstimatorDomain> fewer = domains;
      fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
      EXPECT_FALSE(checkDomains(fewer, covers).uncovered.empty()) << nameOf(way) << domains[i].estimator;
    }
  }
}

namespace {

/** A room with furniture, and the given lights. */
std::string roomWith(const std::string& lights) {
  return view(16, "0 0 3  0 0 0  0 1 0", 60) + R"(
MakeNamedMaterial "paint" "string type" "diffuse" "rgb reflectance" [ .2 .5 .3 ]
MakeNamedMaterial "steel" "string type" "conductor" "rgb reflectance" [ .7 .7 .8 ]
MakeNamedMaterial "both" "string type" "mix" "string materials" [ "paint" "steel" ] "float amount" .4
Material "diffuse" "rgb reflectance" [ .6 .5 .4 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 -1 -2  2 -1 -2  2 -1 2  -2 -1 2 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 -1 -1  -2 1 -1  2 1 -1  2 -1 -1 ]
AttributeBegin
NamedMaterial "both"
Translate .5 -.5 0
Shape "sphere" "float radius" .3
AttributeEnd
AttributeBegin
Material "conductor" "rgb reflectance" [ .9 .9 .9 ]
Translate -.6 -.6 .2
Shape "sphere" "float radius" .3
AttributeEnd
)" + lights;
}

struct LitRoom {
  std::string name, lights;
};

const std::vector<LitRoom>& litRooms() {
  static const std::string mesh = R"(
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 5 4 3 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ]
  "point3 P" [ -1.5 .9 -.9  1.7 .6 -.9  1.4 .9 1.4  -1.5 .9 1.5 ]
AttributeEnd
)",
                           sphere = R"(
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 9 2 1 ]
Translate -.6 .5 .3
Shape "sphere" "float radius" .8
AttributeEnd
)",
                           disk = R"(
AttributeBegin
Material "interface"
AreaLightSource "diffuse" "rgb L" [ 3 6 3 ] "bool twosided" true
Translate .9 .2 0 Rotate 60 0 1 0 Scale 1 .6 1
Shape "disk" "float radius" .9
AttributeEnd
)",
                           patch = R"(
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 2 2 8 ]
Shape "bilinearmesh" "point3 P" [ -1.6 .9 -.6  -.1 1.2 -.5  -1.7 -.7 1.3  0 .9 1.2 ]
AttributeEnd
)",
                           instances = R"(
ObjectBegin "lamp"
AreaLightSource "diffuse" "rgb L" [ 4 4 4 ]
Shape "sphere" "float radius" .3
ObjectEnd
AttributeBegin Translate .4 .6 .3 Scale 1 2 1 ObjectInstance "lamp" AttributeEnd
AttributeBegin Translate -.6 .5 .2 ObjectInstance "lamp" AttributeEnd
)",
                           sky = "LightSource \"infinite\" \"rgb L\" [ .5 .7 .9 ]\n",
                           red = "LightSource \"infinite\" \"rgb L\" [ .8 0 0 ]\n",
                           green = "LightSource \"infinite\" \"rgb L\" [ 0 .3 0 ]\n",
                           point = "LightSource \"point\" \"point3 from\" [ 0 .5 .5 ] \"rgb I\" [ 2 2 2 ]\n";
  static const std::vector<LitRoom> all = {{"mesh", mesh},
                                           {"sphere", sphere},
                                           {"disk", disk},
                                           {"patch", patch},
                                           {"instances", instances},
                                           {"sky", sky},
                                           {"two skies", red + green},
                                           {"all", mesh + sphere + disk + patch + instances + sky + point}};
  return all;
}

/** First emitter along a ray, through surfaces that do not scatter; false if it does not emit. */
bool findLight(const Scene& scene, const SurfacePoint& from, const Vec3f& direction, const Light& wanted,
               Hit& hit, bool& escaped) {
  Ray ray{from.rayOrigin(direction), direction, INFINITE};
  escaped = false;
  for (;;) {
    if (!scene.intersect(ray, hit)) {
      escaped = true;
      return true;
    }
    if (hit.areaLight == &wanted) return true;
    if (hit.material && hit.material->lobes() != NO_LOBE) return false;
    ray = {hit.point.rayOrigin(direction), direction, INFINITE};
  }
}

/** Calls visit(point, hit, wi, sampler) for the surface points of camera walks that have a non-delta lobe. */
template <class Visit> void visitPoints(const Scene& scene, int walks, Visit&& visit) {
  BsdfArena arena;
  for (int i = 0; i < walks; ++i) {
    Sampler sampler(17, 3, static_cast<uint32_t>(i));
    Ray ray = *scene.camera().sampleRay({sampler.next2D() * 16.0f});
    Hit hit;
    for (int depth = 0; depth < 3 && scene.intersect(ray, hit); ++depth) {
      arena.reset();
      const Bsdf* bsdf = hit.material ? hit.material->bsdfAt(hit.point, arena) : nullptr;
      if (!bsdf) break;
      const ScatteringPoint scattering(*bsdf, hit.point);
      if (scattering.hasNonDelta()) visit(scattering, hit.point, -ray.direction, sampler);
      const std::optional<Scatter> s = scattering.scatter(-ray.direction, Transport::RADIANCE, sampler);
      if (!s) break;
      ray = {hit.point.rayOrigin(s->direction), s->direction, INFINITE};
    }
  }
}

constexpr double SAME = 1e-3;

/** Expects that densities and sums agree except for a few paths that pass an edge by rounding. */
void expectFew(size_t wrong, size_t tested, const std::string& what) {
  EXPECT_GT(tested, size_t(samples(500))) << what;
  EXPECT_LE(double(wrong), 1e-3 * double(tested)) << what << ": " << wrong << " of " << tested;
}

} // namespace

/** For a BSDF ray that hits a light, the density is equal to the density with which shadow rays sample the
 * same point. */
TEST(MultipleImportanceSampling, BothSidesKnowTheDensityOfLights) {
  for (const LitRoom& room : litRooms()) {
    const auto scene = sceneFrom(roomWith(room.lights));
    ASSERT_TRUE(scene);
    LightSampler guide;
    learnLights(*scene, guide);
    size_t tested = 0, wrong = 0;
    visitPoints(*scene, samples(4000),
                [&](const ScatteringPoint&, const SurfacePoint& point, const Vec3f& wi, Sampler sampler) {
                  float pick = sampler.next1D();
                  const Vec2f u = sampler.next2D();
                  const LightSampleContext place = lightSampleContext(guide, point, wi);
                  const ChosenLight chosen = guide.choose(scene->lights(), place, pick);
                  const auto light = chosen.light->sampleLi(point.position, pick, u);
                  if (!light || light->unhittable || !(light->pdf > 0)) return;
                  Hit hit;
                  bool escaped = false;
                  if (!findLight(*scene, point, light->direction, *chosen.light, hit, escaped)) return;
                  double density = -1, chance = -1;
                  if (escaped) {
                    if (light->distance != INFINITE) return; // missed the rim by rounding
                    for (size_t i = 0; i < scene->environment().size(); ++i)
                      if (scene->environment()[i] == chosen.light) {
                        density = double(scene->environment()[i]->pdfLi(point.position, light->direction));
                        chance =
                            double(guide.probability(scene->lights(), place, scene->environmentIndices()[i]));
                      }
                  } else {
                    // A point on the far side of the light, or on a different part of it, belongs to a
                    // different path.
                    if (glm::distance(hit.point.position, light->target) > 1e-4f) return;
                    density = double(hit.areaLight->pdfLi(point.position, hit.primitive, hit.point));
                    chance = double(guide.probability(scene->lights(), place, hit.lightIndex));
                  }
                  // The ray is rounded; near a silhouette this moves the point, and changes the cosine.
                  const double cosine =
                      escaped ? 1 : double(absDot(hit.point.geometricNormal, light->direction));
                  const double slack = SAME * std::max(1.0, square(0.1 / cosine));
                  ++tested;
                  if (std::abs(density - double(light->pdf)) > slack * double(light->pdf) ||
                      std::abs(chance - double(chosen.probability)) > SAME * double(chosen.probability))
                    ++wrong;
                });
    expectFew(wrong, tested, room.name);
  }
}

/** A photon that is sent in a given direction has the same flux as one whose direction is sampled. */
TEST(MultipleImportanceSampling, PhotonsKnowWhatADirectionIsWorth) {
  const auto scene = sceneFrom(roomWith(litRooms().front().lights));
  size_t tested = 0, wrong = 0;
  visitPoints(*scene, samples(4000),
              [&](const ScatteringPoint& scattering, const SurfacePoint&, const Vec3f& wi, Sampler sampler) {
                const auto s = scattering.scatterNonDelta(wi, Transport::FLUX, sampler);
                if (!s) return;
                ++tested;
                const Rgb expected = s->weight * s->pdf;
                const Rgb difference = abs(scattering.evaluateFlux(wi, s->direction) - expected);
                if (maxComponent(difference) > float(SAME) * maxComponent(expected)) ++wrong;
              });
  expectFew(wrong, tested, "flux");
}

/** The BSDF density of a shadow ray is equal to the density of BSDF rays, with the lobes of `path` and of
 * `photonmap`. */
TEST(MultipleImportanceSampling, BothSidesKnowTheDensityOfDirections) {
  const auto scene = sceneFrom(roomWith(litRooms().front().lights));
  for (const LobeSet allowed : {LobeSet(ALL_LOBES), LobeSet(NON_DELTA_LOBES)}) {
    size_t tested = 0, wrong = 0;
    visitPoints(
        *scene, samples(4000),
        [&](const ScatteringPoint& scattering, const SurfacePoint&, const Vec3f& wi, Sampler sampler) {
          const auto s = scattering.scatter(wi, Transport::RADIANCE, sampler, allowed);
          if (!s || s->specular()) return;
          ++tested;
          if (std::abs(scattering.pdf(wi, s->direction, allowed) - s->pdf) > float(SAME) * s->pdf) ++wrong;
        });
    expectFew(wrong, tested, "lobes " + std::to_string(allowed));
  }
}

namespace {

/** Direct light by `n` shadow rays, where each path has one minus the weight that the functions for BSDF rays
 * return. The sampler draws the same numbers as addSampledLight, in the same order. `shared` counts the
 * weights that are neither nearly 0 nor nearly 1. */
Rgb leftToShadowRays(const Scene& scene, const LightSampler& guide, const LightSampleContext& place,
                     const ScatteringPoint& scattering, const SurfacePoint& point, const Vec3f& wi, int n,
                     LobeSet allowed, Sampler sampler, size_t& shared) {
  Rgb sum = BLACK;
  Hit at;
  at.point = point;
  for (int i = 0; i < n; ++i) {
    float pick = sampler.next1D();
    const Vec2f u = sampler.next2D();
    const ChosenLight chosen = guide.choose(scene.lights(), place, pick);
    const auto light = chosen.light->sampleLi(point.position, pick, u);
    if (!light || !(light->pdf > 0)) continue;
    TransportCounts counts;
    const Rgb alone = scattering.evaluate(wi, light->direction) * light->radiance /
                      (chosen.probability * light->pdf * float(n));
    if (isBlack(alone) || !visible(scene, at, wi, *light, {}, counts)) continue;
    if (light->unhittable) {
      sum += alone;
      continue;
    }
    Hit hit;
    bool escaped = false;
    if (!findLight(scene, point, light->direction, *chosen.light, hit, escaped)) continue;
    const BsdfRay ray{place, scattering.pdf(wi, light->direction, allowed), true};
    Rgb weighted = BLACK, plain = BLACK;
    forLightHits(scene, guide, escaped ? nullptr : &hit, spawn(point, light->direction), ray, n, nullptr,
                 [&](const LightHit& found) {
                   weighted += found.weighted;
                   plain += found.radiance;
                 });
    // One colour at a time: the two skies have no colour in common.
    for (int c = 0; c < 3; ++c)
      if (alone[c] > 0) {
        const float weight = plain[c] > 0 ? weighted[c] / plain[c] : 0;
        sum[c] += alone[c] * (1 - weight);
        if (weight > 5 * float(SAME) && weight < 1 - 5 * float(SAME)) ++shared;
      }
  }
  return sum;
}

} // namespace

/** Direct light by addSampledLight is equal to shadow rays alone times one minus the weight that
 * lightHit() gives to a BSDF ray of the same path. */
TEST(MultipleImportanceSampling, WeightsSumToOne) {
  const PathClasses classes;
  const CameraState eye = classes.step(classes.cameraStart(), PathEvent::D);
  for (const LitRoom& room : litRooms()) {
    const auto scene = sceneFrom(roomWith(room.lights));
    ASSERT_TRUE(scene);
    LightSampler guide;
    learnLights(*scene, guide);
    for (const int n : {1, 3})
      for (const LobeSet allowed : {LobeSet(ALL_LOBES), LobeSet(NON_DELTA_LOBES)}) {
        size_t tested = 0, wrong = 0, shared = 0;
        visitPoints(*scene, samples(2000),
                    [&](const ScatteringPoint& scattering, const SurfacePoint& point, const Vec3f& wi,
                        Sampler sampler) {
                      const LightSampleContext place = lightSampleContext(guide, point, wi);
                      const Rgb expected = leftToShadowRays(*scene, guide, place, scattering, point, wi, n,
                                                            allowed, sampler, shared);
                      TransportCounts counts;
                      PathRadiance out(classes, counts);
                      Hit at;
                      at.point = point;
                      addSampledLight(*scene, guide, place, scattering, at, {}, wi, Rgb(1), eye, n, allowed,
                                      0, sampler, out);
                      ++tested;
                      const Rgb difference = abs(out.total() - expected);
                      if (maxComponent(difference - expected * float(SAME)) > 0) {
                        ++wrong;
                      }
                    });
        expectFew(wrong, tested, room.name + ", " + std::to_string(n) + " shadow rays");
        EXPECT_GT(shared, size_t(samples(100))) << room.name;
      }
  }
}

/** Paths from point lights that no estimator of the integrator finds, by its domains. */
TEST(EstimatorDomains, KnowWhatOfDeltaLightsTheyMiss) {
  EXPECT_EQ(missedOfDeltaLights(integratorFrom("photonmap", "")->domains()), "");
  EXPECT_EQ(missedOfDeltaLights(integratorFrom("photonmap", "\"string direct\" \"photons\"")->domains()), "");
  for (const char* name : {"path", "simplepath"})
    EXPECT_TRUE(PathAutomaton::compile(missedOfDeltaLights(integratorFrom(name, "")->domains()))
                    .equivalent(PathAutomaton::compile("LS+D(S|D)*E")))
        << name;
}

/** The counts include the rays of learning. */
TEST(Counts, IncludeLearning) {
  std::string lamps;
  for (int i = 0; i < 4; ++i)
    lamps += "LightSource \"point\" \"point3 from\" [ " + std::to_string(i) + " .5 .5 ]\n";
  const auto scene = sceneFrom(roomWith(lamps));
  LightSampler guide;
  const uint64_t learning = learnLights(*scene, guide).rays;
  EXPECT_GT(learning, 1000u);
  for (const char* name : {"path", "photonmap"}) {
    const auto integrator =
        integratorFrom(name, name == std::string("path") ? "" : "\"integer photons\" 1000");
    const PathClasses classes;
    const uint64_t prepared = integrator->prepare(*scene, classes).rays;
    EXPECT_GE(prepared + integrator->forward(*scene, classes, {1, 0}, {}).counts.rays, learning) << name;
  }
  const Rendered picture = renderScene(*scene, "raycast", "", 1);
  const auto pixels = uint64_t(scene->film().whole().area());
  EXPECT_GE(picture.statistics.counts.rays, learning + pixels);
  EXPECT_LE(picture.statistics.counts.rays, learning + 3 * pixels);
}
