/** @file
 * Vertices of light paths, as a walk from either end meets them.
 *
 * A walk from the camera carries a CameraState and radiance, one from a light a LightState and flux.
 * Densities are per unit of area at the vertex they speak of, of a light infinitely far away per solid angle.
 * For what a delta lobe does, the density 1/sr stands in its place: it is in every technique that can make
 * the path, and cancels.
 */
#pragma once

#include <algorithm>
#include <limits>
#include <optional>

#include "recurse/model/bsdf/scatteringPoint.h"
#include "recurse/pathclasses/pathClasses.h"
#include "transport/paths/mediumFlight.h"
#include "transport/paths/nesting.h"

namespace recurse {

/** What the two kinds of walks differ in. */
template <class State> struct WalkSide;
template <> struct WalkSide<CameraState> { static constexpr Transport TRANSPORT = Transport::RADIANCE; };
template <> struct WalkSide<LightState> { static constexpr Transport TRANSPORT = Transport::FLUX; };

/** A path under way: it has left a vertex, and its ray is to find the next one. */
template <class State> struct Subpath {
  Ray ray;
  Rgb throughput{1}; ///< importance or flux, over the density of all that was chosen
  State state{};     ///< what has been read
  Nesting nesting;   ///< what the ray starts inside of
  int depth = 0;     ///< scattering events so far
  /** Density of the ray's direction [1/sr]; of parallel rays of their places, across them [1/area]. */
  double pdf = 1;
  bool parallel = false;   ///< the ray comes from infinitely far, or from a camera with parallel rays
  bool delta = false;      ///< the last event was one of a delta lobe
  float cosine = 1;        ///< of the ray with the geometric normal of the vertex that it left; 1 without one
  Vec3f from{0};           ///< the vertex that it left
  float etaScale = 1;      ///< undoes the 1/η² of radiance inside glass, which is no reason to end a walk
  float width = 0;         ///< of the pixel's footprint where the ray starts [scene units]; 0: not known
  float spread = 0;        ///< of the footprint, per distance
  float sampleSpacing = 1; ///< see CameraRay
  float wavelength = 0;    ///< of light that has been dispersed [nm]; 0: it is white
  // In media:
  Rgb pathPdf{1}, lightPdf{1}; ///< see SpectralPath, of which `throughput` is the third
  int hero = 0;                ///< the channel that draws distances

  SpectralPath spectral() const { return {throughput, pathPdf, lightPdf}; }
};

/** A surface, or a point in a medium, that scatters, where a walk has arrived. */
template <class State> struct PathVertex {
  Hit hit;
  Vec3f wi{0, 0, 1};         ///< unit, towards where the walk came from
  Rgb throughput{1};         ///< that arrives
  State state{};             ///< what was read before this vertex
  State afterD{}, afterS{};  ///< in a medium, afterD has read V
  LobeSet allowed = NO_LOBE; ///< lobes that some path class has a use for
  int depth = 0;             ///< scattering events, this one included
  double pdf = 1;            ///< with which the walk came here
  double toPrevious = 1;     ///< what makes a density of directions the one at the vertex before: |cos|/d²
  std::optional<ScatteringPoint> scattering; ///< lives until the walker's next step; empty in a medium
  const Medium* medium = nullptr;            ///< that scatters; null at a surface

  const SurfacePoint& point() const { return hit.point; }
  /** Whether a connection, a shadow ray or photons can end here. */
  bool isConnectable() const {
    return medium ? allowed != NO_LOBE : (scattering->lobes() & allowed & NON_DELTA_LOBES) != 0;
  }
  /** Density with which a walk that comes from unit `from` goes on towards unit `to` by a non-delta lobe,
   * all lobes allowed [1/sr]. Roulette is left out, here and in every weight. */
  double pdfDirection(const Vec3f& from, const Vec3f& to) const { return double(scattering->pdf(from, to)); }
  /** Density with which a walk that arrives from unit `wo` finds the vertex before this one. */
  double pdfPrevious(const Vec3f& wo) const { return pdfDirection(wo, wi) * toPrevious; }
};

using CameraVertex = PathVertex<CameraState>;
using LightVertex = PathVertex<LightState>;
using CameraSubpath = Subpath<CameraState>;
using LightSubpath = Subpath<LightState>;

/** 1/d² of two points [1/length²], finite where rounding leaves no distance between them. */
inline double inverseDistance2(const Vec3f& a, const Vec3f& b) {
  constexpr double LEAST = std::numeric_limits<float>::min();
  return 1 / std::max(double(lengthSquared(a - b)), LEAST);
}

/** What makes a density per solid angle around unit `direction` at `from` one per area at `to`. */
inline double areaPerSolidAngle(const Vec3f& from, const SurfacePoint& to, const Vec3f& direction) {
  return double(absDot(direction, to.geometricNormal)) * inverseDistance2(to.position, from);
}

} // namespace recurse
