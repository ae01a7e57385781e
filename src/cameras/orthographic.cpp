/** @file
 * Parallel projection.
 */
#include "recurse/model/plugIns.h"
#include "recurse/model/screenWindow.h"

namespace recurse {

namespace {

class Orthographic final : public Camera {
 public:
  Orthographic(const Parameters& p, const CameraContext& c)
      : window(p, c), sceneFromCamera(c.sceneFromCamera),
        direction(glm::normalize(transformVector(sceneFromCamera, Vec3d(0, 0, 1)))),
        scale(glm::length(transformVector(sceneFromCamera, Vec3d(1, 0, 0)))) {}

  EyeRay ray(const Vec2f& film) const override {
    EyeRay r;
    r.origin = Vec3f(transformPoint(sceneFromCamera, Vec3d(window.at(film), 0)));
    r.direction = direction;
    r.width = static_cast<float>(window.pixelSize() * scale);
    return r;
  }

 private:
  ScreenWindow window;
  Mat4d sceneFromCamera;
  Vec3f direction;
  double scale;
};

} // namespace

void registerOrthographic(PlugIns& plugIns) {
  plugIns.cameras.add(
      {{.name = "orthographic",
        .summary = "Parallel projection; the screen window is in units of camera space.",
        .parameters = screenParameters(),
        .examples = {"\"float screenwindow\" [-2 2 -2 2]"}},
       [](const Parameters& p, const CameraContext& c) { return std::make_unique<Orthographic>(p, c); }});
}

} // namespace recurse
