/** @file
 * Learning and sampling of the emission density.
 */
#include "transport/emission/emissionGuide.h"

#include <algorithm>
#include <cmath>

#include "recurse/core/sampling/sampler.h"

namespace recurse {

namespace {

double volumeOf(const EmissionGuide::Numbers& low, const EmissionGuide::Numbers& high) {
  double volume = 1;
  for (size_t d = 0; d < EmissionGuide::DIMENSIONS; ++d) volume *= double(high[d]) - double(low[d]);
  return volume;
}

} // namespace

uint64_t VisibleRegion::Cells::key(int level, const Vec3f& position) {
  const double side = std::ldexp(1.0, level);
  uint64_t key = mixBits(static_cast<uint64_t>(level + 4096));
  for (int axis = 0; axis < 3; ++axis)
    key = hashCombine(key,
                      static_cast<uint64_t>(static_cast<int64_t>(std::floor(double(position[axis]) / side))));
  return key;
}

void VisibleRegion::add(const Vec3f& position, float size) { surfaces.add(position, size, 1); }

void VisibleRegion::addInMedium(const Vec3f& position, float size, float weight) {
  media.add(position, size, weight);
}

void VisibleRegion::Cells::add(const Vec3f& position, float size, float weight) {
  int level = 0;
  std::frexp(2 * size, &level); // the cell's side is at least 2·size
  if (std::find(levels.begin(), levels.end(), level) == levels.end()) levels.push_back(level);
  std::array<uint64_t, 8> keys;
  for (size_t corner = 0; corner < 8; ++corner) {
    Vec3f p = position;
    for (int axis = 0; axis < 3; ++axis) p[axis] += corner >> axis & 1 ? size : -size;
    keys[corner] = key(level, p);
  }
  std::sort(keys.begin(), keys.end());
  const auto end = std::unique(keys.begin(), keys.end());
  for (auto k = keys.begin(); k != end; ++k) weights[*k] += std::ldexp(weight, -2 * level);
}

float VisibleRegion::Cells::importance(const Vec3f& position) const {
  float sum = 0;
  for (const int level : levels)
    if (const auto found = weights.find(key(level, position)); found != weights.end()) sum += found->second;
  return sum;
}

EmissionGuide::EmissionGuide(std::span<const TrainingSample> useful, double trials, size_t lights)
    : lights(lights) {
  std::vector<TrainingSample> parts(useful.begin(), useful.end()); // split() reorders them
  Numbers low, high;
  low.fill(0);
  high.fill(1);
  split(parts, low, high, trials, 0);
  // Until the loop below, Leaf.density is √p.
  double sum = 0, plain = 0, variance = 0;
  for (Leaf& leaf : leaves) {
    const double volume = volumeOf(leaf.low, leaf.high);
    sum += volume * leaf.density;
    plain += volume * square(leaf.density);
    leaf.chance = sum;
  }
  if (!(sum > 0)) {
    *this = {};
    return;
  }
  for (Leaf& leaf : leaves) {
    const double p = square(leaf.density);
    leaf.chance /= sum;
    leaf.density = UNIFORM_PART + (1 - UNIFORM_PART) * leaf.density / sum;
    variance += volumeOf(leaf.low, leaf.high) * p / leaf.density;
  }
  expectedGain = plain / variance;
}

void EmissionGuide::split(std::span<TrainingSample> useful, const Numbers& low, const Numbers& high,
                          double trials, int depth) {
  const auto node = nodes.size();
  nodes.push_back({-1, 0, static_cast<uint32_t>(leaves.size())});
  double weight = 0, squared = 0;
  for (const TrainingSample& u : useful) {
    weight += double(u.weight);
    squared += square(double(u.weight));
  }
  // Minimum logarithm of the likelihood ratio of a split, for significance over all possible splits.
  constexpr double SIGNIFICANT = 8;
  constexpr int DEEPEST = 40;
  double best = SIGNIFICANT;
  size_t dimension = DIMENSIONS;
  float at = 0;
  const double count = squared > 0 ? square(weight) / squared : 0; // effective sample size
  if (depth < DEEPEST && count >= 8)
    for (size_t d = 0; d < DIMENSIONS; ++d) {
      std::array<double, 4> quarters{};
      const float width = high[d] - low[d];
      for (const TrainingSample& u : useful)
        quarters[std::min<size_t>(3, static_cast<size_t>(4 * (u.numbers[d] - low[d]) / width))] +=
            double(u.weight);
      double left = 0;
      for (int i = 1; i < 4; ++i) {
        left += quarters[size_t(i - 1)];
        const double f = i / 4.0, leftFraction = left / weight;
        const double evidence =
            count * ((leftFraction > 0 ? leftFraction * std::log(leftFraction / f) : 0) +
                     (leftFraction < 1 ? (1 - leftFraction) * std::log((1 - leftFraction) / (1 - f)) : 0));
        if (evidence <= best) continue;
        best = evidence;
        dimension = d;
        at = low[d] + width * static_cast<float>(f);
      }
    }
  // Lights may contribute from different regions, which is not significant for all of them together.
  if (dimension == DIMENSIONS && depth < DEEPEST && count >= 16 &&
      double(high[0] - low[0]) * double(lights) > 1) {
    dimension = 0;
    at = (low[0] + high[0]) / 2;
  }
  if (dimension == DIMENSIONS || !(at > low[dimension] && at < high[dimension])) {
    leaves.push_back({low, high, std::sqrt(weight / trials / volumeOf(low, high)), 0});
    return;
  }
  const auto middle = std::partition(useful.begin(), useful.end(),
                                     [&](const TrainingSample& u) { return u.numbers[dimension] < at; });
  const auto leftCount = static_cast<size_t>(middle - useful.begin());
  Numbers lowRight = low, highLeft = high;
  lowRight[dimension] = highLeft[dimension] = at;
  nodes[node].dimension = static_cast<int>(dimension);
  nodes[node].at = at;
  split(useful.first(leftCount), low, highLeft, trials, depth + 1);
  nodes[node].other = static_cast<uint32_t>(nodes.size());
  split(useful.subspan(leftCount), lowRight, high, trials, depth + 1);
}

float EmissionGuide::warp(Numbers& numbers, float choice) const {
  if (!active()) return 1;
  const Leaf* leaf = nullptr;
  if (double(choice) < UNIFORM_PART) {
    size_t node = 0;
    while (nodes[node].dimension >= 0)
      node = numbers[size_t(nodes[node].dimension)] < nodes[node].at ? node + 1 : nodes[node].other;
    leaf = &leaves[nodes[node].other];
  } else {
    const double c = (double(choice) - UNIFORM_PART) / (1 - UNIFORM_PART);
    leaf = &*std::upper_bound(leaves.begin(), leaves.end() - 1, c,
                              [](double value, const Leaf& l) { return value < l.chance; });
    for (size_t d = 0; d < DIMENSIONS; ++d)
      numbers[d] = std::min(leaf->low[d] + numbers[d] * (leaf->high[d] - leaf->low[d]),
                            std::nextafter(leaf->high[d], 0.0f));
  }
  return static_cast<float>(leaf->density);
}

} // namespace recurse
