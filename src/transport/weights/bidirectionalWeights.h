/** @file
 * Weights of all techniques that can make the same path from both of its ends: the balance heuristic (Veach
 * 1997, section 9.2.2) with merged photons (Georgiev et al. 2012), of which correlated ones count for fewer
 * (Grittmann et al. 2021). Numbers of formulas are those of doc-files/notes/bidirectional-weights.md.
 */
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace recurse {

/** x_i, as the weights know it. */
struct WeightedVertex {
  double fromCamera = 1; ///< F_i [1/area]; of x_1 for the samples of one pixel; 1/sr stands for a delta lobe
  double fromLight = 1;  ///< B_i [1/area]; of x_k [1/sr] where the light is infinitely far away
  bool delta = false;    ///< scatters by a delta lobe: neither connects nor merges
  double merges = 0;     ///< m_i [area], set by countMerges()
};

/** How densities of photons next to the light are measured. */
enum class LightGeometry {
  SURFACE,  ///< place and direction are spread
  INFINITE, ///< so, but the direction is sampled first
  DELTA     ///< a point, or one direction
};

/** A full path, and how often each technique tries to find it in a pass. */
struct WeightedPath {
  std::span<WeightedVertex> vertices; ///< x_0 … x_k, k >= 1; of x_0 nothing is used
  double splats = 0;                  ///< light paths that are connected to the camera
  double connections = 0;             ///< of x_i and x_i+1, 0 < i < k - 1
  /** Their number times the density with which they choose x_k, as B_k, over that of the steps through panes
   * that follow their start, see shadowRaysThroughPanes(); 0: none finds the path. */
  double shadowRays = 0;
  bool lightIsIntersectable = true; ///< by camera rays: false for delta lights
  double photons = 0;               ///< light paths whose vertices are merged; 0: none
  double mergeArea = 0;             ///< π r² [area], the same for all techniques of a path
  double correlationArea = 0;       ///< A of (3) [area]; 0: every photon counts as independent
  LightGeometry light = LightGeometry::SURFACE;
  // Without merges the sums over techniques at either end are those of shorter paths, and need not be found
  // again.
  size_t summed = 0;            ///< C_0 … C_summed-1 are in `sumNearCamera`
  double sumNearCamera = 0;     ///< over P(C_summed)
  std::optional<double> beyond; ///< the path goes on beyond its last vertex x_k: sumBeyond() of that

  size_t edges() const { return vertices.size() - 1; }
};

/** Finds m_i for all x_i by (3). Photons that come straight from a light are not merged: shadow rays find the
 * same paths without blur. */
void countMerges(const WeightedPath& path);

/** WeightedPath::shadowRays by (4), of shadow rays that start at x_j, j < k - 1, and go straight through the
 * thin panes x_j+1 … x_k-1. `pdf`: with which they choose x_k, as B_k. `pdfDirection` [1/sr]: with which the
 * camera's walk leaves x_j towards the panes. `distanceRatio`: of x_k from x_j over x_k from x_k-1; 1 where
 * the light is infinitely far away. */
double shadowRaysThroughPanes(double pdf, double pdfDirection, double distanceRatio);

/** Samples of C_0 … C_i-1, over P(C_i); 0 <= i < k. */
double sumNearCamera(const WeightedPath& path, size_t i);
/** Samples of C_k-1 and C_k, over P(C_k-1): what is beyond x_k-1. */
double sumBeyond(const WeightedPath& path);
/** What is beyond x_j-1, 1 < j < k, by what is beyond x_j. */
double sumBeyond(const WeightedPath& path, size_t j, double beyond);

/** The weight of C_i, 0 <= i < k. */
double connectionWeight(const WeightedPath& path, size_t i);
/** The weight of C_k. */
double hitWeight(const WeightedPath& path);
/** The weight of M_i, 0 < i < k - 1. */
double mergeWeight(const WeightedPath& path, size_t i);

} // namespace recurse
