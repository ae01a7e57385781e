/** @file
 * Solid noise: K. Perlin, "Improving Noise", SIGGRAPH 2002, and the sums of it that textures are made of
 * (Perlin, "An Image Synthesizer", SIGGRAPH 1985), cut off where the octaves are finer than the footprint.
 */
#pragma once

#include "recurse/model/texture/textureMapping.h"

namespace recurse {

/** In about [-1, 1]; zero at the points of the integer lattice, mean zero; period 256 along each axis. */
double perlinNoise(const Vec3d& p);

/** Octaves of noise: each is 1.99 times finer than the last, and `roughness` times as high. */
struct NoiseSum {
  int octaves = 8;
  double roughness = 0.5;
  double fractal(const MappedPoint& m) const;    ///< Brownian: the octaves themselves
  double turbulence(const MappedPoint& m) const; ///< their absolute values

 private:
  template <class Term, class Rest>
  double sum(const MappedPoint& m, const Term& term, const Rest& rest) const;
};

/** The parameters of a NoiseSum, and their values. */
std::vector<ParameterSpec> noiseParameters();
NoiseSum noiseSum(const Parameters& parameters);

} // namespace recurse
