/** @file
 * Portals: openings through which light from far away comes, as proposals for sampling.
 */
#pragma once

#include <array>
#include <functional>
#include <optional>

#include "recurse/core/math/rgb.h"
#include "recurse/core/sampling/distribution2d.h"

namespace recurse {

/**
 * A rectangle, and the light that comes through it towards points on its inner side, sampled in proportion to
 * luminance (Bitterli, Novák, Jarosz, "Portal-Masked Environment Map Sampling", 2015). In coordinates in
 * which its edges are straight lines as seen from anywhere, the visible part of the surroundings is a
 * rectangle.
 */
class Portal {
 public:
  /** The corners in order around it; light comes in against (p3 - p0) × (p1 - p0). `radiance` is of a unit
   * direction towards the light. `resolution` is that of the table, along each side. */
  Portal(const std::array<Vec3d, 4>& corners, const std::function<Rgb(const Vec3d&)>& radiance,
         int resolution);

  struct Sample {
    Vec3d direction;
    double pdf; ///< [1/sr]
  };
  /** A direction from the point through the portal. Empty: no light comes from there, or the point lies
   * outside. */
  std::optional<Sample> sample(const Vec3d& from, const Vec2d& u) const;
  /** Of sample() [1/sr]; empty where that never has any. */
  std::optional<double> pdf(const Vec3d& from, const Vec3d& direction) const;

  /** A point of it, uniformly. */
  Vec3d point(const Vec2d& u) const { return corner + edgeX * u.x + edgeY * u.y; }
  /** Its area as light of that direction sees it, or 0 for light that goes outwards. */
  double projectedArea(const Vec3d& direction) const {
    return std::max(0.0, -glm::dot(direction, axisZ)) * glm::length(edgeX) * glm::length(edgeY);
  }
  /** Whether the line through the point goes through the portal. */
  bool isCrossed(const Vec3d& through, const Vec3d& direction) const;

 private:
  struct Visible {
    WindowedDistribution2d::Window window;
    double sum; ///< of the table in the window
  };
  /** What is seen of it. Empty: no light comes from there, or the point lies outside. */
  std::optional<Visible> visibleFrom(const Vec3d& from) const;
  Vec3d toLocal(const Vec3d& d) const { return {glm::dot(d, axisX), glm::dot(d, axisY), glm::dot(d, axisZ)}; }
  Vec3d toScene(const Vec3d& d) const { return axisX * d.x + axisY * d.y + axisZ * d.z; }

  Vec3d corner, edgeX, edgeY; ///< p0, and the edges to p3 and to p1
  Vec3d axisX, axisY, axisZ;  ///< z points outwards
  WindowedDistribution2d table;
};

} // namespace recurse
