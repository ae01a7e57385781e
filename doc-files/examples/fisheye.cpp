/** @file
 * A fisheye camera: the angle to the axis grows evenly with the distance to the middle of the picture.
 */
#include <cmath>

#include "cameras/frame/cameraFrame.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

class Fisheye final : public Camera {
 public:
  Fisheye(const Parameters& p, const CameraContext& c)
      : Camera(p, c), track(c.sceneFromCamera), middle(Vec2d(c.width, c.height) * 0.5),
        pixels(double(c.width) * c.height), perPixel(glm::radians(p.real("fov")) / 2 / glm::length(middle)) {}

  /** Camera space looks along +z, x to the right, y up; the film counts pixels from its upper left corner. */
  std::optional<CameraRay> sampleRay(const CameraSample& sample) const override {
    const Vec2d place = (Vec2d(sample.film) - middle) * Vec2d(perPixel, -perPixel);
    const double theta = glm::length(place);
    if (theta > M_PI) return {}; // filters reach over the corners of the film
    const double ratio = theta > 0 ? std::sin(theta) / theta : 1;
    CameraRay ray;
    ray.time = sample.time;
    ray.spread = float(perPixel);
    track.at(sample.time, [&](const CameraFrame& frame) {
      ray.origin = Vec3f(frame.pointToScene(Vec3d(0)));
      ray.direction = Vec3f(glm::normalize(frame.vectorToScene(Vec3d(place * ratio, std::cos(theta)))));
    });
    return ray;
  }
  bool usesTime() const override { return track.moves(); }

  // For paths from the lights that are connected to the camera: bdpt, vcm, lightpath.

  bool isConnectable() const override { return true; }
  bool isDeltaPosition() const override { return true; }

  /** Where a point is seen: the inverse of sampleRay(). */
  std::optional<WiSample> sampleWi(const Vec3f& point, const Vec2f&, float time) const override {
    return track.at(time, [&](const CameraFrame& frame) -> std::optional<WiSample> {
      const Vec3d seen = frame.pointToCamera(Vec3d(point)), position = frame.pointToScene(Vec3d(0));
      const double distance = glm::distance(position, Vec3d(point)), across = glm::length(Vec2d(seen));
      const double theta = std::atan2(across, seen.z);
      if (!(distance > 0)) return {};
      const Vec2d place = across > 0 ? Vec2d(seen) * (theta / across) : Vec2d(0);
      return WiSample{.film = middle + place * Vec2d(1, -1) / perPixel,
                      .position = position,
                      .direction = (position - Vec3d(point)) / distance,
                      .distance = float(distance),
                      .importance = float(pixels * density(frame, seen)),
                      .pdf = float(square(distance))};
    });
  }
  WePdf pdfWe(const Ray& ray) const override {
    return track.at(ray.time, [&](const CameraFrame& frame) {
      return WePdf{1, float(density(frame, frame.vectorToCamera(Vec3d(ray.direction))))};
    });
  }

 private:
  /** Density of the directions of rays over the whole film [1/sr]: a ring of the film is 2π θ dθ / perPixel²
   * pixels, and its solid angle 2π sin θ dθ. */
  double density(const CameraFrame& frame, const Vec3d& direction) const {
    const double theta = std::atan2(glm::length(Vec2d(direction)), direction.z);
    const double ratio = theta > 0 ? theta / std::sin(theta) : 1;
    return ratio / (square(perPixel) * pixels) * frame.solidAngleRatio(glm::normalize(direction));
  }

  CameraTrack track;
  Vec2d middle;    ///< of the film [pixels]
  double pixels;   ///< of the whole film
  double perPixel; ///< [radians]
};

} // namespace

void registerFisheye(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters = cameraParameters();
  parameters.push_back(
      realParameter("fov", "180", "angle across the picture's diagonal [degrees]").range(1, 350));
  plugIns.cameras.add(
      {{.name = "fisheye",
        .summary = "Equidistant fisheye: angles to the axis are distances to the middle.",
        .parameters = parameters,
        .examples = {"", "\"float fov\" 120"}},
       [](const Parameters& p, const CameraContext& c) { return std::make_unique<Fisheye>(p, c); }});
}

} // namespace recurse
