/** @file
 * Record of light paths of a forward pass: their vertices, from the light on. A light path may branch.
 */
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "recurse/core/math/rgb.h"
#include "recurse/core/math/vector.h"
#include "recurse/model/bsdf/bsdf.h"
#include "recurse/pathclasses/pathClasses.h"

namespace recurse {

/** Index of a missing entry of a record. */
constexpr int NOT_RECORDED = -1;

/** Kind of a vertex of a light path. */
enum class LightVertexKind : uint8_t {
  START,   ///< emission: on the light, or outside of the scene for an infinite light
  SURFACE, ///< arrival at a surface that scatters
  MEDIUM,  ///< scattering in a medium
  ESCAPE   ///< a point outside of the scene, on a ray that hits nothing
};

/** Vertex of a light path. */
struct RecordedLightVertex {
  int previous = NOT_RECORDED; ///< index of the vertex that the light came from; none: a START
  LightVertexKind kind = LightVertexKind::START;
  PathEvent event = PathEvent::D;     ///< event at the previous vertex, unless that is a START
  Vec3f position{0};                  ///< [scene units], relative to Scene::origin()
  Rgb flux{0};                        ///< emitted or on arrival, divided by the number of light paths [W]
  LightState state{};                 ///< path-class state before this vertex's event
  bool stored = false;                ///< kept as a photon, a virtual light or a vertex for connections
  uint32_t object = 0;                ///< object of a SURFACE vertex, see Scene::objectName()
  const Material* material = nullptr; ///< null unless it is a SURFACE
  LobeSet lobes = NO_LOBE;            ///< all lobes of the BSDF
  LobeSet lobe = NO_LOBE;             ///< lobe of the event at the previous vertex; NO_LOBE after a START
  /** Density at the previous vertex of the direction to this one, and of the reverse direction from the
   * camera's side [1/sr]; 0: a delta, or parallel light. */
  float pdf = 0, pdfReverse = 0;
};

/** Record of every n-th light path of the latest forward pass. */
class LightPathRecorder {
 public:
  /** Records at most `limit` light paths. */
  explicit LightPathRecorder(uint64_t limit) : limit(limit) {}

  /** Starts the record of a pass with this number of light paths. */
  void beginPass(uint64_t pathCount) {
    list.clear();
    emitted = pathCount;
    step = limit > 0 ? std::max<uint64_t>(1, (pathCount + limit - 1) / limit) : 0;
  }
  /** Whether the light path with this number is recorded. */
  bool isRecorded(uint64_t path) const { return step > 0 && path % step == 0; }
  /** List for the vertices of the light path with this number; null if it is not recorded. All paths share
   * it: threads record into lists of their own, for append(). */
  std::vector<RecordedLightVertex>* listFor(uint64_t path) { return isRecorded(path) ? &list : nullptr; }
  /** Appends vertices whose indices `previous` refer to `vertices`. */
  void append(const std::vector<RecordedLightVertex>& vertices) {
    const int offset = static_cast<int>(list.size());
    for (RecordedLightVertex vertex : vertices) {
      if (vertex.previous != NOT_RECORDED) vertex.previous += offset;
      list.push_back(vertex);
    }
  }

  const std::vector<RecordedLightVertex>& vertices() const { return list; }
  /** Number of light paths of the pass. */
  uint64_t pathsEmitted() const { return emitted; }
  /** Number of recorded light paths, including those that emit nothing. */
  uint64_t pathsRecorded() const { return step > 0 ? (emitted + step - 1) / step : 0; }

 private:
  uint64_t limit, emitted = 0, step = 0;
  std::vector<RecordedLightVertex> list;
};

} // namespace recurse
