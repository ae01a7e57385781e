/** @file
 * Cryptomatte (Friedman and Jones 2015, specification 1.2.0): ids and coverage of the objects and materials
 * in each pixel, so that a compositor can cut any of them out with soft edges.
 */
#pragma once

#include <cstdint>
#include <string>

#include "recurse/core/image/image.h"
#include "recurse/model/scene/scene.h"

namespace recurse {

/** Id of a name: MurmurHash3 (x86, 32 bits, seed 0), with a bit flipped where the id as a float would be
 * infinite, NaN, zero or denormal. */
uint32_t cryptomatteId(const std::string& name);

struct CryptomatteSettings {
  bool objects = false, materials = false;
  bool throughSpecular = false; ///< mirrors and smooth glass are followed to the surface behind
  uint64_t seed = 0;
};

/**
 * Channels CryptoObject00.R ... CryptoObject02.A, and CryptoMaterial likewise: the six ids that cover most of
 * a pixel, each as the bits of a float, with its coverage weighted by the pixel's filter without its negative
 * lobes. The metadata maps names to ids (`cryptomatte/KEY/manifest`). Surfaces that emit or scatter are seen;
 * camera rays that leave the scene see nothing.
 */
Image renderCryptomattes(const Scene& scene, const CryptomatteSettings& settings);

} // namespace recurse
