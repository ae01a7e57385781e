/** @file
 * Hard cases: generated scenes whose answer is known in closed form, or robustly by other means. Each case
 * reports rows of the table that scripts/hard prints: a figure, the bound it must not exceed, pass or fail.
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
  std::string what;       ///< the case and what of it
  std::string integrator; ///< integrator and choice of direct light; "-" where none is involved
  std::string figure, bound;
  bool passed = false;
  std::string reason; ///< of a failure
};

/** Takes the rows of a case as they are found. */
class Report {
 public:
  Report(std::string name, std::function<void(const Row&)> send)
      : name(std::move(name)), send(std::move(send)) {}

  /** The figure must be a number and not exceed the bound; under sanitizers, with their few samples, only a
   * number. */
  void atMost(const std::string& detail, const std::string& integrator, const std::string& figureName,
              double figure, double bound, const std::string& problem = {}) const;
  /** Something that is right or not; `figure` says how it is. */
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
  bool heavy = false; ///< too long for every test run
  std::function<void(const Report&)> run;
};
using HardCases = std::vector<HardCase>;

/** One way of estimating the whole of light transport. */
struct Way {
  std::string integrator, parameters;
  std::string label;          ///< for the table
  bool usesPhotons = false;   ///< it estimates light from a photon map
  bool directPhotons = false; ///< direct light too
};

/** For `--heavy`: four times the samples of a budget, and progressive photon maps too. */
extern bool thorough;

/**
 * The integrators of the registry, and each choice that they have for direct light. `more` goes to those that
 * shoot photons; under sanitizers they shoot a 16th.
 */
std::vector<Way> allWays(double photons, const std::string& more = {});

/** The other integrators: those that leave out paths, or suppose something, by their nature, and those whose
 * light paths splat. */
struct Method {
  Way way;
  std::string claims, suppositions; ///< as of Integrator
};
std::vector<Method> otherMethods();

/** What a case may spend, and how near it must come. */
struct Budget {
  int samples = 64;      ///< a pixel, for ways without photons
  int photonSamples = 8; ///< a pixel, for ways with photons
  double photons = 1e5;
  double tolerance = 1e-3;       ///< relative, beside four standard errors of the picture's own noise
  double photonTolerance = 0.02; ///< the same where light comes from the map
  std::string photonParameters;
  std::function<bool(const Way&)> only; ///< empty: every way
};
/** Four relative standard deviations of an estimate from so many photons, with the Epanechnikov kernel. */
inline double photonNoise(double found) { return 4 * std::sqrt(4.0 / 3 / found); }

/** Light reaches the map by surfaces between, not straight from a light: without `directPhotons` none is
 * used. */
inline bool fromMap(const Way& way, bool indirect) {
  return way.usesPhotons && (indirect || way.directPhotons);
}

Rendered renderScene(const Scene& scene, const Way& way, int samplesPerPixel, uint64_t seed = 1,
                     const PathClasses& classes = PathClasses());
/** With the budget's samples; sanitizers, which check no means, get a 128th. */
Rendered renderScene(const Scene& scene, const Way& way, const Budget& budget, uint64_t seed = 1);

/**
 * One row for every way: how far the mean of the picture is from what is expected. `indirect` says that the
 * map holds light that matters even when direct light comes from shadow rays. For `--heavy` the other methods
 * are asked too, and may answer that they do not claim all of the scene's paths.
 */
void checkMean(const Report& report, const std::string& detail, const std::string& sceneText, double expected,
               const Budget& budget, bool indirect = false);

/** Half of the window's width. */
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
