/** @file
 * Frames of a transient render (time of flight): equal intervals of optical path length, each with a film
 * layer of its own, like a path class (Jarabo et al. 2014, "A Framework for Transient Rendering").
 */
#pragma once

#include <cstddef>
#include <string>

namespace recurse {

/** Intervals [from + i w, from + (i + 1) w) of optical path length from the light to the camera. Light
 * outside of all goes to a layer before or after them, so that the layers add up to the picture. */
class TransientFrames {
 public:
  /** No frames: lengths are not used. */
  TransientFrames() = default;
  /** `count` > 0 frames of [from, to) [scene units], from < to. */
  TransientFrames(double from, double to, size_t count)
      : begin(from), end(to), perLength(static_cast<float>(double(count) / (to - from))), count(count) {}

  bool empty() const { return count == 0; }
  size_t frameCount() const { return count; }
  double from() const { return begin; }
  double to() const { return end; }
  /** Number of layers: the frames, one before and one after them; 0 without frames. */
  size_t layerCount() const { return empty() ? 0 : count + 2; }
  /** Layer by the optical length [scene units]: 0 before the frames, 1 to frameCount(), one after them. */
  size_t layerOf(float length) const {
    const float place = (length - static_cast<float>(begin)) * perLength;
    if (!(place >= 0)) return 0;
    return place < static_cast<float>(count) ? 1 + static_cast<size_t>(place) : count + 1;
  }
  /** The intervals as FROM:TO:FRAMES. */
  std::string text() const;
  /** Name of a layer: "before", "frame-0000" and so on, "after". */
  std::string layerName(size_t layer) const;
  /** Whether a layer of this name is a frame. */
  static bool isFrameName(const std::string& name);

 private:
  double begin = 0, end = 0; ///< [scene units]
  float perLength = 0;       ///< frames per scene unit
  size_t count = 0;
};

} // namespace recurse
