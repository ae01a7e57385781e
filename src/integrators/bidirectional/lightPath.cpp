/** @file
 * Light tracing (Arvo 1986; Dutré et al. 1993): paths from the lights, connected to the camera at each
 * vertex. It cannot render emission seen directly, nor surfaces seen in mirrors or through glass.
 */
#include "integrators/bidirectional/bidirectional.h"
#include "recurse/model/scene/plugIns.h"
#include "transport/integrator/maxDepthParameter.h"

namespace recurse {

namespace {

class LightPath final : public Bidirectional {
 public:
  explicit LightPath(const BidirectionalSettings& settings) : Bidirectional(settings) {}
  std::string claims() const override { return "L(S|D)*DE"; }
  TransportCounts prepare(const Scene& scene, const PathClasses& classes) override {
    if (!scene.camera().isConnectable())
      throw Error("lightpath needs a camera to which light paths can be connected, such as \"perspective\"");
    return Bidirectional::prepare(scene, classes);
  }
};

} // namespace

void registerLightPath(PlugIns& plugIns) {
  plugIns.integrators.add(
      {{.name = "lightpath",
        .summary = "Light tracing: paths from the lights, connected to the camera. Directly visible lamps, "
                   "mirrors and glass are black.",
        .parameters = {maxDepthParameter(),
                       integerParameter("lightpaths", "",
                                        "number of light paths in each pass; by default one for each pixel")
                           .range(1, 2e9)},
        .examples = {"", "\"integer lightpaths\" 4000 \"integer maxdepth\" 8"}},
       [](const Parameters& p, const NoContext&) {
         BidirectionalSettings settings;
         settings.maxDepth = p.integer("maxdepth");
         settings.hits = settings.shadowRays = settings.connections = false;
         if (p.hasValue("lightpaths")) settings.lightPaths = static_cast<uint64_t>(p.integer("lightpaths"));
         return std::make_unique<LightPath>(settings);
       }});
}

} // namespace recurse
