/** @file
 * Weights between photons that are merged at a surface and camera rays that the surface sends on, where both
 * find the same paths: caustics (LS+D), and direct light of the surface before (LDD). They are those of the
 * balance heuristic (Veach 1997, section 9.2.2), with the density of a merged photon of Georgiev et al. 2012.
 * Densities of delta lobes are taken as equal, so that either side carries one number: the ratio of the two
 * densities as far as it knows them.
 */
#pragma once

#include <cfloat>

#include "recurse/model/bsdf/scatteringPoint.h"
#include "recurse/model/light/light.h"

namespace recurse {

/** Photons straight from a light to a surface: how densely they arrive for each that is emitted, over how
 * densely shadow rays from there choose their origin on the light [1/length²]. These are taken to choose
 * places on a light evenly, and directions of an environment as photons do. `pdf`: of the emission; `cosine`:
 * at the surface; `emitted`, `chosen`: the probabilities of the light for photons and for shadow rays. */
inline float arrivalDensity(LightKind kind, const LePdf& pdf, float distance, float cosine, float emitted,
                            float chosen) {
  const float density = isInfinite(kind) ? pdf.position : pdf.direction / square(distance);
  return density * cosine * emitted / chosen;
}

/** The photon's side of the ratio (camera ray : photon), for a kernel of unit area and a ray of unit density.
 */
class ReverseRatio {
 public:
  /** No camera ray finds the path. */
  ReverseRatio() = default;
  /** `probability`: of the choice of the light. 0 for light that no ray can meet. */
  static ReverseRatio atLight(const LeSample& emitted, const LePdf& pdf, float probability) {
    const float density = pdf.position * pdf.direction * probability;
    const float cosine = emitted.normal == Vec3f(0) ? 1 : absDot(emitted.direction, emitted.normal);
    return ReverseRatio(density > 0 ? cosine / density : 0);
  }
  /** Of a photon that arrived straight from the light with arrivalDensity() and leaves by a non-delta lobe;
   * `pdf`: of that direction [1/sr]. */
  static ReverseRatio atSurface(float arrivals, float pdf, const Vec3f& direction, const SurfacePoint& from) {
    const float density = arrivals * pdf;
    return ReverseRatio(density > 0 ? absDot(direction, from.geometricNormal) / density : 0);
  }
  /** Of a photon that has met other non-delta surfaces before and leaves by a non-delta lobe, with `pdf`,
   * where a ray would be sent back the same way with `pdfBack` [1/sr]. Negative: merged photons do not weigh
   * by it. */
  ReverseRatio furtherOn(float pdfBack, float pdf, const Vec3f& direction, const SurfacePoint& from) const {
    return ReverseRatio(pdf > 0 ? -std::abs(ratio) * pdfBack / pdf * absDot(direction, from.geometricNormal)
                                : 0);
  }
  /** The photon arrives at a surface. */
  void arrive(const Vec3f& direction, const SurfacePoint& at) {
    divideBy(absDot(direction, at.geometricNormal));
  }
  /** The photon leaves it by a delta lobe. */
  void leave(const Vec3f& direction, const SurfacePoint& from) {
    ratio *= absDot(direction, from.geometricNormal);
  }
  float value() const { return ratio; }

 private:
  explicit ReverseRatio(float ratio) : ratio(ratio) {}
  void divideBy(float cosine) { ratio = cosine > 0 ? ratio / cosine : 0; }
  float ratio = 0;
};

/** The camera's side of the ratio (photon : camera ray), from a non-delta vertex where photons are merged. */
class MergeRatio {
 public:
  /** There are no photons that could find the path. */
  MergeRatio() = default;
  /** `merging`: photons emitted · area of the kernel; `pdf`: of the ray [1/sr]. */
  MergeRatio(float merging, float pdf, const Vec3f& direction, const SurfacePoint& from)
      : ratio(merging * absDot(direction, from.geometricNormal) / pdf) {}
  void arrive(const Vec3f& direction, const SurfacePoint& at) {
    const float cosine = absDot(direction, at.geometricNormal);
    ratio = cosine > 0 ? ratio / cosine : 0;
  }
  void leave(const Vec3f& direction, const SurfacePoint& from) {
    ratio *= absDot(direction, from.geometricNormal);
  }
  /** The weight of the camera ray that has met the light. On a surface `arrive` has been called for it too.
   */
  float cameraWeight(const LePdf& pdf, float probability) const {
    return 1 / (1 + ratio * pdf.position * pdf.direction * probability);
  }
  /** The same for a surface lit straight by a light, where `arrive` has been called: `pdf` is that of a
   * photon that it sends to the camera ray's origin [1/sr]. */
  float cameraWeight(float arrivals, float pdf) const { return 1 / (1 + ratio * arrivals * pdf); }

 private:
  float ratio = 0;
};

/** The merging of a kernel's support by that of unit area; finite for any radius, since long before photons
 * have all the weight. */
inline float mergingWithin(float perArea, float radius2) { return std::min(perArea * PI * radius2, 1e30f); }

/** The weight of a merged photon; `pdf`: with which the BSDF sends a ray its way [1/sr]; `rest`: the weight
 * of photons whose ratio is not above 0. */
inline float photonWeight(float reverseRatio, float merging, float pdf, float rest) {
  return reverseRatio > 0 ? merging / std::max(merging + reverseRatio * pdf, FLT_MIN) : rest;
}

} // namespace recurse
