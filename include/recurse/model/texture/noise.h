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
  int octaves = 8;
  double roughness = 0.5;
  double fractal(const MappedPoint& m) const;    ///< fractional Brownian motion: sum of the octaves
  double turbulence(const MappedPoint& m) const; ///< sum of absolute values and, as in pbrt, up to one mean

 private:
  template <class Term, class Rest>
  double sum(const MappedPoint& m, const Term& term, const Rest& rest) const;
};

/** Parameters of a NoiseSum, and the sum that given values define. */
std::vector<ParameterSpec> noiseParameters();
NoiseSum noiseSum(const Parameters& parameters);

} // namespace recurse
