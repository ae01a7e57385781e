/** @file
 * The page of stills: pixels as scaled half floats, deflated, inside of the HTML.
 */
#include <cmath>
#include <limits>

#include <immintrin.h>
#include <nlohmann/json.hpp>
#include <zlib.h>

#include "recurse/core/error.h"
#include "recurse/report/stills.h"
#include "report/page/embedded.h"

namespace recurse {

namespace {

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

std::vector<unsigned char> deflated(const std::vector<unsigned char>& bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::vector<unsigned char> out(size);
  if (compress2(out.data(), &size, bytes.data(), static_cast<uLong>(bytes.size()), Z_BEST_COMPRESSION) !=
      Z_OK)
    throw Error("the page of the stills cannot be compressed: memory is short");
  out.resize(size);
  return out;
}

/** The power of two that brings the largest value close below the largest half float, so that all that is up
 * to a billion times smaller keeps its eleven bits. */
int scaleOf(const Image& layer) {
  float largest = 0;
  for (float value : layer.pixels)
    if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
  constexpr int LARGEST_EXPONENT = 15;
  return largest > 0 ? LARGEST_EXPONENT - 1 - std::ilogb(largest) : 0;
}

/** Red, green and blue one after the other, first all upper bytes, then all lower ones: the upper ones, with
 * sign and exponent, compress well among themselves. */
std::string encoded(const Image& layer, int scale) {
  const size_t pixels = layer.pixels.size() / 3;
  std::vector<unsigned char> bytes(layer.pixels.size() * 2);
  for (size_t p = 0; p < pixels; ++p)
    for (size_t c = 0; c < 3; ++c) {
      const float value = static_cast<float>(std::ldexp(double(layer.pixels[p * 3 + c]), scale));
      const unsigned half = _cvtss_sh(value, _MM_FROUND_TO_NEAREST_INT);
      bytes[c * pixels + p] = static_cast<unsigned char>(half >> 8);
      bytes[(3 + c) * pixels + p] = static_cast<unsigned char>(half & 255);
    }
  return base64(deflated(bytes));
}

nlohmann::ordered_json setJson(const Stills& stills) {
  const auto metadata = [&](const char* name) {
    const auto found = stills.image.metadata.find(name);
    return found == stills.image.metadata.end() ? std::string() : found->second;
  };
  nlohmann::ordered_json layers = nlohmann::ordered_json::array();
  for (size_t i = 0; i < stills.layers.size(); ++i) {
    const StillLayer& layer = stills.layers[i];
    nlohmann::ordered_json json = {{"name", layer.name},
                                   {"expression", layer.expression},
                                   {"mean", {layer.mean.r, layer.mean.g, layer.mean.b}},
                                   {"share", layer.share},
                                   {"exposure", layer.exposure}};
    // Where the classes add up to the whole picture, the page adds them.
    if (i > 0 || !stills.additive) {
      const Image picture = stills.layerImage(i);
      const int scale = scaleOf(picture);
      json["scale"] = scale;
      json["pixels"] = encoded(picture, scale);
    }
    layers.push_back(std::move(json));
  }
  return {{"title", stills.title},
          {"label", stills.label},
          {"settings", metadata("recurse:settings")},
          {"software", metadata("Software")},
          {"additive", stills.additive},
          {"remarks", stills.remarks},
          {"layers", std::move(layers)}};
}

/** JSON that may stand in a script element: "</script>" and "<!--" cannot be in it. */
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

std::string escaped(const std::string& text) {
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

void replaceMark(std::string& page, const std::string& mark, const std::string& text) {
  const size_t at = page.find(mark);
  if (at == std::string::npos) throw Error("internal error: the page of the stills has no " + mark);
  page.replace(at, mark.size(), text);
}

} // namespace

std::string stillsPage(const Stills& stills, const Stills* other) {
  if (other && (other->image.width != stills.image.width || other->image.height != stills.image.height))
    throw Error("the stills to compare with have " + std::to_string(other->image.width) + "x" +
                std::to_string(other->image.height) + " pixels, these have " +
                std::to_string(stills.image.width) + "x" + std::to_string(stills.image.height));
  nlohmann::ordered_json sets = nlohmann::ordered_json::array();
  sets.push_back(setJson(stills));
  if (other) sets.push_back(setJson(*other));
  const nlohmann::ordered_json data = {
      {"width", stills.image.width}, {"height", stills.image.height}, {"sets", std::move(sets)}};
  std::string page(page::STILLS_HTML);
  // The marks are replaced from the end on, so that nothing that was put in is searched.
  replaceMark(page, "<!--SCRIPT-->",
              "<script>\n\"use strict\";\n(() => {\n" + std::string(page::STILLS_DATA_JS) +
                  std::string(page::STILLS_VIEW_JS) + std::string(page::STILLS_JS) + "})();\n</script>");
  replaceMark(page, "<!--DATA-->",
              "<script type=\"application/json\" id=\"data\">" + forHtml(data) + "</script>");
  replaceMark(page, "<!--STYLE-->", "<style>\n" + std::string(page::STILLS_CSS) + "</style>");
  replaceMark(page, "<!--TITLE-->", "<title>" + escaped(stills.title) + " · stills</title>");
  return page;
}

} // namespace recurse
