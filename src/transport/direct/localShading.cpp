/** @file
 * Direct light of a vertex, by a shadow ray and a BSDF ray.
 */
#include "transport/direct/localShading.h"

#include "transport/paths/walker.h"

namespace recurse {

namespace {

constexpr int SHADOW_RAYS = 1; ///< number of shadow rays at each vertex

/** Adds the emission that a BSDF-sampled ray finds before its next scattering event. */
void addBsdfRay(const Scene& scene, const LightSampler& lights, const LightSampleContext& place,
                const CameraVertex& vertex, const Nesting& nesting, Sampler& sampler, PathRadiance& out) {
  const std::optional<Scatter> s =
      vertex.scattering->scatterNonDelta(vertex.wi, Transport::RADIANCE, sampler);
  if (!s || isBlack(vertex.throughput * s->weight)) return;
  const PathClasses& classes = out.pathClasses();
  CameraSubpath path;
  path.ray = spawn(vertex.point(), s->direction);
  path.nesting = nesting;
  path.nesting.scatters(vertex.hit, vertex.wi, s->direction);
  const BsdfRay ray{place, s->pdf, true};
  CameraWalker walker(scene, classes, out.counts, -1);
  CameraVertex next;
  walker.next(path, next, sampler, [&](const Hit* hit) {
    const Rgb radiance = hit ? emittedRadiance(scene, lights, *hit, s->direction, ray, SHADOW_RAYS)
                             : environmentRadiance(scene, lights, s->direction, ray, SHADOW_RAYS);
    out.add(classes.lightStart(), vertex.afterD, vertex.throughput * s->weight * radiance);
  });
}

} // namespace

void addDirectLight(const Scene& scene, const LightSampler& lights, const CameraVertex& vertex,
                    const Nesting& nesting, Sampler& sampler, PathRadiance& out) {
  const PathClasses& classes = out.pathClasses();
  if (!vertex.isConnectable() || scene.lights().size() == 0 ||
      classes.join(classes.lightStart(), vertex.afterD) == 0)
    return;
  const LightSampleContext place = lightSampleContext(lights, vertex.point(), vertex.wi);
  addSampledLight(scene, lights, place, *vertex.scattering, vertex.hit, nesting, vertex.wi, vertex.throughput,
                  vertex.afterD, SHADOW_RAYS, NON_DELTA_LOBES, NO_PANES, sampler, out);
  if (scene.contents().areaLights + scene.contents().environmentLights > 0)
    addBsdfRay(scene, lights, place, vertex, nesting, sampler, out);
}

void addSeenEmission(const Scene& scene, const LightSampler& lights, const CameraSubpath& path,
                     const Hit* hit, PathRadiance& out) {
  const Vec3f& direction = path.ray.direction;
  const Rgb radiance = hit ? emittedRadiance(scene, lights, *hit, direction, {}, 1)
                           : environmentRadiance(scene, lights, direction, {}, 1);
  const float length =
      hit ? path.optical.length : path.optical.at(lengthFromInfinity(scene, path.ray.origin, direction));
  out.add(out.pathClasses().lightStart(), path.state, path.throughput * radiance, length);
}

} // namespace recurse
