/** @file
 * Differences between pbrt-v3 and pbrt-v4.
 */
#include "scene/text/pbrt3.h"

#include <set>

namespace recurse::sceneFile::pbrt3 {

const char* const ADVICE = "this looks like a pbrt-v3 file, an older format; convert it with "
                           "`pbrt --upgrade old.pbrt > new.pbrt` (pbrt-v4's own program)";

bool isPlugIn(const std::string& directive, const std::string& plugIn) {
  // Only names that v4 abandoned: a name in both formats is no evidence.
  static const std::set<std::string> NAMES = {
      "Film image",
      "Integrator directlighting",
      "Sampler 02sequence",
      "Sampler lowdiscrepancy",
      "Sampler maxmindist",
      "Sampler random",
      "Camera environment",
      "Material matte",
      "Material metal",
      "Material glass",
      "Material mirror",
      "Material uber",
      "Material substrate",
      "Material translucent",
      "Material kdsubsurface",
      "Material fourier",
      "Material disney",
      "Shape heightfield",
      "Shape nurbs",
      "AreaLightSource area",
      "LightSource exinfinite",
      "Texture color",
  };
  return NAMES.count(directive + " " + plugIn) > 0;
}

bool isDirective(const std::string& directive) {
  static const std::set<std::string> NAMES = {"WorldEnd", "SurfaceIntegrator", "VolumeIntegrator", "Renderer",
                                              "Volume"};
  return NAMES.count(directive) > 0;
}

const char* parameterTypeHint(const std::string& type) {
  if (type == "color") return "pbrt-v4 calls it 'rgb'";
  if (type == "xyz") return "pbrt-v4 has no xyz colours; convert the value to 'rgb'";
  return nullptr;
}

} // namespace recurse::sceneFile::pbrt3
