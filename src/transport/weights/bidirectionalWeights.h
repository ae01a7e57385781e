/** @file
 * MIS weights of all techniques that can sample the same path from both of its ends: the balance heuristic
 * (Veach 1997, section 9.2.2) with merges (Georgiev et al. 2012), fewer of which count where they are
 * correlated (Grittmann et al. 2021). Formula numbers refer to doc-files/notes/bidirectional-weights.md.
 */
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace recurse {

/** Path vertex x_i, with the densities of both walks. */
struct WeightedVertex {
  double fromCamera = 1; ///< F_i [1/area]; at x_1 for the samples of one pixel; 1/sr for a delta lobe
  double fromLight = 1;  ///< B_i [1/area]; at x_k [1/sr] if the light is infinite
  bool delta = false;    ///< scatters by a delta lobe: neither connects nor merges
  double merges = 0;     ///< m_i [area], set by countMerges()
};

/** Measure of the light walk's first densities. */
enum class LightGeometry {
  SURFACE,  ///< position and direction are both sampled
  INFINITE, ///< position and direction are both sampled, the direction first
  DELTA     ///< a fixed position, or a fixed direction
};

/** Full path, and the number of samples that each technique takes of it in a pass. */
struct WeightedPath {
  std::span<WeightedVertex> vertices; ///< x_0 … x_k, k >= 1; the data of x_0 is unused
  double splats = 0;                  ///< light paths connected to the camera
  double connections = 0;             ///< connections of x_i and x_i+1, 0 < i < k - 1
  /** Number of shadow rays times their density at x_k, in the measure of B_k, over the density of the steps
   * through panes after their start, see shadowRaysThroughPanes(); 0: none finds the path. */
  double shadowRays = 0;
  bool lightIsIntersectable = true; ///< false for delta lights, which camera rays cannot hit
  double photons = 0;               ///< light paths whose vertices are merged; 0: none
  double mergeArea = 0;             ///< π r² [area], the same for all techniques of a path
  double correlationArea = 0;       ///< A of (3) [area]; 0: all photons count as independent
  LightGeometry light = LightGeometry::SURFACE;

  size_t edges() const { return vertices.size() - 1; }
};

/** Computes m_i of all x_i by (3). Photons straight from a light are not merged: shadow rays find the same
 * paths without blur. */
void countMerges(const WeightedPath& path);

/** Computes WeightedPath::shadowRays by (4), for shadow rays that start at x_j, j < k - 1, and pass straight
 * through the thin panes x_j+1 … x_k-1. `pdf`: their density at x_k, in the measure of B_k. `pdfDirection`:
 * density with which the camera walk leaves x_j towards the panes [1/sr]. `distanceRatio`: distance of x_k
 * from x_j over its distance from x_k-1; 1 for infinite lights. */
double shadowRaysThroughPanes(double pdf, double pdfDirection, double distanceRatio);

/** MIS weight of C_i, 0 <= i < k. */
double connectionWeight(const WeightedPath& path, size_t i);
/** MIS weight of C_k. */
double hitWeight(const WeightedPath& path);
/** MIS weight of M_i, 0 < i < k - 1. */
double mergeWeight(const WeightedPath& path, size_t i);

/** MIS weight of C_index or M_index. */
struct TechniqueWeight {
  bool isMerge = false;
  size_t index = 0;
  double weight = 0;
};
/** Weights of all techniques that can make a path without partial sums. */
std::vector<TechniqueWeight> techniqueWeights(const WeightedPath& path);

} // namespace recurse
