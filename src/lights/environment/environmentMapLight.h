/** @file
 * Light from infinitely far by a picture of all directions, and a sun.
 */
#pragma once

#include <optional>

#include "lights/environment/portal.h"
#include "lights/maps/environmentMap.h"
#include "recurse/model/light/light.h"

namespace recurse {

/** A disc in the sky of the same radiance everywhere. */
struct SunDisc {
  Vec3d direction{0, 0, 1}; ///< unit, towards it, in the scene
  double opening = 0;       ///< 1 - cosine of half its angle
  Rgb radiance{0};
};

class EnvironmentMapLight final : public EnvironmentLight {
 public:
  /** `sceneFromLight` counts as far as it turns and stretches directions. */
  EnvironmentMapLight(EnvironmentMap map, const Rgb& scale, const Mat4d& sceneFromLight);
  void addSun(const SunDisc& disc) { sun = disc; }
  /** Has light sampled through an opening; light that comes in elsewhere is not lost. */
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
  /** Of directions, by the picture and the sun; `pick` is used up and replaced by a fresh number. */
  Vec3d sampleSky(float& pick, const Vec2f& u, Sampling sampling) const;
  double pdfSky(const Vec3d& direction, Sampling sampling) const;
  Rgb radianceFrom(const Vec3d& direction) const;
  /** A direction of the scene in light space, and how much of that is in so much of the scene's. */
  Vec3d toLight(const Vec3d& direction, double& stretch) const;
  bool inSun(const Vec3d& direction) const;
  /** The part of samples that goes to the sun. */
  double sunPart() const;
  /** Of positions on the plane across a direction that light goes in [1/length²]. */
  double pdfPosition(const Vec3d& origin, const Vec3d& direction) const;
  double pdfTowards(const Vec3d& from, const Vec3d& direction) const;

  EnvironmentMap map;
  Rgb scale;
  Mat3d lightFromScene, sceneFromLight;
  double determinant; ///< of lightFromScene
  std::optional<SunDisc> sun;
  std::optional<Portal> portal;
  SceneBounds bounds;
};

} // namespace recurse
