/** @file
 * Names of the layers of a transient render.
 */
#include "recurse/pathclasses/transientFrames.h"

#include <algorithm>

#include "recurse/core/io/text.h"

namespace recurse {

namespace {

constexpr const char* FRAME = "frame-";

} // namespace

std::string TransientFrames::layerName(size_t layer) const {
  constexpr size_t DIGITS = 4;
  if (layer == 0) return "before";
  if (layer == count + 1) return "after";
  const std::string number = std::to_string(layer - 1);
  return FRAME + std::string(DIGITS - std::min(DIGITS, number.size()), '0') + number;
}

std::string TransientFrames::text() const { return formatted("%.9g:%.9g:%zu", begin, end, count); }

bool TransientFrames::isFrameName(const std::string& name) { return name.starts_with(FRAME); }

} // namespace recurse
