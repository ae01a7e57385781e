/** @file
 * Paths from the lights, kept for a pass: what camera paths are connected to and merged with.
 */
#pragma once

#include <vector>

#include "transport/emission/pathEnds.h"

namespace recurse {

/** A vertex of a light path as it is kept. */
struct StoredVertex {
  SurfacePoint point;
  const Material* material = nullptr;
  Vec3f wi;       ///< unit, towards where the light came from
  Rgb throughput; ///< flux that arrives, as if the path was the only one
  double fromCamera = 1, fromLight = 1, toPrevious = 1;
  LightState state, afterD;
  bool connectable = false;
  bool delta = false;    ///< the path went on by a delta lobe
  bool straight = false; ///< that of a thin pane, which shadow rays pass too
};

/** The vertices [first, first + count), in the order from the light. */
struct StoredPath {
  LightEnd end;
  double fromCamera = 1; ///< F_k, once there are two vertices
  size_t first = 0;
  uint32_t count = 0;
};

/** Light paths of a pass, those that met nothing included. */
struct LightSubpaths {
  std::vector<StoredPath> paths;
  std::vector<StoredVertex> vertices;

  void clear();
  /** Adds those of another list behind these. */
  void append(const LightSubpaths& more);
  size_t memoryBytes() const;
  const StoredVertex& vertex(const StoredPath& path, uint32_t number) const {
    return vertices[path.first + number - 1];
  }
  /** Whether the path comes from its light through a thin pane. */
  bool startsAtPane(const StoredPath& path) const { return path.count > 0 && vertex(path, 1).straight; }
  /** The way to the light of a path whose last vertex is y_count, seen from unit `towardsCamera`. */
  ShadowRayStart shadowRayStart(const StoredPath& path, uint32_t count, const Vec3f& towardsCamera) const;
  /** Writes y_count … y_1 and the end of the path, as the weights know them; at most `most` of these. */
  void appendDensities(const StoredPath& path, uint32_t count, uint32_t most,
                       std::vector<WeightedVertex>& x) const;
};

} // namespace recurse
