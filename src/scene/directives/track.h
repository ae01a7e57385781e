/** @file
 * Numbers that change from frame to frame of an animation.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** Values at keyframes, and between them. */
class Track {
 public:
  enum class Interpolation { STEP, LINEAR, SMOOTH };

  /** `times` rise; `values` holds as many numbers for each of them. */
  Track(std::vector<double> times, std::vector<double> values, Interpolation interpolation, bool repeats);

  /** The numbers of a frame. Before the first keyframe and after the last those hold, unless it repeats. */
  std::vector<double> at(double frame) const;
  double firstTime() const { return times.front(); }
  double lastTime() const { return times.back(); }

 private:
  double key(size_t i, size_t component) const { return values[i * components + component]; }
  /** By the neighbours of a keyframe; at the ends, unless it repeats, by the only one. */
  double slope(size_t i, size_t component) const;

  std::vector<double> times, values;
  size_t components;
  Interpolation interpolation;
  bool repeats;
};

/** What an Animate directive takes after the name. */
const std::vector<ParameterSpec>& trackSpecs();

} // namespace recurse
