/** @file
 * Search for the open edges of medium boundaries. An edge that two pieces share is closed; around each
 * remaining one, rays test whether both sides of the surface are connected.
 */
#include "model/builder/openBoundaries.h"

#include <algorithm>

#include "model/mesh/singles.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/model/scene/surroundingMedium.h"

namespace recurse {

namespace {

/** A piece of a boundary's rim, in the scene. */
struct OpenPiece {
  RimPiece piece;
  const ShapeDescription* of;
  size_t shape; ///< number of the shape in scene order
};

std::array<float, 6> endsOf(const OpenPiece& open) {
  const auto numbers = [](const Vec3f& v) { return std::array{v.x, v.y, v.z}; };
  const auto [a, b] = std::minmax({numbers(open.piece.from), numbers(open.piece.to)});
  return {a[0], a[1], a[2], b[0], b[1], b[2]};
}

/** True where the segment between two points stays in the same medium. */
bool staysInMedium(const Scene& scene, const Vec3f& from, const Vec3f& to) {
  constexpr int MAX_SURFACES = 16;
  const float distance = glm::distance(from, to);
  if (!(distance > 0)) return true;
  Ray ray{from, (to - from) / distance, distance, 0};
  Hit hit;
  for (int i = 0; i < MAX_SURFACES && scene.intersectPosition(ray, hit); ++i) {
    if (hit.media.isBoundary() || isOpaque(hit.material)) return false;
    ray = rayBehind(ray, hit);
    if (!(ray.tMax > 0)) break;
  }
  return true;
}

/** True where a loop of rays around the middle of the edge connects both sides of the surface. */
bool isOpen(const Scene& scene, const RimPiece& piece) {
  constexpr double NEAR = 0.01;        // loop radius over edge length and over surface width
  constexpr double RESOLVED = 0x1p-20; // least loop radius over the coordinates
  constexpr double FIRST = 0.2;        // start angle off the surface [rad]
  constexpr int STEPS = 6;
  const Vec3d from = piece.from, middle = 0.5 * (from + Vec3d(piece.to)), along = Vec3d(piece.to) - from;
  const double length = glm::length(along);
  if (!(length > 0)) return true;
  const Vec3d axis = along / length, inner = Vec3d(piece.inner) - middle;
  const Vec3d inwards = inner - axis * glm::dot(inner, axis);
  const double width = glm::length(inwards);
  if (!(width > 0)) return false; // no surface to go around
  const double radius = std::max(NEAR * std::min(length, width), RESOLVED * glm::length(middle));
  const Vec3d x = inwards * (radius / width), y = glm::cross(axis, x);
  const auto at = [&](int step) {
    const double angle = FIRST + (2 * M_PI - 2 * FIRST) * step / STEPS;
    return Vec3f(middle + x * std::cos(angle) + y * std::sin(angle));
  };
  for (int i = 0; i < STEPS; ++i)
    if (!staysInMedium(scene, at(i), at(i + 1))) return false;
  return true;
}

/** Result of the search for open edges of a boundary. */
struct OpenEdges {
  size_t count = 0;
  bool all = true;                  ///< every edge was tested; else a selection
  const OpenPiece* first = nullptr; ///< open edge of the first shape in scene order
};

/** Tests at most `most` edges, evenly chosen. */
OpenEdges findOpen(const Scene& scene, const std::vector<OpenPiece>& pieces, size_t most) {
  const size_t looked = std::min(pieces.size(), most), tasks = std::min<size_t>(looked, 64);
  const auto piece = [&](size_t i) -> const OpenPiece& { return pieces[i * pieces.size() / looked]; };
  std::vector<OpenEdges> found(tasks);
  parallelFor(tasks, [&](size_t task) {
    OpenEdges& own = found[task];
    for (size_t i = looked * task / tasks; i < looked * (task + 1) / tasks; ++i) {
      if (!isOpen(scene, piece(i).piece)) continue;
      ++own.count;
      if (!own.first || piece(i).shape < own.first->shape) own.first = &piece(i);
    }
  });
  OpenEdges sum;
  sum.all = looked == pieces.size();
  for (const OpenEdges& own : found) {
    sum.count += own.count;
    if (own.first && (!sum.first || own.first->shape < sum.first->shape)) sum.first = own.first;
  }
  return sum;
}

} // namespace

void warnOfOpenBoundaries(const Scene& scene, const ShapeGroups& shapes, const SceneMedia& media,
                          Diagnostics& diagnostics) {
  if (!scene.hasMedia()) return;
  std::map<std::pair<uint16_t, uint16_t>, std::vector<OpenPiece>> boundaries;
  size_t shapeCount = 0;
  const auto addGroup = [&](const ShapeGroups::Group& group, const Mat4d& sceneFromGroup) {
    std::map<std::pair<uint16_t, uint16_t>, std::vector<OpenPiece>> own;
    for (const ShapeGroups::Placed& p : group.placed) {
      if (!p.media.isBoundary() || isOpaque(p.material)) continue;
      ++shapeCount;
      auto& pieces = own[std::minmax({p.media.inside, p.media.outside})];
      for (const RimPiece& piece : p.shape->rim()) pieces.push_back({piece, p.from, shapeCount});
    }
    for (auto& [pair, pieces] : own) {
      keepSingles(pieces, endsOf);
      for (OpenPiece& open : pieces)
        for (Vec3f* point : {&open.piece.from, &open.piece.to, &open.piece.inner})
          *point = Vec3f(transformPoint(sceneFromGroup, Vec3d(*point)));
      auto& all = boundaries[pair];
      all.insert(all.end(), pieces.begin(), pieces.end());
    }
  };
  addGroup(shapes.groups().front(), Mat4d(1));
  std::vector<bool> isPlaced(shapes.groups().size(), false);
  for (const ShapeGroups::Instance& i : shapes.instances()) {
    if (isPlaced[i.group]) continue;
    isPlaced[i.group] = true;
    addGroup(shapes.groups()[i.group], shapes.sceneFromGroup(i).first());
  }
  constexpr size_t MOST_EDGES = 1 << 16; // some six rays for each; bounds the time for any scene
  const size_t most = std::max<size_t>(1, MOST_EDGES / std::max<size_t>(1, boundaries.size()));
  for (const auto& [pair, pieces] : boundaries) {
    const OpenEdges open = findOpen(scene, pieces, most);
    if (open.first)
      diagnostics.warning(open.first->of->shape.location,
                          "the boundary between " + media.title(pair.first) + " and " +
                              media.title(pair.second) + " is not closed: " + (open.all ? "" : "at least ") +
                              std::to_string(open.count) +
                              (open.count == 1 ? " edge is open" : " edges are open"),
                          "shapes that enclose the medium, together or with opaque surfaces");
  }
}

} // namespace recurse
