/** @file
 * Conversion of a model that Assimp has read to a piece of a scene: node transforms, meshes, materials,
 * lights and cameras.
 */
#pragma once

#include <string>

#include "importers/assimp/gltfDetails.h"
#include "recurse/model/scene/sceneImport.h"

struct aiScene;

namespace recurse {

/** Whether the parameters of the importer "mesh" choose a time of an animation. */
bool wantsPose(const Parameters& p);

/** Reports that a file lacks the animation of the parameters: an error if it is named, else a warning.
 * `names`: the animations that exist. */
void reportMissingAnimation(const Parameters& p, const std::string& path, const std::string& names);

/** `p`: parameters of the importer "mesh". `gltf`: details of a glTF file; null: none. Throws SceneError
 * where the model cannot be used. */
void importAssimpScene(const aiScene& scene, const std::string& path, const Parameters& p,
                       const ImportContext& context, const GltfDetails* gltf, SceneImport& import);

} // namespace recurse
