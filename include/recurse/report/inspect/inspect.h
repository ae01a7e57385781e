/** @file
 * Page that shows how light travels in a scene: the scene in 3D, the recorded paths of some pixels, and the
 * photons of a map.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/core/image/image.h"
#include "recurse/render/recordPixels.h"

namespace recurse {

/** Content of the page. */
struct Inspection {
  std::string title, label;          ///< scene, and settings of the render
  Image picture;                     ///< R, G, B of the crop window
  std::vector<RecordedPixel> pixels; ///< recorded with the classes of the page
  std::vector<StoredPhoton> photons; ///< empty: the integrator has no photon map
  size_t photonsInMap = 0;           ///< number in the map, before thinning
};

/** At most `most` photons, evenly thinned from the map; their power is scaled to include the omitted ones. */
std::vector<StoredPhoton> photonsOf(const Integrator& integrator, size_t most, size_t& inMap);

/** Self-contained page. */
std::string inspectPage(const Scene& scene, const PathClasses& classes, const Inspection& inspection);

} // namespace recurse
