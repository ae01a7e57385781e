/** @file
 * The pinhole camera.
 */
#include "recurse/model/plugIns.h"
#include "recurse/model/screenWindow.h"

namespace recurse {

namespace {

class Perspective final : public Camera {
 public:
  Perspective(const Parameters& p, const CameraContext& c)
      : window(p, c), sceneFromCamera(c.sceneFromCamera), tangent(std::tan(glm::radians(p.real("fov")) / 2)),
        pixel(window.pixelSize() * tangent), eye(transformPoint(sceneFromCamera, Vec3d(0))) {}

  EyeRay ray(const Vec2f& film) const override {
    const Vec2d s = window.at(film) * tangent;
    EyeRay r;
    r.origin = eye;
    r.direction = Vec3f(glm::normalize(transformVector(sceneFromCamera, Vec3d(s, 1))));
    // Away from the axis a pixel subtends less; the widest is what footprints need.
    r.spread = static_cast<float>(pixel / std::sqrt(1 + s.x * s.x + s.y * s.y));
    return r;
  }

 private:
  ScreenWindow window;
  Mat4d sceneFromCamera;
  double tangent;
  double pixel; ///< the larger side of one, at distance 1
  Vec3f eye;
};

} // namespace

void registerPerspective(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters = screenParameters();
  parameters.push_back(
      realParameter("fov", "90", "angle of view along the shorter axis of the film [degrees]")
          .range(1e-3, 179.999));
  plugIns.cameras.add(
      {{.name = "perspective",
        .summary = "The pinhole camera.",
        .parameters = parameters,
        .examples = {"\"float fov\" 45"}},
       [](const Parameters& p, const CameraContext& c) { return std::make_unique<Perspective>(p, c); }});
}

} // namespace recurse
