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

/** What the page shows. */
struct Inspection {
  std::string title, label;          ///< the scene, and how it was rendered
  Image picture;                     ///< R, G, B of the crop window
  std::vector<RecordedPixel> pixels; ///< recorded with the classes of the page
  std::vector<StoredPhoton> photons; ///< empty: the integrator keeps none
  size_t photonsInMap = 0;           ///< before some were left out
};

/** At most `most` photons, evenly from all of the map, with the power of those that are left out. */
std::vector<StoredPhoton> photonsOf(const Integrator& integrator, size_t most, size_t& inMap);

/** A page that needs nothing but itself. */
std::string inspectPage(const Scene& scene, const PathClasses& classes, const Inspection& inspection);

} // namespace recurse
