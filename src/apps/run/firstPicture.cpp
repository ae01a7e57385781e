/** @file
 * First picture: one sample of each pixel by a path tracer that learns nothing.
 */
#include "apps/run/firstPicture.h"

#include "recurse/pathclasses/pathExpression.h"
#include "recurse/transport/integrator/sceneNames.h"

namespace recurse::apps {

namespace {

/** Paths of emitted and direct light. */
constexpr const char* DIRECT = "L(S|D|V)?E";

} // namespace

int maxDepthOf(const ParsedDirective& integrator) {
  for (const ParsedParameter& p : integrator.parameters)
    if (p.name == "maxdepth" && p.numbers.size() == 1) return static_cast<int>(p.numbers[0]);
  return -1;
}

std::unique_ptr<Integrator> pathTracerThatLearnsNothing(int maxDepth) {
  ParsedDirective directive;
  directive.type = "simplepath";
  ParsedParameter limit;
  limit.type = "integer";
  limit.name = "maxdepth";
  limit.numbers = {double(maxDepth)};
  directive.parameters.push_back(limit);
  Diagnostics none;
  return makeIntegrator(directive, false, none);
}

std::optional<PathClasses> firstPictureClasses(const LoadedScene& loaded, const PathClasses& classes) {
  const std::string claims = loaded.integrator->claims();
  if (claims.empty()) return classes;
  const PathAutomaton claimed = PathAutomaton::compile(claims);
  if (claimed.subsetOf(PathAutomaton::compile(DIRECT))) return {};
  std::vector<PathClass> left = classes.classes();
  left.resize(left.size() - classes.frames().layerCount());
  for (PathClass& c : left) {
    if (PathAutomaton::compile(c.expression).intersect(claimed).isEmpty()) return {};
    c.expression = "(" + c.expression + ") & (" + claims + ")";
  }
  PathClasses out = sceneClasses(left, *loaded.scene, loaded.integrator.get());
  if (classes.isTransient()) out.addFrames(classes.frames());
  return out;
}

FirstPicture renderFirstPicture(const LoadedScene& loaded, const PathClasses& classes, uint64_t seed,
                                double timeLimit, const std::atomic<bool>& stop,
                                const std::function<void(const RenderProgress&)>& progress) {
  const auto path = pathTracerThatLearnsNothing(maxDepthOf(loaded.integratorDirective));
  RenderSettings once;
  once.samplesPerPixel = 1;
  once.seed = seed;
  once.timeLimit = timeLimit;
  const auto tell = [&](RenderProgress p) {
    p.phase = "first picture";
    if (progress) progress(p);
  };
  FirstPicture out{Film(loaded.scene->film().crop, classes.layerCount()), {}};
  out.statistics = render(*loaded.scene, *path, classes, once, out.film, stop, tell, nullptr);
  return out;
}

} // namespace recurse::apps
