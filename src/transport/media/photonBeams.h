/** @file
 * Photon beams: flights of photons through media, and their radiance estimate along a camera ray where both
 * lines pass close to each other: beams × beams with a one-dimensional blur (Jarosz, Nowrouzezahrai, Sadeghi
 * and Jensen 2011, "A Comprehensive Theory of Volumetric Radiance Estimation Using Photon Points and Beams").
 */
#pragma once

#include <vector>

#include "recurse/core/math/rgb.h"
#include "transport/media/boxPyramid.h"

namespace recurse {

/** Flight of a photon in a homogeneous medium, up to a distance drawn by its thinnest channel: light that may
 * scatter anywhere on it. */
struct PhotonBeam {
  Vec3f origin{0}, direction{0}; ///< `direction` is unit
  float length = 0;
  Rgb power{0};          ///< flux at the origin [W]
  uint16_t medium = 0;   ///< index of the medium in the scene
  uint8_t pathState = 0; ///< LightState of the flight
  float pathLength = 0;  ///< optical length from the light to the origin [scene units], in transient renders
};

/** Extinction of the thinnest channel, which draws the length of a beam [1/length]. */
inline float thinnest(const Rgb& extinction) {
  return std::min(extinction.r, std::min(extinction.g, extinction.b));
}

/** Beams of a pass, divided into pieces, in a tree of boxes; immutable once built. */
class PhotonBeamMap {
 public:
  /** Builds the map. `scale`: factor on the radii that the beams' density calls for; `widest`: their maximum
   * before scaling [scene units]. Independent of the number of threads. */
  void build(std::vector<PhotonBeam> beams, float scale, float widest);
  size_t size() const { return beams.size(); }
  size_t memoryBytes() const {
    return beams.capacity() * sizeof(PhotonBeam) + pieces.capacity() * sizeof(Piece) + tree.memoryBytes();
  }

  /** Calls visit(beam, s, t, kernel) for each beam whose distance from the ray of unit direction is less than
   * its radius. The closest approach is at `s` along the beam and 0 < t < end along the ray. `kernel`
   * [1/length]: one-dimensional kernel of this distance, over the sine of the angle between both. Nearly
   * parallel beams are omitted. */
  template <class Visit> void visitAlong(const Ray& ray, float end, const Visit& visit) const {
    tree.visitAlong(ray, end, [&](size_t i) {
      const Piece& piece = pieces[i];
      const PhotonBeam& beam = beams[piece.beam];
      const Vec3f perpendicular = glm::cross(ray.direction, beam.direction),
                  between = beam.origin - ray.origin;
      const float sine2 = lengthSquared(perpendicular), projected = glm::dot(between, perpendicular);
      if (!(square(projected) < square(piece.radius) * sine2) || sine2 < square(MIN_SINE)) return;
      const float s = glm::dot(glm::cross(between, ray.direction), perpendicular) / sine2;
      if (!(s >= piece.begin && s < piece.end)) return;
      const float t = glm::dot(glm::cross(between, beam.direction), perpendicular) / sine2;
      if (!(t > 0 && t < end)) return;
      const float u2 = square(projected) / (square(piece.radius) * sine2);
      visit(beam, s, t, 0.75f * (1 - u2) / (piece.radius * std::sqrt(sine2))); // Epanechnikov
    });
  }

 private:
  /** Minimum sine between ray and beam; below it, single precision cannot locate the closest approach. */
  static constexpr float MIN_SINE = 1e-3f;
  struct Piece {
    uint32_t beam;
    float begin, end, radius;
  };
  std::vector<PhotonBeam> beams;
  std::vector<Piece> pieces;
  BoxPyramid tree;
};

} // namespace recurse
