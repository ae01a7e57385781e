/** @file
 * Bump maps and normal maps.
 */
#include "recurse/model/bsdf/surfaceDetail.h"

#include "recurse/core/image/imageTexture.h"
#include "recurse/model/texture/textureMapping.h"

namespace recurse {

namespace {

/** Sets the shading normal, flipped where it is below the surface, as in pbrt. */
void setShadingNormal(SurfacePoint& point, const Vec3d& wanted) {
  const Vec3f n(glm::normalize(wanted));
  const float height = glm::dot(n, point.geometricNormal);
  if (height != 0) // a normal in the tangent plane is not used
    point.shadingNormal = height < 0 ? -n : n;
}

/** The tangent under the rotation that takes the geometric normal to the shading normal. */
Vec3d turned(const SurfacePoint& point, const Vec3d& tangent) {
  const Vec3d from = point.geometricNormal, to = point.shadingNormal;
  return tangent - (from + to) * (glm::dot(tangent, to) / (1 + glm::dot(from, to)));
}

class Bumps final : public SurfaceDetail {
 public:
  explicit Bumps(const TexturedRgb& height) : height(height) {}

  void apply(SurfacePoint& point) const override {
    const Vec3d n = point.shadingNormal;
    Vec3d u = turned(point, point.dpdu), v = turned(point, point.dpdv);
    if (point.crossTangent != 0) {
      u = Vec3d(point.dpdu) - n * glm::dot(n, Vec3d(point.dpdu));
      v = glm::cross(n, u) * double(point.crossTangent);
    }
    if (!(glm::length(glm::cross(u, v)) > 1e-9 * glm::length(u) * glm::length(v)))
      return; // dpdu and dpdv span no plane
    const auto [du, dv] = steps(point);
    const double h = height.at(point).r;
    const Vec3d raisedU = u + slope(point, du, 0) * n + h * Vec3d(point.dndu),
                raisedV = v + slope(point, 0, dv) * n + h * Vec3d(point.dndv);
    const Vec3d normal = glm::cross(raisedU, raisedV);
    if (glm::dot(normal, normal) > 0) setShadingNormal(point, normal);
  }

 private:
  /** Steps in u and v of half a pixel, as in pbrt; UNKNOWN, pbrt's value too, without a footprint. */
  static std::pair<float, float> steps(const SurfacePoint& point) {
    constexpr float UNKNOWN = 0.0005f;
    const FootprintAxes axes(point);
    const auto step = [&](const Vec3f& derivative) {
      const float length2 = lengthSquared(derivative);
      const float s = 0.5f * (absDot(axes.x, derivative) + absDot(axes.y, derivative)) / length2;
      return s > 0 && std::isfinite(s) ? std::min(s, 0.5f) : UNKNOWN;
    };
    return {step(point.dpdu), step(point.dpdv)};
  }

  /** Derivative of the height by u or v: a central difference, divided by the step between the coordinates
   * after rounding. */
  double slope(const SurfacePoint& point, float du, float dv) const {
    SurfacePoint before = point, after = point;
    before.uv -= 0.5f * Vec2f(du, dv);
    after.uv += 0.5f * Vec2f(du, dv);
    const Vec2d step = Vec2d(after.uv) - Vec2d(before.uv);
    const double size = step.x + step.y;
    if (size == 0)
      return 0; // the step is below the rounding of the coordinates, so that no slope can be measured
    const Vec3f shift(0.5 * (Vec3d(point.dpdu) * step.x + Vec3d(point.dpdv) * step.y));
    before.position -= shift;
    after.position += shift;
    return (double(height.at(after).r) - double(height.at(before).r)) / size;
  }

  TexturedRgb height;
};

class NormalMap final : public SurfaceDetail {
 public:
  explicit NormalMap(const FileReference& file)
      : image(file, {ImageEncoding::Kind::LINEAR, 1},
              {.filter = ImageTextureSettings::Filter::BILINEAR, .levels = false}) {}

  void apply(SurfacePoint& point) const override {
    const Vec3d n = point.shadingNormal;
    const Vec3d along = Vec3d(point.dpdu) - n * glm::dot(n, Vec3d(point.dpdu));
    const double length = glm::length(along);
    if (!(length > 0)) return;
    const Vec3d x = along / length, y = glm::cross(n, x);
    const Rgbd colour(image.at({point.uv.x, 1 - point.uv.y}, Vec2f(0), Vec2f(0)));
    const Vec3d local(2.0 * colour - 1.0);
    const Vec3d normal = x * local.x + y * local.y + n * local.z;
    if (glm::dot(normal, normal) > 0) setShadingNormal(point, normal);
  }

 private:
  ImageTexture image;
};

} // namespace

std::unique_ptr<SurfaceDetail> bumps(const TexturedRgb& height) { return std::make_unique<Bumps>(height); }
std::unique_ptr<SurfaceDetail> normalMap(const FileReference& file) {
  return std::make_unique<NormalMap>(file);
}

} // namespace recurse
