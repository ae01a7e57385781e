/** @file
 * Hard cases: generated scenes whose result is known in closed form, or by other robust methods. Each case
 * reports rows of the table that scripts/hard prints: a figure, its bound, pass or fail.
 */
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "recurse/core/image/image.h"
#include "sceneRendering.h"

namespace recurse::hard {

using testing::number;
using testing::perspective;
using testing::Rendered;
using testing::SANITIZED;
using testing::sceneFrom;
using testing::shown;
using testing::view;

struct Row {
  std::string what;       ///< the case and its detail
  std::string integrator; ///< integrator and choice of direct light; "-" for none
  std::string figure, bound;
  bool passed = false;
  std::string reason; ///< reason of a failure
};

/** Receives the rows of a case. */
class Report {
 public:
  Report(std::string name, std::function<void(const Row&)> send)
      : name(std::move(name)), send(std::move(send)) {}

  /** Reports a figure, which must be a number below the bound; under sanitizers, which use few samples, only
   * a number. */
  void atMost(const std::string& detail, const std::string& integrator, const std::string& figureName,
              double figure, double bound, const std::string& problem = {}) const;
  /** Reports whether a property holds; `figure` describes it. */
  void holds(const std::string& detail, const std::string& integrator, const std::string& figure, bool passed,
             const std::string& reason) const;

 private:
  std::string what(const std::string& detail) const { return detail.empty() ? name : name + ": " + detail; }
  std::string name;
  std::function<void(const Row&)> send;
};

struct HardCase {
  int group = 0; ///< 1 to 11
  std::string name;
  bool heavy = false; ///< too slow for every test run
  std::function<void(const Report&)> run;
};
using HardCases = std::vector<HardCase>;

/** A way to estimate all light transport. */
struct Way {
  std::string integrator, parameters;
  std::string label;          ///< label in the table
  bool usesPhotons = false;   ///< reads a photon map
  bool directPhotons = false; ///< reads direct light from the map as well
};

/** For `--heavy`: four times the samples of a budget, and additional progressive photon maps. */
extern bool thorough;

/** The integrators of the registry, with each of their choices for direct light. `more` is for integrators
 * that shoot photons; under sanitizers they shoot a 16th. */
std::vector<Way> allWays(double photons, const std::string& more = {});

/** Integrators that omit paths or make assumptions, by definition, and integrators that splat. */
struct Method {
  Way way;
  std::string claims, suppositions; ///< as in Integrator
};
std::vector<Method> otherMethods();

/** Cost and tolerance of a case. */
struct Budget {
  int samples = 64;      ///< per pixel, for ways without photons
  int photonSamples = 8; ///< per pixel, for ways with photons
  double photons = 1e5;
  double tolerance = 1e-3;       ///< relative, in addition to four standard errors of the picture's own noise
  double photonTolerance = 0.02; ///< tolerance for light from the map
  std::string photonParameters;
  std::function<bool(const Way&)> only; ///< empty: every way
};
/** Four relative standard deviations of an estimate from `found` photons, with the Epanechnikov kernel. */
inline double photonNoise(double found) { return 4 * std::sqrt(4.0 / 3 / found); }

/** Whether the result depends on the map, which has direct light only with `directPhotons`. `indirect`: light
 * reaches the visible surface by other surfaces. */
inline bool fromMap(const Way& way, bool indirect) {
  return way.usesPhotons && (indirect || way.directPhotons);
}

Rendered renderScene(const Scene& scene, const Way& way, int samplesPerPixel, uint64_t seed = 1,
                     const PathClasses& classes = PathClasses());
/** Renders with the samples of the budget; sanitizers, which check no means, use a 128th. */
Rendered renderScene(const Scene& scene, const Way& way, const Budget& budget, uint64_t seed = 1);

/** Reports one row for every way: the relative difference of the picture's mean from the expected value.
 * `indirect`: the map has relevant light even if direct light comes from shadow rays. `--heavy` includes the
 * other methods, which may report that they do not claim all paths of the scene. */
void checkMean(const Report& report, const std::string& detail, const std::string& sceneText, double expected,
               const Budget& budget, bool indirect = false);

/** `half`: half of the window's width. */
std::string orthographic(double half);
std::string diffuse(double albedo);
std::string glass(double eta);
std::string constantLight(double radiance);

void addScaleCases(HardCases& cases);
void addGrazingCases(HardCases& cases);
void addMeshCases(HardCases& cases);
void addGlassCases(HardCases& cases);
void addLampCases(HardCases& cases);
void addFurnaceCases(HardCases& cases);
void addRangeCases(HardCases& cases);
void addPhotonMapCases(HardCases& cases);
void addEllipsoidCases(HardCases& cases);
void addInputCases(HardCases& cases);
void addMediumCases(HardCases& cases);

} // namespace recurse::hard
