/** @file
 * Figures: pictures of the techniques of a method side by side, each with its contributions alone. Functions
 * return early once `stop` is true; their pictures are then incomplete or missing.
 */
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "recurse/core/image/image.h"
#include "recurse/render/render.h"
#include "recurse/report/figures/figureDrawing.h"

namespace recurse {

/** Scale of a panel in false colours. */
struct ColourScale {
  double low = 0, high = 1;
  std::string unit;
  bool diverging = false;     ///< blue to red around the middle; else from dark violet to yellow
  bool isLogarithmic = false; ///< low and high are above 0

  /** Value at a position in [0, 1] from low to high. */
  double valueAt(double position) const;
  /** Colour of a value; values outside of the scale have the colour of its end. */
  Rgb colour(double value) const;
};

/** Picture of a figure, at a place in its grid. */
struct FigurePanel {
  Image image; ///< R, G, B, linear
  std::string name;
  int row = 0;                           ///< from the top, counted from 0
  float column = 0;                      ///< from the left; a pyramid has panels halfway between columns
  float exposure = 0;                    ///< [stops]
  std::optional<ColourScale> scale = {}; ///< drawn below the picture, for false colours
};

/** Panel of a quantity of each pixel, row by row from the top, in the scale's colours; black: not finite. */
FigurePanel scaledPanel(const PixelBounds& crop, const std::vector<double>& values, const ColourScale& scale,
                        const std::string& name, int row, float column);

/** Value below which the fraction, in [0, 1], of the values is. They must not be empty. */
double quantileOf(std::vector<double> values, double fraction);

/** Curve of a plot. Points with a coordinate of 0 or less are left out. */
struct FigureCurve {
  std::string name;
  Rgb colour;
  std::vector<Vec2d> points;
};

/** Plot with logarithmic axes. */
struct FigurePlot {
  std::string name, xName, yName;
  std::vector<FigureCurve> curves;
  double slope = 0; ///< of the dashed line for comparison; 0: none
};

/** Sheet of panels of the same size with their names, and of a plot below them unless it is null. */
FigureDrawing figureSheet(const std::string& title, const std::string& subtitle,
                          const std::vector<FigurePanel>& panels, const FigurePlot* plot = nullptr);

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
 * each unweighted and weighted, and both together. Light that only one of them can find is in both unweighted
 * pictures. `path`: new. */
std::vector<FigurePanel> misPanels(const Scene& scene, Integrator& path, const RenderSettings& settings,
                                   const std::atomic<bool>& stop);

/** Samplings of direct light, side by side. */
struct SamplingsFigure {
  std::vector<FigurePanel> panels; ///< uniform, cosine, BSDF, light, and both by multiple importance sampling
  FigurePlot plot;                 ///< root of the mean squared error over the mean, by number of samples
};

/**
 * Estimates the direct light at the points that the middles of pixels see, directly or through mirrors and
 * glass, by `samples` independent rays of each sampling. Errors are measured against a picture of both
 * samplings with eight times the samples, whose own variance is subtracted. Panels include the emission that
 * the camera sees. Throws Error for scenes with media or dielectrics with a priority, or without lights.
 */
SamplingsFigure samplingsFigure(const Scene& scene, int64_t samples, uint64_t seed,
                                const std::atomic<bool>& stop);

/** Makers of the integrators of estimateFigure(), new for each call. */
struct EstimateMethods {
  std::function<std::unique_ptr<Integrator>()> photonMap; ///< one map of all light
  std::function<std::unique_ptr<Integrator>()> path;      ///< unbiased
};

/** Layers of a photon radiance estimate. Errors are relative to the mean of the picture. */
struct EstimateFigure {
  /** Radiance of one map, of all maps, and of the paths; bias, standard deviation, standard error of the
   * bias; photons and radius of an estimate, of caustic ones apart. */
  std::vector<FigurePanel> panels;
  double squaredBias = 0; ///< mean over the picture, without the noise of the bias; may be negative
  double variance = 0;    ///< mean over the picture, of one map
  double biasError = 0;   ///< median standard error of the bias
};

/**
 * Estimates the radiance towards the middles of pixels by `maps` independent photon maps. The variance is
 * theirs; the bias is their mean less that of `referenceSamples` paths for the same camera rays. Light that
 * the camera sees without non-delta scattering is left out. Both numbers must be above 1. No panels once
 * `stop` is true. Throws Error for scenes with media, and for black pictures.
 */
EstimateFigure estimateFigure(const Scene& scene, const EstimateMethods& methods, int maps,
                              int64_t referenceSamples, uint64_t seed, const std::atomic<bool>& stop);

/** Picture of direct light by shadow rays that start at a fixed distance from their surface. */
struct AcnePicture {
  Image image;      ///< R, G, B
  float offset = 0; ///< along the geometric normal [scene units]; negative: SurfacePoint::rayOrigin()
  double acne = 0;  ///< fraction of shadow rays that are blocked, but not by the rule of rayOrigin()
  double leaks = 0; ///< fraction that is not blocked, but is by the rule
};

/** Direct light at the points that the middles of pixels see, and seen emission, by the same shadow rays with
 * each offset and last with the rule. Throws Error like samplingsFigure(). */
std::vector<AcnePicture> acnePictures(const Scene& scene, const std::vector<float>& offsets, int64_t samples,
                                      uint64_t seed, const std::atomic<bool>& stop);
/** Zero, and fractions of the scene's radius. */
std::vector<float> defaultOffsets(const Scene& scene);
/** Panels of acnePictures(), named by offset, acne and leaks, with the exposure of the last. */
std::vector<FigurePanel> acnePanels(std::vector<AcnePicture> pictures);

/** Panels of radiosity: patches in the colour of their indirect radiosity with lines of the mesh, the same
 * light interpolated between corners, and the picture with direct light. `radiosity`: new. Throws Error if it
 * divides no surface of the scene. */
std::vector<FigurePanel> patchesPanels(const Scene& scene, Integrator& radiosity,
                                       const RenderSettings& settings, const std::atomic<bool>& stop);

/** Number of samples of each pixel that a render takes: more than wanted where each of its passes needs one.
 */
int64_t samplesTaken(const Integrator& integrator, const RenderSettings& settings);

/** Panels of the mean cost of a pixel's samples in false colours: rays, photons of density estimates, and
 * processor time [us], with the range in the name: the 1st to the 99th percentile. `integrator`: new. Without
 * photons, no panel of them. */
std::vector<FigurePanel> costPanels(const Scene& scene, Integrator& integrator,
                                    const RenderSettings& settings, const std::atomic<bool>& stop);

} // namespace recurse
