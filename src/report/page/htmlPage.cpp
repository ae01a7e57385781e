/** @file
 * Pages: pixels as scaled half floats, deflated, inside of the HTML.
 */
#include "report/page/htmlPage.h"

#include <algorithm>
#include <cmath>

#include <OpenImageIO/half.h>
#include <zlib.h>

#include "recurse/core/io/error.h"
#include "report/page/embedded.h"

namespace recurse {

std::string base64(const std::vector<unsigned char>& bytes) {
  static constexpr char DIGITS[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t j = 0; j < 3; ++j) group = group << 8 | (i + j < bytes.size() ? bytes[i + j] : 0u);
    for (size_t j = 0; j < 4; ++j) out += i + j <= bytes.size() ? DIGITS[group >> (18 - 6 * j) & 63] : '=';
  }
  return out;
}

namespace {

std::vector<unsigned char> deflated(const std::vector<unsigned char>& bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::vector<unsigned char> out(size);
  if (compress2(out.data(), &size, bytes.data(), static_cast<uLong>(bytes.size()), Z_BEST_COMPRESSION) !=
      Z_OK)
    throw Error("the page cannot be compressed: memory is short");
  out.resize(size);
  return out;
}

/** Power of two that scales the largest value to just below the largest half float, so that values up to a
 * billion times smaller keep their eleven bits. */
int scaleOf(const Image& layer) {
  float largest = 0;
  for (float value : layer.pixels)
    if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
  constexpr int LARGEST_EXPONENT = 15;
  return largest > 0 ? LARGEST_EXPONENT - 1 - std::ilogb(largest) : 0;
}

/** Red, green and blue planes; first all upper bytes, then all lower bytes. Upper bytes, with sign and
 * exponent, compress well among themselves. */
std::string encoded(const Image& layer, int scale) {
  const size_t pixels = layer.pixels.size() / 3;
  std::vector<unsigned char> bytes(layer.pixels.size() * 2);
  for (size_t p = 0; p < pixels; ++p)
    for (size_t c = 0; c < 3; ++c) {
      const float value = static_cast<float>(std::ldexp(double(layer.pixels[p * 3 + c]), scale));
      const unsigned bits = half(value).bits();
      bytes[c * pixels + p] = static_cast<unsigned char>(bits >> 8);
      bytes[(3 + c) * pixels + p] = static_cast<unsigned char>(bits & 255);
    }
  return base64(deflated(bytes));
}

/** JSON that is safe in a script element: it contains neither "</script>" nor "<!--". */
std::string forHtml(const nlohmann::ordered_json& json) {
  const std::string text = json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  std::string out;
  out.reserve(text.size());
  for (char c : text)
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  return out;
}

void replaceMark(std::string& page, const std::string& mark, const std::string& text) {
  const size_t at = page.find(mark);
  if (at == std::string::npos) throw Error("internal error: the page has no " + mark);
  page.replace(at, mark.size(), text);
}

} // namespace

std::string escapedHtml(const std::string& text) {
  std::string out;
  for (char c : text) switch (c) {
    case '<':
      out += "&lt;";
      break;
    case '>':
      out += "&gt;";
      break;
    case '&':
      out += "&amp;";
      break;
    default:
      out += c;
    }
  return out;
}

void addPixels(nlohmann::ordered_json& json, const Image& image) {
  const int scale = scaleOf(image);
  json["scale"] = scale;
  json["pixels"] = encoded(image, scale);
}

std::string encodedBytes(std::span<const std::byte> bytes, size_t stride) {
  const size_t count = bytes.size() / stride;
  std::vector<unsigned char> planes(count * stride);
  for (size_t i = 0; i < count; ++i)
    for (size_t k = 0; k < stride; ++k)
      planes[k * count + i] = static_cast<unsigned char>(bytes[i * stride + k]);
  return base64(deflated(planes));
}

std::string htmlPage(const HtmlPage& parts, const nlohmann::ordered_json& data) {
  const auto joined = [](const std::vector<std::string_view>& texts) {
    std::string out;
    for (std::string_view text : texts) out += text;
    return out;
  };
  std::string scripts;
  for (std::string_view library : parts.libraries)
    scripts += "<script>\n" + std::string(library) + "\n</script>\n";
  scripts += "<script>\n\"use strict\";\n(() => {\n" + joined(parts.scripts) + "})();\n</script>";
  std::string page(page::FRAME_HTML);
  // Marks are replaced from the end, so that inserted text is not searched.
  replaceMark(page, "<!--SCRIPT-->", scripts);
  replaceMark(page, "<!--DATA-->",
              "<script type=\"application/json\" id=\"data\">" + forHtml(data) + "</script>");
  replaceMark(page, "<!--CONTENT-->\n", std::string(parts.content));
  replaceMark(page, "<!--STYLE-->", "<style>\n" + joined(parts.styles) + "</style>");
  replaceMark(page, "<!--TITLE-->", "<title>" + escapedHtml(parts.title) + "</title>");
  return page;
}

} // namespace recurse
