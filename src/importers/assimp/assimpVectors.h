/** @file
 * Vectors and matrices of Assimp as those of the scene.
 */
#pragma once

#include <assimp/matrix4x4.h>
#include <assimp/vector3.h>

#include "recurse/core/math/vector.h"

namespace recurse {

inline Vec3d vectorOf(const aiVector3D& v) { return {v.x, v.y, v.z}; }

inline Mat4d matrixOf(const aiMatrix4x4& m) { // stored by rows in Assimp, by columns here
  Mat4d out;
  for (unsigned row = 0; row < 4; ++row)
    for (unsigned column = 0; column < 4; ++column)
      out[static_cast<int>(column)][static_cast<int>(row)] = m[row][column];
  return out;
}

} // namespace recurse
