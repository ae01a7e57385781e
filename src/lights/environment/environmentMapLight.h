/** @file
 * Environment light: a picture of all directions, and a sun.
 */
#pragma once

#include <optional>

#include "lights/environment/portal.h"
#include "lights/maps/environmentMap.h"
#include "recurse/model/light/light.h"

namespace recurse {

/** Sun disc of uniform radiance. */
struct SunDisc {
  Vec3d direction{0, 0, 1}; ///< unit, towards the sun, in scene space
  double opening = 0;       ///< 1 - cosine of the angular radius
  Rgb radiance{0};
};

class EnvironmentMapLight final : public EnvironmentLight {
 public:
  /** Only the linear part of `sceneFromLight` is used, to transform directions. */
  EnvironmentMapLight(EnvironmentMap map, const Rgb& scale, const Mat4d& sceneFromLight);
  void addSun(const SunDisc& disc) { sun = disc; }
  /** Has light sampled through an opening; light from elsewhere is still included. */
  void addPortal(const std::array<Vec3d, 4>& corners);

  void prepare(const SceneBounds& b) override { bounds = b; }
  Rgb power() const override;
  std::optional<LeSample> sampleLe(const LeRandom& sample) const override;
  LePdf pdfLe(const LeRay& ray) const override;
  std::optional<LiSample> sampleLi(const Vec3f& point, float pick, const Vec2f& u) const override;
  Rgb radiance(const Vec3f& direction) const override { return radianceFrom(Vec3d(direction)); }
  float pdfLi(const Vec3f& from, const Vec3f& direction) const override;

 private:
  using Sampling = EnvironmentMap::Sampling;
  /** Samples a direction from the picture and the sun; `pick` is consumed and replaced by a fresh number. */
  Vec3d sampleSky(float& pick, const Vec2f& u, Sampling sampling) const;
  double pdfSky(const Vec3d& direction, Sampling sampling) const;
  Rgb radianceFrom(const Vec3d& direction) const;
  /** Direction of the scene in light space; `stretch` is the solid angle there over that in the scene. */
  Vec3d toLight(const Vec3d& direction, double& stretch) const;
  bool inSun(const Vec3d& direction) const;
  /** Fraction of the samples for the sun. */
  double sunPart() const;
  /** Density of positions on the plane perpendicular to a direction of travel [1/length²]. */
  double pdfPosition(const Vec3d& origin, const Vec3d& direction) const;
  double pdfTowards(const Vec3d& from, const Vec3d& direction) const;

  EnvironmentMap map;
  Rgb scale;
  Mat3d lightFromScene, sceneFromLight;
  double determinant; ///< absolute value, of lightFromScene
  std::optional<SunDisc> sun;
  std::optional<Portal> portal;
  SceneBounds bounds;
};

} // namespace recurse
