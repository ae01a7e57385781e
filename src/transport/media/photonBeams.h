/** @file
 * Flights of photons through media, and their estimate along a ray from the camera where the two lines pass
 * each other closely: beams × beams with a blur in one dimension (Jarosz, Nowrouzezahrai, Sadeghi and Jensen
 * 2011, "A Comprehensive Theory of Volumetric Radiance Estimation Using Photon Points and Beams").
 */
#pragma once

#include <vector>

#include "recurse/core/math/rgb.h"
#include "transport/media/boxPyramid.h"

namespace recurse {

/** A flight in a homogeneous medium, as far as a distance drawn by its thinnest channel: light that may
 * scatter anywhere on it. */
struct PhotonBeam {
  Vec3f origin{0}, direction{0}; ///< unit
  float length = 0;
  Rgb power{0};          ///< at the origin [W]
  uint16_t medium = 0;   ///< its number in the scene
  uint8_t pathState = 0; ///< LightState of the flight
};

/** The extinction of the channel that draws how long a beam is. */
inline float thinnest(const Rgb& extinction) {
  return std::min(extinction.r, std::min(extinction.g, extinction.b));
}

/** The beams of a pass, in pieces, in a tree of boxes; immutable once built. */
class PhotonBeamMap {
 public:
  /** `scale`: of the radii over those that the beams' density calls for; `widest`: none is above. The same
   * for any number of threads. */
  void build(std::vector<PhotonBeam> beams, float scale, float widest);
  size_t size() const { return beams.size(); }
  size_t memoryBytes() const {
    return beams.capacity() * sizeof(PhotonBeam) + pieces.capacity() * sizeof(Piece) + tree.memoryBytes();
  }

  /** Calls visit(beam, s, t, kernel) for each beam that the ray of unit direction passes within its radius,
   * where they are closest: at `s` along the beam and 0 < t < end along the ray. `kernel` is 1/length across
   * both, over the sine of the angle in between. */
  template <class Visit> void visitAlong(const Ray& ray, float end, const Visit& visit) const {
    tree.visitAlong(ray, end, [&](size_t i) {
      const Piece& piece = pieces[i];
      const PhotonBeam& beam = beams[piece.beam];
      const Vec3f across = glm::cross(ray.direction, beam.direction), between = beam.origin - ray.origin;
      const float sine2 = lengthSquared(across), projected = glm::dot(between, across);
      if (!(square(projected) < square(piece.radius) * sine2) || sine2 < square(MIN_SINE)) return;
      const float s = glm::dot(glm::cross(between, ray.direction), across) / sine2;
      if (!(s >= piece.begin && s < piece.end)) return;
      const float t = glm::dot(glm::cross(between, beam.direction), across) / sine2;
      if (!(t > 0 && t < end)) return;
      const float u2 = square(projected) / (square(piece.radius) * sine2);
      visit(beam, s, t, 0.75f * (1 - u2) / (piece.radius * std::sqrt(sine2))); // Epanechnikov's
    });
  }

 private:
  /** Of the angle between ray and beam: below, single precision does not tell where they are closest. */
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
