/** @file
 * Features of what a pixel sees, for compositing and for denoisers: albedo, normals, depth, position, and
 * mattes of objects and materials.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/core/image/image.h"
#include "recurse/model/scene/scene.h"

namespace recurse {

/** A layer of features. Each value is the mean over those samples of the pixel that meet a surface, 0 where
 * none does; of the albedo that 0 is a part of the mean. */
struct FeatureLayer {
  const char* name;
  const char* channels; ///< letters: "RGB", "XYZ", "Z"; empty for mattes
  const char* meaning;
};
const std::vector<FeatureLayer>& featureLayers();
/** Throws Error (BAD_USAGE) with those there are where a name is not one of a layer, or is there twice. */
void requireFeatureLayers(const std::vector<std::string>& names);

struct FeatureSettings {
  std::vector<std::string> layers; ///< names from featureLayers()
  int samples = 16;                ///< of a pixel
  bool throughSpecular = false;    ///< mirrors and smooth glass are looked through, as far as 16 of them
  uint64_t seed = 0;
};

/** The channels LAYER.LETTER of the film's part of the picture, and those of mattes (cryptomatte.h). */
Image renderFeatures(const Scene& scene, const FeatureSettings& settings);

} // namespace recurse
