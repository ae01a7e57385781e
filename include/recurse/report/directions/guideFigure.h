/** @file
 * Figure of path guiding: at single points, the light that arrives, and the densities from which camera paths
 * sample its directions.
 */
#pragma once

#include <array>
#include <atomic>
#include <string>
#include <vector>

#include "recurse/report/figures/figures.h"

namespace recurse {

/** Directions of light at the non-delta surface point that the middle of a pixel sees. */
struct PixelDirections {
  /** Densities over the hemisphere around the geometric normal [1/sr]. */
  enum Density {
    INCIDENT,     ///< proportional to the incident radiance times the cosine
    LEFT_TO_RAYS, ///< proportional to the reflected light that other estimators leave to rays; includes the
                  ///< BSDF
    GUIDE,        ///< learned by the guide, also where camera paths do not sample it
    BSDF,         ///< of BSDF sampling
    MIXTURE,      ///< mixture of the guide and the BSDF, which guided camera paths sample
    DENSITIES
  };
  /** Cells of the equal-area disc, HemisphereDisc::CELLS a row. 0 everywhere: no light, or no density. */
  std::array<std::vector<double>, DENSITIES> densities;
  std::vector<double> solidAngles; ///< of the cells [sr]; 0: outside of the disc
  std::string pixel;               ///< "X,Y"
  double irradiance = 0;           ///< luminance [W/m²], without lights that no ray can hit
  double leftToRays = 0;           ///< luminance of the reflected light of LEFT_TO_RAYS [W/(m² sr)]
  bool isGuidable = true;          ///< false: the material is never guided
  LearnedDirections learned;       ///< valid as long as the integrator's pass
  /** Relative variance of one sample of LEFT_TO_RAYS by BSDF sampling here and by the mixture, with the
   * choice between delta lobes and others; beyond, both have the same paths. NaN without such light. */
  double bsdfVariance = 0, mixtureVariance = 0;

  double integral(Density density) const;
};

/** Directions at pixels, and the guide. */
struct GuideFigure {
  std::vector<PixelDirections> pixels;
  GuideStatistics guide;
};

/**
 * Trains the guide of `integrator`, which must be new, in `stages` stages, and finds the directions at pixels
 * {x, y}. Incident radiance is estimated by `samples` rays for each cell of the disc, the light left to rays
 * by as many camera paths, which follow the mixture and have the MIS weights of the render. Returns early
 * when `stop` becomes true: pixels are then missing or incomplete. Throws Error for integrators that learn no
 * directions, for pixels that see no non-delta surface, and like samplingsFigure().
 */
GuideFigure guideFigure(const Scene& scene, Integrator& integrator,
                        const std::vector<std::array<int, 2>>& pixels, int stages, int64_t samples,
                        uint64_t seed, const std::atomic<bool>& stop);

/** Panels of the densities, a row for each pixel, with one logarithmic scale. The disc is the hemisphere seen
 * from above the surface, with equal areas for equal solid angles and the camera at the bottom. */
std::vector<FigurePanel> guidePanels(const GuideFigure& figure);

} // namespace recurse
