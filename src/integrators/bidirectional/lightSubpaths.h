/** @file
 * Light paths of a pass, stored for connections and merges with camera paths.
 */
#pragma once

#include <vector>

#include "transport/emission/pathEnds.h"

namespace recurse {

/** Stored vertex of a light path. */
struct StoredVertex {
  SurfacePoint point;
  const Material* material = nullptr;
  Vec3f wi;       ///< unit, back along the light path
  Rgb throughput; ///< flux on arrival, not divided by the number of paths
  /** F and B of WeightedVertex; PathVertex::toPrevious. F is set once the path has left the next vertex. */
  double fromCamera = 1, fromLight = 1, toPrevious = 1;
  LightState state, afterD; ///< on arrival; after a D event here
  bool connectable = false; ///< see PathVertex::isConnectable()
  bool delta = false;       ///< the path continued by a delta lobe
  bool straight = false;    ///< the delta lobe of a thin pane, which shadow rays pass too
};

/** Stored light path: the vertices [first, first + count), in order from the light. */
struct StoredPath {
  LightEnd end;
  double fromCamera = 1; ///< F_k; set once there are two vertices
  size_t first = 0;
  uint32_t count = 0;
};

/** Light paths of a pass, including those without a vertex. */
struct LightSubpaths {
  std::vector<StoredPath> paths;
  std::vector<StoredVertex> vertices;
  std::vector<float> lengths; ///< optical lengths up to the vertices; empty unless the render is transient

  void clear();
  /** Appends the paths of a second list. */
  void append(const LightSubpaths& more);
  size_t memoryBytes() const;
  const StoredVertex& vertex(const StoredPath& path, uint32_t number) const {
    return vertices[path.first + number - 1];
  }
  /** Optical length from the light to a vertex [scene units]; 0 unless the render is transient. */
  float length(const StoredPath& path, uint32_t number) const {
    return lengths.empty() ? 0 : lengths[path.first + number - 1];
  }
  /** Start of shadow rays to the light of a path that ends at y_count, seen from unit `towardsCamera`. */
  ShadowRayStart shadowRayStart(const StoredPath& path, uint32_t count, const Vec3f& towardsCamera) const;
  /** Appends the densities of y_count … y_1 and of the path's end for the weights. */
  void appendDensities(const StoredPath& path, uint32_t count, std::vector<WeightedVertex>& x) const;
};

} // namespace recurse
