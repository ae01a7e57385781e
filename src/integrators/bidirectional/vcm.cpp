/** @file
 * Vertex connection and merging (Georgiev, Křivánek, Davidovič, Slusallek 2012, "Light Transport Simulation
 * with Vertex Connection and Merging"): bidirectional path tracing whose light paths also serve as photons.
 * Merges render reflected caustics; most other light comes from techniques without their blur.
 */
#include "integrators/bidirectional/bidirectional.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class Vcm final : public Bidirectional {
 public:
  explicit Vcm(const BidirectionalSettings& settings) : Bidirectional(settings) {}
};

} // namespace

void registerVcm(PlugIns& plugIns) {
  plugIns.integrators.add(
      {{.name = "vcm",
        .summary = "Vertex connection and merging: bidirectional path tracing with a photon map.",
        .parameters =
            {integerParameter("maxdepth", "-1", "most scattering events of a path; -1: no limit")
                 .range(-1, 1e9),
             integerParameter("photons", "", "light paths in each pass; by default one for each pixel")
                 .range(1, 2e9),
             realParameter("radius", "",
                           "radius of the search for photons in the first pass [scene units]; by default "
                           "1.5 pixels where the camera sees the first diffuse surface of a path")
                 .positive(),
             realParameter("alpha", "0.75",
                           "how fast the radius shrinks from pass to pass: between 0, at once, and 1, never")
                 .range(0.01, 1),
             booleanParameter("correlated", "true",
                              "weights know that photons which are found from many places are not "
                              "independent; false: the weights of 2012")},
        .examples = {"", "\"integer photons\" 4000 \"integer maxdepth\" 8 \"float radius\" .1",
                     "\"bool correlated\" false \"float alpha\" .5"}},
       [](const Parameters& p, const NoContext&) {
         BidirectionalSettings settings;
         settings.merges = true;
         settings.maxDepth = p.integer("maxdepth");
         settings.alpha = p.real("alpha");
         settings.correlated = p.boolean("correlated");
         if (p.hasValue("radius")) settings.radius = static_cast<float>(p.real("radius"));
         if (p.hasValue("photons")) settings.lightPaths = static_cast<uint64_t>(p.integer("photons"));
         return std::make_unique<Vcm>(settings);
       }});
}

} // namespace recurse
