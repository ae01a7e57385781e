/** @file
 * Pieces of scenes that importers make, put in the place of the directives that name them.
 */
#pragma once

#include <memory>

#include "recurse/scene/directives/sceneDescription.h"

namespace recurse {

struct PlugIns;
class KeptParts;

/** Sees to the parameter "camera" of every importer. */
void addImportParameters(PlugIns& plugIns);

/** Makes every directive of a scene find these files. */
void attachFiles(SceneDescription& scene, const std::shared_ptr<const MemoryFiles>& files);

/** True where a Shape directive names an importer. */
bool hasImports(const SceneDescription& scene);
/** Puts the pieces that importers make in the place of the Shape directives that name them. */
void expandImports(SceneDescription& scene, Diagnostics& diagnostics, bool lenient,
                   KeptParts* kept = nullptr);

} // namespace recurse
