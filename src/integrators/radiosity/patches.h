/** @file
 * Matt surfaces cut into patches, for radiosity: which patch a hit lies on, what is interpolated there, and
 * points of a patch. Triangles of meshes are cut into equal ones, faces of other shapes along their
 * coordinates.
 */
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "recurse/model/scene/scene.h"

namespace recurse {

/** A place on a patch, with the parts that the patch's corners have in it. */
struct PatchPoint {
  uint32_t patch = 0;
  std::array<uint32_t, 3> corners{};
  std::array<float, 3> weights{};
};

class Patches {
 public:
  /** Cuts all that can be cut; edges are no longer than `longestEdge` [scene units; 0: as makes thousands of
   * patches]. Throws Error where that makes too many. */
  void dice(const Scene& scene, float longestEdge);

  size_t count() const { return faceOfPatch.size(); }
  size_t faceCount() const { return faces.size(); }
  float longestEdge() const { return size; }
  /** Shapes that are not cut: no matt surface, or none that can be. */
  size_t ignoredShapes() const { return ignored; }
  /** Corners of neighbours in nearly the same plane are one. */
  size_t cornerCount() const { return sharedCornerCount; }

  /** Empty where the surface is not cut. */
  std::optional<PatchPoint> find(const Hit& hit) const;
  /** Of what is not transparent by alpha. */
  float area(uint32_t patch) const { return areas[patch]; }
  std::array<uint32_t, 3> corners(uint32_t patch) const;
  /** A point of what is not transparent by alpha, uniform in the surface's coordinates. */
  SurfacePoint sample(uint32_t patch, Sampler& sampler) const;

 private:
  /** Part of a cell of a face's grid: below or above its diagonal. */
  struct Cell {
    uint32_t i = 0, j = 0;
    bool upper = false;
    /** Grid coordinates of its corners. */
    std::array<glm::uvec2, 3> corners() const {
      if (upper) return {glm::uvec2(i + 1, j), {i, j + 1}, {i + 1, j + 1}};
      return {glm::uvec2(i, j), {i + 1, j}, {i, j + 1}};
    }
  };
  /** A triangle, or a face by its coordinates, with a grid on it. */
  struct Face {
    const Shape* shape = nullptr;
    uint32_t number = 0; ///< primitive of a mesh, or face of another shape
    bool isTriangle = false;
    glm::uvec2 divisions{1};
    uint32_t firstPatch = 0, firstCorner = 0;

    uint32_t patchCount() const { return (isTriangle ? 1 : 2) * divisions.x * divisions.y; }
    uint32_t cornerCount() const {
      return isTriangle ? (divisions.x + 1) * (divisions.x + 2) / 2 : (divisions.x + 1) * (divisions.y + 1);
    }
    uint32_t corner(const glm::uvec2& at) const;
    uint32_t patch(const Cell& cell) const;
    Cell cell(uint32_t patch) const;
    Vec2d coordinates(const Hit& hit) const;
    SurfacePoint pointAt(const Vec2d& uv) const;
    Vec2d atGrid(const glm::uvec2& corner) const { return Vec2d(corner) / Vec2d(divisions); }
    /** Divisions along each coordinate into pieces that are short enough and nearly flat. */
    Vec2d pieces(double longestEdge) const;
  };
  std::array<Vec2d, 3> cornerCoordinates(uint32_t patch) const;
  /** All faces that are cut, not yet divided; `firstFace` becomes known. */
  std::vector<Face> facesOf(const Scene& scene);
  void requireFew(double longestEdge) const;
  void cut(double maxDivisions);
  float opaqueArea(uint32_t patch) const;
  void shareCorners();

  float size = 0;
  size_t ignored = 0;
  std::vector<Face> faces;
  std::vector<int> firstFace; ///< of each shape of the scene; -1: it is not cut
  std::vector<uint32_t> faceOfPatch;
  std::vector<float> areas;
  std::vector<uint32_t> sharedCorner; ///< of each face's corners
  uint32_t sharedCornerCount = 0;
};

} // namespace recurse
