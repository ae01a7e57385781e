/** @file
 * Expansion of imports: importers make parts of a scene, which replace the directives that name them.
 */
#pragma once

#include <memory>

#include "recurse/scene/directives/sceneDescription.h"

namespace recurse {

struct PlugIns;
class KeptParts;

/** Adds the parameter "camera" to every importer: the name of the file's camera that becomes
 * SceneImport::chosen; an unknown name is an error. */
void addImportParameters(PlugIns& plugIns);

/** Makes the files available to every directive of a scene. */
void attachFiles(SceneDescription& scene, const std::shared_ptr<const MemoryFiles>& files);

/** True where a Shape directive names an importer, also in an object. */
bool hasImports(const SceneDescription& scene);
/** Replaces Shape directives that name importers by the imported parts of a scene. An import's chosen camera
 * sets the transform of the scene's camera, unless that has a name. Errors go to the diagnostics, and their
 * Shape is removed. `lenient`: unknown parameters are warnings. `kept`: imports are reused from it, and left
 * in it for the next frame; null: nothing is kept. */
void expandImports(SceneDescription& scene, Diagnostics& diagnostics, bool lenient,
                   KeptParts* kept = nullptr);

} // namespace recurse
