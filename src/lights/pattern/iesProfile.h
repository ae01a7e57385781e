/** @file
 * Photometric files: what luminaires of the trade send in each direction.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/core/math/vector.h"

namespace recurse {

/** An IESNA LM-63 file of photometric type C, editions of 1986 to 2019. */
class IesProfile {
 public:
  /** Throws Error with the reason, and the line where there is one. */
  static IesProfile read(const std::string& fileName);
  static IesProfile parse(const std::string& text);

  /** Luminous intensity [cd] at a vertical angle (0 is straight down) and a horizontal one [degrees]. */
  double intensity(double vertical, double horizontal) const;
  /** Over all directions [lm]. */
  double flux() const;

 private:
  /** The horizontal angle in the range that the file tells, by its symmetry. */
  double folded(double horizontal) const;

  std::vector<double> vertical, horizontal; ///< ascending [degrees]
  std::vector<double> candela;              ///< for each horizontal angle all vertical ones
};

} // namespace recurse
