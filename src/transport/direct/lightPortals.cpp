/** @file
 * Learning and sampling of portals.
 */
#include "transport/direct/lightPortals.h"

#include <algorithm>
#include <utility>

#include "transport/direct/cameraPaths.h"
#include "transport/paths/walk.h"

namespace recurse {

namespace {

/** Fraction of photons that start on the whole disc, for openings that no camera path has found. */
constexpr float DISC_PART = 0.1f;
/** Minimum number of exits; fewer do not represent the openings of a scene. */
constexpr size_t MIN_EXITS = 64;
/** Square root of the maximum number of camera paths in a round. */
constexpr int MAX_ACROSS = 128;

/** Areas of a box's three sides, as seen along a direction. */
Vec3f projectedSides(const Bounds3f& box, const Vec3f& direction) {
  const Vec3f d = box.diagonal(), w = magnitude(direction);
  return {w.x * d.y * d.z, w.y * d.z * d.x, w.z * d.x * d.y};
}

/** Indices of the distant lights (infinitely far, in one direction). */
std::vector<size_t> distantLights(const Scene& scene) {
  std::vector<size_t> found;
  for (size_t i = 0; i < scene.lights().size(); ++i)
    if (scene.lights()[i].kind() == LightKind::DISTANT) found.push_back(i);
  return found;
}

} // namespace

void LightPortals::findExits(const Scene& sceneToLearn, const std::vector<size_t>& distant, int across,
                             uint64_t seed, std::vector<Exit>& exits, TransportCounts& counts) {
  constexpr int MAX_DEPTH = 5;
  constexpr uint64_t STREAM = 0x504f5254414cull;
  using Exits = std::vector<Exit>;
  const auto follow = [&](Exits& found, CameraSubpath& path, CameraWalker& walker, Sampler& sampler,
                          TransportCounts& pathCounts) {
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
          const auto light = sceneToLearn.lights()[distant[which]].sampleLi(vertex.point().position, 0, {});
          if (light && glm::dot(light->direction, vertex.point().normalTowards(vertex.wi)) > 0 &&
              visible(sceneToLearn, vertex.hit, vertex.wi, *light, path.nesting, pathCounts))
            found.push_back(
                {vertex.point().position, std::min(maxComponent(path.throughput), 1.0f), Vec3f(0)});
        }
      }
      if (!walker.scatter(path, vertex, sampler)) break;
    }
  };
  for (const Exits& row :
       followCameraPaths(sceneToLearn, across, MAX_DEPTH, hashCombine(seed, STREAM), counts, Exits(), follow))
    exits.insert(exits.end(), row.begin(), row.end());
}

