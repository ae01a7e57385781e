/** @file
 * Emission and direct-light sampling of lights with an intensity pattern.
 */
#include "lights/pattern/patternLight.h"

namespace recurse {

PatternLight::PatternLight(const Mat4d& sceneFromLight)
    : position(Vec3f(Vec3d(sceneFromLight[3]))), lightFromScene(glm::inverse(Mat3d(sceneFromLight))),
      sceneFromLight(sceneFromLight), determinant(std::abs(glm::determinant(lightFromScene))) {}

void PatternLight::requireInvertible(const Mat4d& sceneFromLight, const Parameters& p) {
  const double determinant = glm::determinant(Mat3d(sceneFromLight));
  if (!std::isfinite(determinant) || determinant == 0)
    p.fail("", "the light's transform is singular: it cannot be inverted");
}

std::optional<LeSample> PatternLight::sampleLe(const LeRandom& sample) const {
  const std::optional<Vec3d> local = sampleDirection(sample.direction);
  if (!local) return {};
  const Vec3d direction = glm::normalize(sceneFromLight * *local);
  const double pdf = pdfInScene(direction);
  if (!(pdf > 0)) return {};
  const Rgb along = intensity(lightFromScene * direction);
  return LeSample{
      {position, Vec3f(direction)}, along, 1, static_cast<float>(pdf), along * static_cast<float>(1 / pdf)};
}

LePdf PatternLight::pdfLe(const LeRay& ray) const {
  return {0, static_cast<float>(pdfInScene(glm::normalize(Vec3d(ray.direction)))), true};
}

std::optional<LiSample> PatternLight::sampleLi(const Vec3f& point, float, const Vec2f&) const {
  const Vec3f towards = position - point;
  const float distance2 = lengthSquared(towards);
  if (distance2 == 0) return {};
  const float distance = std::sqrt(distance2);
  const Rgb along = intensity(lightFromScene * -glm::normalize(Vec3d(towards)));
  if (isBlack(along)) return {};
  return LiSample{towards / distance, position, distance, along / distance2, 1, true};
}

double PatternLight::pdfInScene(const Vec3d& direction) const {
  const Vec3d local = lightFromScene * direction;
  const double length = glm::length(local);
  return pdfDirection(local) * determinant / (length * length * length);
}

} // namespace recurse
