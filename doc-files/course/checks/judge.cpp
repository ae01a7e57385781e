/** @file
 * Tools of the checks.
 */
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <optional>
#include <sstream>

#include "checks/checks.h"

namespace course {

std::string text(const char* format, ...) {
  char buffer[1000];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}

std::string wrapped(const std::string& words, const std::string& indent) {
  std::istringstream in(words);
  std::string out, line, word;
  while (in >> word) {
    if (!line.empty() && indent.size() + line.size() + word.size() >= 100) {
      out += indent + line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return out + indent + line + "\n";
}

bool isNear(double a, double b, double tolerance) {
  return std::abs(a - b) <= tolerance * std::max(std::abs(a), std::abs(b)) + 1e-7;
}
bool isNear(const Rgb& a, const Rgb& b, double tolerance) {
  return isNear(double(a.r), double(b.r), tolerance) && isNear(double(a.g), double(b.g), tolerance) &&
         isNear(double(a.b), double(b.b), tolerance);
}

std::string factorInWords(double factor, double tolerance) {
  constexpr struct {
    double factor;
    const char* name;
  } KNOWN[] = {{PI_D, "pi"}, {2 * PI_D, "2 pi"}, {4 * PI_D, "4 pi"}, {PI_D / 2, "pi / 2"}, {2, "2"}, {4, "4"},
               {3, "3"}};
  for (const auto& known : KNOWN) {
    if (isNear(factor, known.factor, tolerance)) return std::string(known.name) + " times too large";
    if (isNear(factor * known.factor, 1, tolerance)) return std::string(known.name) + " times too small";
  }
  return text("%.4g times the right value", factor);
}

namespace {

bool areNear(const Values& a, const Values& b) {
  for (size_t i = 0; i < a.size(); ++i)
    if (!isNear(a[i], b[i])) return false;
  return true;
}

/** The factor between all values, if there is one other than 1. */
std::optional<double> commonFactor(const Values& values, const Values& expected) {
  std::optional<double> factor;
  for (size_t i = 0; i < values.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      if (expected[i][c] == 0) {
        if (!isNear(double(values[i][c]), 0)) return {};
        continue;
      }
      const double own = double(values[i][c]) / double(expected[i][c]);
      if (factor && !isNear(own, *factor)) return {};
      factor = own;
    }
  if (factor && isNear(*factor, 1, 5e-4)) return {}; // it would be printed as 1
  return factor;
}

} // namespace

Verdict judge(const Values& values, const Values& expected, const std::vector<Mistake>& mistakes) {
  if (areNear(values, expected)) return {};
  bool isMissing = true;
  for (const Rgb& value : values) isMissing = isMissing && isBlack(value);
  if (isMissing) return {State::MISSING, ""};
  for (const Rgb& value : values)
    if (!isFinite(value)) return wrong("a value is not finite: is there a division by zero?");
  for (const Mistake& mistake : mistakes)
    if (areNear(values, mistake.values)) return wrong(mistake.hint);
  if (const std::optional<double> factor = commonFactor(values, expected))
    return wrong(factorInWords(*factor));
  for (size_t i = 0; i < values.size(); ++i)
    if (!isNear(values[i], expected[i]))
      return wrong(text("a value is (%.6g, %.6g, %.6g) instead of (%.6g, %.6g, %.6g)", double(values[i].r),
                        double(values[i].g), double(values[i].b), double(expected[i].r),
                        double(expected[i].g), double(expected[i].b)));
  return {};
}

Verdict judgeRoulette(const std::vector<RouletteCase>& cases,
                      const std::function<bool(Rgb&, const Rgb&, float)>& survives) {
  constexpr int COUNT = 65536;
  int survivorsOfAll = 0;
  bool isEndless = true;
  std::string hint;
  for (const RouletteCase& c : cases) {
    Rgbd sum(0);
    int survivors = 0;
    bool isUnchanged = true, isOnlyScaled = true;
    for (int i = 0; i < COUNT; ++i) {
      Rgb value = c.before;
      if (!survives(value, c.factor, (float(i) + 0.5f) / COUNT)) continue;
      ++survivors;
      sum += Rgbd(value) / double(COUNT);
      isUnchanged = isUnchanged && isNear(value, c.before);
      isOnlyScaled = isOnlyScaled && isNear(value, c.before * c.factor);
    }
    survivorsOfAll += survivors;
    const Rgb mean(sum), expected = c.before * c.factor;
    const bool shouldEnd = maxComponent(expected) < 0.5f;
    if (shouldEnd && survivors < COUNT) isEndless = false;
    if (isNear(mean, expected, 0.005) || !hint.empty()) continue;
    const double chance = double(survivors) / COUNT;
    if (isUnchanged && survivors < COUNT && c.factor == Rgb(1))
      hint =
          text("survivors must be divided by their probability: the mean is %.3g times what it was", chance);
    else if (isOnlyScaled && survivors < COUNT)
      hint = text("light is lost twice: survivors are multiplied by the reflectance, and only %.3g of the "
                  "paths survive; "
                  "divide by that probability",
                  chance);
    else if (survivors == COUNT && luminance(mean) < luminance(expected))
      hint = "no path ends here, and yet light is lost: limit the probability to 1 before you divide by it";
    else
      hint = text("the mean over all u is (%.3g, %.3g, %.3g) instead of (%.3g, %.3g, %.3g), with %.3g of the "
                  "paths alive",
                  double(mean.r), double(mean.g), double(mean.b), double(expected.r), double(expected.g),
                  double(expected.b), chance);
  }
  if (survivorsOfAll == 0) return {State::MISSING, ""};
  if (!hint.empty()) return wrong(hint);
  if (isEndless)
    return wrong("no path ever ends: the probability must be below 1 where little light is left");
  return {};
}

bool checkGaps(const std::vector<Gap>& gaps) {
  size_t right = 0;
  for (const Gap& gap : gaps) {
    const Verdict verdict = gap.check();
    right += verdict.state == State::RIGHT;
    constexpr const char* STATES[] = {"right", "missing", "wrong", "waits"};
    std::printf("%2d  %-30s%s\n", gap.number, gap.name.c_str(), STATES[size_t(verdict.state)]);
    if (!verdict.hint.empty()) std::printf("%s", wrapped(verdict.hint, "    ").c_str());
  }
  std::printf("\n%zu of %zu gaps are right\n", right, gaps.size());
  return right == gaps.size();
}

} // namespace course
