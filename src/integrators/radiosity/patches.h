/** @file
 * Subdivision of diffuse surfaces into patches for radiosity: lookup of the patch at a hit, interpolation
 * between its corners, and sampling of its points. Triangles of meshes are divided into equal triangles,
 * faces of other shapes along their surface coordinates.
 */
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "recurse/transport/integrator/integrator.h"

namespace recurse {

/** Point on a patch, with the interpolation weights of the patch's corners. */
struct PatchPoint {
  uint32_t patch = 0;
  std::array<uint32_t, 3> corners{};
  std::array<float, 3> weights{};
};

class Patches {
 public:
  /** Divides all suitable shapes into patches with edges up to `longestEdge` [scene units; 0: chosen to give
   * thousands of patches]. Throws Error if there would be too many patches. */
  void dice(const Scene& scene, float longestEdge);

  size_t count() const { return faceOfPatch.size(); }
  size_t faceCount() const { return faces.size(); }
  float longestEdge() const { return size; }
  /** Number of shapes that are not divided: no diffuse material, or not suitable. */
  size_t ignoredShapes() const { return ignored; }
  /** Number of corners, shared by neighbouring patches in nearly the same plane. */
  size_t cornerCount() const { return sharedCornerCount; }

  /** Patch at a hit; nullopt where the surface is not divided. */
  std::optional<PatchPoint> find(const Hit& hit) const;
  /** Area of the patch where alpha leaves it opaque [scene units²]. */
  float area(uint32_t patch) const { return areas[patch]; }
  std::array<uint32_t, 3> corners(uint32_t patch) const;
  /** Corners, normal, area and albedo of the patch; nothing of the light. */
  RadiosityPatch describe(uint32_t patch) const;
  /** Samples an opaque point of the patch, uniform in the surface's coordinates. */
  SurfacePoint sample(uint32_t patch, Sampler& sampler) const;

 private:
  /** Half of a grid cell of a face: below or above the diagonal. */
  struct Cell {
    uint32_t i = 0, j = 0;
    bool upper = false;
    /** Grid coordinates of its three corners. */
    std::array<glm::uvec2, 3> corners() const {
      if (upper) return {glm::uvec2(i + 1, j), {i, j + 1}, {i + 1, j + 1}};
      return {glm::uvec2(i, j), {i + 1, j}, {i, j + 1}};
    }
  };
  /** Face with a grid: a triangle of a mesh, or a face of other shapes by its coordinates. */
  struct Face {
    const Shape* shape = nullptr;
    const Material* material = nullptr;
    uint32_t number = 0; ///< primitive of the mesh, or face of the shape
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
    /** Number of divisions along each coordinate that gives short enough and nearly flat pieces. */
    Vec2d pieces(double longestEdge) const;
  };
  std::array<Vec2d, 3> cornerCoordinates(uint32_t patch) const;
  /** Faces to divide, not yet divided. Sets `firstFace`. */
  std::vector<Face> facesOf(const Scene& scene);
  void requireFew(double longestEdge) const;
  void cut(double maxDivisions);
  float opaqueArea(uint32_t patch) const;
  void shareCorners();

  float size = 0;
  size_t ignored = 0;
  std::vector<Face> faces;
  std::vector<int> firstFace; ///< index by shape of the scene; -1: not divided
  std::vector<uint32_t> faceOfPatch;
  std::vector<float> areas;
  std::vector<uint32_t> sharedCorner; ///< index of the shared corner, by corner of a face
  uint32_t sharedCornerCount = 0;
};

} // namespace recurse
