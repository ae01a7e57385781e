/** @file
 * Feature layers of the first surfaces that camera rays meet and that scatter, for compositing and for
 * denoisers: albedo, normals, depth, position, and mattes of objects and materials; and of path guiding, for
 * studies.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/core/image/image.h"
#include "recurse/model/scene/scene.h"
#include "recurse/transport/integrator/integrator.h"

namespace recurse {

/** Feature layer. Each value, except in mattes, is the mean over the samples of the pixel that hit a surface,
 * 0 where none does; the albedo includes the samples that hit none, as 0. */
struct FeatureLayer {
  const char* name;
  const char* channels;  ///< a letter for each, such as "RGB" or "Z"; empty for mattes
  const char* meaning;   ///< one line
  bool isOfScene = true; ///< false: of the integrator
};
/** All feature layers. */
const std::vector<FeatureLayer>& featureLayers();
/** Throws Error (BAD_USAGE), with all valid names, for a name that is unknown or occurs twice. */
void requireFeatureLayers(const std::vector<std::string>& names);
/** Throws Error (BAD_USAGE) for a layer that the integrator cannot have. The names must be valid. */
void requireFeatureLayers(const std::vector<std::string>& names, const Integrator& integrator);

struct FeatureSettings {
  std::vector<std::string> layers; ///< names from featureLayers()
  int samples = 16;                ///< samples of a pixel; mattes always take 64
  bool throughSpecular = false;    ///< sees through mirrors and smooth glass, up to 16 in a row
  uint64_t seed = 0;
};

/** Channels LAYER.LETTER of the film's crop window from samples uniform over each pixel, and the channels of
 * mattes (cryptomatte.h). Layers of the integrator have the state after its latest pass. Throws Error like
 * requireFeatureLayers(). */
Image renderFeatures(const Scene& scene, const Integrator& integrator, const FeatureSettings& settings);

} // namespace recurse
