/** @file
 * Record of light paths.
 */
#include "recurse/transport/integrator/lightPathRecorder.h"

namespace recurse {

void LightPathRecorder::append(const std::vector<RecordedLightVertex>& part) {
  const int offset = static_cast<int>(list.size());
  for (RecordedLightVertex vertex : part) {
    if (vertex.previous != NOT_RECORDED) vertex.previous += offset;
    list.push_back(vertex);
  }
}

} // namespace recurse
