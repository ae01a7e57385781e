/** @file
 * Error against time: a study renders a scene with several settings, budgets and seeds, measures each picture
 * against references, and tells variance from bias. The report of it is CSV, JSON, a plot and a page.
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

/** What every picture is measured against. */
struct References {
  Image r;    ///< of the denominators, and of every measure that is not free of noise
  Image a, b; ///< two whose noise is independent; both are r where there is only one reference
  bool independent = false;
  std::string description;  ///< what they are and how sure, for a person
  std::string hash() const; ///< of the pixels
};

/** One reference; two that are independent, whose mean is r then; or r and two that are independent. Throws
 * Error where they differ in size or have pixels that are not finite. */
References makeReferences(const std::vector<Image>& images, const std::vector<std::string>& names);

/** A number with its confidence interval of 95%. */
struct Estimate {
  double value = 0, low = 0, high = 0;
};

/**
 * The mean of a quantity over pixels and channels, three a pixel; NaN marks what is left out. The interval
 * comes from the spread of the means of square blocks of pixels, so that errors which neighbours share, such
 * as those of one photon, do not make it too narrow. It takes the picture for a sample of blocks, and so is
 * on the wide side where the quantity itself differs from place to place.
 */
Estimate blockEstimate(const std::vector<double>& values, int width, int height);

/**
 * The squared error of a setting told apart by seeds: variance is that of a pixel over the seeds, and
 * bias² = MSE − variance, the square of what is left when the noise is averaged away. Free of the references'
 * noise where they are independent; else that noise is in bias². The estimate of bias² may be below zero.
 */
struct ErrorSplit {
  Estimate variance, bias2;
  Estimate relVariance, relBias2; ///< over r² + ε, ε = REL_MSE_EPSILON
};
/** Of two pictures or more that differ in their seeds. */
ErrorSplit splitError(const std::vector<Image>& pictures, const References& references);

/** How sure two independent references are. */
struct ReferenceError {
  Estimate relMse;       ///< of their mean: mean of (a − b)² / 4 / (r² + ε)
  double worstShare = 0; ///< the part of it that the worst 0.1% of the pixels make
  std::string text() const;
};
ReferenceError referenceError(const Image& a, const Image& b);

enum class BudgetKind { TIME, SAMPLES, PHOTONS };

/** What a picture may cost: seconds, samples per pixel, or photons. */
struct Budget {
  double amount = 0;
  std::string text; ///< "2s", "16", "1M"
};

/** Settings under a name. */
struct ConvergeRun {
  std::string name;
  std::string settings; ///< in full
};

/** One picture. */
struct ConvergeCell {
  std::string run, budget;
  uint64_t seed = 0;
  double seconds = 0, samplesPerPixel = 0, photons = 0;
  double mse = 0, relMse = 0, relMseTrimmed = 0;
  double mseNoiseFree = 0, relMseNoiseFree = 0; ///< NaN without independent references
  double meanRatio = 0;
  ByScale relMseByScale{}; ///< free of the references' noise where those are independent
  size_t nonFinite = 0;
};

/** Runs, budgets, seeds, and the cells of that grid which are finished. */
struct Study {
  /** Names and values of what all cells must have in common: scene, reference, threads, ... */
  std::vector<std::array<std::string, 2>> identity;
  BudgetKind kind = BudgetKind::TIME;
  std::vector<ConvergeRun> runs;
  std::vector<Budget> budgets; ///< growing
  std::vector<uint64_t> seeds;
  std::vector<ConvergeCell> cells;

  const ConvergeCell* find(const std::string& run, const std::string& budget, uint64_t seed) const;
  /** Takes over what another has; the cells of both must fit, see requireSameStudy(). */
  void include(const Study& other);
};

/** The file with the picture of a cell, relative to the folder of the study. */
std::string cellPictureName(const std::string& run, const std::string& budget, uint64_t seed);

/** Measures a picture; names, seed and costs are left to the caller. */
ConvergeCell measureCell(const Image& picture, const References& references);

/** Throws Error (BAD_USAGE) saying what differs when the cells of `found`, which was read from the folder,
 * cannot stand beside those of `wanted`. Runs, budgets and seeds may be other ones. */
void requireSameStudy(const Study& found, const Study& wanted, const std::string& folder);

/** As JSON, and back. Throws Error naming the file. */
std::string studyJson(const Study& study);
Study readStudy(const std::string& fileName);

/** A run at a budget: what its seeds say together. */
struct ConvergePoint {
  std::string run, budget;
  size_t seeds = 0;
  ConvergeCell mean;                ///< of the seeds' costs and errors
  double smallest = 0, largest = 0; ///< of the seeds' errors that the plot shows
  std::optional<ErrorSplit> split;  ///< of two seeds or more
};

/** Seconds and error, in the order of the seconds. */
using Curve = std::vector<std::array<double, 2>>;

/** error = factor · seconds^exponent: the straight line through a curve in the log-log plot. */
struct PowerLaw {
  double exponent = 0, factor = 0;
  double standardError = 0; ///< of the exponent; NaN with two points
};
/** Least squares of the logarithms; empty with less than two points above zero. */
std::optional<PowerLaw> fitPowerLaw(const Curve& curve);

/** When a curve gets down to an error. */
struct TimeToReach {
  enum class Kind {
    BETWEEN, ///< between two measured points, on the straight line between them in the log-log plot
    BEFORE,  ///< the first point is there already
    BEYOND,  ///< by the fit, at most ten times the longest time measured
    NEVER    ///< neither measured nor within sight
  } kind = Kind::NEVER;
  double seconds = 0;
  std::string text() const;
};
TimeToReach timeToReach(const Curve& curve, double error);

/** Errors for the table, falling: 1, 2 and 5 times powers of ten within what the curves span. */
std::vector<double> targetErrors(const std::vector<Curve>& curves);

/** A study and what it says. */
struct StudyReport {
  Study study;
  std::string title, label;
  References references;
  std::vector<ConvergePoint> points; ///< by run, then by budget
};
/** Reads the pictures in the folder for variance and bias. */
StudyReport reportOf(const Study& study, const References& references, const std::string& folder);

/** What is plotted. */
struct ErrorMeasure {
  const char *key, *title, *definition;
  double (*of)(const ConvergePoint& point); ///< NaN where it is not known
};
/** Those that the report has; the first is the one to look at. */
std::vector<ErrorMeasure> errorMeasures(const StudyReport& report);
Curve curveOf(const StudyReport& report, const std::string& run, const ErrorMeasure& measure);

/** What a person reads on the terminal. */
std::string studyTable(const StudyReport& report);
/** A line for each cell, and a line for each point. */
std::string cellsCsv(const StudyReport& report);
std::string pointsCsv(const StudyReport& report);
/** For gnuplot: draws error against time as PNG. */
std::string plotScript(const StudyReport& report);
/** Plots, tables, and the pictures of the first seed; needs nothing but itself. */
std::string convergePage(const StudyReport& report, const std::string& folder);

/** Writes cells.csv, points.csv, plot.gp, index.html, and plot.png by gnuplot where that is installed.
 * Returns a remark for a person where there is no plot.png; else nothing. */
std::string writeReport(const StudyReport& report, const std::string& folder);

} // namespace recurse
