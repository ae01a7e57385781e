/** @file
 * Building of the guide: kd-trees with median splits; a density and an on/off decision for each cell.
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

  /** Tree of the records whose index modulo 2 is `remainder`; of all records if it is negative. */
  SquareTree tree(int remainder) const {
    std::vector<WeightedPoint> chosen;
    for (size_t i = 0; i < records.size(); ++i) {
      if (remainder >= 0 && static_cast<int>(i % 2) != remainder) continue;
      const Vec3f& direction = records[i].direction;
      if (!frame) {
        chosen.push_back({squareOfDirection(direction), records[i].value});
      } else if (const Vec3f local = frame->toLocal(direction); local.z > 0) {
        chosen.push_back({squareOfDisk({local.x, local.y}), records[i].value});
      }
    }
    return SquareTree(chosen);
  }

  /** Mean logarithm of the density of the mixture over the density of BSDF sampling (Müller 2019, "Practical
   * Path Guiding in Production", section 10.5). Cross-validated: the tree is built from the records with even
   * index, and scored on those with odd index. */
  double gain() const {
    const GuideCell half(tree(0), frame);
    double sum = 0, total = 0;
    for (size_t i = 1; i < records.size(); i += 2) {
      const GuideRecord& r = records[i];
      constexpr float A = GuideCell::BSDF_PROBABILITY;
      sum += double(r.value) * std::log(double(A + (1 - A) * half.pdf(r.direction) / r.pdfBsdf));
      total += double(r.value);
    }
    return total > 0 ? sum / total : 0;
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
  std::vector<double> gains(leaves.size()), counts(leaves.size());
  parallelFor(leaves.size(), [&](size_t i) {
    if (leaves[i].empty()) return;
    std::sort(leaves[i].begin(), leaves[i].end());
    std::vector<GuideRecord> local;
    for (const uint32_t k : leaves[i]) local.push_back(records[k]);
    const CellFit fit(local);
    if (fit.effectiveCount() >= MIN_EFFECTIVE) {
      gains[i] = fit.gain();
      counts[i] = fit.effectiveCount();
      cells[i] = GuideCell(fit.tree(-1), fit.frame);
    }
    cells[i].records = local.size();
  });
  // Shrinks the gains of cells with few records towards the mean of all cells (empirical Bayes).
  const double all = std::accumulate(counts.begin(), counts.end(), 0.0);
  const double mean =
      std::inner_product(gains.begin(), gains.end(), counts.begin(), 0.0) / std::max(all, 1.0);
  for (size_t i = 0; i < cells.size(); ++i) {
    cells[i].gain = (gains[i] * counts[i] + mean * PRIOR_COUNT) / (counts[i] + PRIOR_COUNT);
    cells[i].on = cells[i].hasDensity && cells[i].gain >= MIN_GAIN;
  }
  on = static_cast<size_t>(
      std::count_if(cells.begin(), cells.end(), [](const GuideCell& c) { return c.isOn(); }));
}

const GuideCell* GuideField::cellAt(const Vec3f& position, const Vec3f& normal) const {
  if (nodes.empty()) return nullptr;
  auto node = static_cast<uint32_t>(bucketOf(normal));
  while (nodes[node].axis >= 0)
    node = nodes[node].next + (position[nodes[node].axis] < nodes[node].split ? 0 : 1);
  return &cells[nodes[node].next];
}

GuideStatistics GuideField::statistics() const {
  GuideStatistics out{.cellsOn = on};
  for (const GuideCell& c : cells) {
    out.cells += c.records > 0;
    out.records += c.records;
  }
  return out;
}

} // namespace recurse
