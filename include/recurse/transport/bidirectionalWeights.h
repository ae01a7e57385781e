/** @file
 * Weights of all techniques that can make the same path from both of its ends: the balance heuristic (Veach
 * 1997, section 9.2.2) over hits, shadow rays, connections, splats and merged photons (Georgiev et al. 2012,
 * "Light Transport Simulation with Vertex Connection and Merging"), in which merged photons count for as many
 * as are independent (Grittmann et al. 2021, "Correlation-Aware Multiple Importance Sampling for
 * Bidirectional Rendering Algorithms").
 *
 * A path has k edges, from x_0 at the camera to x_k at the light. Technique C_i connects x_i with x_i+1, what
 * the camera walked to with what the light walked to: C_0 is a splat, C_k-1 a shadow ray, C_k a hit of the
 * light. M_i merges a photon with x_i. With F_j and B_j the densities with which walks from the camera and
 * from the light come to x_j,
 *
 *     P(C_i) = F_1 … F_i B_i+1 … B_k   (1)        P(M_i) = P(C_i) B_i m_i   (2)
 *
 * and each technique is weighted by its number of samples times its density over the sum of these.
 */
#pragma once

#include <cstddef>
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
  double shadowRays = 0;              ///< their number times the density with which they choose x_k, as B_k
  bool lightIsMet = true;             ///< by chance: false for delta lights
  double photons = 0;                 ///< light paths whose vertices are merged; 0: none
  double mergeArea = 0;               ///< π r² [area], the same for all techniques of a path
  double correlationArea = 0;         ///< A of (3) [area]; 0: every photon counts as independent
  LightGeometry light = LightGeometry::SURFACE;

  size_t edges() const { return vertices.size() - 1; }
};

/**
 * Finds m_i for all x_i: the photons times their area times the part of them that is independent. With Q the
 * chance that the camera's walk finds the same vertices up to x_i again, to within an area A, and S the same
 * for the light's walk, this part is
 *
 *     c_i = Q / (Q + S - Q S)   (3)
 *
 * but at least one photon, and all at x_1. Photons that come straight from a light are not merged: shadow
 * rays find the same paths without blur.
 */
void countMerges(const WeightedPath& path);

/** The weight of C_i, 0 <= i < k. */
double connectionWeight(const WeightedPath& path, size_t i);
/** The weight of C_k. */
double hitWeight(const WeightedPath& path);
/** The weight of M_i, 0 < i < k - 1. */
double mergeWeight(const WeightedPath& path, size_t i);

} // namespace recurse
