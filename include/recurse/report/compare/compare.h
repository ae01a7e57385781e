/** @file
 * Error measures of `recurse compare`, between a picture and a reference.
 */
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "recurse/core/image/image.h"
#include "recurse/report/compare/flip.h"

namespace recurse {

/** ε in the denominator of every relative squared error: reference² + ε. */
constexpr double REL_MSE_EPSILON = 0.01;
/** ε in the denominator of MAPE (|reference| + ε) and SMAPE ((|x| + |reference|) / 2 + ε). */
constexpr double MAPE_EPSILON = 0.01;
/** Fraction of the pixels that trimming omits: the pixels with the largest error. */
constexpr double TRIMMED_FRACTION = 0.001;

/** Values for red, green, blue, and all channels together. */
using PerChannel = std::array<double, 4>;
constexpr size_t ALL_CHANNELS = 3;

/** Block sizes of the error by scale [pixels]. */
constexpr std::array<int, 6> ERROR_SCALES = {1, 2, 4, 8, 16, 32};
/** Value for each block size; NaN where the picture is smaller than the block. */
using ByScale = std::array<double, ERROR_SCALES.size()>;

/** Error of one class of paths, as rendered by `recurse stills`. */
struct ClassError {
  std::string name, expression;     ///< "beauty": all paths
  double share = 0;                 ///< fraction of the reference's mean luminance
  ByScale relMseByScale{};          ///< see Comparison, for this layer
  ByScale relMseNoiseFreeByScale{}; ///< see Comparison, for this layer; with two references
};

/**
 * Error measures of x against a reference r, over R, G and B. Pixels where any reference is not finite are
 * omitted. Pixels where only x is not finite are omitted as well, and counted: a picture with any of them has
 * failed.
 */
struct Comparison {
  size_t pixels = 0;             ///< pixels compared
  size_t nonFinite = 0;          ///< pixels of x that are not finite where the reference is
  size_t nonFiniteReference = 0; ///< pixels of any reference that are not finite
  PerChannel mean{}, meanReference{};
  PerChannel meanRatio{};     ///< mean of x over mean of r; NaN where the latter is zero
  PerChannel mse{};           ///< mean of (x − r)²
  PerChannel relMse{};        ///< mean of (x − r)² / (r² + ε)
  PerChannel relMseTrimmed{}; ///< relMse without the pixels of largest error
  size_t trimmedPixels = 0;
  PerChannel mape{};    ///< mean of |x − r| / (|r| + ε)
  PerChannel smape{};   ///< mean of |x − r| / ((|x| + |r|) / 2 + ε)
  PerChannel maximum{}; ///< largest |x − r|
  PerChannel psnr{};    ///< 10 log10(peak² / MSE) [dB]; peak is the largest value of r; infinite when equal

  /** With two references a and b of independent noise: mean of (x − a)(x − b), plain and over r² + ε. The
   * noise of the references cancels in expectation, so that values slightly below zero are possible. */
  bool noiseFree = false;
  PerChannel mseNoiseFree{}, relMseNoiseFree{};

  /**
   * relMSE after averaging x and r over blocks of 1, 2, 4, ... 32 pixels a side: independent noise falls to a
   * quarter from one to the next, blotches and bias do not. The denominator r² + ε uses r smoothed over 7x7
   * pixels, so that the noise of a reference does not increase the weight of dark pixels.
   */
  ByScale relMseByScale{}, relMseNoiseFreeByScale{};

  /** Set by addClasses(): all paths, then the classes. */
  std::vector<ClassError> classes;
  std::vector<std::string> classesLeftOut; ///< classes of x that a reference does not have, and why

  /** Set by addFlip(). Over whole pictures: NaN when any pixel is not finite. */
  std::optional<Flip> flip, hdrFlip;

  struct WorstPixel {
    int x = 0, y = 0;
    double error = 0; ///< relative squared error, mean over the channels
    Rgb value{0}, reference{0};
  };
  std::vector<WorstPixel> worst; ///< largest error first
};

/** Compares with one reference. Throws Error where the sizes differ, or R, G or B is missing. */
Comparison compareImages(const Image& image, const Image& reference);

/** Compares with the reference r, and free of noise with a and b. Without `reference`, r is their mean, whose
 * noise remains in the denominator of relative errors. Throws Error like the function above. */
Comparison compareImages(const Image& image, const Image& a, const Image& b,
                         const Image* reference = nullptr);

/** Error by scale of pictures of the same size: mean of (x − a)(x − b) / (r² + ε), see
 * Comparison::relMseByScale. Blocks cut by the border are omitted, and so are pixels where any picture is not
 * finite. */
ByScale errorByScale(const Image& x, const Image& a, const Image& b, const Image& r);

/** Adds the errors of the classes that all pictures have under the same name and expression; none where x has
 * no layers. Arguments as in compareImages(); without `b`, a is the only reference. */
void addClasses(Comparison& comparison, const Image& x, const Image& a, const Image* b = nullptr,
                const Image* reference = nullptr);

/** Adds LDR-FLIP and HDR-FLIP, which take longer than all other measures together. */
void addFlip(Comparison& comparison, const Image& image, const Image& reference);

/** Mean of two pictures of the same size (R, G, B). */
Image meanImage(const Image& a, const Image& b);

/** Measure of all channels by its name in JSON and in --fail-above: mse, relmse, relmse_trimmed, mape, ...
 * Throws Error (BAD_USAGE) for a measure that the comparison does not have, and with all valid names for an
 * unknown one. */
double metricByName(const Comparison& comparison, const std::string& name);
/** All names of measures, also of those that a comparison may not have. */
std::vector<std::string> metricNames();
/** Definition of the measure: ε, denominator, trimming. Empty for errors by scale, and where the name is a
 * full definition. */
std::string metricDefinition(const std::string& name);

/** Comparison as a table for people. */
std::string comparisonTable(const Comparison& comparison);
/** Comparison as JSON; numbers that are not finite become null. */
std::string comparisonJson(const Comparison& comparison);

/** Error shown by a false-colour picture. */
enum class ErrorMap {
  RELATIVE, ///< |x − r| / (|r| + ε), on a logarithmic scale from 0.001 (dark) to 1 (bright)
  SIGNED    ///< (x − r) / (|r| + ε), from −0.5 (blue: too dark) over grey to 0.5 (red: too bright)
};
/** Error of every pixel, mean over the channels, in false colours; pixels that are not finite are magenta.
 * Throws Error where the sizes differ. */
Image errorMap(const Image& image, const Image& reference, ErrorMap kind);

} // namespace recurse
