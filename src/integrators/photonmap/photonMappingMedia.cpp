/** @file
 * Light of media along a camera path of the photon mapping estimator.
 */
#include "integrators/photonmap/photonMapping.h"

#include "transport/direct/lightAlongRay.h"

namespace recurse {

namespace {

constexpr uint32_t HERO_STREAM = 64; ///< fork number, distinct from the numbers of branches

/** Numbers of shadow rays in media. They are cheap, so there are more before the camera path's first surface,
 * where only a part of the ray may see the sun through a window, or a spotlight. */
RaysToLights raysToLights(int lightSamples, bool first) {
  constexpr int RAYS = 4; // more take a considerable part of a sample's time
  return {lightSamples, first ? RAYS * lightSamples : lightSamples};
}

/** Records a vertex in a medium on the path's ray. */
void recordScattering(const PathState& path, const Vec3f& position, const Rgb& throughput,
                      PathRecorder& recorder) {
  recorder.addVertex(
      {.step = path.recordedStep, .position = position, .inMedium = true, .throughput = throughput});
}

/** Sets the source of the next contribution to one photon at `position`, merged at the latest vertex.
 * `phase`: phase function for its direction [1/sr]. */
void recordMerge(const Vec3f& position, float phase, PathRecorder& recorder) {
  recorder.source = {.technique = PathTechnique::MERGE,
                     .vertex = recorder.source.vertex,
                     .end = position,
                     .vertexPdf = phase,
                     .vertexPdfReverse = phase};
}

} // namespace

void PhotonMapping::passMedium(const Scene& scene, PathState& path, uint16_t number, float end,
                               Sampler& sampler, PathRadiance& out) const {
  const RayTransmittance transmittance(*scene.medium(number), path.walk.ray, end, sampler);
  if (out.recorder) recordFlight(*out.recorder, path.recordedStep, path.walk.ray, end);
  // Where photons are stored, they include the emission of media.
  if (path.weights.byRays || settings.directLight)
    addLight(path, startInMedium(scene, out.pathClasses(), number), transmittance.emitted(),
             path.walk.optical.length, out);
  if (path.walk.depth != settings.maxDepth)
    addScattering(scene, path, number, end, transmittance, sampler, out);
  const float before = maxComponent(path.walk.throughput);
  path.walk.throughput *= transmittance.to(end);
  if (!isBlack(path.walk.throughput)) path.mediaScale *= before / maxComponent(path.walk.throughput);
}

void PhotonMapping::addScattering(const Scene& scene, const PathState& path, uint16_t number, float end,
                                  const RayTransmittance& transmittance, Sampler& sampler,
                                  PathRadiance& out) const {
  const CameraState camera = out.pathClasses().step(path.walk.state, PathEvent::V);
  const Rgb throughput = path.sharedThroughput() * path.weights.share;
  if (out.pathClasses().dead(camera) || isBlack(throughput)) return;
  const Medium& medium = *scene.medium(number);
  const Vec3f& direction = path.walk.ray.direction;
  addPhotonsAlong(path, number, medium, end, transmittance, throughput, camera, out);
  if (settings.directLight) return;
  CameraSubpath lit = path.walk;
  lit.hero = drawHero(sampler.fork(HERO_STREAM).next1D());
  const int panes = panesLeft(settings.maxDepth, path.walk.depth + 1);
  CameraVertex vertex;
  vertex.medium = &medium;
  vertex.wi = -direction;
  vertex.afterD = camera;
  const auto arrive = [&](float t) {
    vertex.hit.point = pointInMedium(path.walk.ray, t);
    lit.optical = path.walk.optical;
    lit.optical.travel(t);
    if (out.recorder) recordScattering(path, vertex.point().position, lit.throughput, *out.recorder);
  };
  if (!medium.isHomogeneous()) {
    static_cast<SpectralPath&>(lit) = {throughput};
    const Collision c = sampleCollision(medium, path.walk.ray, end, lit.hero, Absorption::SAMPLED, sampler,
                                        lit, [](const Rgb&) {});
    if (!c.scatters || isBlack(lit.throughput)) return;
    arrive(c.t);
    addSampledLightInMedia(scene, lights, {vertex.point().position}, lit, vertex, false,
                           settings.lightSamples, panes, sampler, out);
    return;
  }
  const Rgb scattering = medium.at(path.walk.ray.origin).scattering;
  if (isBlack(scattering) || !lightIsSampled(scene, out.pathClasses(), camera)) return;
  const RaysToLights rays = raysToLights(settings.lightSamples, path.walk.depth == 0);
  const auto addRay = [&](int which, Sampler& random) {
    const std::optional<LightAlongRay> s =
        sampleLightAlong(scene, lights, medium, path.walk.ray, end, rays, which, random);
    if (!s) return;
    static_cast<SpectralPath&>(lit) = {throughput * transmittance.to(s->t) * scattering};
    arrive(s->t);
    addLightInMedia(scene, lit, vertex, false, s->light, s->index, 1 / s->reciprocalPdf, panes, random, out);
  };
  int i = 0;
  for (; i < rays.area && !out.abandoned(); ++i) addRay(i, sampler);
  for (; i < rays.others && !out.abandoned(); ++i) {
    // A forked sampler keeps the random numbers of the path unchanged.
    Sampler raySampler = sampler.fork(HERO_STREAM + 1 + static_cast<uint32_t>(i));
    addRay(i, raySampler);
  }
}

void PhotonMapping::addPhotonsAlong(const PathState& path, uint16_t number, const Medium& medium, float end,
                                    const RayTransmittance& transmittance, const Rgb& throughput,
                                    CameraState camera, PathRadiance& out) const {
  const auto add = [&](const Vec3f& position, const Vec3f& flight, const Rgb& scattered, float t,
                       uint8_t pathState, float length) {
    const float f = medium.phase->value(-glm::dot(flight, path.walk.ray.direction));
    ++out.counts.photonsFound;
    const Rgb attenuated = throughput * transmittance.to(t);
    if (out.recorder) {
      recordScattering(path, path.walk.ray.at(t), attenuated, *out.recorder);
      recordMerge(position, f, *out.recorder);
    }
    out.add(LightState(pathState), camera, attenuated * scattered * f, path.walk.optical.at(t) + length);
  };
  const MediaPhotons& inMedia = photons.inMedia();
  inMedia.points.visitAlong(path.walk.ray, end, [&](const VolumePhoton& p, float t, float kernel) {
    if (p.medium != number) return;
    const Vec3f flight = unpackDirection(p.direction);
    add(p.position, flight, p.power * kernel, t, p.pathState,
        lengthNear(path.walk.ray.at(t), p.position, -flight, p.pathLength, path.walk.optical.index));
  });
  if (inMedia.beams.size() == 0 || !medium.isHomogeneous()) return;
  const MediumPoint point = medium.at(path.walk.ray.origin);
  const Rgb extinction = point.extinction(), relative = extinction - thinnest(extinction);
  inMedia.beams.visitAlong(path.walk.ray, end, [&](const PhotonBeam& b, float s, float t, float kernel) {
    if (b.medium == number)
      add(b.origin + s * b.direction, b.direction,
          b.power * flight::transmittance(relative, s) * point.scattering * kernel, t, b.pathState,
          b.pathLength + path.walk.optical.index * s);
  });
}

} // namespace recurse
