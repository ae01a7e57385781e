/** @file
 * Pictures of all directions: environment radiance, or the intensity of a light at a point.
 */
#pragma once

#include "recurse/core/image/image.h"
#include "recurse/core/sampling/distribution2d.h"

namespace recurse {

/** Mapping of directions to a picture. Its top left is at (0, 0), its lower right at (1, 1). */
enum class EnvironmentMapping {
  EQUAL_AREA,        ///< square: the octahedral map of equal areas (Clarberg 2008); +z in the middle
  LATITUDE_LONGITUDE ///< +z at the top, azimuth atan2(y, x) = 2πu
};

/** Position of a unit direction in the picture. */
Vec2d placeOfDirection(EnvironmentMapping mapping, const Vec3d& direction);
/** Unit direction at a position of the picture. */
Vec3d directionOfPlace(EnvironmentMapping mapping, const Vec2d& place);

/** Linear values over all directions, interpolated between pixels, with densities in proportion to their
 * luminance. */
class EnvironmentMap {
 public:
  /** COMPLETE: all directions of positive luminance have a density. COMPENSATED: only directions brighter
   * than BSDF sampling accounts for (Karlík et al., "MIS Compensation", 2019), for MIS with it only. */
  enum class Sampling { COMPLETE, COMPENSATED };

  /** Takes the first three channels, which must be finite and >= 0. EQUAL_AREA needs a square picture. */
  EnvironmentMap(const Image& picture, EnvironmentMapping mapping);

  Rgb value(const Vec3d& direction) const { return at(placeOfDirection(mapping, direction)); }
  struct Sample {
    Vec3d direction;
    double pdf; ///< [1/sr]; 0: no sample
  };
  Sample sample(const Vec2f& u, Sampling sampling) const;
  double pdf(const Vec3d& direction, Sampling sampling) const;
  /** Integral over the sphere of directions. */
  const Rgbd& integral() const { return wholeIntegral; }
  /** Integral of the luminance times the cosine to +z over the upper hemisphere. */
  double upperIrradiance() const;

 private:
  const Distribution2d& densities(Sampling s) const {
    return s == Sampling::COMPLETE || compensated.empty() ? complete : compensated;
  }
  Rgb at(const Vec2d& place) const;
  /** Pixel (x, y); beyond the edges, its neighbour on the sphere. */
  const Rgb& pixel(int x, int y) const;
  void integrate();
  void tabulate();

  EnvironmentMapping mapping;
  int width, height;
  std::vector<Rgb> pixels;
  Rgbd wholeIntegral{0};
  Distribution2d complete, compensated; ///< compensated is empty where it would omit no direction
};

} // namespace recurse
