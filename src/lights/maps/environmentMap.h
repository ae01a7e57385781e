/** @file
 * Pictures of all directions: radiance that comes from far away, or intensity that goes out from a point.
 */
#pragma once

#include "recurse/core/image/image.h"
#include "recurse/core/sampling/distribution2d.h"

namespace recurse {

/** How directions lie in a picture. Its top left is at (0, 0), its lower right at (1, 1). */
enum class EnvironmentMapping {
  EQUAL_AREA,        ///< square: the octahedral map of equal areas (Clarberg 2008); +z in the middle
  LATITUDE_LONGITUDE ///< +z at the top, azimuth atan2(y, x) = 2πu
};

/** Where a unit direction lies in the picture. */
Vec2d placeOfDirection(EnvironmentMapping mapping, const Vec3d& direction);
/** The unit direction at a place of the picture. */
Vec3d directionOfPlace(EnvironmentMapping mapping, const Vec2d& place);

/** Linear values over all directions, interpolated between pixels, with densities in proportion to their
 * luminance. */
class EnvironmentMap {
 public:
  /** Whether every direction of some luminance has a density, or only those that are brighter than what
   * sampling by BSDFs finds as well (Karlík et al., "MIS Compensation", 2019): for use beside it alone. */
  enum class Sampling { COMPLETE, COMPENSATED };

  /** The first three channels, which must be finite and at least 0. A picture of EQUAL_AREA is square. */
  EnvironmentMap(const Image& picture, EnvironmentMapping mapping);

  Rgb value(const Vec3d& direction) const { return at(placeOfDirection(mapping, direction)); }
  struct Sample {
    Vec3d direction;
    double pdf; ///< [1/sr]; 0: there is none
  };
  Sample sample(const Vec2f& u, Sampling sampling) const;
  double pdf(const Vec3d& direction, Sampling sampling) const;
  /** Over the sphere of directions. */
  const Rgbd& integral() const { return wholeIntegral; }
  /** Integral of the luminance times the cosine to +z over the upper hemisphere. */
  double upperIrradiance() const;

 private:
  const Distribution2d& densities(Sampling s) const {
    return s == Sampling::COMPLETE || compensated.empty() ? complete : compensated;
  }
  Rgb at(const Vec2d& place) const;
  /** Beyond the edges what lies there on the sphere. */
  const Rgb& pixel(int x, int y) const;
  void integrate();
  void tabulate();

  EnvironmentMapping mapping;
  int width, height;
  std::vector<Rgb> pixels;
  Rgbd wholeIntegral{0};
  Distribution2d complete, compensated; ///< the latter empty where it would be the same
};

} // namespace recurse
