/** @file
 * Search for boxes by camera paths, and densities of rays through boxes.
 */
#include "transport/emission/emissionBoxes.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "recurse/core/sampling/sampling.h"
#include "transport/direct/cameraExits.h"
#include "transport/direct/cameraPaths.h"

namespace recurse {

namespace {

struct WeightedPosition {
  Vec3f position;
  float weight;
};

struct NestedBox {
  Bounds3f bounds;
  float chance; ///< probability of this box
};

Float8 withLane(const Float8& a, size_t lane, float value) {
  return select(Float8::lanes(1u << lane), Float8(value), a);
}

/** Vertices of camera paths of a few bounces, weighted by throughput (at most 1). */
std::vector<WeightedPosition> cameraVertices(const Scene& scene, uint64_t seed, TransportCounts& counts) {
  constexpr int ACROSS = 64, MAX_DEPTH = 3;
  constexpr uint64_t STREAM = 0x41494d53ull;
  std::vector<WeightedPosition> positions = collectAtCameraVertices<WeightedPosition>(
      scene, ACROSS, MAX_DEPTH, hashCombine(seed, STREAM), counts,
      [](std::vector<WeightedPosition>& found, const CameraSubpath& path, const CameraVertex& vertex) {
        found.push_back({vertex.point().position, std::min(maxComponent(path.throughput), 1.0f)});
      });
  if (positions.size() < ENOUGH_POSITIONS) positions.clear();
  return positions;
}

/** Adds boxes around positions: leaves with about equal numbers of them, and boxes around leaves. */
void split(std::span<WeightedPosition> positions, int levels, float margin, std::vector<NestedBox>& boxes) {
  // Enclosing boxes sample the space between leaves hundreds of times as often as without them.
  constexpr float INNER = 0.1f;
  Bounds3f bounds;
  float weight = 0;
  for (const WeightedPosition& p : positions) {
    bounds.add(p.position);
    weight += p.weight;
  }
  const float more = POSITION_MARGIN * glm::length(bounds.diagonal()) + margin; // a pane is flat
  if (levels == 0 || positions.size() < ENOUGH_POSITIONS) {
    bounds.lower -= more;
    bounds.upper += more;
    boxes.push_back({bounds, weight});
    return;
  }
  if (levels % 2 == 0) {
    boxes.push_back({{bounds.lower - more, bounds.upper + more}, INNER * weight});
  }
  const int axis = widestAxis(bounds.diagonal());
  const size_t middle = positions.size() / 2;
  std::nth_element(positions.begin(), positions.begin() + static_cast<std::ptrdiff_t>(middle),
                   positions.end(), [&](const WeightedPosition& a, const WeightedPosition& b) {
                     return a.position[axis] < b.position[axis];
                   });
  split(positions.first(middle), levels - 1, margin, boxes);
  split(positions.subspan(middle), levels - 1, margin, boxes);
}

/** Boxes around positions, with probabilities that follow the weights; empty without positions. `levels`:
 * there are at most 2^levels leaves; `margin`: margin around each box [scene units]. */
std::vector<NestedBox> nestedBoxes(std::vector<WeightedPosition> positions, int levels, float margin) {
  std::vector<NestedBox> boxes;
  if (positions.empty()) return boxes;
  split(positions, levels, margin, boxes);
  float sum = 0;
  for (const NestedBox& box : boxes) sum += box.chance;
  for (NestedBox& box : boxes) box.chance /= sum;
  return boxes;
}

} // namespace

void BoxBlock::set(size_t lane, const Bounds3f& bounds) {
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<size_t>(i);
    lower[axis] = withLane(lower[axis], lane, bounds.lower[i]);
    upper[axis] = withLane(upper[axis], lane, bounds.upper[i]);
    centers[axis] = withLane(centers[axis], lane, bounds.center()[i]);
  }
  radii2 = withLane(radii2, lane, lengthSquared(bounds.diagonal()) / 4);
}

Bounds3f BoxBlock::bounds(size_t lane) const {
  const auto i = static_cast<int>(lane);
  return {{lower[0][i], lower[1][i], lower[2][i]}, {upper[0][i], upper[1][i], upper[2][i]}};
}

