/** @file
 * States of classes by Bayesian model selection: which of them are missing, doubled or scaled.
 */
#pragma once

#include <array>
#include <vector>

#include "recurse/report/marking/marking.h"
#include "report/marking/cells.h"

namespace recurse {

/** Prior probabilities of the known states of a class, in the order of ClassState. */
using StatePrior = std::array<double, CLASS_STATES>;
/** One class in twenty is wrong, in one of three ways. */
constexpr StatePrior STATE_PRIOR = {0.95, 0.05 / 3, 0.05 / 3, 0.05 / 3};

struct StateProblem {
  ClassSums sums;
  std::vector<double> others;    ///< products of the layers with the light of all other layers
  std::vector<StatePrior> prior; ///< priors of each class
  double exposure = 1;           ///< factor of all classes
  bool findsExposure = false;    ///< a different exposure is tried as well
};

struct StateFindings {
  std::vector<ClassFinding> classes;
  std::vector<ClassState> best; ///< most probable states of all classes together
  double exposure = 1, exposureError = 0, exposureCertainty = 1;
};

StateFindings findStates(const StateProblem& problem);

} // namespace recurse
