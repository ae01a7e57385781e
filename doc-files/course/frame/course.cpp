/** @file
 * Surfaces, lamps and visibility by the scene of Recurse.
 */
#include "frame/course.h"

#include <limits>

#include <recurse/core/io/error.h>

namespace course {

namespace {

/** Reads kind, colour and index from a BSDF of Recurse. */
void describe(const Bsdf& bsdf, Surface& surface, bool isOutside) {
  const LobeSet lobes = bsdf.lobes();
  const Vec3f up(0, 0, isOutside ? 1 : -1);
  const Vec3f wi(surface.wo.x, surface.wo.y, surface.wo.z * up.z);
  if (lobes & DELTA_LOBES) bsdf.deltas(wi, surface.steps);
  for (DeltaScatter& s : surface.steps) s.wo.z *= up.z; // the z axis of the BSDF points outwards
  if (lobes & REFRACTION) {
    surface.kind = Surface::Kind::GLASS;
    DeltaScatters across;
    bsdf.deltas(up, across);
    for (const DeltaScatter& s : across)
      if (s.lobe == REFRACTION) surface.eta = s.eta;
  } else if (lobes & MIRROR) {
    surface.kind = Surface::Kind::MIRROR;
    for (const DeltaScatter& s : surface.steps) surface.colour += s.weight;
  } else if (lobes & LAMBERTIAN) {
    surface.kind = Surface::Kind::DIFFUSE;
    surface.colour = bsdf.value(up, up) * PI;
  }
}

const AreaLight& areaLight(const Light& light) { return static_cast<const AreaLight&>(light); }

} // namespace

std::optional<Surface> traceRay(const Scene& scene, const Ray& ray, TransportCounts& counts) {
  Hit hit;
  ++counts.rays;
  if (!scene.intersect(ray, hit)) return {};
  Surface surface;
  surface.point = hit.point;
  const Vec3f viewer = -ray.direction;
  surface.frame = Frame(hit.point.normalTowards(viewer));
  surface.wo = surface.frame.toLocal(viewer);
  const bool isOutside = glm::dot(viewer, hit.point.geometricNormal) > 0;
  BsdfArena arena;
  if (hit.material)
    if (const Bsdf* bsdf = hit.material->bsdfAt(hit.point, arena)) describe(*bsdf, surface, isOutside);
  if (hit.areaLight) {
    surface.isLamp = true;
    surface.lampIndex = hit.lightIndex;
    surface.lampRadiance = hit.areaLight->radiance(hit.point, hit.point.geometricNormal);
    surface.lampCosine = glm::dot(viewer, hit.point.geometricNormal);
    surface.lampPdfArea =
        scene.lights().probability(hit.lightIndex) * hit.areaLight->shape().pdfArea(hit.primitive, hit.point);
    surface.distance2 = square(hit.t);
  }
  return surface;
}

std::optional<LampPoint> sampleLamp(const Scene& scene, Sampler& sampler) {
  float pick = sampler.next1D();
  const Vec2f u = sampler.next2D();
  if (scene.lights().size() == 0) return {};
  const ChosenLight chosen = scene.lights().choose(pick);
  const AreaLight& light = areaLight(*chosen.light);
  const ShapeSample sample = light.shape().sampleArea(pick, u);
  if (!(sample.pdf > 0)) return {};
  return LampPoint{sample.point, light.radiance(sample.point, sample.point.geometricNormal),
                   sample.pdf * chosen.probability};
}

std::optional<Connection> connect(const Scene& scene, const Surface& surface, const LampPoint& lamp,
                                  TransportCounts& counts) {
  const Vec3f way = lamp.point.position - surface.point.position;
  Connection c{};
  c.distance2 = lengthSquared(way);
  if (!(c.distance2 > 0)) return {};
  c.direction = way / std::sqrt(c.distance2);
  c.cosSurface = glm::dot(c.direction, surface.frame.z);
  c.cosLamp = -glm::dot(c.direction, lamp.point.geometricNormal);
  if (!(c.cosSurface > 0 && c.cosLamp > 0)) return {};
  // Both ends are displaced from their surfaces; the shortened limit covers rounding along the ray.
  const Vec3f from = surface.point.rayOrigin(c.direction), to = lamp.point.rayOrigin(-c.direction);
  ++counts.rays;
  if (scene.occluded({from, to - from, 1 - 16 * std::numeric_limits<float>::epsilon()})) return {};
  return c;
}

float pdfTowardsLamp(const LampPoint& lamp, const Connection& c) {
  return lamp.pdfArea * c.distance2 / c.cosLamp;
}

Ray rayFrom(const Surface& surface, const Vec3f& local) {
  const Vec3f direction = glm::normalize(surface.frame.toWorld(local));
  return {surface.point.rayOrigin(direction), direction};
}

Vec3f specularStep(const Surface& surface, Sampler& sampler) {
  float sum = 0;
  for (const DeltaScatter& s : surface.steps) sum += maxComponent(s.weight);
  float u = sampler.next1D() * sum;
  Vec3f chosen(0, 0, 1);
  for (const DeltaScatter& s : surface.steps) {
    if (!(maxComponent(s.weight) > 0)) continue;
    chosen = s.wo;
    u -= maxComponent(s.weight);
    if (u < 0) break;
  }
  return chosen;
}

Seen seeThrough(const Scene& scene, Ray ray, Sampler& sampler, TransportCounts& counts) {
  Seen seen;
  for (int depth = 0; depth < MAX_DEPTH; ++depth) {
    const std::optional<Surface> hit = traceRay(scene, ray, counts);
    if (!hit) break;
    if (hit->isLamp && hit->lampCosine > 0) seen.emitted += seen.weight * hit->lampRadiance;
    if (hit->kind == Surface::Kind::DIFFUSE) seen.surface = hit;
    if (hit->kind == Surface::Kind::DIFFUSE || hit->kind == Surface::Kind::BLACK) break;
    if (hit->kind == Surface::Kind::MIRROR) seen.weight *= hit->colour;
    ray = rayFrom(*hit, specularStep(*hit, sampler));
  }
  return seen;
}

TransportCounts Tracer::prepare(const Scene& scene, const PathClasses& classes) {
  constexpr LobeSet DIFFUSE = REFLECTION | LAMBERTIAN, GLASS = MIRROR | REFRACTION;
  bool isKnown = !(scene.contents().lobes & ~(DIFFUSE | GLASS)) && !scene.hasMedia();
  for (const SceneShape& shape : scene.shapes()) {
    const LobeSet lobes = shape.material ? shape.material->lobes() : LobeSet(NO_LOBE);
    isKnown = isKnown && (lobes == NO_LOBE || lobes == DIFFUSE || lobes == MIRROR || lobes == GLASS);
  }
  if (!isKnown)
    throw Error("the tracers of the course render diffuse surfaces, smooth conductors and smooth dielectrics "
                "only");
  if (classes.layerCount() > 1) throw Error("the tracers of the course do not separate classes of paths");
  for (size_t i = 0; i < scene.lights().size(); ++i) {
    if (scene.lights()[i].kind() != LightKind::AREA)
      throw Error("the tracers of the course have lamps on surfaces only (AreaLightSource)");
    const AreaLight& light = areaLight(scene.lights()[i]);
    const SurfacePoint point = light.shape().sampleArea(0.5f, Vec2f(0.5f)).point;
    if (!isBlack(light.radiance(point, -point.geometricNormal)))
      throw Error("the lamps of the course shine from one side only");
  }
  return {};
}

void Tracer::backward(const Scene& scene, const CameraRay& ray, Sampler& sampler, PathRadiance& out) const {
  const PathClasses& classes = out.pathClasses();
  out.add(classes.lightStart(), classes.cameraStart(), radiance(scene, ray, sampler, out.counts));
}

} // namespace course
