/** @file
 * Caustics (LS+D) are found in two ways: by photons, and by rays that a rough surface sends back through
 * mirrors and glass to a light. Both are weighted by the balance heuristic (Veach 1997, section 9.2.2), with
 * the density of a merged photon as in vertex merging (Georgiev et al. 2012): photons emitted · area of the
 * kernel · density of the photon.
 *
 * Along mirrors and glass both walks meet the same cosines, and the densities of delta lobes are taken as
 * equal, so that either side carries one number: the ratio of the two densities as far as it knows them.
 */
#pragma once

#include "recurse/model/light.h"
#include "recurse/model/scatteringPoint.h"

namespace recurse {

/** The photon's side of the ratio (camera ray : photon), for a kernel of unit area and a ray of unit density.
 */
class ReverseRatio {
 public:
  /** `probability`: of the choice of the light. 0 for light that no ray can meet. */
  static ReverseRatio atLight(const LeSample& emitted, const LePdf& pdf, float probability) {
    const float density = pdf.position * pdf.direction * probability;
    const float cosine = emitted.normal == Vec3f(0) ? 1 : absDot(emitted.direction, emitted.normal);
    return ReverseRatio(density > 0 ? cosine / density : 0);
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
  float ratio;
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

 private:
  float ratio = 0;
};

/** The weight of a merged photon; `pdf`: with which the BSDF sends a ray its way [1/sr]. */
inline float photonWeight(float reverseRatio, float merging, float pdf) {
  return reverseRatio > 0 ? merging / (merging + reverseRatio * pdf) : 1;
}

} // namespace recurse
