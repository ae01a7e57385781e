/** @file
 * Camera paths on a grid over the film, for learning before a render.
 */
#pragma once

#include <vector>

#include "recurse/core/threads/parallel.h"
#include "transport/paths/walker.h"

namespace recurse {

/** Starts a camera path at the centre of each of resolution x resolution cells of the film, and passes it to
 * follow(row, path, walker, sampler, counts) with the results of its row of cells. Rows are followed in
 * parallel; their results are returned in order. `maxDepth`: maximum scattering events of a path. */
template <class Row, class Follow>
std::vector<Row> followCameraPaths(const Scene& scene, int resolution, int maxDepth, uint64_t seed,
                                   TransportCounts& counts, const Row& empty, const Follow& follow,
                                   InMedia inMedia = InMedia::IGNORE) {
  const PathClasses allPaths;
  std::vector<Row> rows(static_cast<size_t>(resolution), empty);
  std::vector<TransportCounts> rowCounts(rows.size());
  const PixelBounds film = scene.film().whole();
  parallelFor(rows.size(), [&](size_t y) {
    CameraWalker walker(scene, allPaths, rowCounts[y], maxDepth, inMedia);
    for (int x = 0; x < resolution; ++x) {
      Sampler sampler(seed, y, static_cast<uint32_t>(x));
      CameraSample sample;
      sample.film = film.middleOfCell(x, static_cast<int>(y), resolution);
      if (scene.moves()) sample.time = scene.camera().timeAt(sampler.next1D());
      const std::optional<CameraRay> ray = scene.camera().validRay(sample);
      if (!ray) continue;
      CameraSubpath path = startCameraSubpath(scene, allPaths, *ray, rowCounts[y]);
      follow(rows[y], path, walker, sampler, rowCounts[y]);
    }
  });
  for (TransportCounts& c : rowCounts) {
    c.truncatedThroughput = 0; // it is not missing in the picture
    counts.add(c);
  }
  return rows;
}

/** Follows camera paths as followCameraPaths() does, with rows that are lists; returns their items as one
 * list. */
template <class Item, class Follow>
std::vector<Item> collectFromCameraPaths(const Scene& scene, int across, int maxDepth, uint64_t seed,
                                         TransportCounts& counts, const Follow& follow,
                                         InMedia inMedia = InMedia::IGNORE) {
  using Items = std::vector<Item>;
  Items all;
  for (const Items& row : followCameraPaths(scene, across, maxDepth, seed, counts, Items(), follow, inMedia))
    all.insert(all.end(), row.begin(), row.end());
  return all;
}

/** Calls add(items, path, vertex), which may append items, at each vertex of the paths of
 * collectFromCameraPaths(). */
template <class Item, class Add>
std::vector<Item> collectAtCameraVertices(const Scene& scene, int across, int maxDepth, uint64_t seed,
                                          TransportCounts& counts, const Add& add) {
  const auto follow = [&](std::vector<Item>& items, CameraSubpath& path, CameraWalker& walker,
                          Sampler& sampler, TransportCounts&) {
    CameraVertex vertex;
    while (walker.next(path, vertex, sampler)) {
      add(items, path, vertex);
      if (!walker.scatter(path, vertex, sampler)) break;
    }
  };
  return collectFromCameraPaths<Item>(scene, across, maxDepth, seed, counts, follow);
}

} // namespace recurse
