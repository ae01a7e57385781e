/** @file
 * Dicing of surfaces to the size of the camera's pixels.
 */
#pragma once

#include <memory>
#include <vector>

#include "recurse/model/camera/camera.h"
#include "recurse/model/mesh/displacement.h"

namespace recurse {

/** Widths of pixels of a scene's camera, at the start of its motion and in world space. */
class PixelWidths {
 public:
  PixelWidths(std::unique_ptr<Camera> camera, const FilmSettings& film);
  /** Least length along the edge from a to b that spans a pixel [world units]. It is longer at grazing
   * angles, and for an edge with both ends and its middle outside of the film. */
  double alongEdge(const Vec3d& a, const Vec3d& b) const;

 private:
  /** Factor, at least 1, by which edges at a point outside of the film may be longer. */
  double slack(const Vec3d& place) const;
  /** Ratio of the length of an edge to its projection across `view`, limited to 4. */
  static double foreshortening(const Vec3d& along, const Vec3d& view);

  std::unique_ptr<Camera> camera;
  Vec2d size; ///< size of the film [pixels]
  Vec3d eye{0}, forward{0, 0, 1};
  double angle = 0, offset = 0; ///< least values between the rays of adjacent pixels: [rad], [world units]
};

/** True for the directive of a shape whose edges ViewDicing shortens: displaced, without a given length. */
bool isDicedByView(const ParsedDirective& shape);

/** Edge lengths for a group of shapes with one placement or many. */
class ViewDicing final : public Dicing {
 public:
  /** `places`: world from group space. Only those with the narrowest pixels are kept. */
  ViewDicing(const PixelWidths& pixels, std::vector<Mat4d> places);
  double edgeLength(const Vec3d& a, const Vec3d& b) const override;

 private:
  const PixelWidths& pixels;
  std::vector<Mat4d> places;
};

} // namespace recurse
