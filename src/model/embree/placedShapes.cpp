/** @file
 * Visitor of the shapes of the top level and of its instances.
 */
#include "recurse/model/scene/placedShapes.h"

#include "model/embree/embreeScene.h"

namespace recurse {

void visitShapes(const Scene& scene, const std::function<void(const PlacedShape&)>& visit) {
  const GeometryGroup& top = dynamic_cast<const EmbreeScene&>(scene).top();
  for (const SceneGeometry& g : top.allGeometries())
    visit({g.shape, g.material, g.light != nullptr, g.object});
  const float time = scene.camera().timeAt(0);
  for (const GeometryGroup::Instance& i : top.allInstances())
    for (const SceneGeometry& g : i.group->allGeometries())
      visit({g.shape, g.material, g.light != nullptr, i.object, i.sceneFromGroup.at(time)});
}

} // namespace recurse
