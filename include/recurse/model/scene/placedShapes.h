/** @file
 * Enumeration of the shapes of a scene with their transforms, including shapes of instances.
 */
#pragma once

#include <functional>

#include "recurse/model/scene/scene.h"

namespace recurse {

/** Shape with its attributes and its transform. */
struct PlacedShape {
  const Shape* shape = nullptr;
  const Material* material = nullptr; ///< null: no scattering, unless Shape::componentMaterials() has others
  bool emits = false;
  uint32_t object = 0;     ///< see Scene::objectName()
  Mat4d sceneFromShape{1}; ///< at the time when the shutter opens; identity for shapes of Scene::shapes()
};

/** Calls visit(placed) for every shape of a scene made by buildScene(), once for each instance that contains
 * it. Shapes that neither scatter, nor emit, nor bound a medium are no part of the scene. */
void visitShapes(const Scene& scene, const std::function<void(const PlacedShape&)>& visit);

} // namespace recurse
