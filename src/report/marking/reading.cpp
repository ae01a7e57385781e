/** @file
 * Comparison of readings: a picture is predicted from the class layers, with the factors of the marks, and
 * compared with the picture as it is. The probability of the difference is multiplied by the prior
 * probabilities of the change and of the mistakes.
 */
#include "report/marking/reading.h"

#include <algorithm>
#include <cmath>

#include "report/marking/cells.h"

namespace recurse {

namespace {

/** Prior probability of each kind of mistake: one exercise in twenty. */
constexpr double WRONG_PRIOR = 1 / 20.0;
/** Prior probability of a tone curve: programs apply one by default when they write a file for a display. */
constexpr double TONE_CURVE_PRIOR = 1 / 20.0, DISPLAYED_TONE_CURVE_PRIOR = 0.5;

/** Factor of a class in a region, by which the marks explain the picture. A scaled class has one factor, or a
 * curve of values would be explained by another factor in each region. */
double explainingFactor(const ClassFinding& local, const ClassFinding& whole) {
  const auto& p = local.probabilities;
  const bool isScaled =
      std::max_element(p.begin(), p.end()) - p.begin() == std::ptrdiff_t(ClassState::SCALED);
  return isScaled && whole.state == ClassState::SCALED ? whole.factor : local.factor;
}

/** Adds the light of the classes with factors to a pixel. */
void addLight(const Image& reference, int x, int y, const std::vector<double>& factors, Image& out) {
  for (size_t i = 0; i < factors.size(); ++i)
    for (size_t c = 0; c < 3; ++c)
      out.at(x, y)[c] += static_cast<float>(factors[i] * double(reference.at(x, y)[3 * (i + 1) + c]));
}

/** Light of the classes with factors. */
Image sumOf(const Image& reference, const std::vector<double>& factors) {
  Image out(reference.width, reference.height, {"R", "G", "B"});
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) addLight(reference, x, y, factors, out);
  return out;
}

/** Light of the reference with the factors of the marks, region by region. */
Image predictedLight(const ReadMarks& marks, const Image& reference) {
  Image out(reference.width, reference.height, {"R", "G", "B"});
  for (const MarkedRegion& region : marks.marking.regions) {
    std::vector<double> factors;
    for (size_t i = 0; i < region.classes.size(); ++i)
      factors.push_back(marks.whole.exposure * explainingFactor(region.classes[i], marks.whole.classes[i]));
    for (int y = region.y; y < region.y + region.height; ++y)
      for (int x = region.x; x < region.x + region.width; ++x) addLight(reference, x, y, factors, out);
  }
  return out;
}

} // namespace

Image Reading::light(const Image& picture) const {
  const Image values = undone(picture, alignment.change);
  return curve ? curve->light(values) : values;
}

Image Reading::shown(const Image& light) const {
  if (curve) return curve->shown(light);
  Image out = light;
  for (float& value : out.pixels) value = encoded(value, alignment.change.encoding);
  return out;
}

std::vector<Reading> encodedReadings(const Exercise& exercise) {
  std::vector<Reading> out;
  for (const Alignment& alignment : findAlignments(exercise.usable, exercise.reference))
    out.push_back({alignment, std::nullopt});
  return out;
}

std::vector<Reading> curveReadings(const Exercise& exercise, PictureChange change) {
  change.encoding = ValueEncoding::TONE_CURVE;
  const Image values = undone(exercise.usable, change);
  std::vector<Reading> out;
  for (const CurveDomain domain : {CurveDomain::CHANNELS, CurveDomain::LUMINANCE}) {
    std::vector<double> factors(exercise.layers, 1);
    // The curve by the factors and the factors by the curve, in turns: each makes the residual smaller.
    constexpr int TURNS = 6;
    for (int turn = 0; turn < TURNS; ++turn) {
      FittedCurve curve(values, sumOf(exercise.reference.image, factors), domain, exercise.side);
      if (!curve.isKnown()) break;
      const std::vector<double> next = fittedFactors(curve.light(values), exercise.reference);
      if (turn == 0 || turn + 1 == TURNS) out.push_back({{change, factors}, std::move(curve), turn > 0});
      factors = next;
    }
  }
  return out;
}

double scoreOf(const Exercise& exercise, const Reading& reading, const ReadMarks& marks) {
  const Image& picture = exercise.picture;
  PictureChange alignment = reading.alignment.change;
  alignment.encoding = ValueEncoding::LINEAR;
  const Image values = withLoss(undone(exercise.usable, alignment), undone(exercise.clipped, alignment),
                                REGION_CELLS * exercise.side);
  const Image predicted = reading.shown(predictedLight(marks, exercise.reference.image));
  Image layers(values.width, values.height, {"R", "G", "B", "predicted.R", "predicted.G", "predicted.B"});
  for (int y = 0; y < values.height; ++y)
    for (int x = 0; x < values.width; ++x)
      for (int c = 0; c < 6; ++c) layers.at(x, y)[c] = predicted.at(x, y)[c % 3];
  Cells cells(values, layers, exercise.side);
  cells.weigh({1});
  const Marking& marking = marks.marking;
  double mistakes = double(marking.confusions.size()), free = reading.curve ? double(FittedCurve::KNOTS) : 0;
  if (reading.hasFreeClasses) {
    ++mistakes;
    free += double(exercise.layers - 1); // the curve has the exposure
  }
  const auto addScaled = [&] { ++mistakes, ++free; };
  if (marking.exposureError > 0) addScaled();
  for (const ClassMark& mark : marking.classes)
    if (mark.state == ClassState::SCALED)
      addScaled();
    else
      mistakes += mark.state == ClassState::MISSING || mark.state == ClassState::DOUBLED;
  const double curvePrior = exercise.picture.fromIntegers ? DISPLAYED_TONE_CURVE_PRIOR : TONE_CURVE_PRIOR;
  const PictureChange& change = reading.curve ? alignment : reading.alignment.change;
  const double prior = priorScore(change, picture.width, picture.height) -
                       2 * std::log(reading.curve ? curvePrior : 1 - curvePrior) -
                       2 * std::log(WRONG_PRIOR) * mistakes;
  // Bayesian information criterion (Schwarz 1978) of the factors and knots that are free.
  return PATCHES * cells.surprise({1}) + std::log(PATCHES) * free + prior;
}

} // namespace recurse
