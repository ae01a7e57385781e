/** @file
 * Subdivision surfaces of Kobbelt, "√3-Subdivision" (2000), on triangle meshes with boundaries.
 */
#pragma once

#include "recurse/model/mesh/triangleMesh.h"

namespace recurse {

/**
 * One step: each triangle gets a vertex in its middle, and edges between old vertices are flipped. Boundary
 * edges stay in odd steps, and are divided in three in even ones, so that two steps divide each triangle in
 * nine. Throws Error where the triangles are not a surface with an outside.
 */
void sqrt3Step(MeshData& mesh, bool isEven);

/** The mesh after `levels` steps, with vertices moved to the limit surface and its normals; by pbrt's
 * convention of "loopsubdiv", triangles are clockwise as seen from the outside. */
MeshData sqrt3Surface(MeshData mesh, int levels);

} // namespace recurse
