/** @file
 * Cryptomatte (Friedman and Jones 2015, specification 1.2.0): which objects and materials a pixel shows, and
 * how much of it each covers, so that a compositor can cut any of them out with soft edges.
 */
#pragma once

#include <cstdint>
#include <string>

#include "recurse/core/image/image.h"
#include "recurse/model/scene/scene.h"

namespace recurse {

/** The number of a name: MurmurHash3 (x86, 32 bits, seed 0), with exponents of floats that are no numbers, or
 * denormal, avoided. */
uint32_t cryptomatteId(const std::string& name);

struct CryptomatteSettings {
  bool objects = false, materials = false;
  bool throughSpecular = false; ///< mirrors and smooth glass are looked through
  uint64_t seed = 0;
};

/**
 * Channels CryptoObject00.R ... CryptoObject02.A and the same of CryptoMaterial: the six that cover most of a
 * pixel, each with its id (as the bits of a float) and the part that it covers, weighed by the pixel's filter
 * without its negative lobes. The metadata names them (`cryptomatte/KEY/manifest`). What emits and what
 * scatters is seen; camera rays that leave the scene see nothing.
 */
Image renderCryptomattes(const Scene& scene, const CryptomatteSettings& settings);

} // namespace recurse
