/** @file
 * Evidence of states. With the sums N and b of least squares, b is normally distributed about N f with
 * covariance C for factors f. Under a state, the factor is normally distributed about m with variance T:
 * narrow for right, missing and doubled, wide for scaled. Therefore b is normally distributed about N m + h
 * with covariance C + N T N, which penalises the wide distribution, and the factors are m + T N (C + N T N)⁻¹
 * (b - N m - h). h is due to layers whose factors are given. An exposure s is a factor of m, of h and of the
 * root of T.
 */
#include "report/marking/classStates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

namespace recurse {

namespace {

/** Standard deviation of the factor of a right, missing or doubled class: bias of a good renderer. */
constexpr double NARROW = 0.05;
/** Standard deviation of the factor of a scaled class, about 1. */
constexpr double WIDE = 1;
/** Prior probability of a wrong exposure, and the width of its distribution. */
constexpr double EXPOSURE_PRIOR = 0.05, EXPOSURE_WIDTH = 2;
/** Standard errors by which an exposure must differ from zero. */
constexpr double LEAST_DEVIATIONS = 5;
/** Most successive changes of states that are tried; more would mean a different scene. */
constexpr int MOST_CHANGES = 6;

using States = std::vector<ClassState>;
constexpr ClassState KNOWN_STATES[] = {ClassState::RIGHT, ClassState::MISSING, ClassState::DOUBLED,
                                       ClassState::SCALED};

double centre(ClassState state) {
  return state == ClassState::MISSING ? 0 : state == ClassState::DOUBLED ? 2 : 1;
}

/** Cholesky factor of a symmetric matrix in its lower triangle; false where it is not positive definite. */
bool factorise(std::vector<double>& a, size_t n) {
  for (size_t j = 0; j < n; ++j) {
    for (size_t k = 0; k < j; ++k)
      for (size_t i = j; i < n; ++i) a[i * n + j] -= a[i * n + k] * a[j * n + k];
    if (!(a[j * n + j] > 0)) return false;
    const double root = std::sqrt(a[j * n + j]);
    for (size_t i = j; i < n; ++i) a[i * n + j] /= root;
  }
  return true;
}

/** Solves L y = x in place. */
void solveLower(const std::vector<double>& l, std::vector<double>& x) {
  const size_t n = x.size();
  for (size_t i = 0; i < n; ++i) {
    for (size_t k = 0; k < i; ++k) x[i] -= l[i * n + k] * x[k];
    x[i] /= l[i * n + i];
  }
}
/** Evaluation of a set of states. */
struct Hypothesis {
  bool isPossible = false;
  double score = 0; ///< −2 ln of the posterior probability
  double exposure = 1, exposureError = 0;
};

class Evidence {
 public:
  explicit Evidence(const StateProblem& problem) : problem(problem), n(problem.sums.layers()) {
    covariance = problem.sums.covariance;
    // Regularises layers that are equal up to rounding.
    constexpr double ROUNDING = 1e-6;
    for (size_t i = 0; i < n; ++i) covariance[i * n + i] *= 1 + ROUNDING;
  }

  Hypothesis of(const States& states, bool findsExposure) const {
    Hypothesis out;
    out.exposure = problem.exposure;
    for (size_t i = 0; i < n; ++i) out.score -= 2 * std::log(problem.prior[i][size_t(states[i])]);
    if (findsExposure) {
      // An exposure is the factor that most classes share.
      if (2 * std::count(states.begin(), states.end(), ClassState::RIGHT) <= static_cast<std::ptrdiff_t>(n))
        return {};
      // Ordinary least squares of one factor: weights by the inverse covariance would prefer layers that have
      // little noise by chance.
      const std::vector<double> m = centres(states);
      const double light = dot(m, expected(m));
      out.exposure = dot(m, problem.sums.vector) / light;
      if (!(light > 0 && out.exposure > 0)) return {};
      out.exposureError = std::sqrt(dot(m, product(covariance, m))) / light;
      if (out.exposure < LEAST_DEVIATIONS * out.exposureError) return {}; // nothing but noise
      const double information = 1 / (out.exposureError * out.exposureError);
      // Laplace's approximation of the integral over a normal distribution of the exposure about 1.
      out.score += std::log(information * EXPOSURE_WIDTH * EXPOSURE_WIDTH) - 2 * std::log(EXPOSURE_PRIOR);
    }
    std::vector<double> l = spread(states, out.exposure), d = residual(states, out.exposure);
    if (!factorise(l, n)) return {};
    solveLower(l, d);
    out.score += dot(d, d);
    for (size_t i = 0; i < n; ++i) out.score += 2 * std::log(l[i * n + i]);
    out.isPossible = true;
    // Factors of light are not negative.
    for (size_t i = 0; i < n; ++i)
      if (states[i] == ClassState::SCALED && factorOf(i, states[i], out.exposure, l, d).factor < 0)
        out.isPossible = false;
    return out;
  }

  /** Sets factors relative to the exposure, and their standard errors. */
  void setFactors(std::vector<ClassFinding>& classes, const States& states, double exposure) const {
    std::vector<double> l = spread(states, exposure), d = residual(states, exposure);
    if (!factorise(l, n)) return;
    solveLower(l, d);
    for (size_t i = 0; i < n; ++i) {
      const Factor found = factorOf(i, states[i], exposure, l, d);
      classes[i].factor = found.factor;
      classes[i].standardError = found.standardError;
    }
  }

 private:
  struct Factor {
    double factor, standardError;
  };

