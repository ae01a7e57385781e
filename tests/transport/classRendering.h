/** @file
 * Renders of path classes for tests: many classes in one render, their means over the picture, and the errors
 * of these means from renders with independent seeds.
 */
#pragma once

#include "rendering.h"

#include <set>

#include "recurse/pathclasses/pathExpression.h"

namespace recurse::testing {

/** Means of many quantities and their standard errors, from independent batches of equal size. */
class BatchMeans {
 public:
  void add(const std::vector<double>& batch) {
    sum.resize(batch.size());
    squares.resize(batch.size());
    for (size_t i = 0; i < batch.size(); ++i) {
      sum[i] += batch[i];
      squares[i] += batch[i] * batch[i];
    }
    ++count;
  }
  double mean(size_t i) const { return sum[i] / count; }
  double standardError(size_t i) const {
    return std::sqrt(std::max(0.0, squares[i] / count - square(mean(i))) / (count - 1));
  }

 private:
  std::vector<double> sum, squares;
  double count = 0;
};

inline Rendered renderClasses(const Scene& scene, const Way& way, const PathClasses& classes,
                              int samplesPerPixel, uint64_t seed) {
  Rendered out =
      renderScene(scene, *integratorFrom(way.integrator, way.parameters), classes, samplesPerPixel, seed);
  EXPECT_EQ(out.statistics.counts.nonFinite, 0u) << way.integrator << " " << way.parameters;
  return out;
}

/** Means over pictures with the seeds 1, 2, … */
inline BatchMeans classMeans(const Scene& scene, const Way& way, const PathClasses& classes,
                             int samplesPerPixel, int seeds) {
  BatchMeans means;
  for (int seed = 1; seed <= seeds; ++seed)
    means.add(renderClasses(scene, way, classes, samplesPerPixel, uint64_t(seed)).layerMeans());
  return means;
}

/** Every integrator with every combination of its options that are a choice among words or booleans, read
 * from the declarations, so that future integrators and options are included. Excludes "without", which
 * disables single mechanisms for measurements and would multiply the number of combinations. */
inline std::vector<Way> everyWay() {
  std::vector<Way> ways;
  for (const auto& entry : plugIns().integrators.entries()) {
    std::vector<Way> combinations = {{entry.name, ""}};
    for (const ParameterSpec& p : entry.parameters) {
      if (p.ignored || p.count != 1 || p.name == "without") continue;
      std::vector<std::string> choices;
      if (p.type == ParameterType::BOOLEAN)
        choices = {"\"bool " + p.name + "\" false", "\"bool " + p.name + "\" true"};
      if (p.type == ParameterType::STRING)
        for (const std::string& choice : p.choices)
          choices.push_back("\"string " + p.name + "\" \"" + choice + "\"");
      if (choices.empty()) continue;
      std::vector<Way> more;
      for (const Way& way : combinations)
        for (const std::string& choice : choices)
          more.push_back({way.integrator, way.parameters + " " + choice});
      combinations = more;
    }
    ways.insert(ways.end(), combinations.begin(), combinations.end());
  }
  return ways;
}

/** Subset of everyWay() with distinct assignments of paths to estimators. */
inline std::vector<Way> waysThatShareOutDifferently() {
  std::vector<Way> ways;
  std::set<std::string> known;
  for (const Way& way : everyWay()) {
    std::string paths;
    for (const EstimatorDomain& d : integratorFrom(way.integrator, way.parameters)->domains())
      paths += d.estimator + " " + d.expression + "\n";
    if (known.insert(paths).second) ways.push_back(way);
  }
  return ways;
}

/** Way with the given number of photons if the integrator shoots any, or a hundredth of it for virtual
 * lights. */
inline Way withPhotons(Way way, int photons) {
  const auto* entry = plugIns().integrators.find(way.integrator);
  if (entry)
    for (const ParameterSpec& p : entry->parameters) {
      if (p.name == "passes" && !p.ignored) way.parameters += " \"integer passes\" 1";
      if (p.name == "photons" && !p.ignored)
        way.parameters += " \"integer photons\" " + std::to_string(photons);
      if (p.name == "lightpaths" && way.integrator == "vpl")
        way.parameters += " \"integer lightpaths\" " + std::to_string(std::max(1, photons / 100));
    }
  return way;
}

} // namespace recurse::testing
