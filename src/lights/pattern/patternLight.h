/** @file
 * Point light whose intensity follows a pattern in light space, such as a picture.
 */
#pragma once

#include "recurse/model/light/light.h"
#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** Point light at the origin of light space; its transform turns and may stretch the pattern. */
class PatternLight : public Light {
 public:
  explicit PatternLight(const Mat4d& sceneFromLight);
  /** Fails at the plug-in where the transform cannot be inverted. */
  static void requireInvertible(const Mat4d& sceneFromLight, const Parameters& p);

  LightKind kind() const override { return LightKind::POINT; }
  std::optional<LeSample> sampleLe(const LeRandom& sample) const override;
  LePdf pdfLe(const LeRay& ray) const override;
  std::optional<LiSample> sampleLi(const Vec3f& point, float pick, const Vec2f& u) const override;

 private:
  // Intensity pattern. Directions are in light space, away from the light, and of any length.

  virtual Rgb intensity(const Vec3d& direction) const = 0;
  virtual std::optional<Vec3d> sampleDirection(const Vec2f& u) const = 0;
  /** Density of sampleDirection() [1/sr of light space]. */
  virtual double pdfDirection(const Vec3d& direction) const = 0;

  /** Density of a unit direction of the scene [1/sr]. */
  double pdfInScene(const Vec3d& direction) const;

  Vec3f position;
  Mat3d lightFromScene, sceneFromLight;
  double determinant; ///< absolute value, of lightFromScene
};

} // namespace recurse
