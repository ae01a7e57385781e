/** @file Checks of the gaps: verdicts with hints, and tools to diagnose a wrong formula. */
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "frame/course.h"

namespace course {

/** State of a gap. */
enum class State { RIGHT, MISSING, WRONG, WAITS };

struct Verdict {
  State state = State::RIGHT;
  std::string hint; ///< of WRONG and WAITS
};

inline Verdict wrong(const std::string& hint) { return {State::WRONG, hint}; }

/** A gap of an exercise, and its check. */
struct Gap {
  int number = 0;
  std::string name;
  std::function<Verdict()> check;
};

std::vector<Gap> pathTracerGaps();
std::vector<Gap> photonMapperGaps();

/** Text as by printf. */
std::string text(const char* format, ...) __attribute__((format(printf, 1, 2)));

/** Text in lines of at most 100 characters, each with the indent. */
std::string wrapped(const std::string& words, const std::string& indent);

/** Whether two numbers are equal up to rounding, or up to a relative tolerance. */
bool isNear(double a, double b, double tolerance = 1e-4);
bool isNear(const Rgb& a, const Rgb& b, double tolerance = 1e-4);

/** A factor in words: "pi times too large". */
std::string factorInWords(double factor, double tolerance = 0.003);

/** A formula evaluated for several arguments, one value each. */
using Values = std::vector<Rgb>;

/** Values that a typical mistake leads to. */
struct Mistake {
  std::string hint;
  Values values;
};

/** Compares values with the expected ones: RIGHT, MISSING where all are black, or WRONG with the hint of the
 * mistake that explains all values; otherwise with a factor that explains them, or with both values. */
Verdict judge(const Values& values, const Values& expected, const std::vector<Mistake>& mistakes);

/** Judges Russian roulette: `survives` changes its first argument and returns whether the path goes on.
 * Survivors have `before` times `factor` as their expectation. */
struct RouletteCase {
  Rgb before{0}, factor{1};
};
Verdict judgeRoulette(const std::vector<RouletteCase>& cases,
                      const std::function<bool(Rgb& value, const Rgb& factor, float u)>& survives);

/** Runs the checks and prints the verdicts; true where all gaps are right. */
bool checkGaps(const std::vector<Gap>& gaps);

/** Renders the room with a tracer, and marks the picture by the classes of paths of a reference, which is
 * kept in a file for the next time. Prints the marks; true where nothing is wrong. */
bool markPicture(Tracer& tracer, const std::string& name, int samples);

/** Renders a scene file to a picture. */
void renderPicture(Tracer& tracer, const std::string& scene, const std::string& output, int samples);

} // namespace course
