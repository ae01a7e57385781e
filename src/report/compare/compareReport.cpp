/** @file
 * Error measures as a table, as JSON and by name.
 */
#include <cmath>
#include <functional>

#include <nlohmann/json.hpp>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"
#include "recurse/report/compare/compare.h"

namespace recurse {

namespace {

std::string number(double value, int digits = 6) { return formatted("%.*g", digits, value); }

struct Metric {
  const char* name;  ///< JSON key; with _rgb for the three channels
  const char* title; ///< row of the table
  std::string definition;
  const PerChannel Comparison::*values;
  bool noiseFree = false;
};

const std::vector<Metric>& metrics() {
  const std::string epsilon = "ε " + number(REL_MSE_EPSILON);
  const std::string mapeEpsilon = "ε " + number(MAPE_EPSILON);
  const std::string relMse = epsilon + ", denominator reference²+ε";
  static const std::vector<Metric> ALL = {
      {"mean", "mean", "", &Comparison::mean},
      {"mean_reference", "mean of reference", "", &Comparison::meanReference},
      {"mean_ratio", "ratio of means", "", &Comparison::meanRatio},
      {"mse", "MSE", "", &Comparison::mse},
      {"relmse", "relMSE", relMse + ", no trim", &Comparison::relMse},
      {"relmse_trimmed", "relMSE, trimmed",
       relMse + ", worst " + number(TRIMMED_FRACTION * 100) + "% of pixels out", &Comparison::relMseTrimmed},
      {"mse_noise_free", "MSE, noise-free", "mean of (x−a)(x−b)", &Comparison::mseNoiseFree, true},
      {"relmse_noise_free", "relMSE, noise-free", "mean of (x−a)(x−b)/(r²+ε), " + epsilon + ", no trim",
       &Comparison::relMseNoiseFree, true},
      {"mape", "MAPE", "mean of |x−r|/(|r|+ε), " + mapeEpsilon, &Comparison::mape},
      {"smape", "SMAPE", "mean of |x−r|/((|x|+|r|)/2+ε), " + mapeEpsilon, &Comparison::smape},
      {"max", "maximum", "largest |x−r|", &Comparison::maximum},
      {"psnr", "PSNR [dB]", "peak: largest value of the reference", &Comparison::psnr},
  };
  return ALL;
}

/** A measure of the picture as a whole. */
struct WholeMetric {
  const char *name, *title, *definition;
  const std::optional<Flip> Comparison::*value;
};

const std::vector<WholeMetric>& wholeMetrics() {
  static const std::vector<WholeMetric> ALL = {
      {"flip", "LDR-FLIP", "Andersson et al. 2020, pictures cut to [0, 1], 67 pixels per degree",
       &Comparison::flip},
      {"hdrflip", "HDR-FLIP", "Andersson et al. 2021, ACES tone curve, 67 pixels per degree",
       &Comparison::hdrFlip},
  };
  return ALL;
}

/** A measure after averaging blocks of pixels; nameAt() appends the side of the blocks to its name. */
struct ScaleMetric {
  const char *name, *title;
  const ByScale Comparison::*values;
  bool noiseFree = false;

