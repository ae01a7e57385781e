/** @file
 * Error against time: a study renders a scene with several settings, budgets and seeds, compares each picture
 * with references, and separates variance and bias. It is reported as CSV, JSON, a plot and a page.
 */
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "recurse/core/image/image.h"
#include "recurse/report/compare/compare.h"

namespace recurse {

/** References with which all pictures are compared. */
struct References {
  Image r;    ///< for denominators, and for all measures that are not free of noise
  Image a, b; ///< references of independent noise; both are r if there is only one reference
  bool independent = false;
  std::string description;  ///< origin and uncertainty, for people
  std::string hash() const; ///< hash of the pixels
};

/** References from one picture; from two independent ones, with r as their mean; or from r and two
 * independent ones, in this order. Throws Error for other numbers of images, where sizes differ, and for
 * pixels that are not finite. */
References makeReferences(const std::vector<Image>& images, const std::vector<std::string>& names);

/** Number with its 95 % confidence interval; NaN where unknown. */
struct Estimate {
  double value = 0, low = 0, high = 0;
};

/**
 * Mean of a quantity over pixels and channels, three for each pixel; NaN marks omitted values. The interval,
 * of two standard errors to each side, is derived from the variance of the means of square pixel blocks, so
 * that errors correlated between neighbours, such as the errors of one photon, do not make it too narrow. The
 * picture is treated as a sample of blocks, so the interval is conservative where the quantity varies over
 * the picture.
 */
Estimate blockEstimate(const std::vector<double>& values, int width, int height);

/**
 * Decomposition of the squared error of a setting: variance of a pixel over the seeds, and bias² = MSE −
 * variance, the squared error without noise. Free of the references' noise where they are independent; else
 * bias² includes that noise. The estimate of bias² may be below zero.
 */
struct ErrorSplit {
  Estimate variance, bias2;
  Estimate relVariance, relBias2; ///< over r² + ε, ε = REL_MSE_EPSILON
};
/** Decomposition for pictures that differ in their seeds. Throws Error for less than two, and where sizes
 * differ. Pixels that are not finite in a picture are omitted. */
ErrorSplit splitError(const std::vector<Image>& pictures, const References& references);

/** Error of two independent references. */
struct ReferenceError {
  Estimate relMse;       ///< of their mean: mean of (a − b)² / 4 / (r² + ε)
  double worstShare = 0; ///< fraction of it due to the worst 0.1 % of the pixels
  std::string text() const;
};
/** Error of the mean of two independent references. */
ReferenceError referenceError(const Image& a, const Image& b);

/** Cost that budgets limit. */
enum class BudgetKind { TIME, SAMPLES, PHOTONS };

/** Cost limit of a picture by BudgetKind: seconds, samples per pixel, or photons. */
struct Budget {
  double amount = 0;
  std::string text; ///< "2s", "16", "1M"
};

/** Named settings. */
struct ConvergeRun {
  std::string name;
  std::string settings; ///< complete settings
};

/** Measurements of one picture. */
struct ConvergeCell {
  std::string run, budget;
  uint64_t seed = 0;
  double seconds = 0, samplesPerPixel = 0, photons = 0; ///< seconds: time of the render [s]
  double mse = 0, relMse = 0, relMseTrimmed = 0;
  double mseNoiseFree = 0, relMseNoiseFree = 0; ///< NaN without independent references
  double meanRatio = 0;
  ByScale relMseByScale{}; ///< free of the references' noise if these are independent
  size_t nonFinite = 0;
};

/** Runs, budgets and seeds, and the finished cells of that grid. */
struct Study {
  /** Names and values of the common properties of all cells: scene, reference, threads, ... */
  std::vector<std::array<std::string, 2>> identity;
  BudgetKind kind = BudgetKind::TIME;
  std::vector<ConvergeRun> runs;
  std::vector<Budget> budgets; ///< increasing
  std::vector<uint64_t> seeds;
  std::vector<ConvergeCell> cells;

