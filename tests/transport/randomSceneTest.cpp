/** @file
 * Small random scenes by every integrator: none ends the program, and no value on the film is infinite or
 * NaN. RECURSE_RANDOM_SCENES="1000 2000" renders the scenes of seeds 1000 to 1999 instead of the first ones;
 * the last scene remains in the file random-scene.pbrt of the current folder.
 */
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <map>
#include <numeric>
#include <sstream>
#include <tuple>
#include <vector>

#include "randomScene.h"
#include "rendering.h"
#include "transport/forward/shoot.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

struct Outcome {
  std::string refusal; ///< error message for a user; empty: rendered
  std::string unsound; ///< description of an unsound result
};

/** Filters with negative lobes make pixels negative, but never infinite. */
std::string unsoundnessOf(const Rendered& r) {
  if (r.statistics.counts.nonFinite > 0 || r.statistics.photonsRefused > 0) return r.unsound();
  for (size_t layer = 0; layer < r.film.layerCount(); ++layer)
    for (size_t pixel = 0; pixel < r.pixels(); ++pixel)
      if (!isFinite(r.value(pixel, layer))) return "a pixel is not finite";
  return {};
}

Outcome outcomeOf(const RandomScene& scene, uint64_t seed) {
  try {
    const std::unique_ptr<Scene> built = sceneFrom(scene.text, RECURSE_SOURCE_DIR);
    const auto integrator = integratorFrom(scene.integrator, scene.parameters);
    const PathClasses classes = scene.classes.empty() ? PathClasses() : PathClasses(scene.classes);
    const Rendered r = renderScene(*built, *integrator, classes, scene.samplesPerPixel, seed, 1);
    return {{}, unsoundnessOf(r)};
  } catch (const Error& e) {
    return {e.what(), {}};
  }
}

/** Largest number of photons of indirect light at exactly the same point. */
size_t mostInOnePoint(const Scene& scene) {
  ShootSettings settings;
  settings.photons = 256;
  settings.maxDepth = 8;
  settings.direct = false;
  std::map<std::tuple<float, float, float>, size_t> counts;
  size_t most = 0;
  for (const Photon& p : shootPhotons(scene, PathClasses(), Pass(), settings, ForwardControl()).onSurfaces)
    most = std::max(most, ++counts[{p.position.x, p.position.y, p.position.z}]);
  return most;
}

} // namespace

TEST(RandomScenes, SomeHaveManyPhotonsInOnePoint) {
  constexpr uint64_t END = 1000;
  constexpr size_t MANY = 40; // more than the initial capacity of a nearest-neighbour search
  for (uint64_t seed = 0; seed < END; ++seed) {
    const RandomScene scene = RandomSceneWriter(seed).write();
    if (!scene.hasPencil) continue;
    try {
      if (mostInOnePoint(*sceneFrom(scene.text, RECURSE_SOURCE_DIR)) >= MANY) return;
    } catch (const Error&) { // a refused scene
    }
  }
  FAIL() << "none of " << END;
}

TEST(RandomScenes, AreRenderedSoundlyOrRefused) {
  uint64_t first = 0, end = SANITIZED ? 60 : 300;
  const char* range = std::getenv("RECURSE_RANDOM_SCENES");
  if (range) std::istringstream(range) >> first >> end;
  std::vector<uint64_t> seeds(end - first);
  std::iota(seeds.begin(), seeds.end(), first);
  size_t refused = 0;
  for (const uint64_t seed : seeds) {
    const RandomScene scene = RandomSceneWriter(seed).write();
    if (range) std::ofstream("random-scene.pbrt") << "# seed " << seed << "\n" << scene.text;
    const std::clock_t start = std::clock();
    const Outcome outcome = outcomeOf(scene, seed);
    EXPECT_EQ(outcome.unsound, "") << "seed " << seed << "\n" << scene.text;
    if (!outcome.refusal.empty()) ++refused;
    if (range) {
      std::printf("%llu %s %.3f s %.100s\n", static_cast<unsigned long long>(seed), scene.integrator.c_str(),
                  double(std::clock() - start) / CLOCKS_PER_SEC, outcome.refusal.c_str());
      std::fflush(stdout);
    }
  }
  if (!range) {
    EXPECT_LT(refused, seeds.size() / 4);
  }
}
