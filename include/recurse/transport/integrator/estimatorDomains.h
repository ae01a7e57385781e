/** @file
 * Domains of estimators: the paths that each one accounts for. "It is important that different methods of
 * estimating radiance do not take the same paths into account": every estimator of an integrator declares its
 * paths, and automata find paths that are missing or counted twice.
 */
#pragma once

#include <string>
#include <vector>

namespace recurse {

/** An estimator of radiance, and its domain. */
struct EstimatorDomain {
  std::string estimator;  ///< name in explanations, such as "shadow rays"
  std::string expression; ///< its domain, in the notation of pathExpression.h
  std::string cost;       ///< its operations and their cost, in a few words
  /** Group of estimators that may share paths, with weights that add up to one; empty: none. */
  std::string sharedGroup;
  bool hitsLights = false; ///< finds lights by rays that hit their source, which excludes delta lights
  bool onlyPanes = false;  ///< finds only those paths of the domain that pass straight through thin panes
  bool fromMedia = false;  ///< finds only those paths of the domain that begin in an emissive medium
};

/** Faults of a list of estimators; none when `sound()`. */
struct DomainReport {
  struct Overlap {
    std::string first, second; ///< the estimators
    std::string example;       ///< a shortest common path of both domains
  };
  std::vector<Overlap> overlaps;      ///< only of pairs that do not share a group
  std::vector<std::string> uncovered; ///< examples of paths in no domain
  std::string uncoveredExpression;    ///< all paths in no domain, if a short expression was found

  bool sound() const { return overlaps.empty() && uncovered.empty(); }
  /** Text with a line for every fault; empty when sound. */
  std::string text() const;
};

/** Compares the domains with each other and with the paths of the expression `covers`. An `onlyPanes`
 * estimator covers no path, but its overlaps are faults too. Throws Error naming the estimator for an
 * expression that does not compile. */
DomainReport checkDomains(const std::vector<EstimatorDomain>& estimators, const std::string& covers = "all");

/** Expression of the paths from delta lights that no estimator finds, or one such path; empty where all are
 * found. Paths in media are left out. A pane is an S event, so that the expression includes paths straight
 * through thin panes, which an `onlyPanes` estimator may find. Delta lights are not visible, neither directly
 * nor in mirrors: LS*E contains no light from them. */
std::string missedOfDeltaLights(const std::vector<EstimatorDomain>& estimators);

/** Table of the estimators for a terminal, with a line for each. */
std::string formatDomains(const std::vector<EstimatorDomain>& estimators);

} // namespace recurse
