/** @file
 * Delta lights and specular surfaces, between which only paths by chance would find light.
 */
#include "apps/load/missedLight.h"

#include <algorithm>

#include "recurse/pathclasses/pathExpression.h"

namespace recurse::apps {

std::string missedPaths(const LoadedScene& loaded, const std::vector<PathClass>& classes) {
  const SceneContents& contents = loaded.scene->contents();
  if (contents.deltaLights == 0 || !(contents.lobes & DELTA_LOBES)) return {};
  const std::string missed = missedOfDeltaLights(loaded.integrator->domains());
  if (missed.empty()) return {};
  const PathAutomaton paths = PathAutomaton::compile(missed);
  const bool wanted = std::any_of(classes.begin(), classes.end(), [&](const PathClass& c) {
    return !PathAutomaton::compile(c.expression).intersect(paths).isEmpty();
  });
  return wanted ? missed : std::string();
}

} // namespace recurse::apps
