/** @file
 * Marks of an exercise: errors of a picture, attributed to classes of light paths.
 */
#pragma once

#include <array>
#include <string>
#include <vector>

#include "recurse/report/stills/stills.h"

namespace recurse {

/** Encoding of the values in a picture that is expected to be linear. */
enum class ValueEncoding {
  LINEAR,
  SRGB,      ///< encoded by sRGB's curve (IEC 61966-2-1)
  GAMMA_22,  ///< encoded by the power 1 / 2.2
  DECODED,   ///< linear values that were decoded as sRGB: written to a PNG without encoding
  TONE_CURVE ///< compressed by a tone operator: no known encoding, but a monotone curve
};

/** Difference of a picture from its reference that is not caused by light transport. */
struct PictureChange {
  ValueEncoding encoding = ValueEncoding::LINEAR;
  bool isFlippedHorizontally = false; ///< left and right are exchanged
  bool isFlippedVertically = false;   ///< top and bottom are exchanged
  /** Shift [pixels]: pixel (x, y) of the reference appears at (x + shiftX, y + shiftY) once the flips are
   * undone. */
  int shiftX = 0, shiftY = 0;

  bool operator==(const PictureChange&) const = default;
  bool isFlipped() const { return isFlippedHorizontally || isFlippedVertically; }
  bool isShifted() const { return shiftX != 0 || shiftY != 0; }
};

/** State of a class of paths in a picture. */
enum class ClassState {
  RIGHT,
  MISSING, ///< factor 0
  DOUBLED, ///< factor 2
  SCALED,  ///< any other factor
  UNKNOWN  ///< too dark, too noisy, or too similar to a different class
};
constexpr size_t CLASS_STATES = 4; ///< number of known states
constexpr const char* CLASS_STATE_NAMES[] = {"right", "missing", "doubled", "scaled", "unknown"};

/** One class of paths in a part of the picture. */
struct ClassFinding {
  ClassState state = ClassState::UNKNOWN;
  std::array<double, CLASS_STATES> probabilities{}; ///< of the known states
  /** Light of the class over its light in the reference, with the exposure undone, for the most probable
   * states of all classes. */
  double factor = 1, standardError = 0;
};

/** One rectangle of the reference's picture. */
struct MarkedRegion {
  int x = 0, y = 0, width = 0, height = 0; ///< [pixels]
  double usedFraction = 0;                 ///< fraction of its cells without clipped pixels, NaN or infinity
  double unexplained = 0;            ///< relative root mean square error not explained by factors of classes
  std::vector<ClassFinding> classes; ///< in the order of Marking::classes
};

/** One class of paths in the whole picture. */
struct ClassMark {
  std::string name, expression;
  double share = 0; ///< fraction of the reference's mean luminance
  ClassState state = ClassState::UNKNOWN;
  double certainty = 0;                 ///< probability of the state; 0: UNKNOWN
  double factor = 1, standardError = 0; ///< mean ClassFinding::factor where the state holds
  /** Fraction of the picture: regions that show the class's state. 0 with a known state: only the picture as
   * a whole shows it. */
  double visibleFraction = 0;
  double stateFraction = 0; ///< fraction of these regions that are in this state
};

/** Classes some of which are wrong, but whose light does not show which. */
struct ClassConfusion {
  std::vector<size_t> classes;    ///< indices in Marking::classes
  std::vector<ClassState> states; ///< state of each class, if it is the wrong one
  std::vector<double> probabilities;
};

/** Marks of a picture. */
struct Marking {
  PictureChange change;
  double changeCertainty = 0;     ///< probability of the change among all changes tried
  double exposure = 1;            ///< common factor on the light of all classes, besides their own factors
  double exposureError = 0;       ///< standard error of the exposure; 0: the exposure is right
  double exposureCertainty = 0;   ///< probability of this finding on the exposure
  std::vector<ClassMark> classes; ///< in the order of the stills' layers, without the whole picture
  std::vector<ClassConfusion> confusions;
  std::vector<MarkedRegion> regions;
  double clippedFraction = 0;     ///< fraction of the pixels with a clipped channel, in a display format
  double unexplainedFraction = 0; ///< fraction of the picture: regions with more than MARKED_RESIDUAL
  Image picture; ///< R, G, B with the change and the exposure undone; NaN: no pixel of the picture

  /** True where the picture differs by an error that is not attributed to a class. */
  bool isUnexplained() const;
  /** True where no error is detected. */
  bool isRight() const;
};

/** Residual above which no class of light explains the difference of a region. */
constexpr double MARKED_RESIDUAL = 0.2;

/** Marks a picture by the class layers of stills. Throws Error where the sizes differ, the stills have no
 * layers or layers that do not add up to their picture, or all of the picture is clipped or not finite. */
Marking markExercise(const Image& picture, const Stills& reference);

/** Statement about one error of a picture. */
struct MarkingStatement {
  std::string what;   ///< "LS+DE (caustic) is missing, in 92 % of the picture where it is visible"
  std::string advice; ///< meaning, and what to do
  double certainty = 1;
  int shownClass = -1; ///< index in Marking::classes of the class whose map shows the error; -1: none
};
/** All errors: of the picture, of the exposure, of classes (largest first), unexplained; empty: none. */
std::vector<MarkingStatement> markingStatements(const Marking& marking);

/** Statements and a table of the classes, for a terminal. */
std::string markingText(const Marking& marking);
/** Statements, classes and all numbers, as JSON. */
std::string markingJson(const Marking& marking);
/** Self-contained page that shows the location of errors. */
std::string markingPage(const Marking& marking, const Stills& reference, const std::string& title);

} // namespace recurse
