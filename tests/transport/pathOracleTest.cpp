/** @file
 * The oracle: a minimal path tracer that shares only the scene and the BSDFs with the integrators. It adds
 * the contribution of each path to the sum of its word; sums over the words that a std::regex accepts are the
 * reference for the class layers of the integrators.
 */
#include "classRendering.h"

#include <array>
#include <random>
#include <regex>

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Longer paths are excluded on both sides of the comparison. */
constexpr int MAX_EVENTS = 6;
/** Words as bits, from the camera on (1: D), below a leading 1. */
constexpr size_t WORDS = size_t(1) << (MAX_EVENTS + 1);

/** Text of a word in the order of path expressions, from the light to the camera: the last event of the
 * camera walk is first. */
std::string wordText(size_t word) {
  std::string text = "L";
  for (; word > 1; word >>= 1) text += (word & 1) ? 'D' : 'S';
  return text + "E";
}

using WordSums = std::array<Rgbd, WORDS>;

/** Traces a path without shadow rays and Russian roulette; each lobe has the same probability. */
void tracePath(const Scene& scene, Ray ray, std::mt19937_64& random, WordSums& sums) {
  const auto number = [&] { return float(random() >> 40) * 0x1p-24f; };
  Rgbd throughput(1);
  size_t word = 1;
  BsdfArena arena;
  Hit hit;
  for (int events = 0;;) {
    if (!scene.intersect(ray, hit)) {
      for (const EnvironmentLight* light : scene.environment())
        sums[word] += throughput * Rgbd(light->radiance(ray.direction));
      return;
    }
    if (hit.areaLight) sums[word] += throughput * Rgbd(hit.areaLight->radiance(hit.point, -ray.direction));
    arena.reset();
    const Bsdf* bsdf = hit.material ? hit.material->bsdfAt(hit.point, arena) : nullptr;
    if (bsdf) {
      if (events++ == MAX_EVENTS) return;
      const Frame frame(hit.point.shadingNormal);
      const Vec3f wi = frame.toLocal(-ray.direction);
      DeltaScatters deltas;
      bsdf->deltas(wi, deltas);
      const int diffuse = (bsdf->lobes() & NON_DELTA_LOBES) ? 1 : 0, lobes = diffuse + deltas.count;
      if (lobes == 0) return;
      const int lobe = std::min(int(number() * float(lobes)), lobes - 1);
      throughput *= lobes;
      Vec3f wo;
      if (lobe < diffuse) {
        const Vec2f u(number(), number());
        const auto sampled = bsdf->sample(wi, u, number());
        if (!sampled) return;
        wo = *sampled;
        const float pdf = bsdf->pdf(wi, wo);
        if (!(pdf > 0)) return;
        throughput *= Rgbd(bsdf->value(wi, wo)) * double(std::abs(wo.z) / pdf);
        word = 2 * word + 1;
      } else {
        const DeltaScatter& d = deltas.entries[size_t(lobe - diffuse)];
        wo = d.wo;
        throughput *= Rgbd(d.weight) / double(square(d.eta)); // radiance scales with the square of the index
        word = 2 * word;
      }
      ray.direction = glm::normalize(frame.toWorld(wo));
    }
    ray.origin = hit.point.rayOrigin(ray.direction);
  }
}

/** A class, and an equivalent ECMAScript regular expression over words of S and D. */
struct OracleClass {
  std::string expression;
  std::string regex; ///< empty: the same expression
};

const std::vector<OracleClass>& oracleClasses() {
  static const std::vector<OracleClass> all = {// Single words
                                               {"LE", ""},
                                               {"LDE", ""},
                                               {"LSE", ""},
                                               {"LDDE", ""},
                                               {"LDSE", ""},
                                               {"LSDE", ""},
                                               {"LSSE", ""},
                                               {"LDDDE", ""},
                                               {"LSSDE", ""},
                                               {"LDSSE", ""},
                                               {"LSDSE", ""},
                                               {"LDDSE", ""},
                                               {"LDSDE", ""},
                                               // Common classes
                                               {"LS*E", ""},
                                               {"LDS*E", ""},
                                               {"LS+DE", ""},
                                               {"LS+DS+E", ""},
                                               {"L(S|D)*E", ""},
                                               {"L(S|D)*DS*E", ""},
                                               {"L(S|D)*(S|D)DS*E", ""},
                                               {"L(S|D)*DS+E", ""},
                                               {"LS+D(S|D)*E", ""},
                                               {"LD+E", ""},
                                               {"LDD+E", ""},
                                               {"LS+D+E", ""},
                                               // Brackets by Heckbert and by a lecture handout
                                               {"L[S|D]E", ""},
                                               {"L[SS|D]E", "L(SS|D)E"},
                                               {"L[S|D]*S[D]E", "L(S|D)*SDE"},
                                               {"L[SD]{2,3}E", ""},
                                               {"L.E", ""},
                                               {"L.{2}E", ""},
                                               {"L.{4,}E", ""},
                                               {"LD?S?E", ""},
                                               {"L[^S]+E", ""},
                                               {"L[^D]{2,}E", ""},
                                               {"L(SD)+E", ""},
                                               {"L(DS|SD)E", ""},
                                               {"L(D|SS)*E", ""},
                                               {"L.*D.*S.*E", ""},
                                               // Sets
                                               {"all - LDE", "(?!LDE$).*"},
                                               {"!LD.*E", "(?!LD).*"},
                                               {"L.*SE & LD.*E", "LD.*SE"},
                                               {"LS.*E - (caustic | LSE)", "LS(?!E$)(?!S*DS*E$).*"},
                                               {"!(L.*DE | L.*SSE)", "LE|LSE|L.*DSE"},
                                               // Names
                                               {"direct", "L[SD]E"},
                                               {"caustic", "LS+DS*E"}};
  return all;
}

