/** @file
 * Marking of an exercise: alignment of the picture, states of classes in its regions, their combination.
 */
#include "recurse/report/marking/marking.h"

#include <algorithm>
#include <cmath>

#include "recurse/core/io/error.h"
#include "report/marking/cells.h"
#include "report/marking/classStates.h"
#include "report/marking/exercise.h"
#include "report/marking/reading.h"

namespace recurse {

namespace {

/** Change of chi square by a missing class, above which a region shows the class.
 */
constexpr double VISIBLE = 16;
/** Least probability of a known state, and least odds for it from the pixels alone. */
constexpr double KNOWN = 0.9, LEAST_ODDS = 20;
/** Least fraction of the picture that must be wrong in the same way; less is an accident of noise or edges.
 */
constexpr double LEAST_PART = 0.05;
/** Relative difference of the sum of all classes from the picture, above which they cannot be its parts. */
constexpr double SUM_TOLERANCE = 0.01;

void requireClasses(const Image& picture, const Stills& reference) {
  const Image& r = reference.image;
  if (picture.width != r.width || picture.height != r.height)
    throw Error("the pictures differ in size: " + std::to_string(picture.width) + "x" +
                std::to_string(picture.height) + ", and the reference has " + std::to_string(r.width) + "x" +
                std::to_string(r.height) + "; give a picture of the reference's size");
  if (reference.layers.size() < 2)
    throw Error("the reference has no class layers: make them with 'recurse stills SCENE -o DIR' and give "
                "DIR/stills.exr");
  double away = 0, light = 0;
  for (int y = 0; y < r.height; ++y)
    for (int x = 0; x < r.width; ++x) {
      const float* p = r.at(x, y);
      for (size_t c = 0; c < 3; ++c) {
        double sum = 0;
        for (size_t i = 1; i < reference.layers.size(); ++i) sum += double(p[3 * i + c]);
        if (!std::isfinite(sum + double(p[c]))) continue;
        away += std::abs(sum - double(p[c]));
        light += std::abs(double(p[c]));
      }
    }
  if (away > SUM_TOLERANCE * light)
    throw Error("the reference's class layers overlap or leave paths out, and do not add up to its picture; "
                "render stills with disjoint classes, such as the default ones");
}

/** Range of cells, and its sums. */
struct Region {
  CellRange range;
  ClassSums sums;
};

/** Ends of the ranges along one side; a remainder of less than half a region joins the last range. */
std::vector<int> rangeEnds(int cells) {
  std::vector<int> ends;
  for (int end = REGION_CELLS; end < cells; end += REGION_CELLS) ends.push_back(end);
  if (!ends.empty() && cells - ends.back() < REGION_CELLS / 2) ends.pop_back();
  ends.push_back(cells);
  return ends;
}

std::vector<Region> makeRegions(const Cells& cells) {
  std::vector<Region> regions;
  int top = 0;
  for (int bottom : rangeEnds(cells.height())) {
    int left = 0;
    for (int right : rangeEnds(cells.width())) {
      regions.push_back({{left, top, right, bottom}, ClassSums()});
      left = right;
    }
    top = bottom;
  }
  return regions;
}

/** Sets the sums of all regions, and returns the sums of the picture. Where even the best factors leave
 * residuals above their variances, the covariances are scaled up by this ratio: noise of neighbouring
 * pixels is correlated, or the pictures differ in other ways. */
ClassSums sumUp(const Cells& cells, std::vector<Region>& regions, size_t layers) {
  ClassSums all(layers);
  for (Region& region : regions) {
    ClassSums& sums = region.sums = cells.sums(region.range);
    const Misfit misfit =
        cells.misfit(region.range, nonNegativeFactors(sums.ordinaryMatrix, sums.ordinaryVector));
    const double spread = misfit.chiSquare / std::max(1.0, misfit.count - double(layers));
    for (double& covariance : sums.covariance) covariance *= std::max(1.0, spread);
    all += sums;
  }
  return all;
}

/** States of the visible classes; invisible classes have the given factors. */
StateFindings findShown(const ClassSums& sums, const std::vector<double>& hiddenFactors,
                        const std::vector<StatePrior>& prior, double exposure, bool findsExposure) {
  const size_t n = sums.layers();
  std::vector<size_t> shown;
  for (size_t i = 0; i < n; ++i) {
    const double change = exposure * sums.matrix[i * n + i];
    if (change > 0 && change * change > VISIBLE * sums.covarianceWithLoss(i, i)) shown.push_back(i);
  }
  StateProblem problem;
  problem.exposure = exposure;
  problem.findsExposure = findsExposure;
  problem.sums = ClassSums(shown.size());
  problem.others.assign(shown.size(), 0);
  for (size_t a = 0; a < shown.size(); ++a) {
    const size_t i = shown[a];
    problem.prior.push_back(prior[i]);
    problem.sums.vector[a] = sums.vector[i];
    for (size_t j = 0; j < n; ++j)
      if (std::find(shown.begin(), shown.end(), j) == shown.end())
        problem.others[a] += hiddenFactors[j] * sums.matrix[i * n + j];
    for (size_t b = 0; b < shown.size(); ++b) {
      problem.sums.matrix[a * shown.size() + b] = sums.matrix[i * n + shown[b]];
      problem.sums.covariance[a * shown.size() + b] = sums.covarianceWithLoss(i, shown[b]);
    }
  }
  const StateFindings found = findStates(problem);
  StateFindings out = found;
  out.classes.assign(n, ClassFinding());
  out.best.assign(n, ClassState::UNKNOWN);
  for (size_t a = 0; a < shown.size(); ++a) {
    out.classes[shown[a]] = found.classes[a];
    out.best[shown[a]] = found.best[a];
  }
  return out;
}

/** Whether the state is known: probable, and supported by the pixels rather than by the prior. */
bool isKnown(const ClassFinding& finding, const StatePrior& prior) {
  if (finding.state == ClassState::UNKNOWN) return false;
  const size_t state = size_t(finding.state);
  if (finding.probabilities[state] < KNOWN) return false;
  for (size_t other = 0; other < CLASS_STATES; ++other) {
    // A scaled class may be arbitrarily close to the state.
    if (other == state || ClassState(other) == ClassState::SCALED) continue;
    if (finding.probabilities[state] / prior[state] <
        LEAST_ODDS * finding.probabilities[other] / prior[other])
      return false;
  }
  return true;
}

/** Prior of a class in a region: the mean of the general prior and of the probabilities in the whole
 * picture. A class that is scaled there may be missing or doubled in parts. */
StatePrior localPrior(const ClassFinding& whole) {
  StatePrior prior = STATE_PRIOR;
  if (whole.state == ClassState::UNKNOWN) return prior;
  const double scaled = whole.probabilities[size_t(ClassState::SCALED)];
  for (size_t state = 0; state < CLASS_STATES; ++state) {
    const double kept = ClassState(state) == ClassState::SCALED ? 0 : whole.probabilities[state];
    prior[state] = (prior[state] + kept + scaled / CLASS_STATES) / 2;
  }
  return prior;
}

/** States of the classes in a region. */
std::vector<ClassFinding> findLocalStates(const Region& region, const StateFindings& whole) {
  std::vector<double> factors;
  std::vector<StatePrior> priors;
  for (size_t i = 0; i < whole.best.size(); ++i) {
    factors.push_back(whole.classes[i].factor);
    const StatePrior prior = localPrior(whole.classes[i]);
    priors.push_back(prior);
  }
  std::vector<ClassFinding> out = findShown(region.sums, factors, priors, whole.exposure, false).classes;
  for (size_t i = 0; i < out.size(); ++i) {
    if (out[i].state == ClassState::UNKNOWN) out[i].factor = factors[i]; // hidden in this region
    if (!isKnown(out[i], priors[i])) out[i].state = ClassState::UNKNOWN;
  }
  return out;
}

MarkedRegion markRegion(const Region& region, const Cells& cells, const StateFindings& whole, int side,
                        const Image& picture) {
  const CellRange& range = region.range;
  MarkedRegion out;
  out.x = range.left * side;
  out.y = range.top * side;
  // The last regions include the pixels that fill no cell.
  out.width = (range.right == cells.width() ? picture.width : range.right * side) - out.x;
  out.height = (range.bottom == cells.height() ? picture.height : range.bottom * side) - out.y;
  out.usedFraction =
      double(region.sums.cells) / double((range.right - range.left) * (range.bottom - range.top));
  out.classes = findLocalStates(region, whole);
  const ClassSums& sums = region.sums;
  out.unexplained =
      cells.misfit(range, nonNegativeFactors(sums.ordinaryMatrix, sums.ordinaryVector)).unexplained;
  return out;
}

double areaOf(const MarkedRegion& region) {
  return double(region.width) * double(region.height) * region.usedFraction;
}

/** Mark of a class from its regions, and from the whole picture where none of them shows its state. */
ClassMark markClass(size_t i, const StillLayer& layer, const StateFindings& whole,
                    const std::vector<MarkedRegion>& regions) {
  ClassMark mark{layer.name, layer.expression, layer.share};
  std::array<double, CLASS_STATES> area{}, certainty{}, weight{}, factor{};
  std::array<int, CLASS_STATES> count{};
  double all = 0, told = 0;
  for (const MarkedRegion& region : regions) {
    const ClassFinding& finding = region.classes[i];
    const double a = areaOf(region);
    all += a;
    if (finding.state == ClassState::UNKNOWN) continue;
    const size_t state = size_t(finding.state);
    told += a;
    area[state] += a;
    ++count[state];
    certainty[state] += a * finding.probabilities[state];
    const double precision = 1 / (finding.standardError * finding.standardError);
    weight[state] += precision;
    factor[state] += precision * finding.factor;
  }
  const ClassFinding& global = whole.classes[i];
  const size_t wrong = size_t(std::max_element(area.begin() + 1, area.end()) - area.begin());
  if (told == 0) {
    const bool known = isKnown(global, STATE_PRIOR);
    mark.state = known ? global.state : ClassState::UNKNOWN;
    mark.certainty = known ? global.probabilities[size_t(global.state)] : 0;
    mark.factor = global.factor;
    mark.standardError = global.standardError;
    return mark;
  }
  // One or two wrong regions are more often an accident than a mistake that the whole picture does not show.
  const bool isSeen =
      (count[wrong] > 1 && area[wrong] > LEAST_PART * all) || global.state == ClassState(wrong);
  const size_t state = isSeen && area[wrong] > LEAST_PART * told ? wrong : 0;
  if (count[state] == 0) return mark; // wrong in too few regions, and right in none
  mark.state = ClassState(state);
  mark.visibleFraction = told / all;
  mark.stateFraction = area[state] / told;
  mark.certainty = certainty[state] / area[state];
  if (global.state == mark.state) mark.certainty = std::max(mark.certainty, global.probabilities[state]);
  mark.factor = factor[state] / weight[state];
  mark.standardError = 1 / std::sqrt(weight[state]);
  return mark;
}

/** Finds classes of which one is wrong, while it is not known which one. */
void findConfusion(Marking& marking, const StateFindings& whole) {
  ClassConfusion confusion;
  for (size_t i = 0; i < marking.classes.size(); ++i) {
    if (marking.classes[i].state != ClassState::UNKNOWN) continue;
    const auto& p = whole.classes[i].probabilities;
    const size_t wrong = size_t(std::max_element(p.begin() + 1, p.end()) - p.begin());
    if (p[wrong] < 1 - KNOWN) continue;
    confusion.classes.push_back(i);
    confusion.states.push_back(ClassState(wrong));
    confusion.probabilities.push_back(p[wrong]);
  }
  double any = 0;
  for (double p : confusion.probabilities) any += p;
  if (confusion.classes.size() > 1 && any > KNOWN) marking.confusions.push_back(confusion);
}

/** Findings after a tone curve, which leaves the classes unjudged. */
StateFindings unjudged(const std::vector<double>& factors) {
  StateFindings out;
  out.classes.resize(factors.size());
  for (size_t i = 0; i < factors.size(); ++i) out.classes[i].factor = factors[i];
  out.best.assign(factors.size(), ClassState::UNKNOWN);
  return out;
}

ReadMarks markAs(const Exercise& exercise, const Reading& reading) {
  const Stills& reference = exercise.reference;
  const size_t layers = exercise.layers;
  const int side = exercise.side;
  Marking marking;
  marking.change = reading.alignment.change;
  marking.picture = reading.light(exercise.picture);
  PictureChange alignment = reading.alignment.change;
  alignment.encoding = ValueEncoding::LINEAR;
  const Image light =
      withLoss(reading.light(exercise.usable), undone(exercise.clipped, alignment), REGION_CELLS * side);
  Cells cells(light, reference.image, side);
  std::vector<Region> regions = makeRegions(cells);
  std::vector<double> factors = reading.alignment.factors;
  ClassSums sums;
  constexpr int ROUNDS = 2; // weights depend on factors, and these on the weights
  for (int round = 0; round < ROUNDS; ++round) {
    cells.weigh(factors);
    sums = sumUp(cells, regions, layers);
    factors = nonNegativeFactors(sums.ordinaryMatrix, sums.ordinaryVector);
  }
  if (sums.cells == 0)
    throw Error("no part of the picture can be marked: all pixels are clipped at white or not finite");
  const std::vector<double> ones(layers, 1);
  const StateFindings whole =
      reading.curve ? unjudged(reading.alignment.factors)
                    : findShown(sums, ones, std::vector<StatePrior>(layers, STATE_PRIOR), 1, true);
  marking.exposure = whole.exposure;
  marking.exposureError = whole.exposureError;
  marking.exposureCertainty = whole.exposureCertainty;
  double area = 0, unexplained = 0;
  for (const Region& region : regions) {
    marking.regions.push_back(markRegion(region, cells, whole, side, exercise.picture));
    MarkedRegion& marked = marking.regions.back();
    if (reading.curve) {
      marked.classes = whole.classes;
      marked.unexplained = cells.misfit(region.range, reading.alignment.factors).unexplained;
    }
    area += areaOf(marked);
    if (marked.unexplained > MARKED_RESIDUAL) unexplained += areaOf(marked);
  }
  marking.unexplainedFraction = area > 0 ? unexplained / area : 0;
  for (size_t i = 0; i < layers; ++i)
    marking.classes.push_back(markClass(i, reference.layers[i + 1], whole, marking.regions));
  findConfusion(marking, whole);
  for (float& value : marking.picture.pixels) value = static_cast<float>(double(value) / marking.exposure);
  ReadMarks out{std::move(marking), whole};
  out.score = scoreOf(exercise, reading, out);
  return out;
}

/** Whether two changes are the same mistake: both display curves are nearly the same. */
bool isSameChange(PictureChange a, PictureChange b) {
  for (PictureChange* change : {&a, &b})
    if (change->encoding == ValueEncoding::GAMMA_22) change->encoding = ValueEncoding::SRGB;
  return a == b;
}

/** Marks whose certainties are averages over all readings. A state that is not probable then is unknown. */
Marking averaged(Marking marking, const std::vector<ReadMarks>& all,
                 const std::vector<double>& probabilities) {
  marking.changeCertainty = 0;
  double exposureCertainty = 0;
  std::vector<double> certainties(marking.classes.size());
  for (size_t k = 0; k < all.size(); ++k) {
    const Marking& other = all[k].marking;
    if (isSameChange(other.change, marking.change)) marking.changeCertainty += probabilities[k];
    if (other.change.encoding == ValueEncoding::TONE_CURVE) continue; // judges nothing
    if ((other.exposureError > 0) == (marking.exposureError > 0))
      exposureCertainty += probabilities[k] * other.exposureCertainty;
    for (size_t i = 0; i < certainties.size(); ++i)
      if (other.classes[i].state == marking.classes[i].state)
        certainties[i] += probabilities[k] * other.classes[i].certainty;
  }
  marking.exposureCertainty = exposureCertainty;
  for (size_t i = 0; i < certainties.size(); ++i) {
    ClassMark& mark = marking.classes[i];
    mark.certainty = certainties[i];
    if (mark.state != ClassState::RIGHT && mark.certainty < KNOWN) mark.state = ClassState::UNKNOWN;
  }
  return marking;
}

} // namespace

bool Marking::isUnexplained() const { return unexplainedFraction > LEAST_PART; }

bool Marking::isRight() const {
  const auto isFine = [](const ClassMark& mark) {
    return mark.state == ClassState::RIGHT || mark.state == ClassState::UNKNOWN;
  };
  return change == PictureChange() && exposureError == 0 && confusions.empty() && !isUnexplained() &&
         std::all_of(classes.begin(), classes.end(), isFine);
}

Marking markExercise(const Image& picture, const Stills& reference) {
  requireClasses(picture, reference);
  const Exercise exercise(picture, reference);
  std::vector<ReadMarks> all;
  const auto best = [&]() -> ReadMarks& {
    return *std::min_element(all.begin(), all.end(),
                             [](const auto& a, const auto& b) { return a.score < b.score; });
  };
  for (const Reading& reading : encodedReadings(exercise)) all.push_back(markAs(exercise, reading));
  for (const Reading& reading : curveReadings(exercise, best().marking.change))
    all.push_back(markAs(exercise, reading));
  const ReadMarks& chosen = best();
  double sum = 0;
  for (const ReadMarks& marks : all) sum += std::exp((chosen.score - marks.score) / 2);
  std::vector<double> probabilities;
  for (const ReadMarks& marks : all)
    probabilities.push_back(std::exp((chosen.score - marks.score) / 2) / sum);
  Marking marking = averaged(chosen.marking, all, probabilities);
  marking.clippedFraction = exercise.clippedFraction();
  return marking;
}

} // namespace recurse
