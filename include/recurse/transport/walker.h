/** @file
 * The walk: one loop follows paths from either end through surfaces, and hands its caller a vertex at a time.
 *
 *     for (Vertex v; walker.next(path, v, onEmission);) {
 *       ... store, connect, gather, shadow rays ...
 *       if (!walker.scatter(path, v, sampler)) break;
 *     }
 */
#pragma once

#include "recurse/transport/pathVertex.h"
#include "recurse/transport/walk.h"

namespace recurse {

/** A camera subpath before its first step. */
inline CameraSubpath startCameraSubpath(const Scene& scene, const PathClasses& classes, const CameraRay& ray,
                                        TransportCounts& counts) {
  CameraSubpath path;
  path.ray = ray;
  path.from = ray.origin;
  path.state = classes.cameraStart();
  path.nesting = nestingAt(scene, ray, counts);
  path.width = ray.width;
  path.spread = ray.spread;
  path.sampleSpacing = ray.sampleSpacing;
  path.delta = true; // nothing else finds what is seen directly
  return path;
}

template <class State> class Walker {
 public:
  using Path = Subpath<State>;
  using Vertex = PathVertex<State>;

  /** `maxDepth`: most scattering events of a path; -1: no limit. */
  Walker(const Scene& scene, const PathClasses& classes, TransportCounts& counts, int maxDepth)
      : scene(scene), classes(classes), counts(counts), maxDepth(maxDepth) {}

  /**
   * Follows the ray to the next surface that scatters. Calls emission(const Hit*) for each surface on the way
   * that emits, the vertex itself included, and with null when the ray leaves the scene. False: the path
   * ends.
   */
  template <class Emission> bool next(Path& path, Vertex& vertex, Emission&& emission) {
    for (;;) {
      if (!intersect(scene, path.ray, vertex.hit, counts)) {
        emission(nullptr);
        return false;
      }
      if (vertex.hit.areaLight) emission(&vertex.hit);
      path.width += path.spread * vertex.hit.t;
      arena.reset();
      const Footprint footprint =
          path.width > 0 ? Footprint{path.ray.direction, path.width * path.sampleSpacing} : Footprint();
      drawWavelength(scene, path.ray, path.wavelength, vertex.hit);
      const Bsdf* bsdf = bsdfAt(scene, vertex.hit, path.ray.direction, footprint, path.nesting, arena);
      if (bsdf) {
        if (path.depth == maxDepth) {
          counts.truncatedThroughput += double(maxComponent(path.throughput));
          return false;
        }
        ++path.depth;
        arrive(path, vertex, *bsdf);
        return true;
      }
      path.ray = spawn(vertex.hit.point, path.ray.direction);
    }
  }
  bool next(Path& path, Vertex& vertex) {
    return next(path, vertex, [](const Hit*) {});
  }

  /** Goes on by a direction that the BSDF chooses, and by roulette. False: the path ends. */
  std::optional<Scatter> scatter(Path& path, const Vertex& vertex, Sampler& sampler) const {
    constexpr Transport TRANSPORT = WalkSide<State>::TRANSPORT;
    const auto s = vertex.scattering->scatter(vertex.wi, TRANSPORT, sampler, vertex.allowed);
    if (!s) return {};
    const float before = maxComponent(path.throughput);
    take(path, vertex, *s);
    if (isBlack(path.throughput)) return {};
    const float chance = TRANSPORT == Transport::FLUX
                             ? maxComponent(path.throughput) / before // keeps photons alike
                             : maxComponent(path.throughput) * path.etaScale;
    const bool roulette = TRANSPORT == Transport::FLUX || path.depth > ROULETTE_FREE_DEPTH;
    if (roulette && !russianRoulette(std::min(1.0f, chance), path.depth, sampler, path.throughput)) return {};
    goOn(path, vertex, *s);
    return s;
  }

  /** Goes on by a step that the caller has chosen. */
  void follow(Path& path, const Vertex& vertex, const Scatter& s) const {
    take(path, vertex, s);
    goOn(path, vertex, s);
  }

 private:
  /** Short camera walks are not gambled with: most of the light is there. */
  static constexpr int ROULETTE_FREE_DEPTH = 2;

  void arrive(const Path& path, Vertex& vertex, const Bsdf& bsdf) const {
    const SurfacePoint& point = vertex.hit.point;
    vertex.scattering.emplace(bsdf, point);
    vertex.wi = -path.ray.direction;
    vertex.throughput = path.throughput;
    vertex.state = path.state;
    vertex.afterD = classes.step(path.state, PathEvent::D);
    vertex.afterS = classes.step(path.state, PathEvent::S);
    vertex.allowed = LobeSet((classes.dead(vertex.afterD) ? NO_LOBE : NON_DELTA_LOBES) |
                             (classes.dead(vertex.afterS) ? NO_LOBE : DELTA_LOBES));
    vertex.depth = path.depth;
    const double perDistance2 = 1 / double(lengthSquared(point.position - path.from));
    vertex.pdf =
        path.pdf * double(absDot(vertex.wi, point.geometricNormal)) * (path.parallel ? 1 : perDistance2);
    vertex.toPrevious = path.parallel ? 1 : double(path.cosine) * perDistance2;
  }

  void take(Path& path, const Vertex& vertex, const Scatter& s) const {
    path.throughput *= s.weight;
    path.state = s.specular() ? vertex.afterS : vertex.afterD;
    path.etaScale *= square(s.eta);
  }

  void goOn(Path& path, const Vertex& vertex, const Scatter& s) const {
    path.delta = s.specular();
    path.throughput *= dispersedColour(vertex.point(), s, path.wavelength);
    const bool all = (vertex.scattering->lobes() & ~vertex.allowed & ALL_LOBES) == 0;
    path.pdf = path.delta ? 1 : all ? double(s.pdf) : vertex.pdfDirection(vertex.wi, s.direction);
    path.parallel = false;
    path.from = vertex.hit.point.position;
    path.cosine = absDot(s.direction, vertex.hit.point.geometricNormal);
    path.nesting.scatters(vertex.hit, vertex.wi, s.direction);
    if (!path.delta) path.width = path.spread = 0; // what a pixel sees from here on is not known
    path.ray = spawn(vertex.hit.point, s.direction);
  }

  const Scene& scene;
  const PathClasses& classes;
  TransportCounts& counts;
  int maxDepth;
  BsdfArena arena;
};

} // namespace recurse
