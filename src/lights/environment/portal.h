/** @file
 * Portals: openings through which environment light enters, as sampling densities.
 */
#pragma once

#include <array>
#include <functional>
#include <optional>

#include "recurse/core/math/rgb.h"
#include "recurse/core/sampling/distribution2d.h"

namespace recurse {

/**
 * Rectangle through which environment light reaches points on its inner side, sampled in proportion to
 * luminance (Bitterli, Novák, Jarosz, "Portal-Masked Environment Map Sampling", 2015). In coordinates in
 * which its edges are straight lines from any viewpoint, the visible part of the environment is a
 * rectangle.
 */
class Portal {
 public:
  /** Corners are in order around the rectangle; light enters against (p3 - p0) × (p1 - p0). `radiance` takes
   * a unit direction towards the light. `resolution` is the number of cells of the table along each side. */
  Portal(const std::array<Vec3d, 4>& corners, const std::function<Rgb(const Vec3d&)>& radiance,
         int resolution);

  struct Sample {
    Vec3d direction;
    double pdf; ///< [1/sr]
  };
  /** Samples a direction from the point through the portal. Empty where no light comes through, or where
   * the point is outside. */
  std::optional<Sample> sample(const Vec3d& from, const Vec2d& u) const;
  /** Density of sample() [1/sr]; empty where sample() is always empty. */
  std::optional<double> pdf(const Vec3d& from, const Vec3d& direction) const;

  /** Uniform point of the portal. */
  Vec3d point(const Vec2d& u) const { return corner + edgeX * u.x + edgeY * u.y; }
  /** Projected area for light of a unit direction of travel; 0 for light that travels outwards. */
  double projectedArea(const Vec3d& direction) const {
    return std::max(0.0, -glm::dot(direction, axisZ)) * glm::length(edgeX) * glm::length(edgeY);
  }
  /** Whether the line through the point goes through the portal. */
  bool isCrossed(const Vec3d& through, const Vec3d& direction) const;

 private:
  struct Visible {
    WindowedDistribution2d::Window window;
    double sum; ///< sum of the table in the window
  };
  /** Window of the radiance table seen through the portal; empty where no light comes through, or where the
   * point is outside. */
  std::optional<Visible> visibleFrom(const Vec3d& from) const;
  Vec3d toLocal(const Vec3d& d) const { return {glm::dot(d, axisX), glm::dot(d, axisY), glm::dot(d, axisZ)}; }
  Vec3d toScene(const Vec3d& d) const { return axisX * d.x + axisY * d.y + axisZ * d.z; }

  Vec3d corner, edgeX, edgeY; ///< p0, and the edges to p3 and to p1
  Vec3d axisX, axisY, axisZ;  ///< z points outwards
  WindowedDistribution2d table;
};

} // namespace recurse