  /** Factor of class i. `l` is the Cholesky factor of the spread, `d` the residual solved by it. */
  Factor factorOf(size_t i, ClassState state, double exposure, const std::vector<double>& l,
                  const std::vector<double>& d) const {
    const double width = widthOf(state), variance = width * width;
    const auto row = problem.sums.matrix.begin() + static_cast<std::ptrdiff_t>(i * n);
    std::vector<double> column(row, row + static_cast<std::ptrdiff_t>(n));
    solveLower(l, column);
    return {centre(state) + exposure * variance * dot(column, d),
            width * std::sqrt(std::max(0.0, 1 - exposure * exposure * variance * dot(column, column)))};
  }

  static double widthOf(ClassState state) { return state == ClassState::SCALED ? WIDE : NARROW; }
  static double dot(const std::vector<double>& a, const std::vector<double>& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  }
  static std::vector<double> centres(const States& states) {
    std::vector<double> out;
    for (ClassState state : states) out.push_back(centre(state));
    return out;
  }
  static std::vector<double> product(const std::vector<double>& matrix, const std::vector<double>& x) {
    std::vector<double> out(x.size());
    for (size_t i = 0; i < x.size(); ++i)
      for (size_t j = 0; j < x.size(); ++j) out[i] += matrix[i * x.size() + j] * x[j];
    return out;
  }
  /** N m + h. */
  std::vector<double> expected(const std::vector<double>& m) const {
    std::vector<double> out = product(problem.sums.matrix, m);
    for (size_t i = 0; i < n; ++i) out[i] += problem.others[i];
    return out;
  }
  /** Residual b − s (N m + h). */
  std::vector<double> residual(const States& states, double exposure) const {
    std::vector<double> out = expected(centres(states));
    for (size_t i = 0; i < n; ++i) out[i] = problem.sums.vector[i] - exposure * out[i];
    return out;
  }
  /** Covariance C + s² N T N. */
  std::vector<double> spread(const States& states, double exposure) const {
    const std::vector<double>& N = problem.sums.matrix;
    std::vector<double> out = covariance;
    for (size_t k = 0; k < n; ++k) {
      const double width = exposure * widthOf(states[k]), variance = width * width;
      for (size_t i = 0; i < n; ++i)
        for (size_t j = 0; j <= i; ++j) out[i * n + j] += variance * N[i * n + k] * N[k * n + j];
    }
    return out;
  }

  const StateProblem& problem;
  size_t n;
  std::vector<double> covariance; ///< C
};

/** Evaluated sets of states with their scores; hill climbing goes to the best neighbour of a set. */
class StateSearch {
 public:
  StateSearch(const StateProblem& problem, bool findsExposure)
      : evidence(problem), findsExposure(findsExposure) {}

  void climbFrom(States states) {
    double score = scoreOf(states);
    for (int change = 0; change < MOST_CHANGES; ++change) {
      States best = states;
      for (size_t i = 0; i < states.size(); ++i)
        for (ClassState state : KNOWN_STATES) {
          States next = states;
          next[i] = state;
          if (const double s = scoreOf(next); s < score) {
            score = s;
            best = next;
          }
        }
      if (best == states) return;
      states = best;
    }
  }

  const std::map<States, Hypothesis>& all() const { return seen; }

 private:
  double scoreOf(const States& states) {
    const auto [at, isNew] = seen.try_emplace(states);
    if (isNew) at->second = evidence.of(states, findsExposure);
    return at->second.isPossible ? at->second.score : std::numeric_limits<double>::infinity();
  }

  Evidence evidence;
  bool findsExposure;
  std::map<States, Hypothesis> seen;
};

/** Most probable states by the prior alone. */
States expectedStates(const StateProblem& problem) {
  States out;
  for (const StatePrior& prior : problem.prior)
    out.push_back(KNOWN_STATES[std::max_element(prior.begin(), prior.end()) - prior.begin()]);
  return out;
}

} // namespace

StateFindings findStates(const StateProblem& problem) {
  const size_t n = problem.sums.layers();
  std::vector<std::pair<States, Hypothesis>> all;
  for (const bool findsExposure : {false, true}) {
    if (findsExposure && !problem.findsExposure) break;
    StateSearch search(problem, findsExposure);
    search.climbFrom(expectedStates(problem));
    search.climbFrom(States(n, ClassState::RIGHT));
    search.climbFrom(States(n, ClassState::MISSING));
    for (const auto& [states, hypothesis] : search.all())
      if (hypothesis.isPossible) all.emplace_back(states, hypothesis);
  }
  StateFindings out;
  out.classes.resize(n);
  out.exposure = problem.exposure;
  if (all.empty()) {
    out.best.assign(n, ClassState::UNKNOWN);
    return out;
  }
  const auto& [bestStates, best] = *std::min_element(
      all.begin(), all.end(), [](const auto& a, const auto& b) { return a.second.score < b.second.score; });
  out.best = bestStates;
  double sum = 0, sameExposure = 0;
  for (const auto& [states, hypothesis] : all) {
    const double probability = std::exp((best.score - hypothesis.score) / 2);
    sum += probability;
    if ((hypothesis.exposureError > 0) == (best.exposureError > 0)) sameExposure += probability;
    for (size_t i = 0; i < n; ++i) out.classes[i].probabilities[size_t(states[i])] += probability;
  }
  for (size_t i = 0; i < n; ++i) {
    for (double& p : out.classes[i].probabilities) p /= sum;
    out.classes[i].state = out.best[i];
  }
  out.exposure = best.exposure;
  out.exposureError = best.exposureError;
  out.exposureCertainty = sameExposure / sum;
  Evidence(problem).setFactors(out.classes, out.best, out.exposure);
  return out;
}

} // namespace recurse
