/** @file
 * Classic methods: each agrees with `path` on exactly the paths that it claims.
 */
#include "classRendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

const char* const LAMP = R"(
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 12 11 10 ]
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ]
  "point3 P" [ -.7 -1 1.9  -.7 .2 1.9  .7 .2 1.9  .7 -1 1.9 ]
AttributeEnd
)";
const char* const SKY = "LightSource \"infinite\" \"rgb L\" [ .5 .6 .7 ]\n";
const char* const SPOTS = R"(
LightSource "point" "point3 from" [ -1 -1 1.5 ] "rgb I" [ 2 1 1 ]
LightSource "distant" "point3 from" [ 1 -1 2 ] "point3 to" [ 0 0 0 ] "rgb L" [ .3 .5 .4 ]
)";

/** Matt walls with a smooth normal, gloss, a mirror, glass, a pane, and a surface with partial mirror
 * reflection. */
std::string corner(int size, const std::string& lights) {
  return view(size, "0 -4 1.6  0 0 .5  0 0 1", 40) + R"(
Material "diffuse" "rgb reflectance" [ .7 .6 .5 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 -2 0  2 -2 0  2 2 0  -2 2 0 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 .9 0  2 .9 0  2 .9 2  -2 .9 2 ]
  "normal N" [ .2 -1 0  -.2 -1 0  -.2 -1 .2  .2 -1 .2 ]
AttributeBegin
Material "coateddiffuse" "rgb reflectance" [ .2 .5 .3 ] "float roughness" 0
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ 1.4 -2 0  1.4 -2 2  1.4 1 2  1.4 1 0 ]
AttributeEnd
AttributeBegin
Material "blinnphong" "rgb reflectance" [ .3 .3 .6 ] "rgb specular" [ .4 .4 .4 ] "float exponent" 40
Translate -.9 .1 .35
Shape "sphere" "float radius" .35
AttributeEnd
AttributeBegin
Material "conductor" "rgb reflectance" [ .9 .8 .7 ]
Translate 0 .3 .4
Shape "sphere" "float radius" .4
AttributeEnd
AttributeBegin
Material "dielectric" "float eta" 1.5
Translate .75 -.4 .3
Shape "sphere" "float radius" .3
AttributeEnd
AttributeBegin
Material "thindielectric"
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ]
  "point3 P" [ -1.5 -.6 0  -.7 -.6 0  -.7 -.6 1  -1.5 -.6 1 ]
AttributeEnd
)" + lights;
}

/** Classes of paths that together are the claims of the method. */
struct Claim {
  Way way;
  std::vector<PathClass> classes;
};
const std::vector<PathClass> SEEN = {{"lamps", "LS*E"}}, DIRECT = {{"direct", "LDE"}},
                             MIRRORED = {{"mirrored", "LDS+E"}},
                             REFLECTED = {{"two", "LDDS*E"}, {"more", "L(S|D)+DDS*E"}};

std::vector<PathClass> joined(const std::vector<std::vector<PathClass>>& parts) {
  std::vector<PathClass> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

std::vector<Claim> claimsOfMethods() {
  const std::string few = "\"integer lightpaths\" " + std::to_string(samples(64));
  return {{{"raycast", ""}, joined({{{"lamps", "LE"}}, DIRECT})},
          {{"whitted", "\"float minweight\" 0.0001"}, joined({SEEN, DIRECT, MIRRORED})},
          {{"vpl", few}, joined({SEEN, DIRECT, MIRRORED, REFLECTED})},
          {{"vpl", few + " \"float clampdistance\" .8 \"integer passes\" 4"},
           joined({SEEN, DIRECT, MIRRORED, REFLECTED})},
          {{"vpl", few + " \"integer maxdepth\" 3"}, joined({SEEN, DIRECT, MIRRORED, REFLECTED})}};
}

constexpr double ERRORS_APART = 5;

void expectEqual(const Scene& scene, const Way& way, const Way& other, const PathClasses& classes,
                 const std::string& what) {
  if (SANITIZED && way.integrator == "vpl") { // too few light paths for an estimate of the error
    classMeans(scene, way, classes, 1, 2);
    return;
  }
  const BatchMeans means = classMeans(scene, way, classes, samples(way.integrator == "vpl" ? 8 : 16), 12),
                   truth = classMeans(scene, other, classes, samples(40), 12);
  for (size_t i = 0; i < 3 * classes.layerCount(); ++i) {
    const double error = std::hypot(means.standardError(i), truth.standardError(i));
    EXPECT_NEAR(means.mean(i), truth.mean(i), ERRORS_APART * error + 2e-4 * truth.mean(i))
        << what << " " << classes.classes()[i / 3].name << ", errors " << means.standardError(i) << " and "
        << truth.standardError(i);
    // All pixels share the light paths of vpl, so that its error is larger.
    const double vague = (SANITIZED ? 3 : 1) * (way.integrator == "vpl" ? 0.25 : 0.1);
    EXPECT_LT(error, vague * truth.mean(i) + 1e-9)
        << what << " " << classes.classes()[i / 3].name << " is too vague to tell";
  }
}

} // namespace