  /** Finished cell; null: there is none. */
  const ConvergeCell* find(const std::string& run, const std::string& budget, uint64_t seed) const;
  /** Adds runs, budgets, seeds and cells of a study that are missing here; both must fit, see
   * requireSameStudy(). */
  void include(const Study& other);
};

/** File of a cell's picture, relative to the folder of the study. */
std::string cellPictureName(const std::string& run, const std::string& budget, uint64_t seed);

/** Measures a picture; the caller sets names, seed and costs. */
ConvergeCell measureCell(const Image& picture, const References& references);

/** Throws Error (BAD_USAGE) with the differences when the cells of `found`, read from the folder, cannot be
 * combined with the cells of `wanted`. Runs, budgets and seeds may differ. */
void requireSameStudy(const Study& found, const Study& wanted, const std::string& folder);

/** Study as JSON, and from a JSON file. Throws Error naming the file. */
std::string studyJson(const Study& study);
Study readStudy(const std::string& fileName);

/** Statistics over the seeds of a run at a budget. */
struct ConvergePoint {
  std::string run, budget;
  size_t seeds = 0;
  ConvergeCell mean;                ///< mean of the seeds; nonFinite: sum
  double smallest = 0, largest = 0; ///< range of the seeds' errors in the plot
  std::optional<ErrorSplit> split;  ///< for at least two seeds
};

/** Points of seconds and error, in the order of seconds. */
using Curve = std::vector<std::array<double, 2>>;

/** Power law error = factor · seconds^exponent: a straight line in the log-log plot. */
struct PowerLaw {
  double exponent = 0, factor = 0;
  double standardError = 0; ///< of the exponent; NaN with two points
};
/** Least-squares fit of the logarithms; empty with less than two points above zero, or nearly equal times. */
std::optional<PowerLaw> fitPowerLaw(const Curve& curve);

/** Time at which a curve reaches an error. */
struct TimeToReach {
  enum class Kind {
    BETWEEN, ///< interpolated between two measured points, linearly in the log-log plot
    BEFORE,  ///< the first point has reached it already
    BEYOND,  ///< extrapolated from the last point by the fitted exponent, at most tenfold in time
    NEVER    ///< neither measured nor extrapolated
  } kind = Kind::NEVER;
  double seconds = 0; ///< BEFORE: time of the first point; NEVER: 0
  std::string text() const;
};
TimeToReach timeToReach(const Curve& curve, double error);

/** Decreasing errors for the table: 1, 2 and 5 times powers of ten within the range of the curves. */
std::vector<double> targetErrors(const std::vector<Curve>& curves);

/** Study with its evaluation. */
struct StudyReport {
  Study study;
  std::string title, label;
  References references;
  std::vector<ConvergePoint> points; ///< sorted by run, then by budget
};
/** Evaluates a study; reads the pictures in the folder for variance and bias. Throws Error for one that
 * cannot be read. */
StudyReport reportOf(const Study& study, const References& references, const std::string& folder);

/** Error measure to be plotted. */
struct ErrorMeasure {
  const char *key, *title, *definition;
  double (*of)(const ConvergePoint& point); ///< NaN where unknown
};
/** Measures in the report; the most relevant one first. */
std::vector<ErrorMeasure> errorMeasures(const StudyReport& report);
/** Curve of a run by a measure, of the points where it is finite. */
Curve curveOf(const StudyReport& report, const std::string& run, const ErrorMeasure& measure);

/** Table for the terminal. */
std::string studyTable(const StudyReport& report);
/** CSV files with a line for each cell, and with a line for each point. */
std::string cellsCsv(const StudyReport& report);
std::string pointsCsv(const StudyReport& report);
/** Script for gnuplot: draws the first measure against time as PNG. */
std::string plotScript(const StudyReport& report);
/** Self-contained page with plots, tables, and the pictures of the first seed. */
std::string convergePage(const StudyReport& report, const std::string& folder);

/** Writes cells.csv, points.csv, plot.gp, index.html, and plot.png if gnuplot is installed. Returns a remark
 * for people where there is no plot.png, else an empty string. Throws Error where a file cannot be written,
 * or gnuplot fails. */
std::string writeReport(const StudyReport& report, const std::string& folder);

} // namespace recurse