PathClasses compiledClasses() {
  std::vector<PathClass> classes;
  const std::string shortPaths = "L[SD]{0," + std::to_string(MAX_EVENTS) + "}E";
  for (const OracleClass& c : oracleClasses())
    classes.push_back({c.expression, "(" + c.expression + ") & " + shortPaths});
  return PathClasses(classes);
}

BatchMeans askOracle(const Scene& scene, int batches, int pathsPerBatch) {
  std::vector<std::vector<size_t>> words;
  for (const OracleClass& c : oracleClasses()) {
    const std::regex regex(c.regex.empty() ? c.expression : c.regex, std::regex::ECMAScript);
    words.emplace_back();
    for (size_t word = 1; word < WORDS; ++word)
      if (std::regex_match(wordText(word), regex)) words.back().push_back(word);
  }
  std::vector<std::vector<double>> results(static_cast<size_t>(batches));
  parallelFor(results.size(), [&](size_t batch) {
    std::mt19937_64 random(1000 + batch);
    const auto number = [&] { return float(random() >> 40) * 0x1p-24f; };
    WordSums sums{};
    for (int i = 0; i < pathsPerBatch; ++i) {
      const float x = number() * float(scene.film().width), y = number() * float(scene.film().height);
      tracePath(scene, *scene.camera().sampleRay({{x, y}}), random, sums);
    }
    for (const std::vector<size_t>& members : words) {
      Rgbd sum(0);
      for (const size_t word : members) sum += sums[word];
      for (int c = 0; c < 3; ++c) results[batch].push_back(sum[c] / pathsPerBatch);
    }
  });
  BatchMeans means;
  for (const auto& result : results) means.add(result);
  return means;
}

constexpr int FILM = 64;

/** A box open to the camera, with lamps large enough to be hit at random. */
std::string boxWithLamps() {
  return view(FILM, "0 0 3.9  0 0 0  0 1 0", 39.3) + R"(
MakeNamedMaterial "paint" "string type" "diffuse" "rgb reflectance" [ .6 .7 .8 ]
MakeNamedMaterial "steel" "string type" "conductor" "rgb reflectance" [ .9 .8 .7 ]
MakeNamedMaterial "enamel" "string type" "mix" "string materials" [ "paint" "steel" ] "float amount" .3
NamedMaterial "enamel"
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  1 -1 -1  1 -1 1  -1 -1 1 ]
Material "diffuse" "rgb reflectance" [ .7 .7 .7 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 1 -1  -1 1 1  1 1 1  1 1 -1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  -1 1 -1  1 1 -1  1 -1 -1 ]
Material "diffuse" "rgb reflectance" [ .7 .2 .2 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  -1 -1 1  -1 1 1  -1 1 -1 ]
Material "diffuse" "rgb reflectance" [ .2 .6 .2 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ 1 -1 -1  1 1 -1  1 1 1  1 -1 1 ]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 6 5 4 ]
Material "diffuse" "rgb reflectance" [ .3 .3 .3 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ]
  "point3 P" [ -.6 .95 -.6  .6 .95 -.6  .6 .95 .6  -.6 .95 .6 ]
AttributeEnd
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 1 2 4 ]
Material "diffuse" "rgb reflectance" [ .5 .5 .5 ]
Translate -.5 .3 -.5
Shape "sphere" "float radius" .25
AttributeEnd
AttributeBegin
Material "conductor" "rgb reflectance" [ .9 .9 .9 ]
Translate -.45 -.5 -.35
Shape "sphere" "float radius" .4
AttributeEnd
AttributeBegin
Material "dielectric" "float eta" 1.5
Translate .42 -.5 .25
Shape "sphere" "float radius" .4
AttributeEnd
AttributeBegin
Material "thindielectric" "float eta" 1.5
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ]
  "point3 P" [ -.8 -.3 .6  0 -.3 .7  0 .4 .7  -.8 .4 .6 ]
