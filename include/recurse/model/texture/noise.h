/** @file
 * Solid noise (K. Perlin, "Improving Noise", SIGGRAPH 2002), and fractal sums of it for textures (Perlin, "An
 * Image Synthesizer", SIGGRAPH 1985). Octaves too fine for the footprint are replaced by their mean.
 */
#pragma once

#include "recurse/model/texture/textureMapping.h"

namespace recurse {

/** Gradient noise in about [-1, 1], zero at integer lattice points, mean zero, period 256 along each axis. */
double perlinNoise(const Vec3d& p);

/** Sum of octaves of noise: each is 1.99 times finer than the one before, and `roughness` times as high. */
struct NoiseSum {
  int octaves = 8;        ///< at least 1
  double roughness = 0.5; ///< in [0, 1]
  /** Fractional Brownian motion: the sum of the octaves. */
  double fractal(const MappedPoint& m) const;
  /** Sum of the octaves' absolute values. Octaves too fine contribute their mean. As in pbrt, the first of
   * them does so up to twice, and where all are resolved, the mean of one more octave is added. */
  double turbulence(const MappedPoint& m) const;

 private:
  template <class Term, class Rest>
  double sum(const MappedPoint& m, const Term& term, const Rest& rest) const;
};

/** Parameters of a NoiseSum: "octaves" and "roughness". */
std::vector<ParameterSpec> noiseParameters();
/** Sum that the values of these parameters define. */
NoiseSum noiseSum(const Parameters& parameters);

} // namespace recurse
