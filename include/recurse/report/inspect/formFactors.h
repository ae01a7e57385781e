/** @file
 * Form factors between the patches of a radiosity solution.
 */
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "recurse/transport/integrator/integrator.h"

namespace recurse {

/** Rays from one side of a patch that arrive at a patch, on either side. */
struct FormFactorHits {
  uint32_t patch = 0, rays = 0;
};

/** Form factors from one side of a patch to all patches; those that are not listed are 0. */
struct FormFactors {
  size_t side = 0;                  ///< 0: outer
  std::vector<FormFactorHits> hits; ///< by increasing patch
};

/**
 * Estimates the form factors of all patches by rays with the density of the cosine from points that are
 * uniform in the surface's coordinates: on flat faces, in area as well. The form factor from i to j is the
 * fraction of rays from i that hit j first. Of each patch, the side with more RadiosityPatch::received. The
 * standard error of a form factor F is sqrt(F (1 - F) / rays). Without rays, only the sides are set.
 * `patches`: all patches of Integrator::visitPatches(), in this order. `stop` leaves the remaining entries of
 * the result empty.
 */
std::vector<FormFactors> formFactors(const Scene& scene, const Integrator& integrator,
                                     std::span<const RadiosityPatch> patches, uint32_t raysPerPatch,
                                     uint64_t seed, const std::atomic<bool>& stop);

/** Largest number of patches whose form factors a page has. */
constexpr size_t MOST_FACTOR_PATCHES = 60000;

/** Number of rays for each patch, so that a page with all form factors has a moderate size; 0 above
 * MOST_FACTOR_PATCHES. */
uint32_t formFactorRays(size_t patches);

} // namespace recurse
