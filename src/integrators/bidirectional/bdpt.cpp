/** @file
 * Bidirectional path tracing (Veach and Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo
 * Rendering"): all connections between a camera path and a light path.
 */
#include "integrators/bidirectional/bidirectional.h"
#include "recurse/model/scene/plugIns.h"
#include "transport/integrator/maxDepthParameter.h"

namespace recurse {

void registerBdpt(PlugIns& plugIns) {
  plugIns.integrators.add(
      {{.name = "bdpt",
        .summary = "Bidirectional path tracing: paths from the camera and from the lights, connected by "
                   "shadow rays; unbiased.",
        .parameters = {maxDepthParameter(),
                       integerParameter("lightpaths", "",
                                        "number of light paths in each pass; by default one for each pixel")
                           .range(1, 2e9),
                       guidedStartsParameter(),
                       ignoredParameter(ParameterType::BOOLEAN, "regularize", "not needed"),
                       ignoredParameter(ParameterType::BOOLEAN, "visualizestrategies",
                                        "only the final picture is written"),
                       ignoredParameter(ParameterType::BOOLEAN, "visualizeweights",
                                        "only the final picture is written")},
        .examples = {"", "\"integer lightpaths\" 4000 \"integer maxdepth\" 8 \"bool guided\" true"}},
       [](const Parameters& p, const NoContext&) {
         BidirectionalSettings settings;
         settings.maxDepth = p.integer("maxdepth");
         settings.guided = p.boolean("guided");
         if (p.hasValue("lightpaths")) settings.lightPaths = static_cast<uint64_t>(p.integer("lightpaths"));
         return std::make_unique<Bidirectional>(settings);
       }});
}

} // namespace recurse
