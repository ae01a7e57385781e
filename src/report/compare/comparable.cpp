/** @file
 * Check that two pictures can be compared, with an error that gives the reason where they cannot.
 */
#include "report/compare/comparable.h"

#include "recurse/core/io/error.h"

namespace recurse {

namespace {

std::string sizeText(const Image& image) {
  return std::to_string(image.width) + "x" + std::to_string(image.height);
}

} // namespace

void requireComparable(const Image& a, const Image& b, const char* what) {
  if (a.width != b.width || a.height != b.height)
    throw Error(std::string("the pictures differ in size: ") + sizeText(a) + ", and the " + what + " " +
                sizeText(b));
  if (a.channels.size() < 3 || b.channels.size() < 3)
    throw Error("the pictures differ in channels: R, G and B are needed in both");
}

} // namespace recurse