void LightPortals::moveToCrossings(std::vector<Exit>& exits, uint64_t seed) {
  constexpr size_t OTHERS = 64, CLOSEST = 8; // paths through the same hole are closest, for up to eight holes
  constexpr float PARALLEL = 0.05f;          // maximum squared sine between nearly parallel paths
  struct Approach {
    float distance2, along;
  };
  std::vector<Exit> moved(exits.size());
  std::vector<char> known(exits.size());
  parallelFor(exits.size(), [&](size_t i) {
    const Exit& exit = exits[i];
    moved[i] = exit;
    known[i] = exit.direction == Vec3f(0);
    if (known[i]) return;
    Sampler sampler(seed, 0x43524f5353ull, static_cast<uint32_t>(i));
    std::vector<Approach> approaches;
    for (size_t k = 0; k < OTHERS; ++k) {
      const auto j = std::min(exits.size() - 1,
                              static_cast<size_t>(sampler.next1D() * static_cast<float>(exits.size())));
      const Exit& other = exits[j];
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
    moved[i].along = approaches[CLOSEST / 2].along;
    moved[i].position += exit.direction * moved[i].along;
    known[i] = true;
  });
  std::vector<Exit> found;
  for (size_t i = 0; i < exits.size(); ++i)
    if (known[i]) found.push_back(moved[i]);
  exits = std::move(found);
}

std::vector<LightPortals::Exit> LightPortals::exitsOf(const Scene& scene, const std::vector<size_t>& distant,
                                                      int across, uint64_t seed, TransportCounts& counts) {
  constexpr size_t MANY = 8 * MIN_EXITS;
  constexpr int ROUNDS = 4;
  std::vector<Exit> exits;
  for (int round = 0; round < ROUNDS; ++round) {
    findExits(scene, distant, across, hashCombine(seed, uint64_t(round)), exits, counts);
    // Further rounds refine small holes that few paths find; a closed room needs none.
    if (exits.size() >= MANY || exits.size() < MIN_EXITS / ROUNDS) break;
  }
  return exits;
}

std::vector<LightPortals::Exit> LightPortals::crossings(const Scene& scene, uint64_t seed,
                                                        TransportCounts& counts) {
  const FilmSettings& film = scene.film();
  const double pixels = double(film.width) * double(film.height);
  const int across = std::clamp(static_cast<int>(std::sqrt(pixels)), 1, MAX_ACROSS);
  std::vector<Exit> exits = exitsOf(scene, {}, across, seed, counts);
  std::vector<Exit> crossings = exits;
  moveToCrossings(crossings, seed);
  if (crossings.size() >= MIN_EXITS) return crossings;
  if (exits.size() < MIN_EXITS) exits.clear(); // otherwise all paths leave from a pane
  return exits;
}

void LightPortals::learn(const Scene& sceneToLearn, uint64_t seed, TransportCounts& counts) {
  boxes = {};
  blocks.clear();
  scene = sceneToLearn.bounds();
  const std::vector<size_t> distant = distantLights(sceneToLearn);
  if (distant.empty() && sceneToLearn.environment().empty()) return;
  std::vector<Exit> exits = exitsOf(sceneToLearn, distant, MAX_ACROSS, seed, counts);
  // Vertices alone would enclose a whole room with a wide window, and crossings alone may be far outside of a
  // small one.
  std::vector<Exit> crossings = exits;
  moveToCrossings(crossings, seed);
  exits.insert(exits.end(), crossings.begin(), crossings.end());
  enclose(exits);
}

void LightPortals::enclose(const std::vector<Exit>& exits) {
  constexpr int LEVELS = 6;       // at most 2^LEVELS leaves
  constexpr float MARGIN = 1e-3f; // relative to the scene's radius; a pane is flat
  if (exits.size() < MIN_EXITS) return;
  std::vector<WeightedPosition> positions;
  for (const Exit& exit : exits) positions.push_back({exit.position, exit.weight});
  boxes = NestedBoxes(std::move(positions), LEVELS, MARGIN * scene.radius);
  const std::span<const NestedBoxes::Box> all(boxes.begin(), boxes.end());
  for (size_t first = 0; first < all.size(); first += 8)
    blocks.emplace_back(all.subspan(first, std::min<size_t>(8, all.size() - first)));
}

float LightPortals::openPart() const {
  // A convex body's silhouette is a quarter of its surface, over all directions (Cauchy).
  float open = 0;
  for (const NestedBoxes::Box& box : boxes) {
    if (!box.leaf) continue;
    const Vec3f d = box.bounds.diagonal();
    open += (d.x * d.y + d.y * d.z + d.z * d.x) / 2;
  }
  return open * scene.pdfDisc();
}

void LightPortals::redirect(LeSample& sample, float pick, const Vec2f& u) const {
  const Vec3f& w = sample.direction;
  const NestedBoxes::Box* chosen = nullptr;
  if (pick >= DISC_PART) {
    pick = (pick - DISC_PART) / (1 - DISC_PART);
    chosen = &boxes.choose(pick);
    // Samples a side that faces the light, in proportion to its projected area.
    const Vec3f sides = projectedSides(chosen->bounds, w);
    float remaining = pick * (sides.x + sides.y + sides.z);
    int axis = 0;
    while (axis < 2 && (remaining >= sides[axis] || sides[axis] == 0)) remaining -= sides[axis++];
    const Vec3f d = chosen->bounds.diagonal();
    Vec3f point = chosen->bounds.lower;
    if (w[axis] < 0) point[axis] = chosen->bounds.upper[axis];
    point[(axis + 1) % 3] += u.x * d[(axis + 1) % 3];
    point[(axis + 2) % 3] += u.y * d[(axis + 2) % 3];
    sample.origin = point - w * (glm::dot(point - scene.center, w) + scene.radius);
  }
  const float before = sample.pdfPosition;
  sample.pdfPosition = pdf(sample.origin, w, chosen);
  sample.flux *= before / sample.pdfPosition;
}

LightPortals::BoxBlock::BoxBlock(std::span<const NestedBoxes::Box> boxes) {
  alignas(32) float lanes[8];
  const auto gathered = [&](const auto& value) {
    for (size_t i = 0; i < 8; ++i) lanes[i] = i < boxes.size() ? value(boxes[i]) : 0;
    return Float8::load(lanes);
  };
  for (int axis = 0; axis < 3; ++axis) {
    lower[size_t(axis)] = gathered([&](const NestedBoxes::Box& b) { return b.bounds.lower[axis]; });
    upper[size_t(axis)] = gathered([&](const NestedBoxes::Box& b) { return b.bounds.upper[axis]; });
    sides[size_t(axis)] = gathered([&](const NestedBoxes::Box& b) {
      const Vec3f d = b.bounds.diagonal();
      return d[(axis + 1) % 3] * d[(axis + 2) % 3];
    });
  }
  chances = gathered([](const NestedBoxes::Box& b) { return b.chance; });
}

float LightPortals::BoxBlock::pdf(const Vec3f& point, const Vec3f& direction, uint32_t met) const {
  Float8 from(-INFINITE), to(INFINITE), inside = Float8::lanes(0xff), silhouette(0);
  for (size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<int>(i);
    const Float8 p(point[axis]), d(direction[axis]);
    silhouette += abs(d) * sides[i];
    if (direction[axis] == 0) {
      inside = inside & lessEqual(lower[i], p) & lessEqual(p, upper[i]);
      continue;
    }
    const Float8 a = (lower[i] - p) / d, b = (upper[i] - p) / d;
    from = max(from, min(a, b));
    to = min(to, max(a, b));
  }
  const uint32_t mask = met | bits(inside & lessEqual(from, to) & less(Float8(0), chances));
  return mask == 0 ? 0 : sum((chances / silhouette) & Float8::lanes(mask));
}

float LightPortals::pdf(const Vec3f& point, const Vec3f& direction, const NestedBoxes::Box* met) const {
  const size_t known = met ? static_cast<size_t>(met - &*boxes.begin()) : 8 * blocks.size();
  float sum = 0;
  for (size_t i = 0; i < blocks.size(); ++i)
    sum += blocks[i].pdf(point, direction, known / 8 == i ? 1u << (known % 8) : 0);
  return DISC_PART * scene.pdfDisc() + (1 - DISC_PART) * sum;
}

} // namespace recurse
