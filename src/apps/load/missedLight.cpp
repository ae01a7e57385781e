/** @file
 * Light of point, spot and distant lights that an integrator cannot find.
 */
#include "apps/load/missedLight.h"

#include <algorithm>

#include "recurse/pathclasses/pathExpression.h"

namespace recurse::apps {

std::string missedPaths(const LoadedScene& loaded, const std::vector<PathClass>& classes) {
  const SceneContents& contents = loaded.scene->contents();
  if (contents.deltaLights == 0) return {};
  const std::string missed = missedOfDeltaLights(loaded.integrator->domains());
  if (missed.empty()) return {};
  const bool hasDelta = (contents.lobes & DELTA_LOBES) != 0;
  PathAutomaton paths = PathAutomaton::compile(missed);
  if (!hasDelta) paths = paths.intersect(PathAutomaton::compile("L(D|V)*E"));
  const bool wanted = std::any_of(classes.begin(), classes.end(), [&](const PathClass& c) {
    return !PathAutomaton::compile(c.expression).intersect(paths).isEmpty();
  });
  return wanted ? missed : std::string();
}

} // namespace recurse::apps
