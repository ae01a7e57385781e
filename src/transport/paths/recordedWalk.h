/** @file
 * Recording of the vertices that a Walker finds from a light.
 */
#pragma once

#include "recurse/model/scene/scene.h"
#include "recurse/transport/integrator/lightPathRecorder.h"
#include "transport/paths/pathVertex.h"

namespace recurse {

/** Light path of a Walker. Does nothing if its path is not recorded. */
class RecordedWalk {
 public:
  /** `list`: null if nothing is recorded; `scale`: factor from throughputs to recorded fluxes. */
  RecordedWalk(std::vector<RecordedLightVertex>* list, float scale) : scale(scale) {
    if (list) end = RecordedLightPath(*list);
  }

  /** Light path with this number; `recorder` may be null. */
  RecordedWalk(LightPathRecorder* recorder, uint64_t number, float scale)
      : RecordedWalk(recorder ? recorder->listFor(number) : nullptr, scale) {}

  void start(const LightSubpath& path) {
    add(LightVertexKind::START, path, path.ray.origin, path.throughput);
  }
  /** Adds a vertex on arrival, before the walk scatters there. */
  void arrive(const LightSubpath& path, const LightVertex& vertex, bool stored) {
    add(vertex.medium ? LightVertexKind::MEDIUM : LightVertexKind::SURFACE, path, vertex.point().position,
        vertex.throughput, stored);
  }
  /** Callback of Walker::next(): adds the point where a ray that hits nothing has left the scene. */
  auto escape(const LightSubpath& path, const Scene& scene) {
    return [this, &path, &scene](const Hit* hit) {
      if (!hit) add(LightVertexKind::ESCAPE, path, path.ray.at(2 * scene.bounds().radius), path.throughput);
    };
  }

 private:
  void add(LightVertexKind kind, const LightSubpath& path, const Vec3f& position, const Rgb& flux,
           bool stored = false) {
    if (!end) return;
    const PathEvent event = path.delta ? PathEvent::S : end.isInMedium() ? PathEvent::V : PathEvent::D;
    end.add(kind, event, position, flux * scale, path.state, stored);
  }

  float scale;
  RecordedLightPath end;
};

} // namespace recurse