  std::string nameAt(size_t scale) const { return name + ("_at_" + std::to_string(ERROR_SCALES[scale])); }
};

constexpr ScaleMetric SCALE_METRICS[] = {
    {"relmse", "relMSE", &Comparison::relMseByScale},
    {"relmse_noise_free", "relMSE, noise-free", &Comparison::relMseNoiseFreeByScale, true}};

/** Pads to a width counted in characters; titles and definitions may hold bytes of UTF-8. */
std::string padded(const std::string& text, size_t width) {
  size_t shown = 0;
  for (char c : text) shown += (static_cast<unsigned char>(c) & 0xc0) != 0x80;
  return shown < width ? text + std::string(width - shown, ' ') : text;
}

std::string rightAligned(const std::string& text, size_t width) {
  return text.size() < width ? std::string(width - text.size(), ' ') + text : text;
}

std::string colourText(const Rgb& c) { return number(c.r, 4) + " " + number(c.g, 4) + " " + number(c.b, 4); }

} // namespace

std::vector<std::string> metricNames() {
  std::vector<std::string> names;
  for (const Metric& metric : metrics()) names.emplace_back(metric.name);
  for (const WholeMetric& metric : wholeMetrics()) names.emplace_back(metric.name);
  for (const ScaleMetric& metric : SCALE_METRICS)
    for (size_t scale = 0; scale < ERROR_SCALES.size(); ++scale) names.push_back(metric.nameAt(scale));
  names.insert(names.end(), {"non_finite", "non_finite_reference"});
  return names;
}

double metricByName(const Comparison& comparison, const std::string& name) {
  for (const Metric& metric : metrics()) {
    if (name != metric.name) continue;
    if (metric.noiseFree && !comparison.noiseFree)
      throw Error(name + " needs two independent references", ExitStatus::BAD_USAGE);
    return (comparison.*metric.values)[ALL_CHANNELS];
  }
  for (const WholeMetric& metric : wholeMetrics()) {
    if (name != metric.name) continue;
    if (!(comparison.*metric.value)) throw Error(name + " is not in this comparison", ExitStatus::BAD_USAGE);
    return (comparison.*metric.value)->mean;
  }
  for (const ScaleMetric& metric : SCALE_METRICS)
    for (size_t scale = 0; scale < ERROR_SCALES.size(); ++scale) {
      if (name != metric.nameAt(scale)) continue;
      if (metric.noiseFree && !comparison.noiseFree)
        throw Error(name + " needs two independent references", ExitStatus::BAD_USAGE);
      return (comparison.*metric.values)[scale];
    }
  if (name == "non_finite") return double(comparison.nonFinite);
  if (name == "non_finite_reference") return double(comparison.nonFiniteReference);
  std::string message = "no error measure '" + name + "'; there are:";
  for (const std::string& known : metricNames()) message += " " + known;
  throw Error(message, ExitStatus::BAD_USAGE);
}

std::string metricDefinition(const std::string& name) {
  for (const Metric& metric : metrics())
    if (name == metric.name) return metric.definition;
  for (const WholeMetric& metric : wholeMetrics())
    if (name == metric.name) return metric.definition;
  return {};
}

namespace {

/** Table with a row for each class of paths; empty where there are none. */
std::string classTable(const Comparison& c) {
  constexpr size_t GAP = 2, SHARE_COLUMN = 9, COLUMN = 11, SHOWN_SCALES = 4;
  if (c.classes.empty()) return {};
  const std::string title = c.noiseFree ? "relMSE of classes, noise-free" : "relMSE of classes";
  size_t width = title.size();
  for (const ClassError& error : c.classes) width = std::max(width, error.name.size());
  width += GAP;
  std::string out = "\n" + padded(title, width) + rightAligned("share", SHARE_COLUMN);
  for (size_t scale = 0; scale < SHOWN_SCALES; ++scale)
    out +=
        rightAligned(std::to_string(ERROR_SCALES[scale]) + "x" + std::to_string(ERROR_SCALES[scale]), COLUMN);
  out += "  pixels\n";
  for (const ClassError& error : c.classes) {
    const ByScale& values = c.noiseFree ? error.relMseNoiseFreeByScale : error.relMseByScale;
    out += padded(error.name, width) + rightAligned(number(error.share * 100, 3) + " %", SHARE_COLUMN);
    for (size_t scale = 0; scale < SHOWN_SCALES; ++scale)
      out += rightAligned(std::isfinite(values[scale]) ? number(values[scale], 4) : "-", COLUMN);
    out += "  " + error.expression + "\n";
  }
  for (const std::string& left : c.classesLeftOut) out += "class left out: " + left + "\n";
  return out;
}

} // namespace

std::string comparisonTable(const Comparison& c) {
  constexpr size_t TITLE = 20, COLUMN = 13, SCALE_COLUMN = 11;
  std::string out = padded("", TITLE);
  for (const char* name : {"all", "R", "G", "B"}) out += rightAligned(name, COLUMN);
  out += "\n";
  for (const Metric& metric : metrics()) {
    if (metric.noiseFree && !c.noiseFree) continue;
    const PerChannel& values = c.*metric.values;
    out += padded(metric.title, TITLE);
    for (size_t channel : {ALL_CHANNELS, size_t{0}, size_t{1}, size_t{2}})
      out += rightAligned(number(values[channel]), COLUMN);
    if (!metric.definition.empty()) out.append("  ").append(metric.definition);
    out += "\n";
  }
  for (const WholeMetric& metric : wholeMetrics()) {
    if (!(c.*metric.value)) continue;
    out += padded(metric.title, TITLE) + rightAligned(number((c.*metric.value)->mean), COLUMN);
    out.append(3 * COLUMN + 2, ' ').append(metric.definition).append("\n");
  }
  out += "\n" + padded("averaged over", TITLE);
  for (int side : ERROR_SCALES)
    out += rightAligned(std::to_string(side) + "x" + std::to_string(side), SCALE_COLUMN);
  out += "  pixels; from one scale to the next, independent noise decreases to a quarter, blotches do not\n";
  for (const ScaleMetric& metric : SCALE_METRICS) {
    if (metric.noiseFree && !c.noiseFree) continue;
    out += padded(metric.title, TITLE);
    for (double value : c.*metric.values)
      out += rightAligned(std::isfinite(value) ? number(value, 4) : "-", SCALE_COLUMN);
    out += "  ε " + number(REL_MSE_EPSILON) + ", denominator reference²+ε over 7x7 pixels, no trim\n";
  }
  out += classTable(c);
  out.append("\n").append(std::to_string(c.pixels));
  out += std::string(" pixels compared, ") + std::to_string(c.trimmedPixels) + " trimmed\n";
  if (c.nonFiniteReference > 0)
    out += std::to_string(c.nonFiniteReference) + " pixels left out: the reference is not finite there\n";
  if (c.nonFinite > 0)
    out += std::to_string(c.nonFinite) + " pixels of the picture are NOT FINITE (NaN or infinite); the sums "
                                         "leave them out\n";
  if (!c.worst.empty() && c.worst.front().error > 0) {
    out += "worst pixels (x, y from the upper left; squared error over reference²+ε, mean of channels):\n";
    for (const Comparison::WorstPixel& w : c.worst) {
      out += "  ";
      out += padded(std::to_string(w.x) + ", " + std::to_string(w.y), 12) + padded(number(w.error, 4), 12);
      out.append("value ").append(padded(colourText(w.value), 30));
      out.append(" reference ").append(colourText(w.reference)).append("\n");
    }
  }
  return out;
}

std::string comparisonJson(const Comparison& c) {
  nlohmann::ordered_json json;
  for (const Metric& metric : metrics()) {
    if (metric.noiseFree && !c.noiseFree) continue;
    const PerChannel& values = c.*metric.values;
    json[metric.name] = values[ALL_CHANNELS];
    json[std::string(metric.name) + "_rgb"] = {values[0], values[1], values[2]};
  }
  for (const WholeMetric& metric : wholeMetrics())
    if (c.*metric.value) json[metric.name] = (c.*metric.value)->mean;
  if (c.hdrFlip) {
    json["hdrflip_exposures"] = c.hdrFlip->exposures;
    json["flip_pixels_per_degree"] = FLIP_PIXELS_PER_DEGREE;
  }
  for (const ScaleMetric& metric : SCALE_METRICS)
    if (!metric.noiseFree || c.noiseFree)
      for (size_t scale = 0; scale < ERROR_SCALES.size(); ++scale)
        json[metric.nameAt(scale)] = (c.*metric.values)[scale];
  if (!c.classes.empty()) json["classes"] = nlohmann::ordered_json::array();
  for (const ClassError& error : c.classes) {
    nlohmann::ordered_json one = {
        {"name", error.name}, {"expression", error.expression}, {"share", error.share}};
    for (const auto& [metric, values] : {std::pair(SCALE_METRICS[0], error.relMseByScale),
                                         std::pair(SCALE_METRICS[1], error.relMseNoiseFreeByScale)})
      if (!metric.noiseFree || c.noiseFree)
        for (size_t scale = 0; scale < ERROR_SCALES.size(); ++scale)
          one[metric.nameAt(scale)] = values[scale];
    json["classes"].push_back(std::move(one));
  }
  json["non_finite"] = c.nonFinite;
  json["non_finite_reference"] = c.nonFiniteReference;
  json["pixels"] = c.pixels;
  json["trimmed_pixels"] = c.trimmedPixels;
  json["relmse_epsilon"] = REL_MSE_EPSILON;
  json["relmse_denominator"] = "reference^2 + epsilon";
  json["trimmed_fraction"] = TRIMMED_FRACTION;
  json["mape_epsilon"] = MAPE_EPSILON;
  json["worst"] = nlohmann::ordered_json::array();
  for (const Comparison::WorstPixel& w : c.worst)
    json["worst"].push_back({{"x", w.x},
                             {"y", w.y},
                             {"error", w.error},
                             {"value", {w.value.r, w.value.g, w.value.b}},
                             {"reference", {w.reference.r, w.reference.g, w.reference.b}}});
  return json.dump(2) + "\n";
}

} // namespace recurse
