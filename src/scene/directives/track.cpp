/** @file
 * Tracks. `$name` in a scene is replaced by the text of the track's numbers, so that a frame is the scene
 * with these numbers inserted.
 */
#include "scene/directives/track.h"

#include <algorithm>
#include <cmath>

namespace recurse {

Track::Track(std::vector<double> times, std::vector<double> values, Interpolation interpolation, bool repeats)
    : times(std::move(times)), values(std::move(values)),
      components(this->values.size() / this->times.size()), interpolation(interpolation), repeats(repeats) {}

double Track::slope(size_t i, size_t component) const {
  const size_t last = times.size() - 1;
  const auto along = [&](size_t a, size_t b) {
    return (key(b, component) - key(a, component)) / (times[b] - times[a]);
  };
  if (i > 0 && i < last) return along(i - 1, i + 1);
  if (!repeats) return i == 0 ? along(0, 1) : along(last - 1, last);
  const double rise = key(1, component) - key(0, component) + key(last, component) - key(last - 1, component);
  return rise / (times[1] - times[0] + times[last] - times[last - 1]);
}

std::vector<double> Track::at(double frame) const {
  const double period = times.back() - times.front();
  if (repeats && period > 0) {
    frame = times.front() + std::fmod(frame - times.front(), period);
    if (frame < times.front()) frame += period;
  }
  const size_t next =
      static_cast<size_t>(std::upper_bound(times.begin(), times.end(), frame) - times.begin());
  const size_t i = next > 0 ? next - 1 : 0;
  std::vector<double> out(components);
  for (size_t c = 0; c < components; ++c) {
    out[c] = key(i, c);
    if (next == 0 || next == times.size() || frame == times[i] || interpolation == Interpolation::STEP)
      continue;
    const double length = times[next] - times[i], u = (frame - times[i]) / length;
    if (interpolation == Interpolation::LINEAR) {
      out[c] = (1 - u) * key(i, c) + u * key(next, c);
      continue;
    }
    // Cubic Hermite interpolation with Catmull-Rom slopes.
    const double w = u * u * (3 - 2 * u);
    out[c] = (1 - w) * key(i, c) + w * key(next, c) +
             length * u * (1 - u) * ((1 - u) * slope(i, c) - u * slope(next, c));
  }
  return out;
}

const std::vector<ParameterSpec>& trackSpecs() {
  static const std::vector<ParameterSpec> SPECS = {
      arrayParameter(ParameterType::REAL, "times", 0, "", "frames of the keyframes, increasing").require(),
      arrayParameter(ParameterType::REAL, "values", 0, "",
                     "numbers at each keyframe, in sequence: 1 to 16 for each")
          .require(),
      stringParameter(
          "interpolation", "linear",
          "interpolation between keyframes: linear, smooth (Catmull-Rom), or constant from the last keyframe")
          .oneOf({"linear", "smooth", "step"}),
      booleanParameter("repeat", "false",
                       "repeat the animation after the last keyframe, which equals the first"),
  };
  return SPECS;
}

} // namespace recurse
