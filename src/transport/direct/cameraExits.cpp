/** @file
 * Camera paths that leave the scene, and the crossings of their last segments.
 */
#include "transport/direct/cameraExits.h"

#include <algorithm>
#include <utility>

#include "transport/direct/cameraPaths.h"
#include "transport/paths/walk.h"

namespace recurse {

namespace {

/** Square root of the maximum number of camera paths in a round. */
constexpr int MAX_ACROSS = 128;

/** Indices of the distant lights (infinitely far, in one direction). */
std::vector<size_t> distantLights(const Scene& scene) {
  std::vector<size_t> found;
  for (size_t i = 0; i < scene.lights().size(); ++i)
    if (scene.lights()[i].kind() == LightKind::DISTANT) found.push_back(i);
  return found;
}

/** Adds the exits of `resolution`² camera paths. */
void findExits(const Scene& scene, const std::vector<size_t>& distant, int resolution, uint64_t seed,
               std::vector<CameraExit>& exits, TransportCounts& counts) {
  constexpr int MAX_DEPTH = 5;
  constexpr uint64_t STREAM = 0x504f5254414cull;
  const auto follow = [&](std::vector<CameraExit>& found, CameraSubpath& path, CameraWalker& walker,
                          Sampler& sampler, TransportCounts& pathCounts) {
    CameraVertex vertex;
    bool seenByCamera = true; // directly visible sky needs no photons
    const auto leave = [&](const Hit* hit) {
      if (hit || seenByCamera) return;
      const float weight = maxComponent(path.throughput);
      found.push_back({path.ray.origin, std::min(weight, 1.0f), path.ray.direction});
    };
    while (walker.next(path, vertex, sampler, leave)) {
      if (vertex.isConnectable()) {
        seenByCamera = false;
        if (!distant.empty()) {
          const auto which = static_cast<size_t>(sampler.next1D() * static_cast<float>(distant.size()));
          const auto light = scene.lights()[distant[which]].sampleLi(vertex.point().position, 0, {});
          if (light && glm::dot(light->direction, vertex.point().normalTowards(vertex.wi)) > 0 &&
              visible(scene, vertex.hit, vertex.wi, *light, path.nesting, pathCounts))
            found.push_back(
                {vertex.point().position, std::min(maxComponent(path.throughput), 1.0f), Vec3f(0)});
        }
      }
      if (!walker.scatter(path, vertex, sampler)) break;
    }
  };
  const std::vector<CameraExit> found = collectFromCameraPaths<CameraExit>(
      scene, resolution, MAX_DEPTH, hashCombine(seed, STREAM), counts, follow);
  exits.insert(exits.end(), found.begin(), found.end());
}

/** Crossings of the last segments of exits with others; exits without a crossing have none. */
std::vector<CameraExit> crossingsOf(const std::vector<CameraExit>& exits, uint64_t seed) {
  constexpr size_t OTHERS = 64, CLOSEST = 8; // paths through the same hole are closest, for up to eight holes
  constexpr float PARALLEL = 0.05f;          // maximum squared sine between nearly parallel paths
  struct Approach {
    float distance2, along;
  };
  std::vector<std::optional<CameraExit>> moved(exits.size());
  parallelFor(exits.size(), [&](size_t i) {
    const CameraExit& exit = exits[i];
    if (exit.direction == Vec3f(0)) {
      moved[i] = exit;
      return;
    }
    Sampler sampler(seed, 0x43524f5353ull, static_cast<uint32_t>(i));
    std::vector<Approach> approaches;
    for (size_t k = 0; k < OTHERS; ++k) {
      const auto j = std::min(exits.size() - 1,
                              static_cast<size_t>(sampler.next1D() * static_cast<float>(exits.size())));
      const CameraExit& other = exits[j];
      const float cosine = glm::dot(exit.direction, other.direction);
      if (other.direction == Vec3f(0) || !(1 - cosine * cosine > PARALLEL)) continue;
      const Vec3f between = other.position - exit.position;
      const float a = glm::dot(exit.direction, between), b = glm::dot(other.direction, between);
      const float along = (a - cosine * b) / (1 - cosine * cosine);
      const float otherAlong = (cosine * a - b) / (1 - cosine * cosine);
      if (!(along > 0 && otherAlong > 0)) continue;
      const Vec3f gap = between + other.direction * otherAlong - exit.direction * along;
      approaches.push_back({lengthSquared(gap), along});
    }
    if (approaches.size() < 2 * CLOSEST) return;
    std::nth_element(approaches.begin(), approaches.begin() + CLOSEST, approaches.end(),
                     [](const Approach& a, const Approach& b) { return a.distance2 < b.distance2; });
    std::nth_element(approaches.begin(), approaches.begin() + CLOSEST / 2, approaches.begin() + CLOSEST,
                     [](const Approach& a, const Approach& b) { return a.along < b.along; });
    const float along = approaches[CLOSEST / 2].along;
    moved[i] = exit;
    moved[i]->along = along;
    moved[i]->position += exit.direction * along;
  });
  std::vector<CameraExit> found;
  for (const std::optional<CameraExit>& exit : moved)
    if (exit) found.push_back(*exit);
  return found;
}

/** Exits of as many rounds of camera paths as needed to find openings. */
std::vector<CameraExit> exitsOf(const Scene& scene, const std::vector<size_t>& distant, int resolution,
                                uint64_t seed, TransportCounts& counts) {
  constexpr int ROUNDS = 4;
  std::vector<CameraExit> exits;
  for (int round = 0; round < ROUNDS; ++round) {
    findExits(scene, distant, resolution, hashCombine(seed, uint64_t(round)), exits, counts);
    // Further rounds refine small holes that few paths find; a closed room needs none.
    if (exits.size() >= MANY_POSITIONS || exits.size() < ENOUGH_POSITIONS / ROUNDS) break;
  }
  return exits;
}

} // namespace

std::vector<CameraExit> exitCrossings(const Scene& scene, uint64_t seed, TransportCounts& counts) {
  const FilmSettings& film = scene.film();
  const double pixels = double(film.width) * double(film.height);
  const int resolution = std::clamp(static_cast<int>(std::sqrt(pixels)), 1, MAX_ACROSS);
  std::vector<CameraExit> exits = exitsOf(scene, {}, resolution, seed, counts);
  std::vector<CameraExit> crossings = crossingsOf(exits, seed);
  if (crossings.size() >= ENOUGH_POSITIONS) return crossings;
  if (exits.size() < ENOUGH_POSITIONS) exits.clear(); // otherwise all paths leave from a pane
  return exits;
}

std::vector<CameraExit> exitsAndCrossings(const Scene& scene, uint64_t seed, TransportCounts& counts) {
  const std::vector<size_t> distant = distantLights(scene);
  if (distant.empty() && scene.environment().empty()) return {};
  std::vector<CameraExit> exits = exitsOf(scene, distant, MAX_ACROSS, seed, counts);
  // Vertices alone would enclose a whole room with a wide window, and crossings alone may be far outside of a
  // small one.
  const std::vector<CameraExit> crossings = crossingsOf(exits, seed);
  exits.insert(exits.end(), crossings.begin(), crossings.end());
  if (exits.size() < ENOUGH_POSITIONS) exits.clear();
  return exits;
}

} // namespace recurse