AttributeEnd
)";
}

/** Objects on a floor under the sky, and a delta light. */
std::string floorUnderTheSky() {
  return view(FILM, "0 1.2 3.4  0 -.3 0  0 1 0", 36) + R"(
LightSource "infinite" "rgb L" [ .4 .6 .9 ]
MakeNamedMaterial "paint" "string type" "diffuse" "rgb reflectance" [ .8 .5 .3 ]
MakeNamedMaterial "steel" "string type" "conductor" "rgb reflectance" [ .8 .8 .8 ]
MakeNamedMaterial "glaze" "string type" "mix" "string materials" [ "paint" "steel" ] "float amount" .4
Material "diffuse" "rgb reflectance" [ .5 .6 .5 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 -1 -2  2 -1 -2  2 -1 2  -2 -1 2 ]
Material "conductor" "rgb reflectance" [ .85 .9 .85 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ]
  "point3 P" [ -1.2 -1 -1  -1.2 .3 -1.2  1.2 .3 -1.2  1.2 -1 -1 ]
AttributeBegin
NamedMaterial "glaze"
Translate -.6 -.6 .1
Shape "sphere" "float radius" .38
AttributeEnd
AttributeBegin
Material "dielectric" "float eta" 1.4
Translate .5 -.55 .3
Shape "sphere" "float radius" .4
AttributeEnd
AttributeBegin
Material "thindielectric" "float eta" 1.6
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ]
  "point3 P" [ -.2 -.95 .8  .3 -.95 .9  .3 -.2 .9  -.2 -.2 .8 ]
AttributeEnd
AttributeBegin
Material "interface"
AreaLightSource "diffuse" "rgb L" [ 8 6 3 ] "bool twosided" true
Translate 0 .5 0 Rotate 70 1 0 0
Shape "disk" "float radius" .4
AttributeEnd
)";
}

struct OracleCase {
  const char* name;
  std::string scene;
  friend std::ostream& operator<<(std::ostream& out, const OracleCase& c) { return out << c.name; }
};

class PathOracle : public ::testing::TestWithParam<OracleCase> {};

std::string caseName(const ::testing::TestParamInfo<OracleCase>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(Scenes, PathOracle,
                         ::testing::Values(OracleCase{"boxWithLamps", boxWithLamps()},
                                           OracleCase{"floorUnderTheSky", floorUnderTheSky()}),
                         caseName);

/** Seeds are fixed: the bound detects a wrong mean, and an outlier cannot occur later. */
constexpr double SIGMAS = 5;
/** Bias of the photon map at edges and shadow borders; the search radius is a pixel of this small film. */
constexpr double PHOTON_BIAS = 0.03;

} // namespace

TEST_P(PathOracle, ClassesOfEveryIntegratorAgree) {
  const ThreadPool pool;
  const auto scene = sceneFrom(GetParam().scene);
  ASSERT_TRUE(scene);
  const std::vector<OracleClass>& list = oracleClasses();
  ASSERT_GE(list.size(), 30u);
  const PathClasses classes = compiledClasses();
  const BatchMeans truth = askOracle(*scene, 64, samples(16384));

  const std::string photons =
      "\"integer passes\" 1 \"integer photons\" " + std::to_string(samples(50000)) + " \"float radius\" .03";
  struct Run {
    Way way;
    int samplesPerPixel, seeds;
    double bias;
  };
  const Run runs[] = {{{"path", ""}, samples(8), 16, 0},
                      {{"path", "\"integer lightsamples\" 3"}, 1, 16, 0},
                      {{"photonmap", photons}, 1, 16, PHOTON_BIAS},
                      {{"photonmap", photons + " \"string direct\" \"photons\""}, 1, 16, PHOTON_BIAS}};
  for (const Run& run : runs) {
    const BatchMeans means = classMeans(*scene, run.way, classes, run.samplesPerPixel, run.seeds);
    for (size_t i = 0; i < list.size(); ++i)
      for (size_t c = 0; c < 3; ++c) {
        const size_t at = 3 * i + c;
        const double expected = truth.mean(at);
        const double error = std::hypot(truth.standardError(at), means.standardError(at));
        EXPECT_NEAR(means.mean(at), expected, SIGMAS * error + run.bias * expected + 1e-7)
            << run.way.integrator << " " << run.way.parameters << ": " << list[i].expression << " colour "
            << c << ", errors " << truth.standardError(at) << " and " << means.standardError(at);
      }
  }
  // The comparison is meaningful: most classes have small errors, and few are dark.
  size_t sharp = 0;
  for (size_t i = 0; i < list.size(); ++i)
    if (truth.standardError(3 * i + 1) < (SANITIZED ? 0.06 : 0.02) * truth.mean(3 * i + 1)) ++sharp;
  EXPECT_GE(sharp, 30u);
}
