/** @file
 * Measured BRDFs in the adaptive parameterization of Dupuy and Jakob (2018, "An Adaptive Parameterization for
 * Efficient Material Acquisition and Rendering"), as the files of EPFL's material database have them.
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
 * For each direction of incidence p the unit square is warped to half vectors as the visible facets of a
 * distribution are spread, and the table of the square holds what remains of f(p, q) cos q then. Angles are
 * found in the square by θ = u² π/2, φ = (2v - 1) π. All directions have z > 0.
 */
class AdaptiveBrdf {
 public:
  /** Throws Error, with `name`, for bytes that are no such file. */
  AdaptiveBrdf(const std::string& name, std::string_view bytes);

  bool isAnisotropic() const { return !isotropic; }
  /**
   * BRDF [1/sr]. Tables are reciprocal only as far as measurements are: f is the mean of the tables' values
   * for both directions of incidence, weighted with the cosine that each does not divide by.
   */
  Rgb value(const Vec3f& a, const Vec3f& b) const;
  /** The density of sample() [1/sr]. */
  float pdf(const Vec3f& wi, const Vec3f& wo) const;
  /** Empty: below the surface. */
  std::optional<Vec3f> sample(const Vec3f& wi, const Vec2f& u, float pick) const;
  /** The flux that is scattered, nearly. */
  Rgb albedo(const Vec3f& wi) const;

 private:
  /** A direction of incidence. */
  struct Incidence {
    Vec3f direction;
    Vec2f flip{1};       ///< by the surface's symmetry, to the azimuths of the table
    Vec2f azimuth{1, 0}; ///< cosine and sine of that which half vectors' are counted from
    Vec2d square{0};     ///< place in the square
    SliceBlend blend;
  };
  /** A half vector's place in the square, and steradians per area there. */
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

  std::vector<float> phis, thetas; ///< of incidence, in the tables
  bool isotropic = true;
  int symmetry = 1;     ///< the azimuths are so many times in a full turn
  bool relative = true; ///< colours are to be multiplied by D / (4 sigma)
  ParameterGrid grid{{}, {}};
  SliceTable<float> facets; ///< D of half vectors
  SliceTable<float> sigma;  ///< projected area of the facets, of directions of incidence
  ParametricWarp visible, luminance;
  SliceTable<Rgb> colours;
  std::vector<Rgb> albedos; ///< of the slices
};

} // namespace recurse
