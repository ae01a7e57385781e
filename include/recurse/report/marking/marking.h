/** @file
 * Marks of an exercise: what is wrong with a picture, said in classes of light paths.
 */
#pragma once

#include <array>
#include <string>
#include <vector>

#include "recurse/report/stills/stills.h"

namespace recurse {

/** Encoding of the values in a picture that should be linear. */
enum class ValueEncoding {
  LINEAR,
  SRGB,     ///< encoded by sRGB's curve (IEC 61966-2-1)
  GAMMA_22, ///< encoded by the power 1 / 2.2
  DECODED   ///< linear values that were decoded as if they had been sRGB: written to a PNG without encoding
};

/** Difference of a picture from its reference that has nothing to do with light. */
struct PictureChange {
  ValueEncoding encoding = ValueEncoding::LINEAR;
  bool isFlippedHorizontally = false; ///< left and right are exchanged
  bool isFlippedVertically = false;   ///< top and bottom are exchanged
  int shiftX = 0, shiftY = 0;         ///< [pixels] what belongs to (x, y) is at (x + shiftX, y + shiftY)

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
  UNKNOWN  ///< too dark, too noisy, or too much alike another class
};
constexpr size_t CLASS_STATES = 4; ///< of those that are known
constexpr const char* CLASS_STATE_NAMES[] = {"right", "missing", "doubled", "scaled", "unknown"};

/** One class of paths in a part of the picture. */
struct ClassFinding {
  ClassState state = ClassState::UNKNOWN;
  std::array<double, CLASS_STATES> probabilities{}; ///< of the known states
  double factor = 1, standardError = 0;             ///< of the class, given the most probable states
};

/** One rectangle of the reference's picture. */
struct MarkedRegion {
  int x = 0, y = 0, width = 0, height = 0; ///< [pixels]
  double usedFraction = 0;                 ///< of its pixels: those that are finite and not clipped
  double unexplained = 0; ///< root mean square of what no factors of classes explain, relative
  std::vector<ClassFinding> classes;
};

/** One class of paths in the whole picture. */
struct ClassMark {
  std::string name, expression;
  double share = 0; ///< of the reference's mean luminance
  ClassState state = ClassState::UNKNOWN;
  double certainty = 0;                 ///< probability of the state
  double factor = 1, standardError = 0; ///< where the state holds
  double toldFraction = 0;              ///< of the picture: regions that show the class's state
  double stateFraction = 0;             ///< of these regions: those in this state
};

/** Classes of which some are wrong, which their light does not show. */
struct ClassConfusion {
  std::vector<size_t> classes;
  std::vector<ClassState> states; ///< of each, if it is the one
  std::vector<double> probabilities;
};

struct Marking {
  PictureChange change;
  double changeCertainty = 0; ///< probability of the change among all that were tried
  double exposure = 1;        ///< factor of all light
  double exposureError = 0, exposureCertainty = 0;
  std::vector<ClassMark> classes;
  std::vector<ClassConfusion> confusions;
  std::vector<MarkedRegion> regions;
  double clippedFraction = 0;     ///< of the pixels: white of a format for displays
  double unexplainedFraction = 0; ///< of the picture: regions with more than MARKED_RESIDUAL
  Image picture; ///< R, G, B with the change and the exposure undone; NaN where there is nothing

  /** Something differs that is no class of light. */
  bool isUnexplained() const;
  /** Nothing is wrong, as far as can be seen. */
  bool isRight() const;
};

/** Residual above which a region is said to be different in a way that no class of light explains. */
constexpr double MARKED_RESIDUAL = 0.2;

/** Marks a picture by the class layers of stills. Throws Error where the sizes differ, the stills have no
 * layers, or the layers overlap. */
Marking markExercise(const Image& picture, const Stills& reference);

/** One thing that is to be said of a picture. */
struct MarkingStatement {
  std::string what;   ///< "LS+DE (caustic) is missing, in 92 % of the picture that shows it"
  std::string advice; ///< what it means and what to do
  double certainty = 1;
  int shownClass = -1; ///< the class whose map shows it; -1: none
};
/** All that is wrong, the worst first; empty where nothing is. */
std::vector<MarkingStatement> markingStatements(const Marking& marking);

/** The statements and a table of the classes, for a terminal. */
std::string markingText(const Marking& marking);
/** The same with all numbers, as JSON. */
std::string markingJson(const Marking& marking);
/** A page that shows where, and needs nothing but itself. */
std::string markingPage(const Marking& marking, const Stills& reference, const std::string& title);

} // namespace recurse
