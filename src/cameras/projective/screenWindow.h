/** @file
 * Part of the image plane that the film covers, shared by the cameras with an image plane.
 */
#pragma once

#include "recurse/model/camera/camera.h"

namespace recurse {

/** Parameters of cameras with an image plane. */
inline std::vector<ParameterSpec> screenParameters() {
  std::vector<ParameterSpec> all = {
      arrayParameter(ParameterType::REAL, "screenwindow", 4, "",
                     "x0 x1 y0 y1 of the image plane; by default the shorter axis spans -1 to 1"),
      realParameter("frameaspectratio", "", "width over height of the image plane; by default the film's")
          .positive()};
  for (const ParameterSpec& p : cameraParameters()) all.push_back(p);
  return all;
}

/** Maps film positions to the image plane at distance 1 from the camera. */
struct ScreenWindow {
  double x0 = -1, x1 = 1, y0 = -1, y1 = 1;
  double width, height; ///< size of the film [pixels]

  ScreenWindow(const Parameters& p, const CameraContext& c) : width(c.width), height(c.height) {
    const double aspect = p.hasValue("frameaspectratio") ? p.real("frameaspectratio") : width / height;
    if (aspect > 1) {
      x0 = -aspect;
      x1 = aspect;
    } else {
      y0 = -1 / aspect;
      y1 = 1 / aspect;
    }
    if (p.has("screenwindow")) {
      const std::vector<double> w = p.reals("screenwindow");
      if (!(w[0] < w[1] && w[2] < w[3])) p.fail("screenwindow", "the window is empty", "x0 < x1 and y0 < y1");
      x0 = w[0];
      x1 = w[1];
      y0 = w[2];
      y1 = w[3];
    }
  }
  Vec2d at(const Vec2f& film) const {
    return {x0 + (x1 - x0) * double(film.x) / width, y1 - (y1 - y0) * double(film.y) / height};
  }
  /** Film position [pixels] of a point of the image plane. */
  Vec2d filmAt(const Vec2d& image) const {
    return {(image.x - x0) / (x1 - x0) * width, (y1 - image.y) / (y1 - y0) * height};
  }
  double area() const { return (x1 - x0) * (y1 - y0); }
  double pixels() const { return width * height; }
  /** The larger side of a pixel on the image plane. */
  double pixelSize() const { return std::max((x1 - x0) / width, (y1 - y0) / height); }
};

} // namespace recurse
