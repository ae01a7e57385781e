/** @file
 * Light that methods leave out, and their error against the light that they should compute.
 */
#include "recurse/report/methods/methods.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"
#include "recurse/pathclasses/pathExpression.h"
#include "report/page/embedded.h"
#include "report/page/htmlPage.h"
#include "report/stills/sheet.h"

namespace recurse {

namespace {

using Json = nlohmann::ordered_json;

/** Sum of the layers whose class counts. */
Image sumOfLayers(const Stills& stills, const std::vector<bool>& counts) {
  Image sum(stills.image.width, stills.image.height, {"R", "G", "B"});
  for (size_t i = 0; i < counts.size(); ++i) {
    if (!counts[i]) continue;
    const Image layer = stills.layerImage(i + 1);
    for (size_t k = 0; k < sum.pixels.size(); ++k) sum.pixels[k] += layer.pixels[k];
  }
  return sum;
}

double meanLuminance(const StillLayer& layer) { return double(luminance(layer.mean)); }

/** Light of the reference that is not in the picture. */
Image missingLight(const Image& reference, const Image& picture) {
  Image out = reference;
  for (size_t k = 0; k < out.pixels.size(); ++k)
    out.pixels[k] = std::max(0.0f, reference.pixels[k] - picture.pixels[k]);
  return out;
}

Json finiteNumber(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

double noiseFreeError(const Comparison& c) { return c.relMseNoiseFree[ALL_CHANNELS]; }

std::string percent(double part) { return formatted("%.3g %%", 100 * part); }

Json figures(const MethodsReport& report) {
  Json data = {{"title", report.title},
               {"label", report.label},
               {"reference", report.reference},
               {"exact", report.isExact}};
  data["classes"] = Json::array();
  for (size_t i = 0; i < report.classes.size(); ++i)
    data["classes"].push_back({{"name", report.classes[i].name},
                               {"expression", report.classes[i].expression},
                               {"mean", report.referenceMeans[i]}});
  data["methods"] = Json::array();
  for (const MethodResult& m : report.methods) {
    Json one = {{"name", m.name},
                {"settings", m.settings},
                {"claims", m.claims},
                {"suppositions", m.suppositions},
                {"failure", m.failure}};
    if (m.failure.empty()) {
      one["seconds"] = m.seconds;
      one["samples_per_pixel"] = m.samplesPerPixel;
      one["relmse_noise_free"] = finiteNumber(noiseFreeError(m.whole));
      one["mean_ratio"] = finiteNumber(m.whole.meanRatio[ALL_CHANNELS]);
      one["own_relmse_noise_free"] = finiteNumber(noiseFreeError(m.own));
      one["own_mean_ratio"] = finiteNumber(m.own.meanRatio[ALL_CHANNELS]);
      one["missing"] = m.missing;
      one["non_finite"] = m.whole.nonFinite;
      one["class_means"] = m.classMeans;
      one["class_is_claimed"] = m.classIsClaimed;
    }
    data["methods"].push_back(std::move(one));
  }
  return data;
}

/** Letters of a number from 0: a to z, then aa, ab and so on. */
std::string lettersOf(size_t number) {
  const std::string before = number < 26 ? "" : lettersOf(number / 26 - 1);
  return before + static_cast<char>('a' + number % 26);
}

} // namespace

std::vector<PathClass> refineClasses(const std::vector<PathClass>& classes,
                                     const std::vector<std::string>& claims) {
  struct Part {
    PathAutomaton paths;
    std::string expression;
  };
  std::vector<PathClass> out;
  for (const PathClass& c : classes) {
    std::vector<Part> parts = {{PathAutomaton::compile(c.expression), c.expression}};
    for (const std::string& claim : claims) {
      const PathAutomaton claimed = PathAutomaton::compile(claim);
      std::vector<Part> finer;
      for (const Part& part : parts) {
        const PathAutomaton in = part.paths.intersect(claimed), rest = part.paths.difference(claimed);
        if (in.isEmpty() || rest.isEmpty()) {
          finer.push_back(part);
          continue;
        }
        const auto add = [&](const PathAutomaton& paths, const char* operation) {
          const std::string plain = paths.toExpression(40);
          finer.push_back(
              {paths, plain.empty() ? "(" + part.expression + ")" + operation + "(" + claim + ")" : plain});
        };
        add(in, " & ");
        add(rest, " - ");
      }
      parts = std::move(finer);
    }
    for (size_t i = 0; i < parts.size(); ++i)
      out.push_back({parts.size() == 1 ? c.name : c.name + "-" + lettersOf(i), parts[i].expression});
  }
  return out;
}

void prepareReferences(MethodsReport& report) {
  const Image a = report.referenceA.layerImage(0), b = report.referenceB.layerImage(0);
  report.references = makeReferences({a, b}, {"a", "b"});
  report.referenceMeans.clear();
  for (size_t i = 0; i < report.classes.size(); ++i)
    report.referenceMeans.push_back(
        (meanLuminance(report.referenceA.layers[i + 1]) + meanLuminance(report.referenceB.layers[i + 1])) /
        2);
}

void measureMethod(MethodResult& m, const MethodsReport& report) {
  const PathAutomaton claimed = PathAutomaton::compile(m.claims);
  double claimedLight = 0, light = 0;
  m.classIsClaimed.clear();
  m.classMeans.clear();
  for (size_t i = 0; i < report.classes.size(); ++i) {
    const PathAutomaton paths = PathAutomaton::compile(report.classes[i].expression);
    // Where classes are not fine enough, a class counts if the method finds any part of it.
    const bool is = report.isExact ? paths.subsetOf(claimed) : !paths.intersect(claimed).isEmpty();
    m.classIsClaimed.push_back(is);
    light += report.referenceMeans[i];
    if (is) claimedLight += report.referenceMeans[i];
    if (m.failure.empty()) m.classMeans.push_back(meanLuminance(m.stills.layers[i + 1]));
  }
  m.missing = light > 0 ? 1 - claimedLight / light : 0;
  if (!m.failure.empty()) return;
  m.picture = m.stills.layerImage(0);
  m.whole = compareImages(m.picture, report.references.a, report.references.b);
  m.own = compareImages(m.picture, sumOfLayers(report.referenceA, m.classIsClaimed),
                        sumOfLayers(report.referenceB, m.classIsClaimed));
}

Image methodsSheet(const MethodsReport& report) {
  const Image& r = report.references.r;
  const float exposure = automaticExposure(r);
  std::vector<SheetCell> cells;
  SheetCell reference;
  reference.left = r;
  reference.right = Image(r.width, r.height, {"R", "G", "B"});
  reference.leftCaption = formatted("exposure %+.1f", double(exposure));
  reference.leftExposure = reference.rightExposure = exposure;
  reference.name = "reference";
  reference.expression = "all";
  reference.footer = report.reference;
  cells.push_back(std::move(reference));
  for (const MethodResult& m : report.methods) {
    SheetCell cell;
    const bool made = m.failure.empty();
    cell.left = made ? m.picture : Image(r.width, r.height, {"R", "G", "B"});
    cell.right = made ? missingLight(r, m.picture) : cell.left;
    cell.leftExposure = cell.rightExposure = exposure;
    cell.rightCaption = "not in it";
    cell.name = m.name;
    cell.expression = m.claims;
    if (made) {
      cell.leftCaption = formatted("%.3g s", m.seconds) + formatted(", %.4g spp", m.samplesPerPixel);
      cell.figure = formatted("error %.2g", noiseFreeError(m.whole));
      cell.footer = formatted("own error %.2g", noiseFreeError(m.own)) + ", leaves out " + percent(m.missing);
    } else {
      cell.figure = "no picture";
      cell.footer = m.failure;
    }
    cells.push_back(std::move(cell));
  }
  return drawSheet(report.title, report.label, cells);
}

std::string methodsPage(const MethodsReport& report) {
  const Image& r = report.references.r;
  Json data = figures(report);
  data["width"] = r.width;
  data["height"] = r.height;
  data["exposure"] = automaticExposure(r);
  data["map_epsilon"] = MAPE_EPSILON;
  Json reference = Json::object();
  addPixels(reference, r);
  data["pictures"] = Json::array({std::move(reference)});
  for (const MethodResult& m : report.methods) {
    Json picture = {{"name", m.name}};
    if (m.failure.empty()) addPixels(picture, m.picture);
    data["pictures"].push_back(std::move(picture));
  }
  return htmlPage({page::METHODS_HTML,
                   report.title + " · methods",
                   {page::PAGE_CSS, page::METHODS_CSS},
                   {},
                   {page::PIXELS_JS, page::METHODS_JS}},
                  data);
}

std::string methodsTable(const MethodsReport& report) {
  size_t width = 8;
  for (const MethodResult& m : report.methods) width = std::max(width, m.name.size() + 2);
  std::string out = formatted("%-*s%9s%9s%10s%11s%11s%10s  %s\n", static_cast<int>(width), "method",
                              "seconds", "spp", "error", "own error", "own mean", "left out", "computes");
  for (const MethodResult& m : report.methods) {
    out += formatted("%-*s", static_cast<int>(width), m.name.c_str());
    out += m.failure.empty() ? formatted("%9.3g%9.4g%10.3g%11.3g%11.4f%9.3g%%  %s\n", m.seconds,
                                         m.samplesPerPixel, noiseFreeError(m.whole), noiseFreeError(m.own),
                                         m.own.meanRatio[ALL_CHANNELS], 100 * m.missing, m.claims.c_str())
                             : "no picture: " + m.failure + "\n";
    if (!m.suppositions.empty()) out += std::string(width, ' ') + "assumes " + m.suppositions + "\n";
    if (m.failure.empty() && m.whole.nonFinite > 0)
      out += std::string(width, ' ') + std::to_string(m.whole.nonFinite) + " pixels NOT FINITE\n";
  }
  return out +
         "\nerror: relMSE without the noise of the references, mean of (x-a)(x-b)/(r^2+0.01);\n"
         "own error and own mean: of the light of the paths that the method computes" +
         (report.isExact ? "" : ", approximately: the classes do not separate them exactly") +
         "\nreference: " + report.reference + "\n";
}

std::string methodsJson(const MethodsReport& report) {
  return figures(report).dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

} // namespace recurse
