/** @file
 * MIS weights between photons merged at a surface and camera rays that leave it, where both find the same
 * paths: caustics (LS+D), and direct light of the next surface (LDD). They are balance-heuristic weights
 * (Veach 1997, section 9.2.2), with the density of a merged photon of Georgiev et al. 2012. Densities of
 * delta lobes are taken as equal on both sides, so that each side carries only one number: the ratio of the
 * two densities over its part of the path.
 */
#pragma once

#include <cfloat>

#include "recurse/model/bsdf/scatteringPoint.h"
#include "recurse/model/light/light.h"

namespace recurse {

/** Density of photons that arrive at a surface straight from a light, for each photon emitted, over the
 * density with which shadow rays from there sample the photon's origin on the light [1/length²]. Shadow rays
 * are taken to sample a light uniformly by area, and an environment as photons do. `pdf`: of the emission;
 * `cosine`: at the surface; `emitted`, `chosen`: selection probabilities of the light for photons and for
 * shadow rays. */
inline float arrivalDensity(LightKind kind, const LePdf& pdf, float distance, float cosine, float emitted,
                            float chosen) {
  const float density = isInfinite(kind) ? pdf.position : pdf.direction / square(distance);
  return density * cosine * emitted / chosen;
}

/** Factor of a ratio of densities between camera rays and photons, along a path of delta events. */
class DensityRatio {
 public:
  /** Updates the ratio when the path arrives at a surface. */
  void arrive(const Vec3f& direction, const SurfacePoint& at) {
    const float cosine = absDot(direction, at.geometricNormal);
    ratio = cosine > 0 ? ratio / cosine : 0;
  }
  /** Updates the ratio when the path leaves a surface by a delta lobe. */
  void leave(const Vec3f& direction, const SurfacePoint& from) {
    ratio *= absDot(direction, from.geometricNormal);
  }

 protected:
  explicit DensityRatio(float ratio) : ratio(ratio) {}
  float ratio;
};

/** Photon's factor of the ratio (camera ray : photon), for a kernel of unit area and a ray of density 1. */
class ReverseRatio : public DensityRatio {
 public:
  /** Ratio 0: no camera ray finds the path. */
  ReverseRatio() : DensityRatio(0) {}
  /** Ratio at the emission. `probability`: of the choice of the light; 0 for lights that no ray can hit. */
  static ReverseRatio atLight(const LeRay& emitted, const LePdf& pdf, float probability) {
    const float density = pdf.position * pdf.direction * probability;
    const float cosine = emitted.normal == Vec3f(0) ? 1 : absDot(emitted.direction, emitted.normal);
    return ReverseRatio(density > 0 ? cosine / density : 0);
  }
  /** Ratio of a photon that arrived straight from the light with arrivalDensity() and leaves by a non-delta
   * lobe. `pdf`: density of its new direction [1/sr]. */
  static ReverseRatio atSurface(float arrivals, float pdf, const Vec3f& direction, const SurfacePoint& from) {
    const float density = arrivals * pdf;
    return ReverseRatio(density > 0 ? absDot(direction, from.geometricNormal) / density : 0);
  }
  /** Ratio of a photon that other non-delta surfaces have scattered before, and that leaves by a non-delta
   * lobe with `pdf`, where a ray is sent back the same way with `pdfBack` [1/sr]. Negative: merged photons
   * are not weighted by it. */
  ReverseRatio furtherOn(float pdfBack, float pdf, const Vec3f& direction, const SurfacePoint& from) const {
    return ReverseRatio(pdf > 0 ? -std::abs(ratio) * pdfBack / pdf * absDot(direction, from.geometricNormal)
                                : 0);
  }
  float value() const { return ratio; }

 private:
  using DensityRatio::DensityRatio;
};

/** Camera's factor of the ratio (photon : camera ray), from a non-delta vertex where photons are merged. */
class MergeRatio : public DensityRatio {
 public:
  /** Ratio 0: no photon could find the path. */
  MergeRatio() : DensityRatio(0) {}
  /** `mergeDensity`: photons emitted · kernel area [area]; `pdf`: density of the ray's direction [1/sr]. */
  MergeRatio(float mergeDensity, float pdf, const Vec3f& direction, const SurfacePoint& from)
      : DensityRatio(mergeDensity * absDot(direction, from.geometricNormal) / pdf) {}
  /** MIS weight of a camera ray that has hit the light; for area lights after `arrive`. */
  float cameraWeight(const LePdf& pdf, float probability) const {
    return 1 / (1 + ratio * pdf.position * pdf.direction * probability);
  }
  /** MIS weight of a camera ray at a surface lit straight by a light, after `arrive`. `pdf`: density with
   * which a photon is scattered from there to the ray's origin [1/sr]. */
  float cameraWeight(float arrivals, float pdf) const { return 1 / (1 + ratio * arrivals * pdf); }
};

/** Factor by which the mean over a block of 8x8 pixels reduces the variance of density estimates, over that
 * of independent estimates, as pixels of a block share their photons. `radius`: of a support [pixel widths].
 * A fit, within 6 %, of the integral of the squared part of the block that a photon reaches. */
inline double independence(double radius) {
  constexpr double WIDTH = 8; // stains of this size are visible
  const double x = WIDTH / (std::sqrt(M_PI) * radius);
  return std::min(1.0, (1 + x / 3 + x * x) / square(WIDTH));
}

/** Merge density of a kernel's support, from the factor of unit area. Clamped to be finite for any radius;
 * photons have all the weight long before. */
inline float mergeDensityWithin(float perArea, float radius2) {
  return std::min(perArea * PI * radius2, 1e30f);
}

/** MIS weight of a merged photon. `pdf`: density with which the BSDF samples its direction [1/sr];
 * `unknownWeight`: weight of photons whose ratio is not above 0. */
inline float photonWeight(float reverseRatio, float mergeDensity, float pdf, float unknownWeight) {
  return reverseRatio > 0 ? mergeDensity / std::max(mergeDensity + reverseRatio * pdf, FLT_MIN)
                          : unknownWeight;
}

} // namespace recurse
