/** @file
 * Reading of IESNA LM-63 files.
 */
#include "lights/pattern/iesProfile.h"

#include <charconv>
#include <fstream>
#include <numbers>
#include <sstream>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"

namespace recurse {

namespace {

using std::numbers::pi;
/** Upper bound on the number of angles, more than any file of a luminaire has. */
constexpr double MAX_ANGLES = 10000;

/** Numbers after the keywords, separated by blanks, commas or line ends. */
class Numbers {
 public:
  Numbers(const std::string& text, size_t at, int line) : text(text), at(at), line(line) {}

  double next(const char* what) {
    while (at < text.size() && (std::isspace(static_cast<unsigned char>(text[at])) || text[at] == ','))
      line += text[at++] == '\n';
    if (at == text.size()) throw Error("ends before " + std::string(what));
    if (text[at] == '+') ++at;
    double value = 0;
    const auto [end, error] = std::from_chars(&text[at], text.data() + text.size(), value);
    if (error != std::errc() || !std::isfinite(value))
      throw Error("line " + std::to_string(line) + ": where " + what +
                  " is expected, but there is no number");
    at = static_cast<size_t>(end - text.data());
    return value;
  }
  /** Reads a count, at least 1. */
  size_t count(const char* what) {
    const double n = next(what);
    if (!(n >= 1 && n <= MAX_ANGLES) || n != std::floor(n))
      throw Error("line " + std::to_string(line) + ": " + what + formatted(" cannot be %.10g", n));
    return static_cast<size_t>(n);
  }
  std::vector<double> list(size_t count, const char* what) {
    std::vector<double> out;
    for (size_t i = 0; i < count; ++i) out.push_back(next(what));
    return out;
  }
  int lineNumber() const { return line; }

 private:
  const std::string& text;
  size_t at;
  int line;
};

void checkAscending(const std::vector<double>& angles, double least, double most, const char* what) {
  for (size_t i = 0; i < angles.size(); ++i)
    if ((i > 0 && !(angles[i] > angles[i - 1])) || angles[i] < least || angles[i] > most)
      throw Error(std::string(what) + " angles do not increase from " + std::to_string(int(least)) + " to " +
                  std::to_string(int(most)) + " degrees");
}

/** Index and fraction between rising values; clamped. */
std::pair<size_t, double> between(const std::vector<double>& values, double x) {
  if (values.size() == 1 || x <= values.front()) return {0, 0};
  if (x >= values.back()) return {values.size() - 2, 1};
  const auto above = std::upper_bound(values.begin(), values.end(), x);
  const auto i = static_cast<size_t>(above - values.begin()) - 1;
  return {i, (x - values[i]) / (values[i + 1] - values[i])};
}

} // namespace

IesProfile IesProfile::read(const std::string& fileName) {
  std::ifstream file(fileName, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw Error("cannot be read");
  return parse(text.str());
}

IesProfile IesProfile::parse(const std::string& text) {
  int line = 1;
  size_t at = 0;
  for (; text.compare(at, 5, "TILT=") != 0; ++line) {
    at = text.find('\n', at);
    if (at == std::string::npos) throw Error("is no IES file: no line begins with TILT=");
    ++at;
  }
  size_t end = std::min(text.find('\n', at), text.size());
  std::string tilt = text.substr(at + 5, end - at - 5);
  while (!tilt.empty() && std::isspace(static_cast<unsigned char>(tilt.back()))) tilt.pop_back();
  Numbers numbers(text, end, line);
  if (tilt == "INCLUDE") { // factors for tilted lamps, not part of the profile
    numbers.next("the lamp's geometry");
    numbers.list(2 * numbers.count("the number of tilt angles"), "a tilt angle or factor");
  }
  numbers.next("the number of lamps");
  numbers.next("lumens per lamp");
  const double multiplier = numbers.next("the multiplier");
  const size_t verticals = numbers.count("the number of vertical angles");
  const size_t horizontals = numbers.count("the number of horizontal angles");
  const double type = numbers.next("the photometric type");
  if (type != 1)
    throw Error("line " + std::to_string(numbers.lineNumber()) + ": photometric type " +
                (type == 2   ? "B"
                 : type == 3 ? "A"
                             : std::to_string(type)) +
                " is not supported; only type C (1) is");
  numbers.list(4, "the units and the size of the opening");
  const double ballast = numbers.next("the ballast factor");
  numbers.list(2, "the ballast-lamp factor and the watts");

  IesProfile p;
  p.vertical = numbers.list(verticals, "a vertical angle");
  p.horizontal = numbers.list(horizontals, "a horizontal angle");
  checkAscending(p.vertical, 0, 180, "vertical");
  checkAscending(p.horizontal, 0, 360, "horizontal");
  const double last = p.horizontal.back(), first = p.horizontal.front();
  const bool whole = first == 0 && (last == 0 || last == 90 || last == 180 || last == 360);
  if (!whole && !(first == 90 && last == 270))
    throw Error("horizontal angles from " + std::to_string(first) + " to " + std::to_string(last) +
                " degrees have no known symmetry; known are 0, 0 to 90, 0 to 180, 90 to 270 and 0 to 360");
  p.candela = numbers.list(verticals * horizontals, "a candela value");
  for (double& c : p.candela) {
    c *= multiplier * ballast;
    if (c < 0) throw Error("has a negative candela value");
  }
  return p;
}

double IesProfile::folded(double c) const {
  c = std::fmod(c, 360);
  if (c < 0) c += 360;
  const double last = horizontal.back();
  if (last == 90) {
    c = std::fmod(c, 180);
    return std::min(c, 180 - c);
  }
  if (last == 180) return std::min(c, 360 - c);
  if (last == 270) return c < 90 ? 180 - c : c > 270 ? 540 - c : c;
  return c; // full turn, or a single angle
}

double IesProfile::intensity(double gamma, double c) const {
  constexpr double ROUNDING = 1e-9;
  if (gamma < vertical.front() - ROUNDING || gamma > vertical.back() + ROUNDING) return 0;
  const auto interpolate = [](const std::pair<size_t, double>& at, const auto& value) {
    const auto& [i, s] = at;
    return s > 0 ? value(i) * (1 - s) + value(i + 1) * s : value(i);
  };
  const std::pair<size_t, double> place = between(vertical, gamma);
  return interpolate(between(horizontal, folded(c)), [&](size_t row) {
    return interpolate(place, [&](size_t i) { return candela[row * vertical.size() + i]; });
  });
}

double IesProfile::flux() const {
  // Midpoint rule with cells of half a degree: files have angles of whole or half degrees.
  constexpr int ROWS = 720, COLUMNS = 720;
  double sum = 0;
  for (int i = 0; i < ROWS; ++i) {
    const double low = 180.0 * i / ROWS, high = 180.0 * (i + 1) / ROWS;
    double row = 0;
    for (int k = 0; k < COLUMNS; ++k) row += intensity((low + high) / 2, 360.0 * (k + 0.5) / COLUMNS);
    sum += row / COLUMNS * (std::cos(low * pi / 180) - std::cos(high * pi / 180));
  }
  return sum * 2 * pi;
}

} // namespace recurse
