/** @file
 * The part of the image plane that the film shows, as cameras share it.
 */
#pragma once

#include "recurse/model/camera.h"

namespace recurse {

/** Parameters that every camera takes. */
inline std::vector<ParameterSpec> screenParameters() {
  return {arrayParameter(ParameterType::REAL, "screenwindow", 4, "",
                         "x0 x1 y0 y1 of the image plane; by default the shorter axis spans -1 to 1"),
          realParameter("frameaspectratio", "", "width over height of the image plane; by default the film's")
              .positive(),
          realParameter("lensradius", "0", "radius of the lens; only 0, a pinhole, is rendered today")
              .range(0, 1e30),
          ignoredParameter(ParameterType::REAL, "focaldistance", "without a lens everything is in focus"),
          ignoredParameter(ParameterType::REAL, "shutteropen", "nothing moves"),
          ignoredParameter(ParameterType::REAL, "shutterclose", "nothing moves")};
}

/** Maps film positions to the image plane at distance 1 from the eye. */
struct ScreenWindow {
  double x0 = -1, x1 = 1, y0 = -1, y1 = 1;
  double width, height; ///< of the film, in pixels

  ScreenWindow(const Parameters& p, const CameraContext& c) : width(c.width), height(c.height) {
    if (p.real("lensradius") != 0) p.fail("lensradius", "depth of field is not rendered yet", "0");
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
  /** The larger side of a pixel on the image plane. */
  double pixelSize() const { return std::max((x1 - x0) / width, (y1 - y0) / height); }
};

} // namespace recurse
