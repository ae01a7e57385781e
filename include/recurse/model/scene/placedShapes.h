/** @file
 * Shapes of a scene where they stand, those of instances included.
 */
#pragma once

#include <functional>

#include "recurse/model/scene/scene.h"

namespace recurse {

struct PlacedShape {
  const Shape* shape = nullptr;
  const Material* material = nullptr; ///< null: it does not scatter
  bool emits = false;
  uint32_t object = 0;     ///< see Scene::objectName()
  Mat4d sceneFromShape{1}; ///< when the shutter opens
};

/** Calls visit(placed) for every shape of a scene that buildScene() made, once for each instance that it is a
 * part of. */
void visitShapes(const Scene& scene, const std::function<void(const PlacedShape&)>& visit);

} // namespace recurse
