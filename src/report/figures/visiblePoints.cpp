/** @file
 * Walk through mirrors and glass to the points that pixels see.
 */
#include "report/figures/visiblePoints.h"

#include <limits>

#include "recurse/core/io/error.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/model/bsdf/surfaceDetail.h"

namespace recurse {

namespace {

/** Camera ray, or a ray after delta events. */
struct ViewRay {
  Ray ray;
  Rgb weight{1};
  int depth = 0;
};

Rgb emissionAt(const Scene& scene, const Hit* hit, const Vec3f& direction) {
  if (hit) return hit->areaLight->radiance(hit->point, -direction);
  Rgb sum = BLACK;
  for (const EnvironmentLight* light : scene.environment()) sum += light->radiance(direction);
  return sum;
}

/** BSDF with the material's surface detail applied; null where rays pass through. */
const Bsdf* detailedBsdf(Hit& hit, const Footprint& footprint, BsdfArena& arena) {
  hit.point.footprint = footprint;
  if (hit.material->detail) hit.material->detail->apply(hit.point);
  return hit.material->bsdfAt(hit.point, arena);
}

Ray rayFrom(const SurfacePoint& point, const Vec3f& direction) {
  return {point.rayOrigin(direction), direction, INFINITE, point.time};
}

} // namespace

PixelView viewAlong(const Scene& scene, const CameraRay& first, BsdfArena& arena) {
  PixelView view;
  std::vector<ViewRay> rays = {{first, Rgb(first.weight)}};
  while (!rays.empty()) {
    const ViewRay current = rays.back();
    rays.pop_back();
    const Vec3f direction = current.ray.direction;
    std::optional<Hit> hit = followRay(scene, current.ray, [&](const Hit* light) {
      view.emission += current.weight * emissionAt(scene, light, direction);
    });
    if (!hit) continue;
    const Bsdf* bsdf = detailedBsdf(*hit, {direction, first.width + first.spread * hit->t}, arena);
    const ScatteringPoint scattering(*bsdf, hit->point);
    if (scattering.hasNonDelta())
      view.points.push_back({*hit, bsdf, -direction, current.weight, current.ray});
    if (!scattering.hasDelta() || current.depth == MAX_DELTA_DEPTH) continue;
    std::array<Scatter, DeltaScatters::MAX_COUNT> steps;
    const int count = scattering.deltaScatters(-direction, Transport::RADIANCE, steps);
    for (int i = 0; i < count; ++i) {
      const Rgb weight = current.weight * steps[size_t(i)].weight;
      if (maxComponent(weight) >= MIN_DELTA_WEIGHT)
        rays.push_back({rayFrom(hit->point, steps[size_t(i)].direction), weight, current.depth + 1});
    }
  }
  return view;
}

std::optional<Hit> followRay(const Scene& scene, Ray ray, const std::function<void(const Hit*)>& use) {
  Hit hit;
  while (scene.intersect(ray, hit)) {
    if (hit.areaLight) use(&hit);
    BsdfArena arena;
    if (hit.material && hit.material->bsdfAt(hit.point, arena)) return hit;
    ray = rayFrom(hit.point, ray.direction);
  }
  use(nullptr);
  return {};
}

void requireVisiblePoints(const Scene& scene) {
  if (scene.hasMedia()) throw Error("the figure cannot draw media such as those of the scene");
  if (!scene.nestedIndices().empty())
    throw Error("the figure cannot draw dielectrics with a priority such as those of the scene");
  if (scene.lights().size() == 0) throw Error("the figure needs a scene with lights");
}

std::optional<CameraRay> middleRay(const Scene& scene, int x, int y) {
  return scene.camera().validRay({.film = Vec2f(x, y) + 0.5f, .time = scene.camera().timeAt(0.5f)});
}

void visitMiddleRays(const Scene& scene, const std::atomic<bool>& stop,
                     const std::function<void(size_t pixel, const CameraRay&)>& use) {
  const PixelBounds& crop = scene.film().crop;
  const auto width = size_t(crop.width());
  parallelFor(size_t(crop.height()), [&](size_t row) {
    for (size_t column = 0; column < width && !stop; ++column)
      if (const auto ray =
              middleRay(scene, crop.x0 + static_cast<int>(column), crop.y0 + static_cast<int>(row)))
        use(row * width + column, *ray);
  });
}

void visitViews(const Scene& scene, const std::atomic<bool>& stop,
                const std::function<void(size_t pixel, const PixelView&)>& use) {
  visitMiddleRays(scene, stop, [&](size_t pixel, const CameraRay& ray) {
    BsdfArena arena;
    use(pixel, viewAlong(scene, ray, arena));
  });
}

std::optional<ViewedLight> sampleLight(const Scene& scene, const ViewedPoint& visible,
                                       const ScatteringPoint& scattering, Sampler& sampler) {
  float pick = sampler.next1D();
  const Vec2f u = sampler.next2D();
  const ChosenLight chosen = scene.lights().choose(pick);
  if (!(chosen.probability > 0)) return {};
  const SurfacePoint& at = visible.hit.point;
  const std::optional<LiSample> light = chosen.light->sampleLiAt(at.time, at.position, pick, u);
  if (!light || !(light->pdf > 0)) return {};
  const Rgb contribution =
      visible.weight * scattering.evaluate(visible.wi, light->direction) * light->radiance;
  if (isBlack(contribution)) return {};
  return ViewedLight{*light, chosen.probability * light->pdf, contribution};
}

bool isBlocked(const Scene& scene, const SurfacePoint& from, const Vec3f& origin, const LiSample& light) {
  const bool isEndless = light.distance == INFINITE;
  // The shortened limit covers rounding along the ray.
  const Ray ray = {origin, isEndless ? light.direction : light.target - origin,
                   isEndless ? INFINITE : 1 - 16 * std::numeric_limits<float>::epsilon(), from.time};
  return ray.direction != Vec3f(0) && scene.occluded(ray);
}

} // namespace recurse
