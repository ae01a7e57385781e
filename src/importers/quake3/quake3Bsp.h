/** @file
 * Compiled maps of Quake III (IBSP version 46): the lumps with geometry and light.
 */
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recurse/core/math/vector.h"

namespace recurse {

/** Geometry and light of a map. Lengths are in map units and +z is up. Triangles are counter-clockwise
 * seen from their front; v increases upwards. */
struct Quake3Bsp {
  struct ShaderReference {
    std::string name;
    bool isSky = false, isInvisible = false;
  };
  struct Vertex {
    Vec3d position{0}, normal{0};
    Vec2d uv{0};
  };
  struct Face {
    uint32_t shader = 0;
    std::vector<Vertex> vertices;
    std::vector<glm::uvec3> triangles; ///< vertex indices; empty for a patch
    uint32_t patchWidth = 0,
             patchHeight = 0; ///< control points of a biquadratic patch, row by row; 0: no patch
  };
  using Entity = std::map<std::string, std::string>; ///< keys in lower case

  std::vector<ShaderReference> shaders;
  std::vector<Face> faces; ///< polygons, patches and meshes; no billboards
  std::vector<Entity> entities;
};

/** Values of an entity's keys; empty, or `otherwise`, where there is none. */
std::string valueOf(const Quake3Bsp::Entity& entity, const std::string& key);
std::optional<Vec3d> vectorOf(const Quake3Bsp::Entity& entity, const std::string& key);
double numberOf(const Quake3Bsp::Entity& entity, const std::string& key, double otherwise);

/** Throws Error with the file, the offset and the fault. */
Quake3Bsp readQuake3Bsp(const std::string& name, std::string_view bytes);

/** Number of parts, at most `most`, into which each patch piece is cut along each side, so that no
 * triangle is further than `tolerance` from the surface [map units]. */
int patchSteps(const Quake3Bsp& map, double tolerance, int most);
/** Tessellates a patch with `steps` parts along each side of each piece; replaces the control points.
 */
void tessellatePatch(Quake3Bsp::Face& face, int steps);

} // namespace recurse
