/** @file
 * Hypotheses about the values of a picture, and their probabilities.
 */
#pragma once

#include <optional>
#include <vector>

#include "report/marking/alignment.h"
#include "report/marking/classStates.h"
#include "report/marking/exercise.h"
#include "report/marking/fittedCurve.h"

namespace recurse {

/** How the values of a picture came from the light. */
struct Reading {
  Alignment alignment;
  std::optional<FittedCurve> curve; ///< with ValueEncoding::TONE_CURVE
  bool hasFreeClasses = false;      ///< with a curve: factors of classes were fitted together with it

  /** Light of a picture, aligned with the reference. */
  Image light(const Image& picture) const;
  /** Picture, aligned with the reference, that shows this light. */
  Image shown(const Image& light) const;
};

/** Readings by the known encodings. */
std::vector<Reading> encodedReadings(const Exercise& exercise);
/** Readings by tone curves, with the flips and the shift of a change: with all classes right, and with free
 * ones. */
std::vector<Reading> curveReadings(const Exercise& exercise, PictureChange change);

/** Marks by a reading. */
struct ReadMarks {
  Marking marking;
  StateFindings whole;
  double score = 0; ///< −2 ln of the probability of the picture, the reading and the marks
};

/** −2 ln of the probability of the picture, the reading and the marks that were found by it. Differences are
 * measured in the values of the picture, so that all readings can be compared. */
double scoreOf(const Exercise& exercise, const Reading& reading, const ReadMarks& marks);

} // namespace recurse
