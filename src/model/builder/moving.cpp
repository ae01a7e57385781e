/** @file
 * Points and emission from the space of a moving shape to the scene, and back.
 */
#include "model/builder/moving.h"

namespace recurse {

namespace {

/** The motion's transform at one time. Directions and normals are normalised, tangents are not. */
struct Moment {
  explicit Moment(const Mat4d& m)
      : m(m), linear(m), inverse(glm::inverse(m)), volume(std::abs(glm::determinant(linear))) {}

  Vec3f pointToShape(const Vec3f& p) const { return Vec3f(transformPoint(inverse, Vec3d(p))); }
  Vec3f directionToShape(const Vec3f& d) const {
    return Vec3f(glm::normalize(transformVector(inverse, Vec3d(d))));
  }
  Vec3f directionToScene(const Vec3f& d) const { return Vec3f(glm::normalize(linear * Vec3d(d))); }
  Vec3f normalToShape(const Vec3f& n) const {
    return Vec3f(glm::normalize(glm::transpose(linear) * Vec3d(n)));
  }
  SurfacePoint toShape(SurfacePoint p) const {
    p.position = pointToShape(p.position);
    p.geometricNormal = normalToShape(p.geometricNormal);
    p.shadingNormal = normalToShape(p.shadingNormal);
    p.dpdu = Vec3f(transformVector(inverse, Vec3d(p.dpdu)));
    p.dpdv = Vec3f(transformVector(inverse, Vec3d(p.dpdv)));
    return p;
  }
  /** Transforms an offset ray origin to the scene, and offsets it by the motion's rounding error as well. */
  Vec3f displaced(const Vec3f& position, const Vec3f& normal, const Vec3f& direction,
                  Vec3f& sceneNormal) const {
    SurfacePoint p{};
    p.position = position;
    p.geometricNormal = p.shadingNormal = normal;
    placeByMotion(m, p);
    sceneNormal = p.geometricNormal;
    return p.rayOrigin(direction);
  }
  /** Ratio of solid angles around a unit direction: space of the shape over scene. */
  float solidAngleRatio(const Vec3f& direction) const {
    const double length = glm::length(linear * Vec3d(direction));
    return static_cast<float>(length * length * length / volume);
  }
  /** Ratio of areas across a unit normal: space of the shape over scene. */
  float areaRatio(const Vec3f& normal) const {
    return static_cast<float>(1 / (volume * glm::length(glm::transpose(Mat3d(inverse)) * Vec3d(normal))));
  }

  Mat4d m;
  Mat3d linear;
  Mat4d inverse;
  double volume; ///< ratio of volumes: scene over space of the shape
};

} // namespace

void placeByMotion(const Mat4d& m, SurfacePoint& p) {
  const auto magnitudes = [](const Mat3d& a) {
    return Mat3d(glm::abs(a[0]), glm::abs(a[1]), glm::abs(a[2]));
  };
  const Mat3d linear(m), inverse = glm::inverse(linear), normalMatrix = glm::transpose(inverse);
  const Vec3d position = transformPoint(m, Vec3d(p.position));
  // Rounding error of the inverse's some 20 operations, mapped to the shape's space and back.
  const Mat3d thereAndBack = magnitudes(linear) * magnitudes(inverse);
  const Vec3d rounded = glm::abs(position) + 2.0 * glm::abs(Vec3d(m[3]));
  p.error = Vec3f(magnitudes(linear) * Vec3d(p.error) + double(roundingBound(20)) * (thereAndBack * rounded));
  p.position = Vec3f(position);
  transformDirections(linear, normalMatrix, p);
}

MovingAreaLight::MovingAreaLight(std::unique_ptr<AreaLight> made, MatrixTrack sceneFromShape)
    : AreaLight(made->shape()), light(std::move(made)), track(std::move(sceneFromShape)) {}

Rgb MovingAreaLight::power() const {
  // Areas scale by the square of the mean scale; exact for uniform scaling.
  double scale2 = 0;
  for (const Mat4d& m : track.steps())
    scale2 += std::pow(std::abs(glm::determinant(Mat3d(m))), 2.0 / 3) / double(track.steps().size());
  return light->power() * static_cast<float>(scale2);
}

Rgb MovingAreaLight::radiance(const SurfacePoint& point, const Vec3f& direction) const {
  const Moment moment(track.at(point.time));
  return light->radiance(moment.toShape(point), moment.directionToShape(direction));
}

std::optional<LeSample> MovingAreaLight::sampleLe(const LeRandom& sample) const {
  std::optional<LeSample> le = light->sampleLe(sample);
  if (!le) return le;
  const Moment moment(track.at(sample.time));
  const float area = moment.areaRatio(le->normal), solidAngle = moment.solidAngleRatio(le->direction);
  const float cosine = absDot(le->normal, le->direction);
  if (!(cosine > 0)) return {};
  const Vec3f direction = moment.directionToScene(le->direction);
  le->origin = moment.displaced(le->origin, le->normal, direction, le->normal);
  le->direction = direction;
  le->pdfPosition *= area;
  le->pdfDirection *= solidAngle;
  le->flux *= absDot(le->normal, direction) / (cosine * area * solidAngle);
  le->time = sample.time;
  return le;
}

Rgb MovingAreaLight::radianceTowards(const LeSample& sample, const Vec3f& direction) const {
  const Moment moment(track.at(sample.time));
  LeSample inShape = sample;
  inShape.origin = moment.pointToShape(sample.origin);
  inShape.direction = moment.directionToShape(sample.direction);
  inShape.normal = moment.normalToShape(sample.normal);
  return light->radianceTowards(inShape, moment.directionToShape(direction));
}

LePdf MovingAreaLight::pdfLe(const LeRay& ray) const {
  const Moment moment(track.at(ray.time));
  LeRay inShape = ray;
  inShape.origin = moment.pointToShape(ray.origin);
  inShape.direction = moment.directionToShape(ray.direction);
  inShape.normal = moment.normalToShape(ray.normal);
  LePdf pdf = light->pdfLe(inShape);
  pdf.position *= moment.areaRatio(inShape.normal);
  pdf.direction *= moment.solidAngleRatio(inShape.direction);
  return pdf;
}

std::optional<LiSample> MovingAreaLight::sampleLiAt(float time, const Vec3f& point, float pick,
                                                    const Vec2f& u) const {
  const Moment moment(track.at(time));
  std::optional<LiSample> li = light->sampleLi(moment.pointToShape(point), pick, u);
  if (!li) return li;
  li->pdf *= moment.solidAngleRatio(li->direction);
  li->direction = moment.directionToScene(li->direction);
  li->target = moment.displaced(li->target, li->normal, -li->direction, li->normal);
  li->distance = glm::distance(li->target, point);
  li->time = time;
  return li;
}

float MovingAreaLight::pdfLi(const Vec3f& from, uint32_t primitive, const SurfacePoint& point) const {
  const Moment moment(track.at(point.time));
  const Vec3f start = moment.pointToShape(from);
  const SurfacePoint there = moment.toShape(point);
  return light->pdfLi(start, primitive, there) *
         moment.solidAngleRatio(glm::normalize(there.position - start));
}

} // namespace recurse
