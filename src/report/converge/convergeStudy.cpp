/** @file
 * Grid of a study, its file, and the pictures of its cells.
 */
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include <nlohmann/json.hpp>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"
#include "recurse/report/converge/converge.h"

namespace recurse {

namespace {

using Json = nlohmann::ordered_json;

constexpr double UNKNOWN = std::numeric_limits<double>::quiet_NaN();
constexpr int FORMAT = 1; ///< version of converge.json

const char* const KINDS[] = {"time", "samples", "photons"};

struct CellField {
  const char* name;
  double ConvergeCell::*value;
};
constexpr CellField CELL_FIELDS[] = {{"seconds", &ConvergeCell::seconds},
                                     {"samples_per_pixel", &ConvergeCell::samplesPerPixel},
                                     {"photons", &ConvergeCell::photons},
                                     {"mse", &ConvergeCell::mse},
                                     {"relmse", &ConvergeCell::relMse},
                                     {"relmse_trimmed", &ConvergeCell::relMseTrimmed},
                                     {"mse_noise_free", &ConvergeCell::mseNoiseFree},
                                     {"relmse_noise_free", &ConvergeCell::relMseNoiseFree},
                                     {"mean_ratio", &ConvergeCell::meanRatio}};

std::string scaleField(size_t scale) { return "relmse_at_" + std::to_string(ERROR_SCALES[scale]); }

struct SplitField {
  const char* name;
  Estimate ErrorSplit::*value;
};
constexpr SplitField SPLIT_FIELDS[] = {{"variance", &ErrorSplit::variance},
                                       {"bias2", &ErrorSplit::bias2},
                                       {"relvariance", &ErrorSplit::relVariance},
                                       {"relbias2", &ErrorSplit::relBias2}};

/** JSON number; null for infinity and NaN, which JSON does not have. */
Json numberJson(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
double numberOf(const Json& json) { return json.is_null() ? UNKNOWN : json.get<double>(); }

std::string csvNumber(double value) { return std::isfinite(value) ? formatted("%.9g", value) : ""; }

/** Error of a cell by the first measure, with which plots and tables begin. */
double shownError(const ConvergeCell& cell, bool independent) {
  return independent ? cell.relMseNoiseFree : cell.relMse;
}

Image cellPicture(const std::string& folder, const ConvergeCell& cell) {
  return readImage(
      (std::filesystem::path(folder) / cellPictureName(cell.run, cell.budget, cell.seed)).string());
}

} // namespace

const ConvergeCell* Study::find(const std::string& run, const std::string& budget, uint64_t seed) const {
  const auto found = std::find_if(cells.begin(), cells.end(), [&](const ConvergeCell& cell) {
    return cell.run == run && cell.budget == budget && cell.seed == seed;
  });
  return found == cells.end() ? nullptr : &*found;
}

void Study::include(const Study& other) {
  const auto addMissing = [](auto& to, const auto& from, const auto& same) {
    for (const auto& item : from)
      if (std::none_of(to.begin(), to.end(), [&](const auto& there) { return same(there, item); }))
        to.push_back(item);
  };
  addMissing(runs, other.runs, [](const auto& a, const auto& b) { return a.name == b.name; });
  addMissing(budgets, other.budgets, [](const auto& a, const auto& b) { return a.text == b.text; });
  std::sort(budgets.begin(), budgets.end(), [](const auto& a, const auto& b) { return a.amount < b.amount; });
  addMissing(seeds, other.seeds, [](auto a, auto b) { return a == b; });
  for (const ConvergeCell& cell : other.cells)
    if (!find(cell.run, cell.budget, cell.seed)) cells.push_back(cell);
}

std::string cellPictureName(const std::string& run, const std::string& budget, uint64_t seed) {
  return "cells/" + run + "-" + budget + "-seed" + std::to_string(seed) + ".exr";
}

void requireSameStudy(const Study& found, const Study& wanted, const std::string& folder) {
  std::string differences;
  const auto differ = [&](const std::string& what, const std::string& there, const std::string& here) {
    differences += "\n  " + what + ": there " + (there.empty() ? "none" : there) + ", now " +
                   (here.empty() ? "none" : here);
  };
  if (found.kind != wanted.kind)
    differ("budgets", KINDS[static_cast<size_t>(found.kind)], KINDS[static_cast<size_t>(wanted.kind)]);
  const auto valueIn = [](const Study& study, const std::string& name) {
    for (const auto& [key, value] : study.identity)
      if (key == name) return value;
    return std::string();
  };
  for (const auto& [key, value] : wanted.identity)
    if (valueIn(found, key) != value) differ(key, valueIn(found, key), value);
  for (const ConvergeRun& run : wanted.runs)
    for (const ConvergeRun& before : found.runs)
      if (before.name == run.name && before.settings != run.settings)
        differ("run " + run.name, before.settings, run.settings);
  if (!differences.empty())
    throw Error(folder + " holds a study with other settings, which cannot be continued:" + differences +
                    "\n"
                    "Choose another folder, or another name for the run, or remove " +
                    folder,
                ExitStatus::BAD_USAGE);
}

std::string studyJson(const Study& study) {
  Json json = {{"format", FORMAT}, {"kind", KINDS[static_cast<size_t>(study.kind)]}};
  json["identity"] = Json::object();
  for (const auto& [key, value] : study.identity) json["identity"][key] = value;
  json["relmse_epsilon"] = REL_MSE_EPSILON;
  json["relmse_denominator"] = "reference^2 + epsilon";
  json["trimmed_fraction"] = TRIMMED_FRACTION;
  json["runs"] = Json::array();
  for (const ConvergeRun& run : study.runs)
    json["runs"].push_back({{"name", run.name}, {"settings", run.settings}});
  json["budgets"] = Json::array();
  for (const Budget& budget : study.budgets)
    json["budgets"].push_back({{"text", budget.text}, {"amount", budget.amount}});
  json["seeds"] = study.seeds;
  json["cells"] = Json::array();
  for (const ConvergeCell& cell : study.cells) {
    Json one = {{"run", cell.run}, {"budget", cell.budget}, {"seed", cell.seed}};
    for (const CellField& field : CELL_FIELDS) one[field.name] = numberJson(cell.*field.value);
    for (size_t i = 0; i < ERROR_SCALES.size(); ++i) one[scaleField(i)] = numberJson(cell.relMseByScale[i]);
    one["non_finite"] = cell.nonFinite;
    json["cells"].push_back(std::move(one));
  }
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Study readStudy(const std::string& fileName) {
  std::ifstream in(fileName, std::ios::binary);
  if (!in) throw Error(fileName + ": cannot be read");
  try {
    const Json json = Json::parse(in);
    if (json.at("format") != FORMAT)
      throw Error(fileName + ": was written by another version of the program");
    Study study;
    const auto kind = std::find(std::begin(KINDS), std::end(KINDS), json.at("kind").get<std::string>());
    if (kind == std::end(KINDS)) throw Error(fileName + ": unknown kind of budget");
    study.kind = static_cast<BudgetKind>(kind - std::begin(KINDS));
    for (const auto& [key, value] : json.at("identity").items()) study.identity.push_back({key, value});
    for (const Json& run : json.at("runs")) study.runs.push_back({run.at("name"), run.at("settings")});
    for (const Json& budget : json.at("budgets"))
      study.budgets.push_back({budget.at("amount"), budget.at("text")});
    study.seeds = json.at("seeds").get<std::vector<uint64_t>>();
    for (const Json& one : json.at("cells")) {
      ConvergeCell cell;
      cell.run = one.at("run");
      cell.budget = one.at("budget");
      cell.seed = one.at("seed");
      for (const CellField& field : CELL_FIELDS) cell.*field.value = numberOf(one.at(field.name));
      for (size_t i = 0; i < ERROR_SCALES.size(); ++i)
        cell.relMseByScale[i] = one.contains(scaleField(i)) ? numberOf(one[scaleField(i)]) : UNKNOWN;
      cell.nonFinite = one.at("non_finite");
      study.cells.push_back(cell);
    }
    return study;
  } catch (const Json::exception& error) {
    throw Error(fileName + ": is not a file of a study: " + error.what());
  }
}

StudyReport reportOf(const Study& study, const References& references, const std::string& folder) {
  StudyReport report{study, "", "", references, {}};
  for (const ConvergeRun& run : study.runs)
    for (const Budget& budget : study.budgets) {
      ConvergePoint point;
      point.run = run.name;
      point.budget = budget.text;
      std::vector<const ConvergeCell*> cells;
      for (uint64_t seed : study.seeds)
        if (const ConvergeCell* cell = study.find(run.name, budget.text, seed)) cells.push_back(cell);
      if (cells.empty()) continue;
      point.seeds = cells.size();
      point.smallest = std::numeric_limits<double>::infinity();
      point.largest = -point.smallest;
      std::vector<Image> pictures;
      for (const ConvergeCell* cell : cells) {
        for (const CellField& field : CELL_FIELDS)
          point.mean.*field.value += cell->*field.value / double(cells.size());
        for (size_t i = 0; i < ERROR_SCALES.size(); ++i)
          point.mean.relMseByScale[i] += cell->relMseByScale[i] / double(cells.size());
        point.mean.nonFinite += cell->nonFinite;
        point.smallest = std::min(point.smallest, shownError(*cell, references.independent));
        point.largest = std::max(point.largest, shownError(*cell, references.independent));
        if (cells.size() > 1) pictures.push_back(cellPicture(folder, *cell));
      }
      if (pictures.size() > 1) point.split = splitError(pictures, references);
      report.points.push_back(std::move(point));
    }
  return report;
}

namespace {

template <size_t SCALE> ErrorMeasure measureAtScale(const char* key, const char* title) {
  return {key, title,
          "relMSE of means over square blocks of pixels, with r over 7x7 pixels in the denominator",
          [](const ConvergePoint& p) { return p.mean.relMseByScale[SCALE]; }};
}

} // namespace

std::vector<ErrorMeasure> errorMeasures(const StudyReport& report) {
  static_assert(REL_MSE_EPSILON == 0.01 && TRIMMED_FRACTION == 0.001, "the definitions below say so");
  std::vector<ErrorMeasure> out;
  if (report.references.independent)
    out.push_back({"relmse_noise_free", "relMSE, noise-free",
                   "mean of (x−a)(x−b)/(r²+ε), ε 0.01, no trim; without the noise of the references",
                   [](const ConvergePoint& p) { return p.mean.relMseNoiseFree; }});
  out.push_back({"relmse", "relMSE", "mean of (x−r)²/(r²+ε), ε 0.01, no trim",
                 [](const ConvergePoint& p) { return p.mean.relMse; }});
  out.push_back({"relmse_trimmed", "relMSE, trimmed",
                 "mean of (x−r)²/(r²+ε), ε 0.01, without the worst 0.1% of the pixels",
                 [](const ConvergePoint& p) { return p.mean.relMseTrimmed; }});
  out.push_back({"mse", "MSE", "mean of (x−r)²", [](const ConvergePoint& p) { return p.mean.mse; }});
  const ErrorMeasure scales[] = {measureAtScale<1>("relmse_at_2", "relMSE, 2x2 pixels averaged"),
                                 measureAtScale<2>("relmse_at_4", "relMSE, 4x4 pixels averaged"),
                                 measureAtScale<3>("relmse_at_8", "relMSE, 8x8 pixels averaged"),
                                 measureAtScale<4>("relmse_at_16", "relMSE, 16x16 pixels averaged"),
                                 measureAtScale<5>("relmse_at_32", "relMSE, 32x32 pixels averaged")};
  for (const ErrorMeasure& measure : scales) // none where the picture is smaller
    if (std::any_of(report.points.begin(), report.points.end(),
                    [&](const ConvergePoint& p) { return std::isfinite(measure.of(p)); }))
      out.push_back(measure);
  const bool split = std::any_of(report.points.begin(), report.points.end(),
                                 [](const ConvergePoint& p) { return p.split.has_value(); });
  if (split) {
    out.push_back({"relvariance", "relative variance",
                   "variance of a pixel over the seeds, over r²+ε, ε 0.01",
                   [](const ConvergePoint& p) { return p.split ? p.split->relVariance.value : UNKNOWN; }});
    out.push_back({"relbias2", "relative bias²", "relMSE minus relative variance, over r²+ε, ε 0.01",
                   [](const ConvergePoint& p) { return p.split ? p.split->relBias2.value : UNKNOWN; }});
  }
  return out;
}

Curve curveOf(const StudyReport& report, const std::string& run, const ErrorMeasure& measure) {
  Curve curve;
  for (const ConvergePoint& point : report.points)
    if (point.run == run && std::isfinite(measure.of(point)))
      curve.push_back({point.mean.seconds, measure.of(point)});
  std::sort(curve.begin(), curve.end());
  return curve;
}

std::string cellsCsv(const StudyReport& report) {
  std::string out = "run,budget,seed";
  for (const CellField& field : CELL_FIELDS) out += std::string(",") + field.name;
  for (size_t i = 0; i < ERROR_SCALES.size(); ++i) out += "," + scaleField(i);
  out += ",non_finite\n";
  for (const ConvergeCell& cell : report.study.cells) {
    out += cell.run + "," + cell.budget + "," + std::to_string(cell.seed);
    for (const CellField& field : CELL_FIELDS) out += "," + csvNumber(cell.*field.value);
    for (double value : cell.relMseByScale) out += "," + csvNumber(value);
    out += "," + std::to_string(cell.nonFinite) + "\n";
  }
  return out;
}

std::string pointsCsv(const StudyReport& report) {
  std::string out = "run,budget,seeds";
  for (const CellField& field : CELL_FIELDS) out += std::string(",") + field.name;
  for (size_t i = 0; i < ERROR_SCALES.size(); ++i) out += "," + scaleField(i);
  for (const SplitField& field : SPLIT_FIELDS)
    for (const char* part : {"", "_low", "_high"}) out += std::string(",") + field.name + part;
  out += "\n";
  for (const ConvergePoint& point : report.points) {
    out += point.run + "," + point.budget + "," + std::to_string(point.seeds);
    for (const CellField& field : CELL_FIELDS) out += "," + csvNumber(point.mean.*field.value);
    for (double value : point.mean.relMseByScale) out += "," + csvNumber(value);
    for (const SplitField& field : SPLIT_FIELDS) {
      const Estimate estimate = point.split ? *point.split.*field.value : Estimate{UNKNOWN, UNKNOWN, UNKNOWN};
      for (double value : {estimate.value, estimate.low, estimate.high}) out += "," + csvNumber(value);
    }
    out += "\n";
  }
  return out;
}

} // namespace recurse
