/** @file
 * How finely surfaces are divided for the camera's pixels.
 */
#pragma once

#include <memory>
#include <vector>

#include "recurse/model/camera/camera.h"
#include "recurse/model/mesh/displacement.h"

namespace recurse {

/** The camera of a scene at the start of its motion, in world space: how wide a pixel is where. */
class PixelWidths {
 public:
  PixelWidths(std::unique_ptr<Camera> camera, const FilmSettings& film);
  /** How long a way from a to b is that looks as long as a pixel is wide, at the least [world units]: longer
   * where it is seen at a grazing angle, and where the film sees neither end nor the middle. */
  double alongEdge(const Vec3d& a, const Vec3d& b) const;

 private:
  /** By how much edges may be longer at a place because it is out of sight. */
  double slack(const Vec3d& place) const;
  /** By how much an edge is longer than it is seen along `view`. */
  static double foreshortening(const Vec3d& along, const Vec3d& view);

  std::unique_ptr<Camera> camera;
  Vec2d size; ///< of the film [pixels]
  Vec3d eye{0}, forward{0, 0, 1};
  double angle = 0, offset = 0; ///< between the rays of neighbouring pixels, and between their origins
};

/** Edges of a group of shapes that stands in one place or many. */
class ViewDicing final : public Dicing {
 public:
  /** `places`: world from the space of the group. The nearest of them count. */
  ViewDicing(const PixelWidths& pixels, std::vector<Mat4d> places);
  double edgeLength(const Vec3d& a, const Vec3d& b) const override;

 private:
  const PixelWidths& pixels;
  std::vector<Mat4d> places;
};

} // namespace recurse
