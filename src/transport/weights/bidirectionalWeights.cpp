/** @file
 * MIS weights of bidirectional techniques, from ratios of neighbouring ones: products of the densities
 * themselves would overflow on long paths.
 */
#include "transport/weights/bidirectionalWeights.h"

#include <algorithm>

namespace recurse {

namespace {

/** Sums over the techniques on either side of C_i, over P(C_i). */
class Techniques {
 public:
  explicit Techniques(const WeightedPath& path) : path(path), x(path.vertices), k(path.edges()) {}

  /** Number of samples of C_i, i < k - 1. */
  double connections(size_t i) const {
    if (x[i + 1].delta || (i > 0 && x[i].delta)) return 0;
    return i == 0 ? path.splats : path.connections;
  }
  /** Number of samples of C_k-1, times B_k. */
  double shadowRays() const { return k == 1 ? 0 : path.shadowRays; }
  /** Number of samples of C_k. */
  double hits() const { return path.lightIsIntersectable ? 1 : 0; }
  /** Sum of the techniques nearer to the camera than C_i, and of M_i; i < k. */
  double nearCamera(size_t i) const {
    double sum = 0;
    for (size_t j = 1; j <= i; ++j)
      sum = x[j].merges * x[j].fromLight + x[j].fromLight / x[j].fromCamera * (connections(j - 1) + sum);
    return sum;
  }
  /** Sum of the techniques nearer to the light than C_i; i < k - 1. */
  double nearLight(size_t i) const {
    double sum = (shadowRays() + x[k].fromCamera * hits()) / x[k].fromLight; // C_k-1 and C_k, over P(C_k-1)
    for (size_t j = k - 1; j > i + 1; --j) sum = sumFromMerge(j, sum) + connections(j - 1);
    return sumFromMerge(i + 1, sum);
  }
  /** Sum of M_j, C_j and all techniques beyond, over P(C_j-1). */
  double sumFromMerge(size_t j, double beyond) const {
    return x[j].merges * x[j].fromCamera + x[j].fromCamera / x[j].fromLight * beyond;
  }

  const WeightedPath& path;
  std::span<const WeightedVertex> x;
  size_t k;
};

} // namespace

double shadowRaysThroughPanes(double pdf, double pdfDirection, double distanceRatio) {
  return pdf / pdfDirection * (distanceRatio * distanceRatio);
}

double connectionWeight(const WeightedPath& path, size_t i) {
  const Techniques t(path);
  if (i + 1 < t.k) return t.connections(i) / (t.connections(i) + t.nearCamera(i) + t.nearLight(i));
  // Multiplied by B_k, which is 0 where shadow rays find the light but photons never start.
  const double shadowRays = t.shadowRays(), light = t.x[t.k].fromLight;
  return shadowRays / (shadowRays + light * t.nearCamera(i) + t.x[t.k].fromCamera * t.hits());
}

double hitWeight(const WeightedPath& path) {
  const Techniques t(path);
  if (t.k == 1) return 1;
  const double light = t.x[t.k].fromLight;
  // Without shadow rays, the factor of the sum is 0 / 0 where the light has no photons.
  const double others = t.shadowRays() + (light > 0 ? light * t.nearCamera(t.k - 1) : 0);
  return 1 / (1 + others / t.x[t.k].fromCamera);
}

double mergeWeight(const WeightedPath& path, size_t i) {
  const Techniques t(path);
  const double merge = t.x[i].merges * t.x[i].fromLight;
  return merge / (t.connections(i) + t.nearCamera(i) + t.nearLight(i));
}

std::vector<TechniqueWeight> techniqueWeights(const WeightedPath& path) {
  const size_t k = path.edges();
  std::vector<TechniqueWeight> all;
  const auto add = [&](bool isMerge, size_t i, double weight) {
    if (weight > 0) all.push_back({isMerge, i, weight});
  };
  for (size_t i = 0; i < k; ++i) add(false, i, connectionWeight(path, i));
  if (path.lightIsIntersectable) add(false, k, hitWeight(path));
  for (size_t i = 1; i + 1 < k; ++i) add(true, i, mergeWeight(path, i));
  return all;
}

void countMerges(const WeightedPath& path) {
  const auto x = path.vertices;
  const size_t k = path.edges();
  const double area = path.correlationArea;
  if (path.photons == 0) return;
  for (WeightedVertex& v : x) v.merges = 0;
  if (k < 3) return;
  // Delta lobes contribute a factor of 1: their directions are reproduced.
  double light = x[k - 1].fromLight * area; // S of (3), from the position and direction of emission
  if (path.light != LightGeometry::DELTA) light *= x[k].fromLight;
  if (path.light == LightGeometry::SURFACE) light *= area;
  light = std::min(1.0, light);
  for (size_t i = k - 2; i > 0; --i) {
    if (!x[i + 1].delta) light *= std::min(1.0, x[i].fromLight * area);
    x[i].merges = light; // S of (3); m_i follows below
  }
  double camera = 1; // Q of (3)
  for (size_t i = 1; i + 1 < k; ++i) {
    if (i == 1 || !x[i - 1].delta) camera *= std::min(1.0, x[i].fromCamera * area);
    const double either = camera + x[i].merges - camera * x[i].merges;
    const bool all = i == 1 || area == 0 || !(either > 0);
    const double independent = all ? 1 : std::max(camera / either, 1 / path.photons);
    x[i].merges = x[i].delta ? 0 : path.photons * path.mergeArea * independent;
  }
}

} // namespace recurse
