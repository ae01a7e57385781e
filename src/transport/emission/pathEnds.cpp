/** @file
 * Ends of paths at lights and at the camera.
 */
#include "transport/emission/pathEnds.h"

#include "transport/direct/directLight.h"

namespace recurse {

LightGeometry LightEnd::geometry() const {
  if (light->isDelta()) return LightGeometry::DELTA;
  return isInfinite() ? LightGeometry::INFINITE : LightGeometry::SURFACE;
}

LightEnd lightEnd(const Scene& scene, const EmissionSettings& emission, uint32_t index, const LeRay& ray,
                  const SurfacePoint& next) {
  const LightTable& lights = emission.table(scene);
  LightEnd end{&lights[index], index, ray};
  const LePdf p = emission.pdfLe(index, *end.light, ray);
  const double position = p.deltaPosition ? 1 : double(p.position);
  const double direction = p.deltaDirection ? 1 : double(p.direction);
  const double pick = double(lights.probability(index));
  if (end.isInfinite()) {
    end.pdf = pick * direction;
    end.pdfNext = position * double(absDot(ray.direction, next.geometricNormal));
  } else {
    end.pdf = pick * position;
    end.pdfNext = direction * areaPerSolidAngle(ray.origin, next, ray.direction);
  }
  return end;
}

double directionToEnd(const LightEnd& end, const Vec3f& from) {
  if (end.light->kind() != LightKind::AREA) return 1;
  return double(absDot(end.ray.direction, end.ray.normal)) * inverseDistance2(end.ray.origin, from);
}

namespace {

/** Density with which a shadow ray from x_k-1 chooses the end, in the measure of B_k. */
double shadowRayPdf(const Scene& scene, const LightSampler& lights, const LightSampleContext& from,
                    const LightEnd& end) {
  const auto pick = double(lights.probability(scene.lights(), from, end.index));
  switch (end.light->kind()) {
  case LightKind::AREA: {
    SurfacePoint point;
    point.position = end.ray.origin;
    point.geometricNormal = point.shadingNormal = end.ray.normal;
    point.time = end.ray.time;
    const auto* area = static_cast<const AreaLight*>(end.light);
    return pick * double(area->pdfLi(from.position, end.ray.primitive, point)) *
           directionToEnd(end, from.position);
  }
  case LightKind::ENVIRONMENT:
    return pick * double(lights.pdfLi(*static_cast<const EnvironmentLight*>(end.light), from.position,
                                      -end.ray.direction));
  case LightKind::POINT:
  case LightKind::DISTANT:
    break;
  }
  return pick;
}

} // namespace

double shadowRayDensity(const Scene& scene, const LightSampler& lights, const ShadowRayStart& from,
                        const LightEnd& end, std::span<const WeightedVertex> vertices) {
  if (!from.point) return 0;
  const double pdf =
      shadowRayPdf(scene, lights, lightSampleContext(lights, *from.point, from.towardsCamera), end);
  if (from.panes == 0) return pdf;
  const Vec3f& start = from.point->position;
  const WeightedVertex& firstPane = vertices[vertices.size() - 1 - from.panes];
  const Vec3f towards = glm::normalize(from.firstPane->position - start);
  const double pdfDirection = firstPane.fromCamera / areaPerSolidAngle(start, *from.firstPane, towards);
  if (!(pdfDirection > 0)) return 0; // underflow
  const Vec3f& light = end.ray.origin;
  const double distanceRatio = end.isInfinite() ? 1
                                                : double(glm::distance(light, start)) /
                                                      double(glm::distance(light, from.lastPane->position));
  return shadowRaysThroughPanes(pdf, pdfDirection, distanceRatio);
}

CameraEnd::CameraEnd(const Scene& scene, const Ray& ray) {
  const Camera& camera = scene.camera();
  if (!camera.isConnectable()) return;
  parallel = camera.isDeltaDirection();
  const WePdf p = camera.pdfWe(ray);
  pdf =
      double(scene.film().width) * double(scene.film().height) * double(parallel ? p.position : p.direction);
  connectable = pdf > 0;
}

CameraEnd::CameraEnd(const Scene& scene, const CameraRay& ray)
    : CameraEnd(scene, static_cast<const Ray&>(ray)) {
  if (connectable) return;
  parallel = !(ray.spread > 0) && ray.width > 0;
  const float extent = parallel ? ray.width : ray.spread;
  pdf = extent > 0 ? 1 / square(double(extent)) : 1;
}

} // namespace recurse
