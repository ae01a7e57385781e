/** @file
 * Building of the guide: kd-trees with median splits, and a density for each cell.
 */
#include "transport/guiding/guideField.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "recurse/core/sampling/equalAreaSquare.h"
#include "recurse/core/sampling/sampling.h"
#include "recurse/core/threads/parallel.h"

namespace recurse {

namespace {

constexpr int MAX_CELL_DEPTH = 24;

/** Index of the signed axis nearest to a normal; one more for normal 0, in a medium. */
size_t bucketOf(const Vec3f& normal) { return normal == Vec3f(0) ? SIGNED_AXES : signedAxis(normal); }

/** Learns one cell from its records. */
class CellFit {
 public:
  explicit CellFit(std::span<const GuideRecord> local) {
    records.assign(local.begin(), local.end());
    const auto firstOfCamera = std::stable_partition(records.begin(), records.end(),
                                                     [](const GuideRecord& r) { return r.fromPhoton; });
    const std::span photons(records.begin(), firstOfCamera), cameraPaths(firstOfCamera, records.end());
    clip(photons);
    clip(cameraPaths);
    const double fromPhotons = std::min(Weights(photons).effectiveCount(), GuideField::MAX_PHOTONS);
    scaleTo(fromPhotons, photons);
    scaleTo(Weights(cameraPaths).effectiveCount(), cameraPaths);
    count = Weights(records).effectiveCount();
    Vec3f sum(0);
    for (const GuideRecord& r : records) sum += r.normal;
    // Each normal is within 55 degrees of the bucket's axis.
    if (local.front().normal != Vec3f(0)) frame = Frame(glm::normalize(sum));
  }

  /** Effective number of records. */
  double effectiveCount() const { return count; }

  /** Tree of the records. */
  SquareTree tree() const {
    std::vector<WeightedPoint> points;
    for (const GuideRecord& r : records) {
      if (!frame) {
        points.push_back({squareOfDirection(r.direction), r.value});
      } else if (const Vec3f local = frame->toLocal(r.direction); local.z > 0) {
        points.push_back({squareOfDisk({local.x, local.y}), r.value});
      }
    }
    return SquareTree(points);
  }

  std::optional<Frame> frame; ///< empty in a medium

 private:
  /** Sums of the values of records. */
  struct Weights {
    double sum = 0, squares = 0;
    explicit Weights(std::span<const GuideRecord> records) {
      for (const GuideRecord& r : records) {
        sum += double(r.value);
        squares += square(double(r.value));
      }
    }
    /** Effective number of records, (Σ value)² / Σ value² (Kish 1965, "Survey Sampling"). */
    double effectiveCount() const { return squares > 0 ? square(sum) / squares : 0; }
  };

  /** Scales the values so that `sum` is their sum. */
  static void scaleTo(double sum, std::span<GuideRecord> scaled) {
    const double before = Weights(scaled).sum;
    if (!(before > 0)) return;
    for (GuideRecord& r : scaled) r.value = static_cast<float>(double(r.value) * sum / before);
  }

