/** @file
 * Figures: pictures of the techniques of a method side by side, each with its contributions alone.
 */
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "recurse/core/image/image.h"
#include "recurse/render/render.h"

namespace recurse {

/** Picture of a figure, at a place in its grid. */
struct FigurePanel {
  Image image; ///< R, G, B, linear
  std::string name;
  int row = 0;
  float column = 0;   ///< a pyramid has panels halfway between columns
  float exposure = 0; ///< [stops]
};

/** Sheet of panels of the same size with their names, in linear values, to be written without exposure. */
Image figureSheet(const std::string& title, const std::string& subtitle,
                  const std::vector<FigurePanel>& panels);

/** Strategy of bidirectional path tracing (Veach 1997, section 10.2) and its pictures. */
struct StrategyPictures {
  int lightVertices = 0, cameraVertices = 0; ///< s and t; paths have s + t - 1 edges
  Image weighted; ///< contributions times MIS weights: they add up to the picture of paths with 2 to N edges
  Image unweighted; ///< an estimate of the paths of this length by the strategy alone
};

/**
 * Pictures of all strategies for paths of 2 to `longest` edges: for each length with s = 0 (hits of lights),
 * s = 1 (light samples), connections, and t = 1 (light paths connected to the camera). `bidirectional`: bdpt;
 * `lightPaths`: lightpath; both new. Returns early when `stop` becomes true.
 */
std::vector<StrategyPictures> strategyPictures(const Scene& scene, Integrator& bidirectional,
                                               Integrator& lightPaths, const RenderSettings& settings,
                                               int longest, const std::atomic<bool>& stop);

/** Panels of the strategies: a pyramid with a row for each length, and s increasing to the right. The rows
 * have exposures of their own, by the sum of the weighted pictures. */
std::vector<FigurePanel> pyramidPanels(const std::vector<StrategyPictures>& strategies, bool weighted);

/** Panels of multiple importance sampling (Veach and Guibas 1995): shadow rays alone, rays of the BSDF alone,
 * each unweighted and weighted, and both together. Light that only one of them can find is in both pictures
 * of a technique alone. `path`: new. */
std::vector<FigurePanel> misPanels(const Scene& scene, Integrator& path, const RenderSettings& settings,
                                   const std::atomic<bool>& stop);

/** Number of samples of each pixel that a render takes: more than wanted where each of its passes needs one.
 */
int64_t samplesTaken(const Integrator& integrator, const RenderSettings& settings);

/** Panels of the cost of a pixel in false colours: rays, photons of density estimates, and processor time
 * [us], with the range in the name. `integrator`: new. Photons are left out if there are none. */
std::vector<FigurePanel> costPanels(const Scene& scene, Integrator& integrator,
                                    const RenderSettings& settings, const std::atomic<bool>& stop);

} // namespace recurse
