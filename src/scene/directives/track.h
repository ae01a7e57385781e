/** @file
 * Animation tracks: numbers as a function of the frame.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** Values at keyframes, with interpolation between them. */
class Track {
 public:
  enum class Interpolation { STEP, LINEAR, SMOOTH };

  /** `times` increase; `values` has the same count of numbers for each of them. */
  Track(std::vector<double> times, std::vector<double> values, Interpolation interpolation, bool repeats);

  /** Values at a frame. Before the first and after the last keyframe they are constant, unless it repeats. */
  std::vector<double> at(double frame) const;
  double firstTime() const { return times.front(); }
  double lastTime() const { return times.back(); }

 private:
  double key(size_t i, size_t component) const { return values[i * components + component]; }
  /** Slope at a keyframe by its neighbours; at the ends, unless it repeats, by the only neighbour. */
  double slope(size_t i, size_t component) const;

  std::vector<double> times, values;
  size_t components;
  Interpolation interpolation;
  bool repeats;
};

/** Parameters of an Animate directive. */
const std::vector<ParameterSpec>& trackSpecs();
/** Parameters of a LightScale directive. */
const std::vector<ParameterSpec>& lightScaleSpecs();

} // namespace recurse
