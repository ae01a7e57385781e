/** @file
 * Measured BRDFs in the adaptive parameterization of Dupuy and Jakob (2018, "An Adaptive Parameterization for
 * Efficient Material Acquisition and Rendering"), the format of EPFL's material database.
 */
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "bsdfs/measured/parametricWarp.h"
#include "recurse/core/math/rgb.h"

namespace recurse {

class TensorFile;

/**
 * Measured BRDF. For each direction of incidence p, a distribution of visible normals warps the unit square
 * to half vectors, and a table over the square holds the remaining factor of f(p, q) cos q. The square maps
 * to angles by θ = u² π/2, φ = (2v - 1) π. All directions have z > 0.
 */
class AdaptiveBrdf {
 public:
  /** Throws Error, whose message includes `name`, for bytes that are not such a file. */
  AdaptiveBrdf(const std::string& name, std::string_view bytes);

  bool isAnisotropic() const { return !isotropic; }
  /**
   * BRDF [1/sr]. Measured tables are not exactly reciprocal: f is the mean of the values for both directions
   * of incidence, weighted by the cosine that each table contains.
   */
  Rgb value(const Vec3f& a, const Vec3f& b) const;
  /** The density of sample() [1/sr]. */
  float pdf(const Vec3f& wi, const Vec3f& wo) const;
  /** Samples an outgoing direction; empty where it is below the surface. */
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float pick) const;
  /** Approximate albedo for light from wi. */
  Rgb albedo(const Vec3f& wi) const;

 private:
  /** Direction of incidence, and its coordinates in the tables. */
  struct Incidence {
    Vec3f direction;
    Vec2f flip{1};       ///< signs that map w into the azimuths of the table by symmetry
    Vec2f azimuth{1, 0}; ///< cosine and sine of the reference azimuth of half vectors
    Vec2d square{0};     ///< coordinates in the square
    SliceBlend blend;
  };
  /** Coordinates of a half vector in the square, and the Jacobian there [sr per area]. */
  struct HalfPoint {
    Vec2d square;
    double jacobian;
  };

  void readIncidence(const TensorFile& file);
  void readFacets(const TensorFile& file);
  void readColours(const TensorFile& file);
  void findAlbedos();

  Incidence incidence(const Vec3f& w) const;
  HalfPoint halfPoint(const Incidence& p, const Vec3f& m) const;
  Vec3f halfVectorAt(const Incidence& p, const Vec2d& square) const;
  Rgb valueTimesCosine(const Incidence& p, const Vec3f& m) const;

  std::vector<float> phis, thetas; ///< nodes of incidence of the tables [rad]
  bool isotropic = true;
  int symmetry = 1;     ///< repetitions of the table's azimuths in a full turn
  bool relative = true; ///< colours are to be multiplied by D / (4 sigma)
  ParameterGrid grid{{}, {}};
  SliceTable<float> facets; ///< D of half vectors
  SliceTable<float> sigma;  ///< projected area of the facets, over directions of incidence
  ParametricWarp visible, luminance;
  SliceTable<Rgb> colours;
  std::vector<Rgb> albedos; ///< one for each slice
};

} // namespace recurse