  /** Clips values to their 99.9 % quantile, so that no single record dominates the cell. Clipping biases the
   * guide only, not the estimates. */
  static void clip(std::span<GuideRecord> clipped) {
    constexpr double QUANTILE = 0.999;
    if (clipped.empty()) return;
    std::vector<float> values;
    for (const GuideRecord& r : clipped) values.push_back(r.value);
    const auto rank = static_cast<ptrdiff_t>(QUANTILE * double(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + rank, values.end());
    const float limit = values[static_cast<size_t>(rank)];
    for (GuideRecord& r : clipped) r.value = std::min(r.value, limit);
  }

  std::vector<GuideRecord> records;
  double count = 0;
};

} // namespace

float GuideCell::pdf(const Vec3f& direction) const {
  if (!frame) return tree.pdf(squareOfDirection(direction)) * (INV_PI / 4);
  const Vec3f local = frame->toLocal(direction);
  return local.z > 0 ? tree.pdf(squareOfDisk({local.x, local.y})) * local.z * INV_PI : 0;
}

Vec3f GuideCell::sample(Vec2f u, float& density) const {
  const Vec2f point = tree.sample(u, density);
  if (!frame) {
    density *= INV_PI / 4;
    return directionOfSquare(point);
  }
  const Vec3f local = cosineHemisphere(point);
  density *= local.z * INV_PI;
  return frame->toWorld(local);
}

void GuideField::divide(std::span<uint32_t> order, std::span<const GuideRecord> records, uint32_t node,
                        float smallest, int depth, std::vector<std::span<uint32_t>>& leaves) {
  Bounds3f box;
  for (const uint32_t i : order) box.add(records[i].position);
  const Vec3f size = order.empty() ? Vec3f(0) : box.diagonal();
  const int axis = widestAxis(size);
  if (order.size() <= MAX_RECORDS || !(size[axis] >= smallest) || !(size[axis] > 0) ||
      depth >= MAX_CELL_DEPTH) {
    nodes[node].next = static_cast<uint32_t>(leaves.size());
    leaves.push_back(order);
    return;
  }
  const size_t half = order.size() / 2;
  std::nth_element(order.begin(), order.begin() + static_cast<ptrdiff_t>(half), order.end(),
                   [&](uint32_t a, uint32_t b) {
                     return std::pair(records[a].position[axis], a) < std::pair(records[b].position[axis], b);
                   });
  nodes[node].axis = axis;
  nodes[node].split = records[order[half]].position[axis];
  const auto children = static_cast<uint32_t>(nodes.size());
  nodes[node].next = children;
  nodes.resize(nodes.size() + 2);
  divide(order.first(half), records, children, smallest, depth + 1, leaves);
  divide(order.subspan(half), records, children + 1, smallest, depth + 1, leaves);
}

void GuideField::build(std::span<const GuideRecord> records, float smallest) {
  nodes.assign(SIGNED_AXES + 1, {});
  cells.clear();
  std::vector<uint32_t> order(records.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return bucketOf(records[a].normal) < bucketOf(records[b].normal);
  });
  std::vector<std::span<uint32_t>> leaves;
  auto first = order.begin();
  for (size_t bucket = 0; bucket <= SIGNED_AXES; ++bucket) {
    const auto end =
        std::find_if(first, order.end(), [&](uint32_t i) { return bucketOf(records[i].normal) != bucket; });
    divide({first, end}, records, static_cast<uint32_t>(bucket), smallest, 0, leaves);
    first = end;
  }
  cells.resize(leaves.size());
  parallelFor(leaves.size(), [&](size_t i) {
    if (leaves[i].empty()) return;
    std::sort(leaves[i].begin(), leaves[i].end());
    std::vector<GuideRecord> local;
    for (const uint32_t k : leaves[i]) local.push_back(records[k]);
    const CellFit fit(local);
    if (fit.effectiveCount() >= MIN_EFFECTIVE) cells[i] = GuideCell(fit.tree(), fit.frame);
    cells[i].records = local.size();
  });
}

const GuideCell* GuideField::cellAt(const Vec3f& position, const Vec3f& normal) const {
  if (nodes.empty()) return nullptr;
  auto node = static_cast<uint32_t>(bucketOf(normal));
  while (nodes[node].axis >= 0)
    node = nodes[node].next + (position[nodes[node].axis] < nodes[node].split ? 0 : 1);
  return &cells[nodes[node].next];
}

LearnedDirections GuideField::learnedAt(const Vec3f& position, const Vec3f& normal) const {
  const GuideCell* cell = cellAt(position, normal);
  if (!cell) return {};
  return {.guide = cell->hasDensity ? cell : nullptr, .records = cell->records};
}

GuideStatistics GuideField::statistics() const {
  GuideStatistics out;
  for (const GuideCell& c : cells) {
    out.cells += c.records > 0;
    out.cellsOn += c.hasDensity;
    out.records += c.records;
  }
  return out;
}

} // namespace recurse
