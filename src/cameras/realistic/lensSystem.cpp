/** @file
 * Refraction from surface to surface, and focus by the cardinal points of the thick lens.
 */
#include "cameras/realistic/lensSystem.h"

#include "recurse/core/io/text.h"

namespace recurse {

LensSystem::LensSystem(std::vector<LensSurface> surfaces, double focusDistance, Mask mask)
    : list(std::move(surfaces)), mask(std::move(mask)) {
  // Paraxial ray-transfer matrix of heights and angles, from the first surface to the last one (Gerrard and
  // Burch 1975, "Introduction to Matrix Methods in Optics").
  double a = 1, b = 0, c = 0, d = 1, index = 1, length = 0;
  for (size_t i = 0; i < list.size(); ++i) {
    const LensSurface& s = list[i];
    const double power = s.isStop() ? 0 : (s.index - index) / (s.index * s.radius);
    c = -power * a + index / s.index * c;
    d = -power * b + index / s.index * d;
    index = s.index;
    if (i + 1 == list.size()) break;
    a += s.thickness * c;
    b += s.thickness * d;
    length += s.thickness;
  }
  if (!(c < 0) || index != 1)
    throw CannotFocus(
        index != 1 ? "the medium behind the last surface is not air" : "the lenses do not converge", 0);
  focal = -1 / c;
  const double frontPrincipal = (d - 1) / c, rearPrincipal = length + (1 - a) / c; // behind the first vertex
  // Object and image distance from the principal planes: their sum is known, and their product is f times it.
  const double sum = focusDistance - (rearPrincipal - frontPrincipal);
  const double image = (sum - std::sqrt(sum * (sum - 4 * focal))) / 2;
  const double rear = rearPrincipal + image - length;
  if (!(sum >= 4 * focal) || !(rear > 0))
    throw CannotFocus(
        formatted("a lens of focal length %.4g m cannot focus on anything at %.4g m from the film", focal,
                  focusDistance),
        4 * focal + rearPrincipal - frontPrincipal);
  list.back().thickness = rear;
}

std::optional<LensRay> LensSystem::trace(const LensRay& fromFilm) const {
  LensRay ray = fromFilm;
  double z = 0;
  for (size_t i = list.size(); i-- > 0;) {
    const LensSurface& s = list[i];
    z += s.thickness;
    if (!(ray.direction.z > 0)) return {};
    double t = 0;
    Vec3d normal(0, 0, -1);
    if (s.isStop()) {
      t = (z - ray.origin.z) / ray.direction.z;
    } else {
      // The intersection on the side of the vertex: the farther one where the surface bulges forwards.
      const Vec3d way = ray.origin - Vec3d(0, 0, z - s.radius);
      const double along = glm::dot(way, ray.direction);
      const double rest = square(s.radius) - (glm::dot(way, way) - square(along));
      if (!(rest >= 0)) return {};
      t = -along + std::copysign(std::sqrt(rest), s.radius);
      normal = (way + ray.direction * t) / -s.radius;
    }
    if (!(t >= 0)) return {};
    ray.origin += ray.direction * t;
    const Vec2d across(ray.origin);
    if (glm::dot(across, across) > square(s.apertureRadius)) return {};
    if (s.isStop()) {
      if (mask) ray.weight *= mask(across / s.apertureRadius);
      if (!(ray.weight > 0)) return {};
      continue;
    }
    const double eta = s.index / (i > 0 ? list[i - 1].index : 1.0);
    if (eta == 1) continue;
    const double cosine = -glm::dot(ray.direction, normal); // the normal faces the incoming ray
    const double k = 1 - eta * eta * (1 - cosine * cosine);
    if (!(k >= 0)) return {}; // total reflection
    ray.direction = glm::normalize(ray.direction * eta + normal * (eta * cosine - std::sqrt(k)));
  }
  return ray;
}

} // namespace recurse