TEST(Methods, ComputeWhatPathDoesOnThePathsThatTheyClaim) {
  const ThreadPool pool;
  for (const auto& [name, lights] : {std::pair{"lamp", LAMP}, {"sky", SKY}, {"spots", SPOTS}}) {
    const auto scene = sceneFrom(corner(16, lights));
    ASSERT_TRUE(scene);
    for (const Claim& claim : claimsOfMethods()) {
      // The classes compared are the claims of the method.
      PathAutomaton all = PathAutomaton::compile(claim.classes.front().expression);
      for (const PathClass& c : claim.classes) all = all.unite(PathAutomaton::compile(c.expression));
      const std::string claims = integratorFrom(claim.way.integrator, claim.way.parameters)->claims();
      EXPECT_TRUE(all.equivalent(PathAutomaton::compile(claims))) << claim.way.integrator;
      const bool deep = claim.way.parameters.find("maxdepth") != std::string::npos;
      // Light of points through mirrors and glass is found by light paths only.
      const char* complete = std::string_view(name) == "spots" ? "bdpt" : "path";
      expectEqual(*scene, claim.way, {complete, deep ? "\"integer maxdepth\" 3" : ""},
                  PathClasses(claim.classes), claim.way.integrator + claim.way.parameters + " " + name);
    }
  }
}

/** Only the claimed paths reach the film. */
TEST(Methods, AddNoOtherPaths) {
  const ThreadPool pool;
  const auto scene = sceneFrom(corner(16, LAMP));
  for (const Claim& claim : claimsOfMethods()) {
    const std::string claims = integratorFrom(claim.way.integrator, claim.way.parameters)->claims();
    const PathClasses both(
        std::vector<PathClass>{{"rest", "surface - (" + claims + ")"}, {"claimed", claims}});
    const std::vector<double> means = renderClasses(*scene, claim.way, both, 4, 1).layerMeans();
    for (size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(means[i], 0) << claim.way.integrator;
      EXPECT_GT(means[3 + i], 0) << claim.way.integrator << " is black";
    }
  }
}

/** Between parallel mirrors, the reported loss is equal to the lost light: with reflectance r and lamps L,
 * the picture has the sum over n < maxdepth of L r^n and r^maxdepth is cut off. */
TEST(Methods, WhittedCountsWhatItCuts) {
  const std::string scene = view(4, "0 0 0  0 0 1  0 1 0", 10) + R"(
AreaLightSource "diffuse" "rgb L" [ 1 1 1 ]
Material "conductor" "rgb reflectance" [ .9 .9 .9 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -9 -9 1  -9 9 1  9 9 1  9 -9 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -9 -9 -1  9 -9 -1  9 9 -1  -9 9 -1 ]
)";
  // The reflectance of the conductor depends slightly on the angle; it is .9 at normal incidence.
  const auto check = [&](const std::string& parameters, int lamps, int mirrors) {
    const Rendered r = renderText(scene, "whitted", parameters, 4);
    const double seen = (1 - std::pow(.9, lamps)) / .1, cut = std::pow(.9, mirrors);
    EXPECT_NEAR(r.mean(), seen, 0.01 * seen) << parameters;
    EXPECT_NEAR(r.statistics.counts.truncatedThroughput / double(r.statistics.samples), cut, 0.02 * cut)
        << parameters;
  };
  check("\"integer maxdepth\" 8 \"float minweight\" 0", 9, 8);     // the path ends at the ninth lamp
  check("\"integer maxdepth\" 1000 \"float minweight\" .5", 7, 7); // .9^6 is the last weight above a half
}

