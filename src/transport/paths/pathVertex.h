/** @file
 * Vertices of light paths, shared by walks from the camera and from the lights.
 *
 * A walk from the camera carries a CameraState and radiance, a walk from a light a LightState and flux.
 * Densities are per unit area at the vertex they refer to; for an infinite light they are per solid angle. A
 * delta lobe contributes a density of 1/sr: this factor occurs in every technique that can generate the path,
 * and cancels in the MIS weights.
 */
#pragma once

#include <algorithm>
#include <limits>
#include <optional>

#include "recurse/model/bsdf/scatteringPoint.h"
#include "recurse/pathclasses/pathClasses.h"
#include "transport/paths/mediumFlight.h"
#include "transport/paths/nesting.h"
#include "transport/paths/opticalPath.h"

namespace recurse {

/** Subpath between two vertices: it has left a vertex, and its ray is about to find the next one. Its
 * throughput is importance or flux, over the density of all sampling decisions. */
template <class State> struct Subpath : SpectralPath {
  Ray ray;
  State state{};   ///< state of the path-class automaton
  Nesting nesting; ///< dielectrics and media that contain the ray's origin
  int depth = 0;   ///< number of scattering events of the subpath
  /** Density of the ray's direction [1/sr]; for parallel rays, of their position across them [1/area]. */
  double pdf = 1;
  bool parallel = false;    ///< the ray starts at an infinite light, or at a camera with parallel rays
  bool delta = false;       ///< the last event was a delta scattering
  float cosine = 1;         ///< cosine at the vertex that the ray left, to its geometric normal; 1 without
  Vec3f from{0};            ///< position of the vertex that the ray left
  float etaScale = 1;       ///< undoes the 1/η² of radiance inside glass, for Russian roulette only
  float width = 0;          ///< width of the pixel footprint at the ray's origin [scene units]; 0: unknown
  float spread = 0;         ///< growth of the footprint per unit of distance
  float sampleSpacing = 1;  ///< see CameraRay
  float wavelength = 0;     ///< wavelength of dispersed light [nm]; 0: white light
  OpticalPath optical;      ///< up to the ray's origin; up to the next vertex once it is found
  LobeSet needed = NO_LOBE; ///< the path ends at a material without any of these lobes; NO_LOBE: at none
  int hero = 0;             ///< colour channel that draws distances in media
  float farthest = 1;       ///< reciprocal of the survival probability outside of the scene
};

/** Vertex of a walk: a point of scattering at a surface or in a medium. */
template <class State> struct PathVertex {
  Hit hit;
  Vec3f wi{0, 0, 1};         ///< unit, back along the walk
  Rgb throughput{1};         ///< throughput on arrival
  State state{};             ///< state before this vertex
  State afterD{}, afterS{};  ///< states after a non-delta or delta event; in a medium both after V
  LobeSet allowed = NO_LOBE; ///< lobes that continue a path of some path class
  int depth = 0;             ///< scattering events, including this one
  double pdf = 1;            ///< density with which the walk found this vertex
  double toPrevious = 1;     ///< factor |cos|/d² from density of directions to area at the previous vertex
  std::optional<ScatteringPoint> scattering; ///< valid until the walker's next step; empty in a medium
  const Medium* medium = nullptr;            ///< medium that scatters; null at a surface
  const DirectionGuide* guide = nullptr;     ///< mixed into the phase function of camera paths; null: none
  float survival = 1; ///< survival probability of a light path in a medium, not used above 1

  const SurfacePoint& point() const { return hit.point; }
  /** Whether a connection, a shadow ray or a photon merge is possible here. */
  bool isConnectable() const {
    return medium ? allowed != NO_LOBE : (scattering->lobes() & allowed & NON_DELTA_LOBES) != 0;
  }
  float phase(const Vec3f& wo) const { return medium->phase->value(glm::dot(-wi, wo)); }
  /** BSDF times the cosine, or phase function, for light from unit `wo` at a vertex of a camera path. */
  Rgb evaluate(const Vec3f& wo) const { return medium ? Rgb(phase(wo)) : scattering->evaluate(wi, wo); }
  /** Density with which the walk continues towards unit `wo` by a non-delta lobe, with all lobes allowed
   * [1/sr]. Russian roulette is not included, neither here nor in any MIS weight. */
  double pdfDirection(const Vec3f& wo) const {
    if (!medium) return double(scattering->pdf(wi, wo));
    return double(guide ? guide->mixturePdf(phase(wo), wo) : phase(wo));
  }
  /** Density with which a walk from the other end that arrives from unit `wo` continues towards the previous
   * vertex [1/sr]. */
  double pdfReverse(const Vec3f& wo) const {
    return double(medium ? phase(wo) : scattering->pdf(wo, wi, ALL_LOBES, Transport::FLUX));
  }
  /** Density per area with which such a walk samples the previous vertex. */
  double pdfPrevious(const Vec3f& wo) const { return pdfReverse(wo) * toPrevious; }
};

using CameraVertex = PathVertex<CameraState>;
using LightVertex = PathVertex<LightState>;
using CameraSubpath = Subpath<CameraState>;
using LightSubpath = Subpath<LightState>;

/** Inverse squared distance of two points [1/length²]; finite for equal points. */
inline double inverseDistance2(const Vec3f& a, const Vec3f& b) {
  return 1 / std::max(double(lengthSquared(a - b)), double(std::numeric_limits<float>::min()));
}

/** Factor from density per solid angle in unit `direction` at `from` to density per area at `to`. */
inline double areaPerSolidAngle(const Vec3f& from, const SurfacePoint& to, const Vec3f& direction) {
  return double(absDot(direction, to.geometricNormal)) * inverseDistance2(to.position, from);
}

} // namespace recurse
