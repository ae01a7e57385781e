/** @file
 * Vertex connection and merging (Georgiev, Křivánek, Davidovič, Slusallek 2012, "Light Transport Simulation
 * with Vertex Connection and Merging"): bidirectional path tracing whose light paths also serve as photons.
 * Merges render reflected caustics; most other light comes from techniques without their blur.
 */
#include "integrators/bidirectional/bidirectional.h"
#include "recurse/model/scene/plugIns.h"
#include "transport/integrator/maxDepthParameter.h"

namespace recurse {

void registerVcm(PlugIns& plugIns) {
  plugIns.integrators.add(
      {{.name = "vcm",
        .summary = "Vertex connection and merging: bidirectional path tracing with a photon map.",
        .parameters = {maxDepthParameter(),
                       integerParameter("photons", "",
                                        "number of light paths in each pass; by default one for each pixel")
                           .range(1, 2e9),
                       realParameter("radius", "",
                                     "merge radius of the first pass [scene units]; by default 1.5 pixels at "
                                     "the first diffuse surface of a camera path")
                           .positive(),
                       realParameter("alpha", "0.75",
                                     "reduction of the radius: that of pass i is about i^((alpha-1)/2) times "
                                     "the first; between 0 (fastest) and 1 (constant)")
                           .range(0.01, 1),
                       guidedStartsParameter(),
                       booleanParameter("correlated", "true",
                                        "MIS weights include the correlation of merges that share photons; "
                                        "false: the weights of Georgiev et al. 2012")},
        .examples = {"", "\"integer photons\" 4000 \"integer maxdepth\" 8 \"float radius\" .1",
                     "\"bool correlated\" false \"float alpha\" .5 \"bool guided\" true"}},
       [](const Parameters& p, const NoContext&) {
         BidirectionalSettings settings;
         settings.merges = true;
         settings.maxDepth = p.integer("maxdepth");
         settings.guided = p.boolean("guided");
         settings.alpha = p.real("alpha");
         settings.correlated = p.boolean("correlated");
         if (p.hasValue("radius")) settings.radius = static_cast<float>(p.real("radius"));
         if (p.hasValue("photons")) settings.lightPaths = static_cast<uint64_t>(p.integer("photons"));
         return std::make_unique<Bidirectional>(settings);
       }});
}

} // namespace recurse
