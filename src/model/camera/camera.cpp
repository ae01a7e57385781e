/** @file
 * Shutter times, normalised to the scene's motion.
 */
#include "recurse/model/camera/camera.h"

namespace recurse {

std::vector<ParameterSpec> cameraParameters() {
  return {stringParameter("name", "", "name for `--camera`, where a scene has several cameras"),
          realParameter("shutteropen", "0", "beginning of the exposure, for motion blur; see TransformTimes"),
          realParameter("shutterclose", "1",
                        "end of the exposure; as in pbrt-v4, the picture is multiplied by the difference")};
}

Camera::Camera(const Parameters& p, const CameraContext& c) {
  const double open = p.real("shutteropen"), close = p.real("shutterclose");
  if (!(close > open))
    p.fail("shutterclose", "\"shutterclose\" is not after \"shutteropen\"", "a time after \"shutteropen\"");
  const auto normalised = [&](double time) {
    return static_cast<float>((time - c.startTime) / (c.endTime - c.startTime));
  };
  shutterOpen = normalised(open);
  shutterClose = normalised(close);
  exposure = static_cast<float>(close - open);
}

} // namespace recurse
