/** @file
 * What Assimp has read of a model, written down as a piece of a scene: node transforms, meshes, materials,
 * lights and cameras.
 */
#pragma once

#include <string>

#include "recurse/model/scene/sceneImport.h"

struct aiScene;

namespace recurse {

/** `p`: of the importer "mesh". Throws SceneError where the model cannot be used. */
void importAssimpScene(const aiScene& scene, const std::string& path, const Parameters& p,
                       const ImportContext& context, SceneImport& import);

} // namespace recurse
