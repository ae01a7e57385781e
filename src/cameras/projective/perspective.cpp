/** @file
 * Central projection: the pinhole camera, and the thin lens.
 */
#include "cameras/frame/cameraFrame.h"
#include "cameras/projective/aperture.h"
#include "cameras/projective/screenWindow.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** Perspective camera. Directions are given by their intersection with the image plane at distance 1. */
class Perspective final : public Camera {
 public:
  Perspective(const Parameters& p, const CameraContext& c)
      : Camera(p, c), window(p, c), aperture(p), track(c.sceneFromCamera),
        tangent(std::tan(glm::radians(p.real("fov")) / 2)), pixel(window.pixelSize() * tangent),
        imageArea(window.area() * square(tangent)) {}

  std::optional<CameraRay> sampleRay(const CameraSample& sample) const override {
    const Vec2d image = window.at(sample.film) * tangent;
    CameraRay r;
    r.time = sample.time;
    // A pixel subtends less away from the axis; footprints need its widest extent.
    r.spread = static_cast<float>(pixel / std::sqrt(1 + image.x * image.x + image.y * image.y));
    Vec3d lens(0), direction(image, 1);
    if (usesLens()) {
      lens = Vec3d(aperture.sample(sample.lens), 0);
      direction -= lens / aperture.focalDistance; // aims at the same point of the plane in focus
    }
    track.at(sample.time, [&](const CameraFrame& frame) {
      r.origin = Vec3f(frame.pointToScene(lens));
      r.direction = Vec3f(glm::normalize(frame.vectorToScene(direction)));
    });
    return r;
  }
  bool usesLens() const override { return aperture.radius > 0; }
  bool usesTime() const override { return track.moves(); }

  bool isConnectable() const override { return true; }
  bool isDeltaPosition() const override { return !usesLens(); }
  std::optional<WiSample> sampleWi(const Vec3f& point, const Vec2f& lens, float time) const override {
    return track.at(time, [&](const CameraFrame& frame) { return connect(frame, point, lens); });
  }
  WePdf pdfWe(const Ray& ray) const override {
    return track.at(ray.time, [&](const CameraFrame& frame) {
      const Vec3d direction = frame.vectorToCamera(Vec3d(ray.direction));
      return direction.z > 0 ? densities(frame, direction) : WePdf();
    });
  }

 private:
  /** Densities of a ray by its direction in camera space. */
  WePdf densities(const CameraFrame& frame, const Vec3d& direction) const {
    const Vec3d unit = glm::normalize(direction);
    const double inCamera = 1 / (imageArea * unit.z * unit.z * unit.z);
    return {usesLens() ? static_cast<float>(1 / (aperture.area() * frame.areaScale)) : 1,
            static_cast<float>(inCamera * frame.solidAngleRatio(unit))};
  }
  std::optional<WiSample> connect(const CameraFrame& frame, const Vec3f& point, const Vec2f& u) const {
    const Vec3d seen = frame.pointToCamera(Vec3d(point));
    if (!(seen.z > 0)) return {};
    const Vec3d lens = usesLens() ? Vec3d(aperture.sample(u), 0) : Vec3d(0), direction = seen - lens;
    const Vec2d image = Vec2d(direction) / direction.z + Vec2d(lens) / aperture.focalDistance;
    const Vec3d position = frame.pointToScene(lens), way = position - Vec3d(point);
    const double distance = glm::length(way), cosine = -glm::dot(way, frame.axis) / distance;
    const WePdf pdf = densities(frame, direction);
    return WiSample{.film = window.filmAt(image / tangent),
                    .position = position,
                    .direction = way / distance,
                    .distance = static_cast<float>(distance),
                    .importance = static_cast<float>(window.pixels() * double(pdf.position) *
                                                     double(pdf.direction) / cosine),
                    .pdf = static_cast<float>(double(pdf.position) * square(distance) / cosine)};
  }

  ScreenWindow window;
  Aperture aperture;
  CameraTrack track;
  double tangent;
  double pixel;     ///< larger side of a pixel at distance 1
  double imageArea; ///< area of the film at distance 1
};

} // namespace

void registerPerspective(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters = screenParameters();
  for (const ParameterSpec& p : apertureParameters()) parameters.push_back(p);
  parameters.push_back(
      realParameter("fov", "90", "angle of view along the shorter axis of the film [degrees]")
          .range(1e-3, 179.999));
  plugIns.cameras.add(
      {{.name = "perspective",
        .summary = "Perspective projection, through a pinhole or a thin lens.",
        .parameters = parameters,
        .examples = {"\"float fov\" 45",
                     "\"float fov\" 45 \"float lensradius\" 0.1 \"float focaldistance\" 4",
                     "\"float lensradius\" 0.1 \"float focaldistance\" 4 \"integer apertureblades\" 6"}},
       [](const Parameters& p, const CameraContext& c) { return std::make_unique<Perspective>(p, c); }});
}

} // namespace recurse
