/** @file
 * Parsing and printing of small values; options that may be repeated.
 */
#include "apps/options/optionText.h"

#include <charconv>
#include <cmath>
#include <optional>

#include <CLI/CLI.hpp>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"

namespace recurse::apps {

CLI::Option* addRepeatedOption(CLI::App& command, const std::string& name, std::vector<std::string>& values,
                               const std::string& description) {
  return command.add_option(name, values, description)->expected(1)->allow_extra_args(false)->take_all();
}

void badUsage(const std::string& message) { throw Error(message, ExitStatus::BAD_USAGE); }

namespace {

[[noreturn]] void fail(const std::string& option, const std::string& text, const std::string& wanted) {
  throw Error(option + ": '" + text + "' is not " + wanted, ExitStatus::BAD_USAGE);
}

/** Number that is the whole text; none for hexadecimal, infinity, NaN and blanks. */
std::optional<double> realOf(const std::string& text) {
  double value = 0;
  const char* begin = text.c_str();
  const char* end = begin + text.size();
  if (begin != end && *begin == '+') ++begin;
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

} // namespace

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (char c : text)
    if (c == separator)
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

double parseDuration(const std::string& option, const std::string& text) {
  const std::string wanted = "a time; write for example 30s, 2m or 1h30m";
  double seconds = 0, lastUnit = INFINITY;
  size_t begin = 0;
  while (begin < text.size()) {
    size_t end = begin;
    while (end < text.size() && (std::isdigit(static_cast<unsigned char>(text[end])) || text[end] == '.'))
      ++end;
    const std::optional<double> value = realOf(text.substr(begin, end - begin));
    double unit = 0;
    if (end < text.size()) {
      if (text.compare(end, 2, "ms") == 0)
        unit = 1e-3, ++end;
      else
        unit = text[end] == 'h' ? 3600 : text[end] == 'm' ? 60 : text[end] == 's' ? 1 : 0;
      ++end;
    } else if (begin == 0) {
      unit = 1; // a number alone
    }
    // Units from large to small, each once.
    if (!value || unit == 0 || unit >= lastUnit) fail(option, text, wanted);
    seconds += *value * unit;
    lastUnit = unit;
    begin = end;
  }
  if (!(seconds > 0) || !std::isfinite(seconds)) fail(option, text, wanted);
  return seconds;
}

std::array<int, 2> parseResolution(const std::string& option, const std::string& text) {
  const std::vector<std::string> parts = split(text, 'x');
  std::array<int, 2> size{};
  for (size_t i = 0; i < 2; ++i) {
    const bool digits = parts.size() == 2 && !parts[i].empty() && parts[i].size() <= 5 &&
                        parts[i].find_first_not_of("0123456789") == std::string::npos;
    if (digits) size[i] = std::stoi(parts[i]);
    if (size[i] < 1 || size[i] > 65536)
      fail(option, text, "a size; write WIDTHxHEIGHT, such as 640x480, each from 1 to 65536");
  }
  return size;
}

std::array<double, 4> parseCropWindow(const std::string& option, const std::string& text) {
  const std::vector<std::string> parts = split(text, ',');
  std::array<double, 4> window{};
  bool good = parts.size() == 4;
  for (size_t i = 0; good && i < 4; ++i) {
    const std::optional<double> value = realOf(parts[i]);
    good = value && *value >= 0 && *value <= 1;
    if (good) window[i] = *value;
  }
  if (!good || !(window[0] < window[1]) || !(window[2] < window[3]))
    fail(option, text, "a window; write x0,x1,y0,y1 with 0 <= x0 < x1 <= 1 and 0 <= y0 < y1 <= 1");
  return window;
}

int64_t parseCount(const std::string& option, const std::string& text, int64_t minimum, int64_t maximum) {
  const std::string wanted =
      "a whole number from " + std::to_string(minimum) + " to " + std::to_string(maximum);
  std::string digits = text;
  double scale = 1;
  if (!digits.empty()) {
    const char last = digits.back();
    scale = last == 'k' ? 1e3 : last == 'M' ? 1e6 : last == 'G' ? 1e9 : 1;
    if (scale != 1) digits.pop_back();
  }
  const std::optional<double> value = realOf(digits);
  if (!value) fail(option, text, wanted);
  const double scaled = *value * scale;
  // 2^53: beyond it not every whole number is a double.
  if (scaled != std::floor(scaled) || std::abs(scaled) > 9007199254740992.0) fail(option, text, wanted);
  const int64_t count = static_cast<int64_t>(scaled);
  if (count < minimum || count > maximum) fail(option, text, wanted);
  return count;
}

std::array<int, 2> parsePixel(const std::string& option, const std::string& text, const PixelBounds& crop) {
  const std::vector<std::string> parts = split(text, ',');
  if (parts.size() != 2) badUsage(option + ": " + text + " is not X,Y");
  const auto coordinate = [&](const std::string& part) {
    return static_cast<int>(parseCount(option, part, 0, (1 << 30) - 1));
  };
  const int x = coordinate(parts[0]), y = coordinate(parts[1]);
  if (x < crop.x0 || x >= crop.x1 || y < crop.y0 || y >= crop.y1)
    badUsage(option + ": " + text + " is outside of the picture of " + std::to_string(crop.x0) + "," +
             std::to_string(crop.y0) + " to " + std::to_string(crop.x1 - 1) + "," +
             std::to_string(crop.y1 - 1));
  return {x, y};
}

uint64_t parseSeed(const std::string& option, const std::string& text) {
  uint64_t seed = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (text.empty() || error != std::errc() || stop != text.data() + text.size())
    fail(option, text, "a whole number from 0 to 18446744073709551615");
  return seed;
}

PathClass parseClass(const std::string& option, const std::string& text) {
  const size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
    badUsage(option + ": '" + text + "' is not NAME=EXPRESSION, such as caustic=LS+DE");
  return {text.substr(0, equals), text.substr(equals + 1)};
}

double parseReal(const std::string& option, const std::string& text) {
  const std::optional<double> value = realOf(text);
  if (!value) fail(option, text, "a number");
  return *value;
}

std::string durationText(double seconds) {
  if (seconds < 60) return formatted(seconds < 10 ? "%.2fs" : "%.1fs", seconds);
  const auto whole = static_cast<long long>(std::llround(seconds));
  const auto two = [](long long x) { return std::string(x < 10 ? "0" : "") + std::to_string(x); };
  if (whole < 3600) return std::to_string(whole / 60) + "m" + two(whole % 60) + "s";
  return std::to_string(whole / 3600) + "h" + two(whole / 60 % 60) + "m";
}

std::string countText(double count) {
  for (const auto& [unit, letter] : {std::pair{1e9, "G"}, {1e6, "M"}, {1e3, "k"}})
    if (count >= 10 * unit || (count >= unit && unit > 1e3))
      return formatted(count >= 100 * unit ? "%.0f" : "%.3g", count / unit) + letter;
  return formatted(count == std::floor(count) ? "%.0f" : "%.3g", count);
}

std::string bytesText(double bytes) {
  for (const auto& [unit, name] : {std::pair{1e9, " GB"}, {1e6, " MB"}, {1e3, " kB"}})
    if (bytes >= unit) return formatted(bytes >= 100 * unit ? "%.0f" : "%.3g", bytes / unit) + name;
  return formatted("%.0f", bytes) + " bytes";
}

std::string folderName(const std::string& folder) { return folder.ends_with('/') ? folder : folder + "/"; }

std::string shellQuoted(const std::string& text) {
  const bool plain =
      !text.empty() && text.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                              "0123456789_-+./,:=@%") == std::string::npos;
  if (plain) return text;
  std::string quoted = "'";
  for (char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

} // namespace recurse::apps
