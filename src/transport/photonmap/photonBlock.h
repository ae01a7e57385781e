/** @file
 * Blocks of eight neighbouring photons, the form in which queries return their results.
 */
#pragma once

#include "recurse/core/math/float8.h"
#include "transport/photonmap/photon.h"

namespace recurse {

/** Eight directions on the octahedron, not normalised. Same arithmetic as unpackDirection(). */
inline Vec3f8 unpackOctahedron(const uint32_t* packed) {
  const Uint32x8 p = Uint32x8::load(packed);
  const Float8 u = toFloat(p & Uint32x8(0xffff)) * Float8(1 / 32767.0f) - Float8(1);
  const Float8 v = toFloat(p >> 16) * Float8(1 / 32767.0f) - Float8(1);
  const Float8 z = Float8(1) - abs(u) - abs(v);
  const Float8 fold = max(Float8(0) - z, Float8(0));
  return {u - copysign(fold, u), v - copysign(fold, v), z};
}

/** Eight unit directions from eight packed ones on a 32-byte boundary. Same floats as unpackDirection(). */
inline Vec3f8 unpackDirections(const uint32_t* packed) {
  const Vec3f8 d = unpackOctahedron(packed);
  const Float8 scale = Float8(1) / sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
  return {d.x * scale, d.y * scale, d.z * scale};
}

/** Payload of eight slots: the data of a photon that an estimate needs, except its position. */
struct PhotonPayload {
  alignas(32) float red[8];
  alignas(32) float green[8];
  alignas(32) float blue[8];
  alignas(32) uint32_t direction[8]; ///< packed; back along the photon's path
};

/** Eight neighbouring slots; the mask marks the photons that the query found. */
struct PhotonBlock {
  uint32_t first;               ///< slot of lane 0; a multiple of 8
  uint32_t mask;                ///< bit i: lane i was found; not 0
  Float8 distance2;             ///< D² of GatherRegion; valid only in lanes of the mask
  const PhotonPayload* payload; ///< all eight lanes may be read
  const uint8_t* pathStates;    ///< eight values, see Photon
  const float* reverseRatios;   ///< eight values, see Photon; null where all are 0
  const uint32_t* normals;      ///< eight values, packed, see Photon

  Float8 red() const { return Float8::load(payload->red); }
  Float8 green() const { return Float8::load(payload->green); }
  Float8 blue() const { return Float8::load(payload->blue); }
  Rgb power(int lane) const { return {payload->red[lane], payload->green[lane], payload->blue[lane]}; }
  /** Unit directions back along the photons' paths. */
  Vec3f8 directions() const { return unpackDirections(payload->direction); }
  Vec3f direction(int lane) const { return unpackDirection({payload->direction[lane]}); }
  float reverseRatio(int lane) const { return reverseRatios ? reverseRatios[lane] : 0; }
  /** x in the lanes that were found, 0 elsewhere. */
  Float8 found(Float8 x) const { return x & Float8::lanes(mask); }
};

} // namespace recurse
