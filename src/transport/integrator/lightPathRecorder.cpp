/** @file
 * Record of light paths.
 */
#include "recurse/transport/integrator/lightPathRecorder.h"

namespace recurse {

void LightPathRecorder::append(const std::vector<RecordedLightVertex>& vertices) {
  const int offset = static_cast<int>(list.size());
  for (RecordedLightVertex vertex : vertices) {
    if (vertex.previous != NOT_RECORDED) vertex.previous += offset;
    list.push_back(vertex);
  }
}

} // namespace recurse
