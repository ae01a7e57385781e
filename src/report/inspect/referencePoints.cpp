/** @file
 * Irradiance of Lambertian surfaces from the radiance that leaves them.
 */
#include "recurse/report/inspect/inspect.h"

#include <cmath>

#include "recurse/core/threads/parallel.h"
#include "report/figures/visiblePoints.h"

namespace recurse {

namespace {

/** Albedo of the surface that the ray hits, if it is Lambertian; sets the point. Black otherwise. */
Rgb albedoOf(const Scene& scene, const Ray& ray, ReferencePoint& out) {
  Hit hit;
  if (!scene.intersect(ray, hit) || !hit.material || hit.material->detail) return BLACK;
  BsdfArena arena;
  const Bsdf* bsdf = hit.material->bsdfAt(hit.point, arena);
  if (!bsdf || !(bsdf->lobes() & LAMBERTIAN) || (bsdf->lobes() & (TRANSMISSION | DELTA_LOBES))) return BLACK;
  out.position = hit.point.position;
  out.normal = hit.point.normalTowards(-ray.direction);
  out.object = hit.object;
  return bsdf->albedo(Vec3f(0, 0, 1));
}

/** Whether the light that leaves a Lambertian surface may be compared with the light of photons there. Fog
 * attenuates the radiance on its way to the camera; photons of a pass have one time; and light straight
 * through panes is direct light to some integrators. */
bool isComparable(const Scene& scene) {
  return !scene.hasMedia() && !scene.moves() && !(scene.contents().lobes & STRAIGHT);
}

/** Estimates the irradiance where the ray arrives, with samples of these seeds. Leaves p.samples at 0 where
 * the surface is not Lambertian. */
void estimateReference(const Scene& scene, const Integrator& integrator, const PathClasses& classes,
                       const CameraRay& ray, int64_t samples, uint64_t seed, const std::atomic<bool>& stop,
                       ReferencePoint& p) {
  const Rgb albedo = albedoOf(scene, ray, p);
  if (!(albedo.r > 0 && albedo.g > 0 && albedo.b > 0)) return;
  TransportCounts counts;
  PathRadiance out(classes, counts);
  Rgbd sum(0);
  double squares = 0;
  for (p.samples = 0; p.samples < samples && !stop; ++p.samples) {
    // Samples of one stream are stratified, so that their variance says nothing about the error of the mean.
    Sampler sampler(hashCombine(seed, static_cast<uint64_t>(p.samples)), 0, 0);
    out.reset();
    integrator.backward(scene, ray, sampler, out);
    sum += Rgbd(out.total());
    squares += square(double(luminance(out.total() * PI / albedo)));
  }
  if (p.samples == 0) return;
  const auto n = double(p.samples);
  p.irradiance = Rgb(sum / n) * PI / albedo;
  const double variance = (squares - n * square(double(luminance(p.irradiance)))) / (n - 1);
  p.standardError = n > 1 ? static_cast<float>(std::sqrt(std::max(0.0, variance) / n)) : INFINITE;
}

/** Origin of a ray against `normal` whose first surface is the one nearest to a position, which may be off it
 * on either side. A surface seen from behind counts as farther away than one that faces the normal, so that
 * the back of a thin object is not taken for its front. None: no surface is near. */
std::optional<Vec3f> originAbove(const Scene& scene, const Vec3f& position, const Vec3f& normal) {
  constexpr float REACH = 0.02f; // of the scene's radius
  constexpr float BEHIND = 4;    // factor of the distance of a surface seen from behind
  const float reach = REACH * scene.bounds().radius;
  const Vec3f start = position + normal * reach;
  std::optional<Vec3f> origin;
  float nearest = INFINITE, passed = 0; // passed: distance from the start to the previous surface
  Ray ray;
  ray.origin = start;
  ray.direction = -normal;
  ray.tMax = 2 * reach;
  for (Hit hit; scene.intersect(ray, hit);) {
    const float along = glm::dot(start - hit.point.position, normal);
    const bool faces = glm::dot(hit.point.geometricNormal, normal) > 0;
    const float distance = std::abs(along - reach) * (faces ? 1 : BEHIND);
    if (distance < nearest) {
      nearest = distance;
      origin = start - normal * ((passed + along) / 2);
    }
    passed = along;
    ray = rayBehind(ray, hit);
    if (!(ray.tMax > 0)) break;
  }
  return origin;
}

} // namespace

std::vector<ReferencePoint> referencePoints(const Scene& scene, const Integrator& integrator,
                                            const PathClasses& classes, std::span<const RecordedPixel> pixels,
                                            int64_t samples, uint64_t seed, const std::atomic<bool>& stop) {
  if (!isComparable(scene)) return {};
  std::vector<ReferencePoint> points(pixels.size());
  parallelFor(pixels.size(), [&](size_t i) {
    ReferencePoint& p = points[i];
    p.x = pixels[i].x;
    p.y = pixels[i].y;
    if (const std::optional<CameraRay> ray = middleRay(scene, p.x, p.y))
      estimateReference(scene, integrator, classes, *ray, samples, hashCombine(seed, i), stop, p);
  });
  std::erase_if(points, [](const ReferencePoint& p) { return p.samples == 0; });
  return points;
}

std::optional<ReferencePoint> referenceAt(const Scene& scene, const Integrator& integrator,
                                          const PathClasses& classes, const Vec3f& position,
                                          const Vec3f& normal, int64_t samples, uint64_t seed,
                                          const std::atomic<bool>& stop) {
  if (!isComparable(scene)) return {};
  const std::optional<Vec3f> above = originAbove(scene, position, normal);
  if (!above) return {};
  CameraRay ray;
  ray.origin = *above;
  ray.direction = -normal;
  ReferencePoint p;
  estimateReference(scene, integrator, classes, ray, samples, seed, stop, p);
  return p.samples > 0 ? std::optional(p) : std::nullopt;
}

} // namespace recurse
