/** @file
 * Expansion of imports: importers make parts of a scene, which replace the directives that name them.
 */
#pragma once

#include <memory>

#include "recurse/scene/directives/sceneDescription.h"

namespace recurse {

struct PlugIns;
class KeptParts;

/** Adds the parameter "camera" to every importer. */
void addImportParameters(PlugIns& plugIns);

/** Makes the files available to every directive of a scene. */
void attachFiles(SceneDescription& scene, const std::shared_ptr<const MemoryFiles>& files);

/** True where a Shape directive names an importer. */
bool hasImports(const SceneDescription& scene);
/** Replaces Shape directives that name importers by the imported parts of a scene; errors go to the
 * diagnostics. */
void expandImports(SceneDescription& scene, Diagnostics& diagnostics, bool lenient,
                   KeptParts* kept = nullptr);

} // namespace recurse
