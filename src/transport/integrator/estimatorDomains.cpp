/** @file
 * The check that estimators are disjoint and complete, and their table.
 */
#include "recurse/transport/integrator/estimatorDomains.h"

#include <algorithm>
#include <array>

#include "recurse/core/io/error.h"
#include "recurse/pathclasses/pathExpression.h"

namespace recurse {

DomainReport checkDomains(const std::vector<EstimatorDomain>& estimators, const std::string& covers) {
  std::vector<PathAutomaton> domains, covered;
  for (const EstimatorDomain& e : estimators) {
    try {
      domains.push_back(PathAutomaton::compile(e.expression));
      if (!e.onlyPanes) covered.push_back(domains.back());
    } catch (const Error& error) {
      throw Error("domain of " + e.estimator + ": " + error.what(), error.status());
    }
  }
  DomainReport report;
  for (const PathOverlap& o : findOverlaps(domains)) {
    const EstimatorDomain &first = estimators[o.first], &second = estimators[o.second];
    const bool shared = !first.sharedGroup.empty() && first.sharedGroup == second.sharedGroup;
    if (!shared) report.overlaps.push_back({first.estimator, second.estimator, o.example});
  }
  const PathAutomaton uncoveredPaths = leftOver(PathAutomaton::compile(covers), covered);
  if (!uncoveredPaths.isEmpty()) {
    report.uncovered = uncoveredPaths.exampleWords(4, 2);
    if (report.uncovered.empty()) report.uncovered = {uncoveredPaths.shortestWord()};
    report.uncoveredExpression = uncoveredPaths.toExpression();
  }
  return report;
}

std::string DomainReport::text() const {
  std::string out;
  for (const Overlap& o : overlaps) out += o.first + " and " + o.second + " both compute " + o.example + "\n";
  if (uncovered.empty()) return out;
  out += "no estimator computes";
  for (const std::string& word : uncovered) out += " " + word;
  if (!uncoveredExpression.empty()) out += "; all of these: " + uncoveredExpression;
  return out + "\n";
}

std::string missedOfDeltaLights(const std::vector<EstimatorDomain>& estimators) {
  std::vector<EstimatorDomain> finding;
  for (const EstimatorDomain& e : estimators)
    if (!e.hitsLights && !e.onlyPanes) finding.push_back(e);
  const DomainReport report = checkDomains(finding, "surface - LS*E");
  return report.uncovered.empty() || !report.uncoveredExpression.empty() ? report.uncoveredExpression
                                                                         : report.uncovered.front();
}

std::string formatDomains(const std::vector<EstimatorDomain>& estimators) {
  std::vector<std::array<std::string, 3>> rows = {{"estimator", "paths", "cost"}};
  for (const EstimatorDomain& e : estimators)
    rows.push_back({e.estimator, e.expression,
                    e.cost + (e.sharedGroup.empty() ? "" : " (MIS group: " + e.sharedGroup + ")")});
  std::array<size_t, 2> width = {};
  for (const auto& row : rows)
    for (size_t c = 0; c < width.size(); ++c) width[c] = std::max(width[c], row[c].size());
  std::string out;
  for (const auto& row : rows) {
    for (size_t c = 0; c < width.size(); ++c) out += row[c] + std::string(width[c] - row[c].size() + 2, ' ');
    out += row[2] + "\n";
  }
  return out;
}

} // namespace recurse
