/** @file
 * Who estimates which paths. "It is important that different methods of estimating radiance do not take the
 * same paths into account": so every estimator of an integrator declares its paths, and what they leave out
 * or take twice is found by automata.
 */
#pragma once

#include <string>
#include <vector>

namespace recurse {

/** One way to estimate radiance, and the paths it takes into account. */
struct EstimatorDomain {
  std::string estimator;  ///< as an explanation calls it, such as "shadow rays"
  std::string expression; ///< its paths, as in pathExpression.h
  std::string cost;       ///< what it does and what that costs, in a few words
  std::string
      sharedGroup; ///< estimators of one group may share paths: their weights add up to one. Else empty
  bool hitsLights = false; ///< finds light by rays that hit its source, which no delta light has
  bool onlyPanes = false;  ///< finds, of these paths, those that go straight through thin panes
};

/** What is wrong with a list of estimators; nothing when `sound()`. */
struct DomainReport {
  struct Overlap {
    std::string first, second; ///< the estimators
    std::string example;       ///< a shortest path that both take into account
  };
  std::vector<Overlap> overlaps;      ///< only of pairs that do not declare to share
  std::vector<std::string> uncovered; ///< examples of paths that no estimator takes into account
  std::string uncoveredExpression;    ///< all of those, where a short expression was found

  bool sound() const { return overlaps.empty() && uncovered.empty(); }
  /** A line for every finding; empty when sound. */
  std::string text() const;
};

/** Compares the estimators with each other and with the paths that they should cover together. Throws Error
 * for an expression that does not compile, with the name of the estimator. */
DomainReport checkDomains(const std::vector<EstimatorDomain>& estimators, const std::string& covers = "all");

/** The paths from lights at a point or in one direction that no estimator finds, but straight through thin
 * panes, as an expression; empty where there are none. Such lights cannot be seen, at once or in mirrors:
 * LS*E has no light of theirs. */
std::string missedOfDeltaLights(const std::vector<EstimatorDomain>& estimators);

/** The estimators as a table for a terminal, a line each. */
std::string formatDomains(const std::vector<EstimatorDomain>& estimators);

} // namespace recurse
