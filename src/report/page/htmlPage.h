/** @file
 * Common code of the self-contained pages: assembly of their parts into one file, and pixels inside it.
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

/** Bytes of `stride`-byte numbers, deflated, in base 64: first bytes of all numbers, then second bytes,
 * which compress well among themselves. decodeNumbers() of src/report/page/pixels.js decodes them. */
std::string encodedBytes(std::span<const std::byte> bytes, size_t stride);
template <class T> std::string encodedNumbers(const std::vector<T>& numbers) {
  return encodedBytes(std::as_bytes(std::span(numbers)), sizeof(T));
}

/** Bytes in base 64 (RFC 4648, section 4). */
std::string base64(const std::vector<unsigned char>& bytes);

/** Text for HTML, SVG and XML, outside of attributes. */
std::string escapedHtml(const std::string& text);

/** Parts of a page. */
struct HtmlPage {
  std::string_view content; ///< header and main element; frame.html is around them
  std::string title;
  std::vector<std::string_view> styles, libraries, scripts; ///< libraries: scripts that stay apart
};

/** Complete page, which depends on no other file. */
std::string htmlPage(const HtmlPage& parts, const nlohmann::ordered_json& data);

} // namespace recurse
