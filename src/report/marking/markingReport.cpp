/** @file
 * Marks in words and as JSON.
 */
#include "recurse/report/marking/marking.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"
#include "recurse/pathclasses/pathExpression.h"

namespace recurse {

namespace {

using Json = nlohmann::ordered_json;

std::string percentText(double part) { return formatted("%.3g %%", std::round(1000 * part) / 10); }
/** Factor to a thousandth; + 0 removes the sign of a negative zero. */
std::string factorText(double factor) { return formatted("%.3g", std::round(1000 * factor) / 1000 + 0.0); }

/** Notation, which lectures use, and name of a class; the name alone where the notation would fill the line.
 */
std::string nameOf(const ClassMark& mark) {
  constexpr size_t LONGEST = 24;
  if (mark.expression.empty() || mark.expression.size() > LONGEST) return mark.name;
  return mark.expression == mark.name ? mark.name : mark.expression + " (" + mark.name + ")";
}

/** One of the shortest paths of a class, without media if there is one; empty where its expression is
 * unknown. */
std::string shortestPath(const ClassMark& mark) {
  if (mark.expression.empty()) return {};
  try {
    const PathAutomaton all = PathAutomaton::compile(mark.expression);
    const PathAutomaton atSurfaces = all.intersect(PathAutomaton::compile("L(S|D)*E"));
    return (atSurfaces.isEmpty() ? all : atSurfaces).shortestWord();
  } catch (const Error&) { // expression of a foreign program
    return {};
  }
}

/** A path in words. */
std::string pathText(const std::string& word) {
  std::string out;
  for (char letter : word) {
    const char* vertex = letter == 'L'   ? "lamp"
                         : letter == 'S' ? "mirror or glass"
                         : letter == 'V' ? "medium"
                         : letter == 'E' ? "eye"
                                         : "diffuse or glossy surface";
    out += (out.empty() ? "" : ", ") + std::string(vertex);
  }
  return out;
}

/** Whether a class has longer paths than this one. */
bool hasLongerPaths(const ClassMark& mark, const std::string& shortest) {
  if (shortest.size() < 2) return false;
  const std::string longer = "L(S|D|V){" + std::to_string(shortest.size() - 1) + ",}E";
  return !PathAutomaton::compile(mark.expression).intersect(PathAutomaton::compile(longer)).isEmpty();
}

/** Hint at a well-known mistake that gives this factor; empty where there is none. */
std::string wellKnownFactor(double factor, double error) {
  struct Known {
    double factor;
    const char* text;
  };
  static constexpr Known ALL[] = {
      {std::numbers::pi,
       "pi: is the factor 1/pi of the diffuse BSDF missing, or a density used twice as divisor?"},
      {1 / std::numbers::pi,
       "1/pi: is the diffuse BSDF divided by pi twice, or a density missing as divisor?"},
      {0.5, "one half: is one of two techniques missing, while the other has a MIS weight?"},
      {2, "two: do two techniques count the light without MIS weights?"},
      {4, "four: is the solid angle or area of a sphere used for that of its disk?"},
      {0.25, "a quarter: is the area of a disk used for that of its sphere?"}};
  constexpr double NEAR = 0.03, DEVIATIONS = 2;
  for (const Known& known : ALL)
    if (std::abs(factor / known.factor - 1) < NEAR + DEVIATIONS * error / known.factor)
      return std::string(" The factor is near ") + known.text;
  return {};
}

std::string whereText(const ClassMark& mark) {
  if (mark.visibleFraction == 0) return ", in the picture as a whole";
  return ", in " + percentText(mark.stateFraction) + " of the picture where it is visible";
}

void addChange(std::vector<MarkingStatement>& out, const Marking& marking) {
  const PictureChange& change = marking.change;
  const auto add = [&](const std::string& what, const std::string& advice) {
    out.push_back({what, advice, marking.changeCertainty});
  };
  if (change.encoding == ValueEncoding::SRGB || change.encoding == ValueEncoding::GAMMA_22)
    add("The values are encoded for a display (sRGB or gamma 2.2)",
        "An EXR file holds linear values: write the radiance as it is. Only 8-bit pictures are encoded.");
  if (change.encoding == ValueEncoding::DECODED)
    add("The values were linearised twice: shadows are too dark",
        "Linear values were written to an 8-bit picture without encoding. Encode them with the sRGB curve "
        "before writing PNG or JPEG, or write EXR.");
  if (change.encoding == ValueEncoding::TONE_CURVE)
    add("The values are not in proportion to light: a tone curve or an unknown encoding was applied",
        "Classes of light cannot be judged after it. Write linear values: an EXR file, or a PNG file with "
        "'--tonemap none --exposure 0' if nothing but lamps is above white." +
            (marking.isUnexplained()
                 ? " No curve explains " + percentText(marking.unexplainedFraction) +
                       " of the picture: the tone operator was a local one, or there are other mistakes."
                 : ""));
  if (change.isFlippedHorizontally && change.isFlippedVertically)
    add("The picture is rotated by 180 degrees",
        "Check the signs of x and y of camera rays, and the order of pixels in the file.");
  else if (change.isFlippedHorizontally)
    add("Left and right are swapped",
        "Check the sign of the camera's x axis (the order in its cross product), and the order of columns.");
  else if (change.isFlippedVertically)
    add("Top and bottom are swapped",
        "Row 0 is the top of the picture: check the sign of y of camera rays, and the order of rows.");
  if (!change.isShifted()) return;
  std::string shift;
  if (change.shiftX != 0)
    shift = std::to_string(std::abs(change.shiftX)) + (change.shiftX > 0 ? " to the right" : " to the left");
  if (change.shiftY != 0)
    shift += (shift.empty() ? "" : " and ") + std::to_string(std::abs(change.shiftY)) +
             (change.shiftY > 0 ? " down" : " up");
  add("The picture is shifted: pixels " + shift,
      "The camera differs: check its position and direction, the centre of the film, and that the pixel (x, "
      "y) covers x to x + 1.");
}

MarkingStatement statementOf(const ClassMark& mark, int number) {
  const std::string shortest = shortestPath(mark);
  const std::string paths = shortest.empty() ? "" : " Its paths: " + pathText(shortest) + ".";
  MarkingStatement out{"", "", mark.certainty, number};
  switch (mark.state) {
  case ClassState::MISSING:
    out.what = nameOf(mark) + " is missing" + whereText(mark);
    out.advice =
        "No estimator counts this light." + paths +
        " Which of your estimators should? 'recurse explain' lists the paths of each estimator of Recurse.";
    break;
  case ClassState::DOUBLED:
    out.what = nameOf(mark) + " is counted twice" + whereText(mark);
    out.advice =
        "Two estimators count the same light, such as shadow rays and rays that hit the lamp, or shadow "
        "rays and photons." +
        paths + " Remove one, or use MIS weights that add up to 1.";
    break;
  default:
    out.what = nameOf(mark) + " is " + factorText(mark.factor) + " times as bright as it should be" +
               whereText(mark);
    out.advice = "A factor is wrong where this light is computed." + paths +
                 " Check BSDF, cosine and density at its vertices." +
                 wellKnownFactor(mark.factor, mark.standardError);
    if (mark.factor < 1 && hasLongerPaths(mark, shortest))
      out.advice += " Or its longer paths are missing: check the maximum depth.";
  }
  return out;
}

const char* stateText(ClassState state) {
  return state == ClassState::DOUBLED ? "counted twice" : CLASS_STATE_NAMES[size_t(state)];
}

MarkingStatement statementOf(const ClassConfusion& confusion, const Marking& marking) {
  std::string list;
  double sum = 0;
  for (size_t i = 0; i < confusion.classes.size(); ++i) {
    list += (list.empty() ? "" : ", or ") + nameOf(marking.classes[confusion.classes[i]]) + " is " +
            stateText(confusion.states[i]) + " (" + percentText(confusion.probabilities[i]) + ")";
    sum += confusion.probabilities[i];
  }
  return {"Either " + list,
          "The light of these classes has the same pattern in this scene, so that they cannot be "
          "distinguished. Use a scene where the patterns differ.",
          std::min(sum, 1.0), static_cast<int>(confusion.classes.front())};
}

std::string sureText(double certainty) {
  return certainty > 0.999 ? "more than 99.9 % sure" : percentText(certainty) + " sure";
}

/** Breaks a text into lines of at most 100 characters, each with the indent. */
std::string wrapped(const std::string& text, const std::string& indent) {
  constexpr size_t WIDTH = 100;
  std::string out, line;
  for (size_t start = 0; start < text.size();) {
    const size_t end = std::min(text.find(' ', start), text.size());
    const std::string word = text.substr(start, end - start);
    if (!line.empty() && indent.size() + line.size() + 1 + word.size() > WIDTH) {
      out += indent + line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
    start = end + 1;
  }
  return out + indent + line + "\n";
}

std::string classTable(const Marking& marking) {
  std::string out = formatted("%-24s %8s  %-8s %8s %9s  %8s  %s\n", "class", "share", "state", "factor", "+-",
                              "told in", "paths");
  for (const ClassMark& mark : marking.classes) {
    const bool isKnown = mark.state != ClassState::UNKNOWN;
    out += formatted("%-24s %8s  %-8s %8s %9s  %8s  %s\n", mark.name.c_str(), percentText(mark.share).c_str(),
                     CLASS_STATE_NAMES[size_t(mark.state)], isKnown ? factorText(mark.factor).c_str() : "-",
                     isKnown ? formatted("%.2g", mark.standardError).c_str() : "-",
                     percentText(mark.visibleFraction).c_str(), mark.expression.c_str());
  }
  return out;
}

/** Remarks on the limits of the marks. */
std::vector<std::string> remarks(const Marking& marking) {
  std::vector<std::string> out;
  std::string unknown;
  for (const ClassMark& mark : marking.classes)
    if (mark.state == ClassState::UNKNOWN && mark.share > 0)
      unknown += (unknown.empty() ? "" : ", ") + mark.name;
  if (!unknown.empty() && marking.change.encoding != ValueEncoding::TONE_CURVE)
    out.push_back("Not judged: " + unknown +
                  ". They are too dark or too noisy in this picture, or too similar to other classes.");
  constexpr double SURE = 0.9;
  if (marking.changeCertainty < SURE)
    out.push_back("It is not known how the values were made from light: this reading of them is " +
                  percentText(marking.changeCertainty) + " probable. Give an EXR file with linear values.");
  if (marking.clippedFraction > 0)
    out.push_back(percentText(marking.clippedFraction) +
                  " of the pixels are clipped at white (8 bits): lamps, caustics and noise there cannot be "
                  "marked. Give an EXR file.");
  return out;
}

} // namespace

std::vector<MarkingStatement> markingStatements(const Marking& marking) {
  std::vector<MarkingStatement> out;
  addChange(out, marking);
  if (marking.exposureError > 0)
    out.push_back({"All light is " + factorText(marking.exposure) + " times as bright as it should be",
                   "The ratios of the classes are right: check the power of the lamps, the exposure, and the "
                   "division by the number of samples." +
                       wellKnownFactor(marking.exposure, marking.exposureError),
                   marking.exposureCertainty});
  std::vector<size_t> wrong;
  for (size_t i = 0; i < marking.classes.size(); ++i)
    if (marking.classes[i].state != ClassState::RIGHT && marking.classes[i].state != ClassState::UNKNOWN)
      wrong.push_back(i);
  std::stable_sort(wrong.begin(), wrong.end(),
                   [&](size_t a, size_t b) { return marking.classes[a].share > marking.classes[b].share; });
  for (size_t i : wrong) out.push_back(statementOf(marking.classes[i], static_cast<int>(i)));
  for (const ClassConfusion& confusion : marking.confusions) out.push_back(statementOf(confusion, marking));
  if (marking.isUnexplained() && marking.change.encoding != ValueEncoding::TONE_CURVE)
    out.push_back({"In " + percentText(marking.unexplainedFraction) +
                       " of the picture the difference is not explained by any class of light",
                   "Geometry, a material, a texture or the camera differs from the reference there."});
  return out;
}

std::string markingText(const Marking& marking) {
  std::string out;
  const std::vector<MarkingStatement> statements = markingStatements(marking);
  if (statements.empty()) out += "No errors were found in this picture.\n";
  for (const MarkingStatement& statement : statements)
    out += "* " + statement.what + " (" + sureText(statement.certainty) + ")\n" +
           wrapped(statement.advice, "  ");
  out += "\n" + classTable(marking);
  for (const std::string& remark : remarks(marking)) out += "\n" + wrapped(remark, "");
  return out;
}

std::string markingJson(const Marking& marking) {
  static constexpr const char* ENCODING_NAMES[] = {"linear", "srgb", "gamma22", "decoded", "tone curve"};
  const PictureChange& change = marking.change;
  Json json = {{"right", marking.isRight()}};
  json["statements"] = Json::array();
  for (const MarkingStatement& s : markingStatements(marking))
    json["statements"].push_back({{"what", s.what}, {"advice", s.advice}, {"certainty", s.certainty}});
  json["remarks"] = remarks(marking);
  json["encoding"] = ENCODING_NAMES[size_t(change.encoding)];
  json["flipped_horizontally"] = change.isFlippedHorizontally;
  json["flipped_vertically"] = change.isFlippedVertically;
  json["shift"] = {change.shiftX, change.shiftY};
  json["change_certainty"] = marking.changeCertainty;
  json["exposure"] = marking.exposure;
  json["exposure_standard_error"] = marking.exposureError;
  json["exposure_certainty"] = marking.exposureCertainty;
  json["clipped"] = marking.clippedFraction;
  json["unexplained"] = marking.unexplainedFraction;
  json["classes"] = Json::array();
  for (const ClassMark& mark : marking.classes)
    json["classes"].push_back({{"name", mark.name},
                               {"expression", mark.expression},
                               {"share", mark.share},
                               {"state", CLASS_STATE_NAMES[size_t(mark.state)]},
                               {"certainty", mark.certainty},
                               {"factor", mark.factor},
                               {"standard_error", mark.standardError},
                               {"told_in", mark.visibleFraction},
                               {"state_in", mark.stateFraction}});
  json["alike"] = Json::array();
  for (const ClassConfusion& confusion : marking.confusions) {
    Json one = Json::array();
    for (size_t i = 0; i < confusion.classes.size(); ++i)
      one.push_back({{"name", marking.classes[confusion.classes[i]].name},
                     {"state", CLASS_STATE_NAMES[size_t(confusion.states[i])]},
                     {"probability", confusion.probabilities[i]}});
    json["alike"].push_back(std::move(one));
  }
  json["regions"] = Json::array();
  for (const MarkedRegion& region : marking.regions) {
    Json one = {{"x", region.x},
                {"y", region.y},
                {"width", region.width},
                {"height", region.height},
                {"used", region.usedFraction},
                {"unexplained", region.unexplained}};
    one["classes"] = Json::array();
    for (const ClassFinding& finding : region.classes)
      one["classes"].push_back({{"state", CLASS_STATE_NAMES[size_t(finding.state)]},
                                {"factor", finding.factor},
                                {"standard_error", finding.standardError}});
    json["regions"].push_back(std::move(one));
  }
  return json.dump(2) + "\n";
}

} // namespace recurse