TEST(Methods, AmbientOcclusionIsTheLightOfAWhiteSkyOnWhiteMatter) {
  const ThreadPool pool;
  const auto things = [](const std::string& sky) {
    return view(16, "0 -4 1.6  0 0 .5  0 0 1", 40) + sky + R"(
Material "diffuse" "rgb reflectance" [ 1 1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 -2 0  2 -2 0  2 2 0  -2 2 0 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 .9 0  2 .9 0  2 .9 2  -2 .9 2 ]
Translate .3 0 .6
Shape "sphere" "float radius" .4
)";
  };
  const PathClasses direct(DIRECT);
  const auto white = sceneFrom(things("LightSource \"infinite\" \"rgb L\" [ 1 1 1 ]\n"));
  expectEqual(*white, {"ambientocclusion", ""}, {"path", ""}, direct, "under a sky");
  // The lights of the scene have no effect.
  const auto dark = sceneFrom(things(""));
  EXPECT_EQ(renderClasses(*dark, {"ambientocclusion", ""}, direct, 4, 1).layerMeans(),
            renderClasses(*white, {"ambientocclusion", ""}, direct, 4, 1).layerMeans());
  // Nothing occludes a point within a tiny distance.
  const auto near = renderClasses(*dark, {"ambientocclusion", "\"float maxdistance\" 1e-4"}, direct, 16, 1);
  for (size_t p = 0; p < near.film.bounds().area(); ++p) EXPECT_GT(near.film.value(p, 0).r, 0.9f);
}

TEST(Methods, AmbientLightIsReflectedByTheAlbedo) {
  const auto scene = sceneFrom(view(4, "0 0 3  0 0 0  0 1 0", 20) + R"(
Material "diffuse" "rgb reflectance" [ .5 .25 1 ]
Shape "disk" "float radius" 9
)");
  const Rendered r = renderScene(*scene, "raycast", "\"rgb ambient\" [ .2 .4 .6 ]", 4);
  for (size_t p = 0; p < r.pixels(); ++p)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(r.value(p)[c], Rgb(.1f, .1f, .6f)[c], 1e-6f);
}

/** Two matt walls at an angle: with clamped virtual lights they are too dark near the edge, with compensation
 * or without a clamp they are not. */
TEST(Methods, VirtualLightsAreDarkInCornersUnlessCompensated) {
  const ThreadPool pool;
  const auto scene = sceneFrom(litCorner(16));
  const PathClasses two(std::vector<PathClass>{{"two", "LDDE"}});
  const std::string few = "\"integer lightpaths\" " + std::to_string(samples(64));
  const BatchMeans truth = classMeans(*scene, {"path", ""}, two, samples(192), 8);
  const auto means = [&](const std::string& more) {
    return classMeans(*scene, {"vpl", few + more}, two, samples(64), 8);
  };
  const BatchMeans clamped = means(" \"float clampdistance\" 1 \"bool compensate\" false");
  // Sanitizers have few light paths.
  const double vague = SANITIZED ? 4 * std::hypot(clamped.standardError(1), truth.standardError(1)) : 0;
  EXPECT_LT(clamped.mean(1), 0.9 * truth.mean(1) + vague);
  for (const char* distance : {"0", ".3", "1", "3"}) {
    const BatchMeans bounded = means(std::string(" \"float clampdistance\" ") + distance);
    if (SANITIZED) continue; // too few light paths for an estimate of the error
    const double error = std::hypot(bounded.standardError(1), truth.standardError(1));
    EXPECT_NEAR(bounded.mean(1), truth.mean(1), ERRORS_APART * error) << distance;
    EXPECT_LT(error, (SANITIZED ? 0.1 : 0.03) * truth.mean(1)) << distance;
  }
}
