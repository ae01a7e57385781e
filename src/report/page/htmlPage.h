/** @file
 * What the self-contained pages have in common: their parts put into one file, and pixels inside of it.
 */
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "recurse/core/image/image.h"

namespace recurse {

/** Adds "scale" and "pixels" to `json`: R, G and B as half floats times a power of two, deflated, in base 64.
 * src/report/page/pixels.js decodes them. */
void addPixels(nlohmann::ordered_json& json, const Image& image);

/** Bytes of `stride`-byte numbers in base 64, deflated: first the first byte of each, then the second ones,
 * as they compress well among themselves. decodeNumbers() of src/report/page/pixels.js decodes them. */
std::string encodedBytes(std::span<const std::byte> bytes, size_t stride);
template <class T> std::string encodedNumbers(const std::vector<T>& numbers) {
  return encodedBytes(std::as_bytes(std::span(numbers)), sizeof(T));
}

/** The parts that a page is made of. */
struct HtmlPage {
  std::string_view content; ///< header and main element; frame.html is around them
  std::string title;
  std::vector<std::string_view> styles, libraries, scripts; ///< libraries: scripts that stay apart
};

/** The whole page, which needs nothing but itself. */
std::string htmlPage(const HtmlPage& parts, const nlohmann::ordered_json& data);

} // namespace recurse
