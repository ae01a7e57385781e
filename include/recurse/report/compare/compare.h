/** @file
 * How far a picture is from a reference: the error measures of `recurse compare`.
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
/** The part of the pixels that trimming leaves out: those with the largest error. */
constexpr double TRIMMED_FRACTION = 0.001;

/** Red, green, blue, and all channels together. */
using PerChannel = std::array<double, 4>;
constexpr size_t ALL_CHANNELS = 3;

/** Sides of the blocks of pixels over which the error by scale averages. */
constexpr std::array<int, 6> ERROR_SCALES = {1, 2, 4, 8, 16, 32};
/** A value for each; NaN where the picture is smaller than the block. */
using ByScale = std::array<double, ERROR_SCALES.size()>;

/** The error of one class of paths, as `recurse stills` renders them. */
struct ClassError {
  std::string name, expression;     ///< "beauty": all paths
  double share = 0;                 ///< of the reference's mean luminance
  ByScale relMseByScale{};          ///< as of Comparison, of this layer
  ByScale relMseNoiseFreeByScale{}; ///< the same; with two references
};

/**
 * The measures of x against a reference r, over R, G and B. Pixels where r is not finite are left out.
 * Pixels where only x is not finite are left out as well, and counted: a picture with any of them has failed.
 */
struct Comparison {
  size_t pixels = 0;             ///< that were compared
  size_t nonFinite = 0;          ///< pixels of x that are not finite where the reference is
  size_t nonFiniteReference = 0; ///< pixels of any reference that are not finite
  PerChannel mean{}, meanReference{};
  PerChannel meanRatio{};     ///< mean of x over mean of r; NaN where the latter is zero
  PerChannel mse{};           ///< mean of (x − r)²
  PerChannel relMse{};        ///< mean of (x − r)² / (r² + ε)
  PerChannel relMseTrimmed{}; ///< the same without the pixels of largest error
  size_t trimmedPixels = 0;
  PerChannel mape{};    ///< mean of |x − r| / (|r| + ε)
  PerChannel smape{};   ///< mean of |x − r| / ((|x| + |r|) / 2 + ε)
  PerChannel maximum{}; ///< largest |x − r|
  PerChannel psnr{};    ///< 10 log10(peak² / MSE) [dB]; peak is the largest value of r; infinite when equal

  /** With two references a and b whose noise is independent: mean of (x − a)(x − b), plain and over r² + ε.
   *  Free of the references' noise in the mean, and so possibly a little below zero. */
  bool noiseFree = false;
  PerChannel mseNoiseFree{}, relMseNoiseFree{};

  /**
   * relMSE after x and r were averaged over blocks of 1, 2, 4, ... 32 pixels a side: independent noise falls
   * to a quarter from one to the next, stains and bias do not. Over r² + ε as well, but with r smoothed over
   * 7x7 pixels first, so that a reference's noise does not weigh its dark pixels up.
   */
  ByScale relMseByScale{}, relMseNoiseFreeByScale{};

  /** Where addClasses() was called: all paths, then the classes. */
  std::vector<ClassError> classes;
  std::vector<std::string> classesLeftOut; ///< those that not all pictures have, and why

  /** Where addFlip() was called. Over whole pictures: NaN when any pixel is not finite. */
  std::optional<Flip> flip, hdrFlip;

  struct WorstPixel {
    int x = 0, y = 0;
    double error = 0; ///< relative squared error, mean of the channels
    Rgb value{0}, reference{0};
  };
  std::vector<WorstPixel> worst; ///< largest error first
};

/** Compares with one reference. Throws Error where the sizes differ. */
Comparison compareImages(const Image& image, const Image& reference);

/** Compares with the reference r, and free of noise with a and b; without `reference` r is their mean, whose
 * noise stays in the denominator of the relative error. */
Comparison compareImages(const Image& image, const Image& a, const Image& b,
                         const Image* reference = nullptr);

/** The error by scale: mean of (x − a)(x − b) / (r² + ε). Blocks that the border cuts do not count, nor do
 * pixels where any picture is not finite. */
ByScale errorByScale(const Image& x, const Image& a, const Image& b, const Image& r);

/** Adds the errors of the classes that all pictures have under the same name and expression; none where x has
 * no layers. The other pictures are those of compareImages(), without `b` a is the only reference. */
void addClasses(Comparison& comparison, const Image& x, const Image& a, const Image* b = nullptr,
                const Image* reference = nullptr);

/** Adds LDR-FLIP and HDR-FLIP, which take longer than all other measures together. */
void addFlip(Comparison& comparison, const Image& image, const Image& reference);

/** The mean of two pictures of the same size (R, G, B). */
Image meanImage(const Image& a, const Image& b);

/** One measure by the name that JSON and --fail-above give it: mse, relmse, relmse_trimmed, mape, ... Throws
 * Error (BAD_USAGE), with the names there are, for any other. */
double metricByName(const Comparison& comparison, const std::string& name);
std::vector<std::string> metricNames();
/** How the measure of that name is made: ε, denominator, trim. Empty where the name says it all. */
std::string metricDefinition(const std::string& name);

/** What a person reads. */
std::string comparisonTable(const Comparison& comparison);
/** The same as JSON; a number that is not finite becomes null. */
std::string comparisonJson(const Comparison& comparison);

/** Which error a false-colour picture shows. */
enum class ErrorMap {
  RELATIVE, ///< log10 of |x − r| / (|r| + ε), from 0.001 (dark) to 1 (bright)
  SIGNED    ///< (x − r) / (|r| + ε), from −0.5 (blue: too dark) over grey to 0.5 (red: too bright)
};
/** The error of every pixel as a picture; pixels that are not finite are magenta. */
Image errorMap(const Image& image, const Image& reference, ErrorMap kind);

} // namespace recurse
