/** @file
 * Parallel projection, with or without a lens.
 */
#include "cameras/frame/cameraFrame.h"
#include "cameras/projective/aperture.h"
#include "cameras/projective/screenWindow.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** Orthographic camera. With a lens it is telecentric: every film point has a separate lens before it. */
class Orthographic final : public Camera {
 public:
  Orthographic(const Parameters& p, const CameraContext& c)
      : Camera(p, c), window(p, c), aperture(p), track(c.sceneFromCamera),
        scale(glm::length(track.start().vectorToScene(Vec3d(1, 0, 0)))) {}

  std::optional<CameraRay> sampleRay(const CameraSample& sample) const override {
    Vec3d origin(window.at(sample.film), 0), direction(0, 0, 1);
    if (usesLens()) {
      const Vec3d lens(aperture.sample(sample.lens), 0);
      origin += lens;
      direction -= lens / aperture.focalDistance;
    }
    CameraRay r;
    r.time = sample.time;
    track.at(sample.time, [&](const CameraFrame& frame) {
      r.origin = Vec3f(frame.pointToScene(origin));
      r.direction = Vec3f(glm::normalize(frame.vectorToScene(direction)));
    });
    r.width = static_cast<float>(window.pixelSize() * scale);
    return r;
  }
  bool usesLens() const override { return aperture.radius > 0; }
  bool usesTime() const override { return track.moves(); }

  bool isConnectable() const override { return true; }
  bool isDeltaDirection() const override { return !usesLens(); }
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
  std::optional<WiSample> connect(const CameraFrame& frame, const Vec3f& point, const Vec2f& u) const {
    const Vec3d seen = frame.pointToCamera(Vec3d(point));
    if (!(seen.z > 0)) return {};
    const Vec3d lens = usesLens() ? Vec3d(aperture.sample(u), 0) : Vec3d(0);
    const Vec3d direction = Vec3d(0, 0, 1) - lens / aperture.focalDistance;
    const Vec3d origin = seen - direction * seen.z;
    const Vec3d position = frame.pointToScene(origin), way = position - Vec3d(point);
    const double distance = glm::length(way), cosine = -glm::dot(way, frame.axis) / distance;
    const WePdf pdf = densities(frame, direction);
    return WiSample{.film = window.filmAt(Vec2d(origin - lens)),
                    .position = position,
                    .direction = way / distance,
                    .distance = static_cast<float>(distance),
                    .importance = static_cast<float>(window.pixels() * double(pdf.position) *
                                                     double(pdf.direction) / cosine),
                    .pdf = pdf.direction};
  }

  /** Densities of a ray by its direction in camera space, which determines the point on the lens. */
  WePdf densities(const CameraFrame& frame, const Vec3d& direction) const {
    const auto position = static_cast<float>(1 / (window.area() * frame.areaScale));
    if (!usesLens()) return {position, 1};
    const Vec3d unit = glm::normalize(direction);
    const double inCamera = square(aperture.focalDistance) / (aperture.area() * unit.z * unit.z * unit.z);
    return {position, static_cast<float>(inCamera * frame.solidAngleRatio(unit))};
  }

  ScreenWindow window;
  Aperture aperture;
  CameraTrack track;
  double scale;
};

} // namespace

void registerOrthographic(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters = screenParameters();
  for (const ParameterSpec& p : apertureParameters()) parameters.push_back(p);
  plugIns.cameras.add(
      {{.name = "orthographic",
        .summary = "Parallel projection; the screen window is in camera space.",
        .parameters = parameters,
        .examples = {"\"float screenwindow\" [-2 2 -2 2]",
                     "\"float lensradius\" 0.1 \"float focaldistance\" 4"}},
       [](const Parameters& p, const CameraContext& c) { return std::make_unique<Orthographic>(p, c); }});
}

} // namespace recurse
