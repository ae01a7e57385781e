/** @file
 * Recording of the vertices that a Walker finds from a light.
 */
#pragma once

#include "recurse/model/scene/scene.h"
#include "recurse/transport/integrator/lightPathRecorder.h"
#include "transport/paths/pathVertex.h"

namespace recurse {

/** Light path of a Walker. Copies record branches of the path. Does nothing if its path is not recorded. */
class RecordedWalk {
 public:
  /** `list`: null if nothing is recorded; `scale`: factor from throughputs to recorded fluxes. */
  RecordedWalk(std::vector<RecordedLightVertex>* list, float scale) : list(list), scale(scale) {}

  /** Light path with this number; `recorder` may be null. */
  RecordedWalk(LightPathRecorder* recorder, uint64_t number, float scale)
      : RecordedWalk(recorder ? recorder->listFor(number) : nullptr, scale) {}

  void start(const LightSubpath& path) {
    add(LightVertexKind::START, path, path.ray.origin, path.throughput);
    if (!path.parallel) pdf = static_cast<float>(path.pdf);
  }
  /** Adds a vertex on arrival, before the walk scatters there. */
  void arrive(const LightSubpath& path, const LightVertex& vertex, bool stored) {
    add(vertex.medium ? LightVertexKind::MEDIUM : LightVertexKind::SURFACE, path, vertex.point().position,
        vertex.throughput, stored, &vertex);
  }
  /** Notes the event by which the walk leaves the latest vertex. */
  void leave(const LightVertex& vertex, const Scatter& s) {
    if (!list) [[likely]]
      return;
    lobe = s.lobe;
    pdf = s.specular() ? 0 : s.pdf;
    pdfReverse = s.specular() ? 0 : static_cast<float>(vertex.pdfReverse(s.direction));
  }
  /** Callback of Walker::next(): adds the point where a ray that hits nothing has left the scene. */
  auto escape(const LightSubpath& path, const Scene& scene) {
    return [this, &path, &scene](const Hit* hit) {
      if (!hit) add(LightVertexKind::ESCAPE, path, path.ray.at(2 * scene.bounds().radius), path.throughput);
    };
  }

 private:
  void add(LightVertexKind kind, const LightSubpath& path, const Vec3f& position, const Rgb& flux,
           bool stored = false, const LightVertex* at = nullptr) {
    if (!list) [[likely]]
      return;
    const bool fromMedium = last != NOT_RECORDED && (*list)[size_t(last)].kind == LightVertexKind::MEDIUM;
    RecordedLightVertex v{.previous = last,
                          .kind = kind,
                          .event = path.delta   ? PathEvent::S
                                   : fromMedium ? PathEvent::V
                                                : PathEvent::D,
                          .position = position,
                          .flux = flux * scale,
                          .state = path.state,
                          .stored = stored,
                          .lobe = lobe,
                          .pdf = pdf,
                          .pdfReverse = pdfReverse};
    if (kind == LightVertexKind::SURFACE) {
      v.object = at->hit.object;
      v.material = at->hit.material;
      v.lobes = at->scattering->lobes();
    }
    last = static_cast<int>(list->size());
    list->push_back(v);
  }

  std::vector<RecordedLightVertex>* list;
  float scale;
  int last = NOT_RECORDED; ///< index of the latest vertex in the list
  // Of the latest event:
  LobeSet lobe = NO_LOBE;
  float pdf = 0, pdfReverse = 0;
};

} // namespace recurse
