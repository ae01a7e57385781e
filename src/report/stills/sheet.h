/** @file
 * Contact sheets: pairs of pictures with captions.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/core/image/image.h"

namespace recurse {

/** Two pictures of the same size side by side, with their captions. */
struct SheetCell {
  Image left, right;
  float leftExposure = 0, rightExposure = 0; ///< stops
  std::string leftCaption, rightCaption;
  std::string name, figure; ///< figure: at the right end of the name's line
  std::string expression, footer;
};

/** Contact sheet in linear values, to be written without exposure. Texts that are too long are cut. */
Image drawSheet(const std::string& title, const std::string& subtitle, const std::vector<SheetCell>& cells);

} // namespace recurse
