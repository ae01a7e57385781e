/** @file
 * Report of a study: table, plot and page.
 */
#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"
#include "recurse/report/converge/converge.h"
#include "recurse/report/stills/stills.h"
#include "report/compare/falseColour.h"
#include "report/page/embedded.h"
#include "report/page/htmlPage.h"

namespace recurse {

namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

/** Theoretical slope of the squared error over time. */
struct ExpectedSlope {
  double exponent;
  const char *label, *why;
};
constexpr ExpectedSlope EXPECTED[] = {
    {-1, "t^-1", "independent samples: variance of the mean"},
    {-2.0 / 3, "t^-2/3", "optimal progressive photon mapping (Knaus and Zwicker 2011): bias and variance"}};

std::string rounded(double value, int digits = 3) { return formatted("%.*g", digits, value); }

/** Pads a text by its width on a terminal; texts may contain bytes of UTF-8. */
std::string column(const std::string& text, size_t width) {
  size_t shown = 0;
  for (char c : text) shown += (static_cast<unsigned char>(c) & 0xc0) != 0x80;
  return text + std::string(shown < width ? width - shown : 1, ' ');
}

std::string fitText(const std::optional<PowerLaw>& fit) {
  if (!fit) return "no fit";
  std::string out = "t^" + rounded(fit->exponent, 3);
  if (std::isfinite(fit->standardError)) out += " ± " + rounded(fit->standardError, 1);
  return out;
}

std::vector<Curve> curvesOf(const StudyReport& report, const ErrorMeasure& measure) {
  std::vector<Curve> curves;
  for (const ConvergeRun& run : report.study.runs) curves.push_back(curveOf(report, run.name, measure));
  return curves;
}

/** Start of the lines of the expected slopes: the worst of the curves' first points. Empty without any. */
std::optional<std::array<double, 2>> slopesFrom(const std::vector<Curve>& curves) {
  std::optional<std::array<double, 2>> start;
  for (const Curve& curve : curves)
    for (const auto& point : curve)
      if (point[1] > 0) {
        if (!start || point[1] > (*start)[1]) start = point;
        break;
      }
  return start;
}

double lastTime(const std::vector<Curve>& curves) {
  double last = 0;
  for (const Curve& curve : curves)
    for (const auto& point : curve) last = std::max(last, point[0]);
  return last;
}

std::string gnuplotString(const std::string& text) {
  std::string out = "'";
  for (char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + "'";
}

Json estimateJson(const Estimate& e) {
  Json out = Json::array();
  for (double value : {e.value, e.low, e.high})
    out.push_back(std::isfinite(value) ? Json(value) : Json(nullptr));
  return out;
}

Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json measureJson(const StudyReport& report, const ErrorMeasure& measure) {
  const std::vector<Curve> curves = curvesOf(report, measure);
  const std::vector<double> targets = targetErrors(curves);
  Json out = {{"key", measure.key}, {"title", measure.title}, {"definition", measure.definition}};
  out["targets"] = targets;
  out["runs"] = Json::array();
  for (size_t i = 0; i < curves.size(); ++i) {
    Json run = {{"curve", curves[i]}, {"fit", nullptr}, {"fit_text", fitText(fitPowerLaw(curves[i]))}};
    if (const std::optional<PowerLaw> fit = fitPowerLaw(curves[i]))
      run["fit"] = {{"exponent", fit->exponent},
                    {"factor", fit->factor},
                    {"standard_error", finite(fit->standardError)}};
    run["reach"] = Json::array();
    for (double target : targets) run["reach"].push_back(timeToReach(curves[i], target).text());
    out["runs"].push_back(std::move(run));
  }
  out["slopes"] = Json::array();
  if (const auto start = slopesFrom(curves))
    for (const ExpectedSlope& slope : EXPECTED) {
      const double end = lastTime(curves), low = (*start)[1] * std::pow(end / (*start)[0], slope.exponent);
      out["slopes"].push_back(
          {{"label", slope.label}, {"why", slope.why}, {"line", {{(*start)[0], (*start)[1]}, {end, low}}}});
    }
  return out;
}

/** 256 colours of the error map, encoded for a display (sRGB). */
Json falseColours() {
  Json out = Json::array();
  for (int i = 0; i < 256; ++i) {
    const Rgb c = falseColour(float(i) / 255);
    Json one = Json::array();
    for (int k = 0; k < 3; ++k) {
      const double x = double(c[k]);
      one.push_back(std::lround(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055)));
    }
    out.push_back(std::move(one));
  }
  return out;
}

/** Runs gnuplot in the folder; false where there is no such program. Throws Error where it fails. */
bool runGnuplot(const std::string& folder, const std::string& output) {
  const std::string setting = "output='" + output + "'", log = folder + "/.gnuplot.log";
  const pid_t child = ::fork();
  if (child < 0) throw Error("cannot start a process for gnuplot");
  constexpr int NO_PROGRAM = 127;
  if (child == 0) {
    const int messages = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (messages < 0 || ::dup2(messages, STDERR_FILENO) < 0 || ::chdir(folder.c_str()) != 0) ::_exit(1);
    ::execlp("gnuplot", "gnuplot", "-e", setting.c_str(), "plot.gp", nullptr);
    ::_exit(NO_PROGRAM);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  std::error_code ignored;
  fs::remove(log, ignored);
  if (WIFEXITED(status) && WEXITSTATUS(status) == NO_PROGRAM) return false;
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw Error(folder + "/plot.gp: gnuplot failed; run 'gnuplot plot.gp' in this folder to see why");
  return true;
}

} // namespace

namespace {

/** Table of the error after averaging blocks of pixels, a line for each point. */
std::string scaleTable(const StudyReport& report, size_t width) {
  std::string out = column("averaged", width) + column("budget", 10);
  for (int side : ERROR_SCALES) out += column(std::to_string(side) + "x" + std::to_string(side), 10);
  out += "\n";
  for (const ConvergePoint& p : report.points) {
    out += column(p.run, width) + column(p.budget, 10);
    for (double error : p.mean.relMseByScale) out += column(std::isfinite(error) ? rounded(error) : "-", 10);
    out += "\n";
  }
  return out + "relMSE of means over blocks of pixels; from one scale to the next, independent noise "
               "decreases to a "
               "quarter\n";
}

} // namespace

std::string studyTable(const StudyReport& report) {
  const std::vector<ErrorMeasure> measures = errorMeasures(report);
  const ErrorMeasure& measure = measures.front();
  size_t width = 8;
  for (const ConvergeRun& run : report.study.runs) width = std::max(width, run.name.size() + 2);
  std::string out = column("run", width) + column("budget", 10) + column("seeds", 7) + column("seconds", 10) +
                    column("spp", 10) + column(measure.title, 21) + column("variance", 12) + "bias² (95%)\n";
  for (const ConvergePoint& p : report.points) {
    out += column(p.run, width) + column(p.budget, 10) + column(std::to_string(p.seeds), 7) +
           column(rounded(p.mean.seconds), 10) + column(rounded(p.mean.samplesPerPixel), 10) +
           column(rounded(measure.of(p), 4), 21);
    if (p.split)
      out += column(rounded(p.split->relVariance.value), 12) + rounded(p.split->relBias2.value) + " (" +
             rounded(p.split->relBias2.low) + " to " + rounded(p.split->relBias2.high) + ")";
    else
      out += "(needs two seeds)";
    if (p.mean.nonFinite > 0) out += "  " + std::to_string(p.mean.nonFinite) + " pixels NOT FINITE";
    out += "\n";
  }
  out += std::string("\n") + measure.title + ": " + measure.definition +
         "\nvariance and bias²: of the same error, over r²+ε\nreference: " + report.references.description +
         "\n\n";
  out += scaleTable(report, width) + "\n";
  const std::vector<Curve> curves = curvesOf(report, measure);
  out += column("time to", width);
  for (double target : targetErrors(curves)) out += column(rounded(target), 16);
  out += "error ~\n";
  for (size_t i = 0; i < curves.size(); ++i) {
    out += column(report.study.runs[i].name, width);
    for (double target : targetErrors(curves)) {
      std::string text = timeToReach(curves[i], target).text();
      const size_t remark = text.find(" (");
      out += column(text.substr(0, remark), 16);
    }
    out += fitText(fitPowerLaw(curves[i])) + "\n";
  }
  return out;
}

std::string plotScript(const StudyReport& report) {
  const ErrorMeasure measure = errorMeasures(report).front();
  const std::vector<Curve> curves = curvesOf(report, measure);
  std::string out = "# Error against time. Run by: gnuplot plot.gp\n"
                    "if (!exists('output')) output = 'plot.png'\n"
                    "set terminal pngcairo size 1200,800 fontscale 1.2 noenhanced\n"
                    "set output output\n"
                    "set title offset 0,0.8 " +
                    gnuplotString(report.title + ": error against time") + "\nset label " +
                    gnuplotString(measure.definition) +
                    " at graph 0.5,1.025 center\nset logscale xy\n"
                    "set xlabel 'seconds'\n"
                    "set ylabel " +
                    gnuplotString(measure.title) +
                    "\nset grid xtics ytics mxtics mytics lt 1 lc rgb '#b0b0b0', lt 1 lc rgb '#e0e0e0'\n"
                    "set format y '%g'\n"
                    "set key outside bottom center vertical maxrows 4\n";
  std::string plots;
  const auto plot = [&plots](const std::string& text) {
    plots += (plots.empty() ? "plot " : ", \\\n  ") + text;
  };
  for (size_t i = 0; i < curves.size(); ++i) {
    const std::string& run = report.study.runs[i].name;
    std::string rows;
    for (const ConvergePoint& p : report.points) {
      const double error = measure.of(p);
      // Errors that are not above zero cannot be on a logarithmic axis; the table of the page has them.
      if (p.run == run && error > 0)
        rows += rounded(p.mean.seconds, 9) + " " + rounded(error, 9) + " " +
                rounded(p.smallest > 0 ? p.smallest : error, 9) + " " + rounded(p.largest, 9) + "\n";
    }
    if (rows.empty()) continue;
    out += "$run" + std::to_string(i) + " << END\n" + rows + "END\n";
    plot("$run" + std::to_string(i) + " using 1:2:3:4 with yerrorlines lw 2 pt 7 lc " +
         std::to_string(i + 1) + " title " + gnuplotString(run + "  " + fitText(fitPowerLaw(curves[i]))));
  }
  if (const auto start = slopesFrom(curves)) {
    const double end = lastTime(curves);
    int dash = 2;
    for (const ExpectedSlope& slope : EXPECTED) {
      const std::string name = "$slope" + std::to_string(dash);
      out += name + " << END\n" + rounded((*start)[0], 9) + " " + rounded((*start)[1], 9) + "\n" +
             rounded(end, 9) + " " + rounded((*start)[1] * std::pow(end / (*start)[0], slope.exponent), 9) +
             "\nEND\n";
      plot(name + " using 1:2 with lines lc rgb '#909090' dt " + std::to_string(dash++) + " title " +
           gnuplotString(slope.label));
    }
  }
  return out +
         (plots.empty() ? "set label 'nothing to plot' at graph 0.5,0.5 center\nplot [1:10] [1:10] 1/0"
                        : plots) +
         "\n";
}

std::string convergePage(const StudyReport& report, const std::string& folder) {
  const Image& r = report.references.r;
  Json data = {{"title", report.title},
               {"label", report.label},
               {"width", r.width},
               {"height", r.height},
               {"exposure", automaticExposure(r)},
               {"reference", report.references.description},
               {"independent", report.references.independent},
               {"map_epsilon", MAPE_EPSILON},
               {"colours", falseColours()}};
  data["identity"] = report.study.identity;
  data["runs"] = Json::array();
  for (const ConvergeRun& run : report.study.runs)
    data["runs"].push_back({{"name", run.name}, {"settings", run.settings}});
  data["measures"] = Json::array();
  for (const ErrorMeasure& measure : errorMeasures(report))
    data["measures"].push_back(measureJson(report, measure));
  data["points"] = Json::array();
  for (const ConvergePoint& p : report.points) {
    Json point = {{"run", p.run},
                  {"budget", p.budget},
                  {"seeds", p.seeds},
                  {"seconds", p.mean.seconds},
                  {"samples_per_pixel", p.mean.samplesPerPixel},
                  {"photons", p.mean.photons},
                  {"mean_ratio", finite(p.mean.meanRatio)},
                  {"non_finite", p.mean.nonFinite}};
    for (const ErrorMeasure& measure : errorMeasures(report)) point[measure.key] = finite(measure.of(p));
    if (p.split) {
      point["variance_interval"] = estimateJson(p.split->relVariance);
      point["bias2_interval"] = estimateJson(p.split->relBias2);
    }
    data["points"].push_back(std::move(point));
  }
  data["cells"] = Json::parse(studyJson(report.study)).at("cells");
  data["budgets"] = Json::array();
  for (const Budget& budget : report.study.budgets) data["budgets"].push_back(budget.text);
  data["pictures"] = Json::array();
  Json reference = {{"run", "reference"}, {"budget", nullptr}};
  addPixels(reference, r);
  data["pictures"].push_back(std::move(reference));
  for (const ConvergePoint& p : report.points)
    for (uint64_t seed : report.study.seeds) {
      const ConvergeCell* cell = report.study.find(p.run, p.budget, seed);
      if (!cell) continue;
      Json picture = {{"run", p.run}, {"budget", p.budget}, {"seed", seed}, {"seconds", cell->seconds}};
      addPixels(
          picture,
          readImage((fs::path(folder) / cellPictureName(cell->run, cell->budget, cell->seed)).string()));
      data["pictures"].push_back(std::move(picture));
      break; // one seed is enough to look at
    }
  return htmlPage({page::CONVERGE_HTML,
                   report.title + " · error against time",
                   {page::PAGE_CSS, page::CONVERGE_CSS},
                   {page::CHART_MIN_JS},
                   {page::PIXELS_JS, page::TONE_JS, page::LOCAL_TONE_JS, page::EDGES_JS, page::VIEW_JS,
                    page::CONVERGE_JS}},
                  data);
}

std::string writeReport(const StudyReport& report, const std::string& folder) {
  const auto file = [&](const char* name) { return (fs::path(folder) / name).string(); };
  writeFileAtomically(file("cells.csv"), cellsCsv(report));
  writeFileAtomically(file("points.csv"), pointsCsv(report));
  writeFileAtomically(file("plot.gp"), plotScript(report));
  writeFileAtomically(file("index.html"), convergePage(report, folder));
  const char* const unfinished = ".plot.png";
  std::error_code ignored;
  try {
    if (!runGnuplot(folder, unfinished)) {
      fs::remove(file("plot.png"), ignored); // an older one would be out of date
      return "plot.png was not made: install gnuplot (Debian package gnuplot-nox), then run 'gnuplot "
             "plot.gp' in " +
             folder;
    }
  } catch (const Error&) {
    fs::remove(file(unfinished), ignored);
    throw;
  }
  std::error_code failure;
  fs::rename(file(unfinished), file("plot.png"), failure);
  if (failure) throw Error(file("plot.png") + ": " + failure.message());
  return {};
}

} // namespace recurse
