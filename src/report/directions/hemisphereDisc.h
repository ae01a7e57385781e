/** @file
 * Hemisphere of directions as a disc of equal areas for equal solid angles (Lambert's azimuthal projection).
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "recurse/core/math/vector.h"

namespace recurse {

/** The hemisphere above a surface as seen from above, divided into square cells. */
class HemisphereDisc {
 public:
  static constexpr int CELLS = 96; ///< in a row; those at the corners are outside

  /** `normal`: unit; `bottom`: the direction that is drawn towards the bottom. */
  HemisphereDisc(const Vec3f& normal, const Vec3f& bottom) : frame(normal, bottom) {}

  /** Unit direction at a point of a cell, `at` in [0, 1)²; empty outside of the disc. */
  std::optional<Vec3f> direction(size_t cell, const Vec2f& at) const {
    const Vec2f corner(cell % CELLS, cell / CELLS);
    const Vec2f p = (corner + at) * (2.0f / CELLS) - 1.0f;
    const float z = 1 - glm::dot(p, p);
    if (!(z > 0)) return {};
    const float scale = std::sqrt(1 + z);
    return frame.toWorld({p.y * scale, p.x * scale, z});
  }
  /** Cell of a unit direction; empty below the horizon. */
  std::optional<size_t> cellOf(const Vec3f& direction) const {
    const Vec3f local = frame.toLocal(direction);
    if (!(local.z > 0)) return {};
    const float scale = 1 / std::sqrt(1 + local.z);
    const auto index = [&](float x) {
      return static_cast<size_t>(
          std::clamp(static_cast<int>((x * scale + 1) * (CELLS / 2.0f)), 0, CELLS - 1));
    };
    return index(local.x) * CELLS + index(local.y);
  }
  float cosine(const Vec3f& direction) const { return glm::dot(direction, frame.z); }

  /** Solid angle of a cell that is inside [sr]. */
  static constexpr double CELL_ANGLE = 8.0 / (CELLS * CELLS);

 private:
  Frame frame; ///< x is drawn down, y to the right
};

} // namespace recurse
