/** @file
 * Rendering and reporting for the hard cases.
 */
#include "hardCase.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <typeindex>

namespace recurse::hard {

/** Limit of four relative standard errors, with which a mean still shows that light was lost or counted
 * twice. */
constexpr double MAX_NOISE = SANITIZED ? INFINITY : 0.4;

void Report::atMost(const std::string& detail, const std::string& integrator, const std::string& figureName,
                    double figure, double bound, const std::string& problem) const {
  Row row;
  row.what = what(detail);
  row.integrator = integrator;
  row.figure = figureName + " " + shown("%.3g", figure);
  row.bound = "<= " + shown("%.3g", bound);
  row.passed = problem.empty() && (SANITIZED ? !std::isnan(figure) : figure <= bound); // false for NaN
  row.reason = problem.empty() ? "beyond the bound" : problem;
  send(row);
}

void Report::holds(const std::string& detail, const std::string& integrator, const std::string& figure,
                   bool passed, const std::string& reason) const {
  send({what(detail), integrator, figure, "right", passed, reason});
}

bool thorough = false;

namespace {

/** Reason why a comparison would be meaningless: a picture without light, or a bound that a black picture
 * keeps. Empty: none. */
std::string saysNothing(double mean, double bound) {
  if (SANITIZED) return {};
  if (!(mean > 0)) return "the picture is black";
  if (!(bound < 1)) return "the bound is so wide that a black picture would keep it";
  return {};
}

/** Calls visit(entry, integrator) for each integrator of the registry. */
template <class Visit> void forIntegrators(const Visit& visit) {
  std::set<std::type_index> seen;
  for (const auto& entry : plugIns().integrators.entries()) {
    // Aliases of an integrator are skipped.
    const auto made = testing::integratorFrom(entry.name, "");
    const Integrator& integrator = *made;
    if (!seen.insert(typeid(integrator)).second) continue;
    // It is meant for study, without methods for hard cases.
    if (entry.name != "simplephotonmap") visit(entry, integrator);
  }
}

/** Whether an integrator splats, so that the noise of a picture cannot be measured in it, or omits paths, so
 * that it does not claim all light. */
bool isOtherMethod(const Integrator& integrator) {
  return integrator.splats() || !integrator.claims().empty();
}

} // namespace

std::vector<Method> otherMethods() {
  std::vector<Method> methods;
  forIntegrators([&](const auto& entry, const Integrator& integrator) {
    if (!isOtherMethod(integrator)) return;
    const bool merges = std::any_of(entry.parameters.begin(), entry.parameters.end(),
                                    [](const ParameterSpec& p) { return p.name == "photons" && !p.ignored; });
    methods.push_back(
        {{entry.name, "", entry.name, merges, false}, integrator.claims(), integrator.suppositions()});
  });
  return methods;
}

std::vector<Way> allWays(double photons, const std::string& more) {
  std::vector<Way> ways;
  forIntegrators([&](const auto& entry, const Integrator& integrator) {
    // With one map an integrator that chooses among others has nothing to choose.
    if (isOtherMethod(integrator) || !integrator.choices().empty()) return;
    const auto parameter = [&](const char* name) -> const ParameterSpec* {
      for (const ParameterSpec& p : entry.parameters)
        if (p.name == name && !p.ignored) return &p;
      return nullptr;
    };
    if (!parameter("photons")) {
      ways.push_back({entry.name, "", entry.name, false, false});
      return;
    }
    const std::string base = std::string(parameter("passes") ? "\"integer passes\" 1 " : "") +
                             "\"integer photons\" " +
                             shown("%.0f", SANITIZED ? std::max(photons / 64, 1.0) : photons) + " " + more;
    const ParameterSpec* direct = parameter("direct");
    if (!direct) {
      ways.push_back({entry.name, base, entry.name, true, true});
      return;
    }
    for (const std::string& choice : direct->choices) {
      const bool byDefault = choice == direct->defaultText;
      ways.push_back({entry.name, base + (byDefault ? "" : " \"string direct\" \"" + choice + "\""),
                      byDefault ? entry.name : entry.name + ", direct " + choice, true, choice == "photons"});
    }
    if (thorough && parameter("passes"))
      ways.push_back({entry.name, base + " \"integer passes\" 4", entry.name + ", 4 passes", true, false});
  });
  return ways;
}

Rendered renderScene(const Scene& scene, const Way& way, int samplesPerPixel, uint64_t seed,
                     const PathClasses& classes) {
  return testing::renderScene(scene, *testing::integratorFrom(way.integrator, way.parameters), classes,
                              samplesPerPixel, seed);
}

Rendered renderScene(const Scene& scene, const Way& way, const Budget& budget, uint64_t seed) {
  const int n = way.usesPhotons ? budget.photonSamples : budget.samples;
  return renderScene(scene, way, SANITIZED ? std::max(1, n / 128) : thorough ? 4 * n : n, seed);
}

namespace {

/** Mean of the light that each method does not claim, by the photon map, which finds all light. */
std::vector<double> unclaimedLight(const Scene& scene, const std::vector<Method>& methods) {
  std::vector<PathClass> classes;
  for (const Method& m : methods)
    classes.push_back({m.way.integrator, m.claims.empty() ? "L.*E" : "!(" + m.claims + ")"});
  const Way all{"photonmap", "\"integer passes\" 1 \"integer photons\" 20000", "", true, false};
  classes.push_back({"all", "all"});
  const Rendered r = renderScene(scene, all, 16, 1, PathClasses(classes));
  if (!SANITIZED && !(r.mean(methods.size()) > 0))
    throw Error("what methods claim cannot be told: the picture is black");
  std::vector<double> means;
  for (size_t i = 0; i < methods.size(); ++i) means.push_back(methods[i].claims.empty() ? 0 : r.mean(i));
  return means;
}

/** Reports one row for each method: a result, or the relative error. The noise is measured from pictures with
 * different seeds. */
void checkOtherMethods(const Report& report, const std::string& detail, const Scene& scene, double expected,
                       const Budget& budget) {
  constexpr int PICTURES = 8;
  constexpr double MOST_NOISE =
      5.4; // in standard errors estimated from this number of pictures; exceeded once in 1000
  const std::vector<Method> methods = otherMethods();
  const std::vector<double> unclaimed = unclaimedLight(scene, methods);
  for (size_t i = 0; i < methods.size(); ++i) {
    const Method& m = methods[i];
    const auto answers = [&](const std::string& answer) {
      report.holds(detail, m.way.label, answer, true, {});
    };
    const auto integrator = testing::integratorFrom(m.way.integrator, "");
    if (const std::string part = unsupportedPart(*integrator, scene); !part.empty()) {
      answers("does not render " + part);
      continue;
    }
    if (unclaimed[i] > budget.tolerance / 2 * std::abs(expected)) {
      answers("does not claim these paths");
      continue;
    }
    if (!m.suppositions.empty()) {
      answers("supposes otherwise");
      continue;
    }
    double sum = 0, squares = 0;
    std::string problem;
    for (uint64_t seed = 1; seed <= PICTURES && problem.empty(); ++seed) {
      const Rendered r = renderScene(scene, m.way, std::max(1, budget.samples / PICTURES), seed);
      problem = r.unsound();
      sum += r.mean();
      squares += square(r.mean());
    }
    const double mean = sum / PICTURES;
    const double noise = MOST_NOISE *
                         std::sqrt(std::max(0.0, squares / PICTURES - square(mean)) / (PICTURES - 1)) /
                         std::abs(expected);
    if (problem.empty() && noise > MAX_NOISE) {
      answers("finds too few of these paths");
      continue;
    }
    const double bound = (m.way.usesPhotons ? budget.photonTolerance : budget.tolerance) + noise;
    if (problem.empty()) problem = saysNothing(mean, bound);
    report.atMost(detail, m.way.label, "relative error", std::abs(mean / expected - 1), bound, problem);
  }
}

} // namespace

void checkMean(const Report& report, const std::string& detail, const std::string& sceneText, double expected,
               const Budget& budget, bool indirect) {
  const auto scene = sceneFrom(sceneText);
  for (const Way& way : allWays(budget.photons, budget.photonParameters)) {
    if (budget.only && !budget.only(way)) continue;
    const Rendered r = renderScene(*scene, way, budget);
    const double noise = 4 * r.standardError() / std::abs(expected);
    const double bound = (fromMap(way, indirect) ? budget.photonTolerance : budget.tolerance) + noise;
    std::string problem = r.unsound();
    if (problem.empty() && noise > MAX_NOISE) problem = "the noise is so large that the bound says nothing";
    if (problem.empty()) problem = saysNothing(r.mean(), bound);
    report.atMost(detail, way.label, "relative error", std::abs(r.mean() / expected - 1), bound, problem);
  }
  if (thorough && !budget.only) checkOtherMethods(report, detail, *scene, expected, budget);
}

std::string orthographic(double half) {
  const std::string h = number(half);
  return "Camera \"orthographic\" \"float screenwindow\" [-" + h + " " + h + " -" + h + " " + h + "]";
}

std::string diffuse(double albedo) {
  const std::string a = number(albedo);
  return "Material \"diffuse\" \"rgb reflectance\" [" + a + " " + a + " " + a + "]\n";
}
std::string glass(double eta) { return "Material \"dielectric\" \"float eta\" " + number(eta) + "\n"; }
std::string constantLight(double radiance) {
  const std::string l = number(radiance);
  return "LightSource \"infinite\" \"rgb L\" [" + l + " " + l + " " + l + "]\n";
}

} // namespace recurse::hard
