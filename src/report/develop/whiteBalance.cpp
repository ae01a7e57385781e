/** @file
 * White balance by Bradford's chromatic adaptation (Lam 1985; ICC.1:2010, annex E).
 */
#include <algorithm>
#include <cmath>

#include "recurse/model/film/toneCurve.h"
#include "recurse/report/develop/develop.h"

namespace recurse {

namespace {

/** White point of a temperature [K], as XYZ with Y = 1: on the daylight locus (CIE 15:2004, equations 3.3
 * and 3.4), below 4000 K on the black-body locus (Kim et al. 2002, US patent 7024034). */
Vec3d whiteOfTemperature(double kelvin) {
  const double t = 1000 / kelvin;
  double x = 0, y = 0;
  if (kelvin >= 4000) {
    x = kelvin <= 7000 ? 0.244063 + t * (0.09911 + t * (2.9678 - t * 4.6070))
                       : 0.237040 + t * (0.24748 + t * (1.9018 - t * 2.0064));
    y = -3 * x * x + 2.87 * x - 0.275;
  } else {
    x = 0.179910 + t * (0.8776956 - t * (0.2343589 + t * 0.2661239));
    y = kelvin < 2222 ? -0.20219683 + x * (2.18555832 - x * (1.34811020 + x * 1.1063814))
                      : -0.16748867 + x * (2.09137015 - x * (1.37418593 + x * 0.9549476));
  }
  return {x / y, 1, (1 - x - y) / y};
}

/** Linear Rec. 709 to XYZ (ITU-R BT.709-6, white D65); rows of the matrix. */
Vec3d xyzOfRgb(const Rgbd& c) {
  return {0.4123908 * c.r + 0.3575843 * c.g + 0.1804808 * c.b,
          0.2126390 * c.r + 0.7151687 * c.g + 0.0721923 * c.b,
          0.0193308 * c.r + 0.1191948 * c.g + 0.9505322 * c.b};
}

Vec3d coneResponse(const Vec3d& xyz) {
  return {0.8951 * xyz.x + 0.2664 * xyz.y - 0.1614 * xyz.z, -0.7502 * xyz.x + 1.7135 * xyz.y + 0.0367 * xyz.z,
          0.0389 * xyz.x - 0.0685 * xyz.y + 1.0296 * xyz.z};
}

/** Mean colour of the pixels that are neither dark nor bright, as XYZ. */
Vec3d meanWhite(const Image& picture) {
  const float low = luminanceQuantile(picture, 0.1), high = luminanceQuantile(picture, 0.95);
  Rgbd sum{0};
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const Rgb c = picture.rgb(x, y);
      const float light = luminance(c);
      if (light > 0 && light >= low && light <= high) sum += Rgbd(c) / double(light);
    }
  return xyzOfRgb(sum.g > 0 ? sum : Rgbd(1));
}

} // namespace

void applyWhiteBalance(Image& picture, const WhiteBalance& balance) {
  if (!balance.automatic && balance.kelvin == 0) return;
  const Vec3d from =
      coneResponse(balance.automatic ? meanWhite(picture) : whiteOfTemperature(balance.kelvin));
  const Vec3d to = coneResponse(xyzOfRgb(Rgbd(1)));
  Vec3d scale = to / glm::max(from, Vec3d(1e-6));
  // Adaptation as one matrix on Rec. 709, from its effect on the three primaries.
  Mat3d cones;
  for (int i = 0; i < 3; ++i) {
    Rgbd primary{0};
    primary[i] = 1;
    cones[i] = coneResponse(xyzOfRgb(primary));
  }
  Mat3d scaled = cones;
  for (int i = 0; i < 3; ++i) scaled[i] *= scale;
  Mat3d matrix = glm::inverse(cones) * scaled;
  if (balance.automatic) { // preserves the luminance of the mean
    const Rgbd mean = glm::inverse(matrix) * Rgbd(1);
    matrix *= luminance(mean);
  }
  changeColours(picture, [&](const Rgb& c) { return max(Rgb(matrix * Rgbd(c)), 0); });
}

} // namespace recurse
