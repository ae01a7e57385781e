/** @file
 * Surfaces and area lights under motion.
 */
#pragma once

#include "recurse/core/math/animatedTransform.h"
#include "recurse/model/light/light.h"

namespace recurse {

/** Transforms a point of a moving shape to the scene. Its error covers the ray transform of Embree, which
 * uses the inverse of a matrix of floats. */
void placeByMotion(const Mat4d& sceneFromShape, SurfacePoint& p);

/** An area light on a moving shape. The wrapped light and its shape stay in the space of the shape. */
class MovingAreaLight final : public AreaLight {
 public:
  MovingAreaLight(std::unique_ptr<AreaLight> light, MatrixTrack sceneFromShape);

  void prepare(const SceneBounds& bounds) override { light->prepare(bounds); }
  Rgb power() const override;
  Rgb radiance(const SurfacePoint& point, const Vec3f& direction) const override;
  std::optional<LeSample> sampleLe(const LeRandom& sample) const override;
  LePdf pdfLe(const LeRay& ray) const override;
  Rgb radianceTowards(const LeSample& sample, const Vec3f& direction) const override;
  std::optional<LiSample> sampleLi(const Vec3f& point, float pick, const Vec2f& u) const override {
    return sampleLiAt(0, point, pick, u);
  }
  std::optional<LiSample> sampleLiAt(float time, const Vec3f& point, float pick,
                                     const Vec2f& u) const override;
  float pdfLi(const Vec3f& from, uint32_t primitive, const SurfacePoint& point) const override;

 private:
  std::unique_ptr<AreaLight> light;
  MatrixTrack track;
};

} // namespace recurse