BoxBlock::Line::Line(const Light& light, const LeRay& ray, float lightDensity)
    : origin(ray.origin), direction(ray.direction), inverse(Vec3f(1) / ray.direction),
      lightDensity(lightDensity), infinite(light.isInfinite()) {
  LeRay back = ray;
  back.direction = -ray.direction;
  if (!infinite && ray.normal != Vec3f(0) && light.pdfLe(back).direction > 0) factor = 0.5f;
}

Float8 BoxBlock::acrossSilhouettes(const Line& line, uint32_t hitBoxes) const {
  Float8 from(-INFINITE), to(INFINITE), inside = Float8::lanes(0xff), silhouette(0);
  for (size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<int>(i);
    const size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const Float8 p(line.origin[axis]);
    silhouette += Float8(std::abs(line.direction[axis])) * (upper[j] - lower[j]) * (upper[k] - lower[k]);
    if (line.direction[axis] == 0) {
      inside = inside & lessEqual(lower[i], p) & lessEqual(p, upper[i]);
      continue;
    }
    const Float8 inverse(line.inverse[axis]), a = (lower[i] - p) * inverse, b = (upper[i] - p) * inverse;
    from = max(from, min(a, b));
    to = min(to, max(a, b));
  }
  const uint32_t hit = hitBoxes | bits(inside & lessEqual(from, to) & less(Float8(0), silhouette));
  return hit == 0 ? Float8(0) : Float8(1) / silhouette & Float8::lanes(hit);
}

Float8 BoxBlock::inCones(const Line& line, uint32_t hitBoxes) const {
  std::array<Float8, 3> way;
  Float8 distance2(0), apart2(0);
  for (size_t i = 0; i < 3; ++i) {
    way[i] = centers[i] - Float8(line.origin[static_cast<int>(i)]);
    distance2 += way[i] * way[i];
  }
  const Float8 inverse2 = Float8(1) / distance2, sine2 = radii2 * inverse2, inverse = sqrt(inverse2);
  for (size_t i = 0; i < 3; ++i) {
    const Float8 apart = Float8(line.direction[static_cast<int>(i)]) - way[i] * inverse;
    apart2 += apart * apart;
  }
  // 1 - cosine of the half-angle of the cone, without cancellation.
  const Float8 opening = sine2 / (Float8(1) + sqrt(max(Float8(0), Float8(1) - sine2)));
  const uint32_t hit = hitBoxes | bits(lessEqual(apart2, Float8(2) * opening) & less(Float8(0), opening));
  const Float8 density = Float8(line.factor * INV_PI / 2) / opening & Float8::lanes(hit);
  return select(less(sine2, Float8(1)), density, Float8(line.lightDensity));
}

void EmissionBoxes::learn(const Scene& scene, uint64_t seed, TransportCounts& counts) {
  constexpr int EXIT_LEVELS = 6, VERTEX_LEVELS = 4; // at most 2^LEVELS leaves
  constexpr float MARGIN = 1e-5f;                   // relative to the scene's radius
  *this = {};
  std::vector<WeightedPosition> vertices = cameraVertices(scene, seed, counts), exits;
  if (vertices.empty()) return;
  for (const CameraExit& exit : exitsAndCrossings(scene, seed, counts))
    exits.push_back({exit.position, exit.weight});
  const float margin = MARGIN * scene.bounds().radius;
  const auto append = [&](const std::vector<NestedBox>& boxes) {
    const size_t first = 8 * blocks.size();
    blocks.resize(blocks.size() + (boxes.size() + 7) / 8);
    chances.resize(8 * blocks.size(), 0.0f);
    for (size_t i = 0; i < boxes.size(); ++i) {
      blocks[(first + i) / 8].set((first + i) % 8, boxes[i].bounds);
      chances[first + i] = boxes[i].chance;
    }
  };
  append(nestedBoxes(std::move(exits), EXIT_LEVELS, margin));
  exitBlocks = blocks.size();
  append(nestedBoxes(std::move(vertices), VERTEX_LEVELS, margin));
}

} // namespace recurse
