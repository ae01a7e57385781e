/** @file
 * The walk: one loop that follows paths from either end through surfaces and media. Its caller gets one
 * vertex at a time, until next() or scatter() returns false.
 */
#pragma once

#include "transport/paths/pathVertex.h"
#include "transport/paths/walk.h"

namespace recurse {

/** Camera subpath before its first intersection. */
inline CameraSubpath startCameraSubpath(const Scene& scene, const PathClasses& classes, const CameraRay& ray,
                                        TransportCounts& counts) {
  CameraSubpath path;
  path.ray = ray;
  path.from = ray.origin;
  path.state = classes.cameraStart();
  path.nesting = nestingAt(scene, ray, counts);
  path.nesting.startIn(scene.cameraMedium());
  path.optical.index = indexAtStart(scene, classes, ray, path.nesting, counts);
  path.width = ray.width;
  path.spread = ray.spread;
  path.sampleSpacing = ray.sampleSpacing;
  path.delta = true; // emission seen directly has no other technique
  return path;
}

/** What a walk does in media. */
enum class InMedia {
  SCATTER, ///< samples scattering events
  PASS,    ///< passes them; the callback `flight` of next() attenuates the path
  IGNORE
};

template <class State> class Walker {
 public:
  using Path = Subpath<State>;
  using Vertex = PathVertex<State>;

  /** `maxDepth`: maximum scattering events; -1: no limit. */
  Walker(const Scene& scene, const PathClasses& classes, TransportCounts& counts, int maxDepth,
         InMedia inMedia = InMedia::SCATTER)
      : scene(scene), classes(classes), counts(counts), maxDepth(maxDepth),
        scatters(inMedia == InMedia::SCATTER), media(inMedia != InMedia::IGNORE && scene.hasMedia()) {}

  /**
   * Follows the ray to the next scattering event, at a surface or in a medium. Calls emission(const Hit*) for
   * each emitting surface on the way, the vertex itself included, and with null when the ray leaves the
   * scene; calls mediumEmission(Rgb) with the radiance of a medium on the way, times the throughput; calls
   * flight(uint16_t, float) before each flight through a medium, with its index and the distance to the next
   * surface. Returns false if the path ends.
   */
  template <class Emission = Ignore, class MediumEmission = Ignore, class Flight = Ignore>
  bool next(Path& path, Vertex& vertex, Sampler& sampler, Emission&& emission = {},
            MediumEmission&& mediumEmission = {}, Flight&& flight = {}) {
    for (;;) {
      const bool isHit = intersect(scene, path.ray, vertex.hit, counts);
      vertex.medium = nullptr;
      if (media && isHit) path.nesting.approach(vertex.hit, path.ray.direction);
      if (media) {
        const bool isEvent =
            sampleMedium(path, vertex, isHit ? vertex.hit.t : INFINITE, sampler, mediumEmission, flight);
        if (isBlack(path.throughput) || (isEvent && endsByDepth(path))) return false;
        if (isEvent) {
          arriveInMedium(path, vertex);
          return true;
        }
      }
      if (!isHit) {
        emission(nullptr);
        return false;
      }
      path.optical.travel(vertex.hit.t);
      if (vertex.hit.areaLight) emission(&vertex.hit);
      path.width += path.spread * vertex.hit.t;
      if (path.needed && vertex.hit.material && !(vertex.hit.material->lobes() & path.needed)) return false;
      arena.reset();
      const Footprint footprint =
          path.width > 0 ? Footprint{path.ray.direction, path.width * path.sampleSpacing} : Footprint();
      drawWavelength(scene, path.wavelength, sampler, vertex.hit);
      const Bsdf* bsdf = bsdfAt(scene, vertex.hit, path.ray.direction, footprint, path.nesting, arena);
      if (bsdf) {
        if (endsByDepth(path)) return false;
        arrive(path, vertex, *bsdf);
        return true;
      }
      path.nesting.enterMedium(vertex.hit, path.ray.direction);
      path.ray = rayBehind(path.ray, vertex.hit);
    }
  }
  /** Samples the next direction from the BSDF or the phase function, then applies Russian roulette. Returns
   * nullopt if the path ends. At a surface a light path survives by the ratio of its flux to `keptPart`
   * times the flux on arrival, a camera path by its throughput. */
  std::optional<Scatter> scatter(Path& path, const Vertex& vertex, Sampler& sampler,
                                 float keptPart = 1) const {
    if (vertex.medium) return scatterInMedium(path, vertex, sampler);
    const auto s = vertex.scattering->scatter(vertex.wi, TRANSPORT, sampler, vertex.allowed);
    if (!s) return {};
    const float before = maxComponent(path.throughput);
    applyWeight(path, vertex, *s);
    if (isBlack(path.throughput)) return {};
    // The survival of light paths keeps fluxes nearly equal.
    const float chance = maxComponent(path.throughput) / (before * keptPart);
    if (!survives(path, chance, sampler)) return {};
    spawnRay(path, vertex, *s);
    return s;
  }

  /** Continues with a scattering event that the caller has chosen. */
  void follow(Path& path, const Vertex& vertex, const Scatter& s) const {
    applyWeight(path, vertex, s);
    spawnRay(path, vertex, s);
  }

 private:
  static constexpr bool IS_LIGHT = std::is_same_v<State, LightState>;
  static constexpr Transport TRANSPORT = IS_LIGHT ? Transport::FLUX : Transport::RADIANCE;

  /** Russian roulette: light paths survive with probability `chance`, camera paths by their throughput. */
  static bool survives(Path& path, float chance, Sampler& sampler) {
    return IS_LIGHT ? russianRoulette(std::min(1.0f, chance), path.depth, sampler, path.throughput)
                    : cameraRoulette(path.etaScale, path.depth, sampler, path.throughput);
  }
  bool endsByDepth(Path& path) const {
    if (path.depth == maxDepth) {
      if (!IS_LIGHT) counts.truncatedThroughput += double(maxComponent(path.throughput));
      return true;
    }
    ++path.depth;
    return false;
  }

  /** True if the medium scatters before `end`. The event is at vertex.hit.point. The throughput is black
   * where the path is absorbed. */
  template <class MediumEmission, class Flight>
  bool sampleMedium(Path& path, Vertex& vertex, float end, Sampler& sampler, MediumEmission&& emission,
                    Flight&& flight) const {
    const uint16_t number = path.nesting.medium(scene);
    const Medium* medium = scene.medium(number);
    if (!medium) return false;
    flight(number, end);
    if (!scatters) return false;
    const float before = channelSum(path.throughput);
    const Collision c =
        sampleCollision(*medium, path.ray, end, path.hero,
                        IS_LIGHT ? Absorption::SAMPLED : Absorption::EXPECTED, sampler, path, emission);
    if (!c.scatters || isBlack(path.throughput)) return false;
    // The mean of the channels keeps fluxes nearly equal: it is constant where single channels fluctuate with
    // their densities.
    vertex.survival = channelSum(path.throughput) / before;
    vertex.medium = medium;
    vertex.hit = Hit();
    vertex.hit.point = pointInMedium(path.ray, c.t);
    vertex.hit.t = c.t;
    path.optical.travel(c.t);
    return staysNear(path, *medium, vertex.hit.point.position, sampler);
  }

  /** Russian roulette in a medium without end. A path that diffuses at distance r from the scene comes back
   * to a sphere of radius R with probability R / r at most, the solution of Laplace's equation outside of the
   * sphere, and survives the first arrival at r with this probability. The sphere contains the scene, and the
   * medium around it up to the depth to which light reaches the camera. */
  bool staysNear(Path& path, const Medium& medium, const Vec3f& position, Sampler& sampler) const {
    constexpr float VISIBLE = 4; // depth to which the medium is seen [mean free paths]
    const SceneBounds& bounds = scene.bounds();
    const float distance = glm::distance(position, bounds.center);
    if (distance <= bounds.radius) return true;
    const float extinction = maxComponent(medium.at(position).extinction());
    const float farther = distance / (bounds.radius + VISIBLE / extinction);
    if (farther <= path.farthest) return true;
    const float chance = path.farthest / farther;
    path.farthest = farther;
    if (russianRoulette(chance, path.depth, sampler, path.throughput)) return true;
    path.throughput = BLACK;
    return false;
  }

  void arriveInMedium(const Path& path, Vertex& vertex) const {
    vertex.scattering.reset();
    vertex.guide = nullptr;
    vertex.wi = -path.ray.direction;
    vertex.throughput = path.throughput;
    vertex.state = path.state;
    vertex.afterD = vertex.afterS = classes.step(path.state, PathEvent::V);
    vertex.allowed = classes.dead(vertex.afterD) ? NO_LOBE : REFLECTION;
    vertex.depth = path.depth;
  }

  std::optional<Scatter> scatterInMedium(Path& path, const Vertex& vertex, Sampler& sampler) const {
    if (vertex.allowed == NO_LOBE) return {};
    const PhaseFunction& phase = *vertex.medium->phase;
    const Vec3f& direction = path.ray.direction;
    const Vec2f u = sampler.next2D();
    Scatter s;
    float byGuide = 0;
    if (vertex.guide && sampler.next1D() >= vertex.guide->bsdfProbability())
      s.direction = vertex.guide->sample(u, byGuide);
    else
      s.direction = phase.sample(direction, u);
    const float f = phase.value(glm::dot(direction, s.direction));
    s.pdf = vertex.guide ? vertex.guide->mixturePdf(f, s.direction) : f;
    s.lobe = REFLECTION;
    if (!(s.pdf > 0) || !(f > 0)) return {};
    s.weight = Rgb(f / s.pdf);
    s.rouletteScale = s.pdf / f;
    path.throughput *= s.weight;
    path.etaScale *= s.rouletteScale;
    if (!survives(path, vertex.survival, sampler)) return {};
    path.state = vertex.afterD;
    path.delta = false;
    path.pdf = double(s.pdf);
    path.parallel = false;
    path.from = vertex.hit.point.position;
    path.cosine = 1;
    path.lightPdf = path.pathPdf;
    path.width = path.spread = 0;
    path.ray = spawn(vertex.hit.point, s.direction);
    return s;
  }

  void arrive(const Path& path, Vertex& vertex, const Bsdf& bsdf) const {
    const SurfacePoint& point = vertex.hit.point;
    vertex.scattering.emplace(bsdf, point);
    vertex.wi = -path.ray.direction;
    vertex.throughput = path.throughput;
    vertex.state = path.state;
    const SurfaceKind kind = surfaceKind(classes, vertex.hit);
    vertex.afterD = classes.step(path.state, PathEvent::D, kind);
    vertex.afterS = classes.step(path.state, PathEvent::S, kind);
    vertex.allowed = LobeSet((classes.dead(vertex.afterD) ? NO_LOBE : NON_DELTA_LOBES) |
                             (classes.dead(vertex.afterS) ? NO_LOBE : DELTA_LOBES));
    vertex.depth = path.depth;
    const double perDistance2 = inverseDistance2(point.position, path.from);
    vertex.pdf =
        path.pdf * double(absDot(vertex.wi, point.geometricNormal)) * (path.parallel ? 1 : perDistance2);
    vertex.toPrevious = path.parallel ? 1 : double(path.cosine) * perDistance2;
  }

  void applyWeight(Path& path, const Vertex& vertex, const Scatter& s) const {
    path.throughput *= s.weight;
    path.state = s.specular() ? vertex.afterS : vertex.afterD;
    path.etaScale *= square(s.eta) * s.rouletteScale;
    path.optical.scatter(s.eta);
  }

  void spawnRay(Path& path, const Vertex& vertex, const Scatter& s) const {
    path.delta = s.specular();
    path.throughput *= dispersedColour(vertex.point(), s, path.wavelength);
    const bool all = (vertex.scattering->lobes() & ~vertex.allowed & ALL_LOBES) == 0;
    path.pdf = path.delta ? 1 : all ? double(s.pdf) : vertex.pdfDirection(s.direction);
    path.parallel = false;
    path.from = vertex.hit.point.position;
    path.cosine = absDot(s.direction, vertex.hit.point.geometricNormal);
    path.nesting.scatters(vertex.hit, vertex.wi, s.direction);
    if (media && !passesPane(scene, *vertex.scattering, s)) path.lightPdf = path.pathPdf;
    if (!path.delta) path.width = path.spread = 0; // the footprint after a non-delta event is unknown
    path.ray = spawn(vertex.hit.point, s.direction);
  }

  const Scene& scene;
  const PathClasses& classes;
  TransportCounts& counts;
  int maxDepth;
  bool scatters, media;
  BsdfArena arena;
};

using CameraWalker = Walker<CameraState>;

} // namespace recurse
