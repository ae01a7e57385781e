/** @file
 * Photometric files: measured intensity distributions of luminaires.
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
  /** Luminous flux over all directions [lm]. */
  double flux() const;

 private:
  /** Horizontal angle folded by symmetry into the range of the file [degrees]. */
  double folded(double horizontal) const;

  std::vector<double> vertical, horizontal; ///< ascending [degrees]
  std::vector<double> candela;              ///< rows of vertical angles, one row for each horizontal angle
};

} // namespace recurse
