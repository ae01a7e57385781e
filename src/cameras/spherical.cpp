/** @file
 * Spherical camera: all directions around a point in one picture.
 */
#include "cameras/frame/cameraFrame.h"
#include "recurse/model/scene/plugIns.h"

namespace recurse {

namespace {

/** Map between the square [0, 1]² and directions of camera space. */
class SphereMap {
 public:
  virtual ~SphereMap() = default;
  /** Unit direction; coordinates beyond the edges of the square continue as on the sphere. */
  virtual Vec3d direction(const Vec2d& uv) const = 0;
  virtual Vec2d place(const Vec3d& direction) const = 0;
  /** Density at a unit direction, for uniform points of the square [1/sr]. */
  virtual double pdf(const Vec3d& direction) const = 0;
};

/** Equirectangular map: longitude to the right, polar angle downwards. */
class Equirectangular final : public SphereMap {
 public:
  Vec3d direction(const Vec2d& uv) const override {
    const double theta = M_PI * uv.y, phi = 2 * M_PI * uv.x;
    return {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
  }
  Vec2d place(const Vec3d& d) const override {
    const double phi = std::atan2(d.z, d.x);
    return {(phi < 0 ? phi + 2 * M_PI : phi) / (2 * M_PI), std::atan2(std::hypot(d.x, d.z), d.y) / M_PI};
  }
  double pdf(const Vec3d& d) const override { return 1 / (2 * square(M_PI) * std::hypot(d.x, d.z)); }
};

/** The octahedral map in which every pixel has the same solid angle (Clarberg 2008, "Fast Equal-Area Mapping
 * of the (Hemi)Sphere using SIMD"): up in the middle, down in the corners. */
class EqualArea final : public SphereMap {
 public:
  Vec3d direction(const Vec2d& uv) const override {
    const Vec2d s = wrapped(uv) * 2.0 - 1.0, size = glm::abs(s);
    const double inside = 1 - (size.x + size.y), r = 1 - std::abs(inside);
    const double phi = r > 0 ? M_PI / 4 * (1 + (size.y - size.x) / r) : M_PI / 4;
    const double across = r * std::sqrt(2 - r * r);
    return {std::copysign(std::cos(phi) * across, s.x), std::copysign(1 - r * r, inside),
            std::copysign(std::sin(phi) * across, s.y)};
  }
  Vec2d place(const Vec3d& d) const override {
    const double r = std::sqrt(std::max(0.0, 1 - std::abs(d.y)));
    const double part = std::atan2(std::abs(d.z), std::abs(d.x)) / (M_PI / 2);
    Vec2d size(r * (1 - part), r * part);
    if (d.y < 0) size = {1 - size.y, 1 - size.x};
    return (Vec2d(std::copysign(size.x, d.x), std::copysign(size.y, d.z)) + 1.0) / 2.0;
  }
  double pdf(const Vec3d&) const override { return 1 / (4 * M_PI); }

 private:
  /** Beyond an edge the picture continues at the opposite position on the same edge. */
  static Vec2d wrapped(Vec2d uv) {
    for (int axis = 0; axis < 2; ++axis) {
      if (uv[axis] >= 0 && uv[axis] <= 1) continue;
      uv[axis] = uv[axis] < 0 ? -uv[axis] : 2 - uv[axis];
      uv[1 - axis] = 1 - uv[1 - axis];
    }
    return glm::clamp(uv, 0.0, 1.0);
  }
};

class Spherical final : public Camera {
 public:
  Spherical(const Parameters& p, const CameraContext& c)
      : Camera(p, c), track(c.sceneFromCamera), size(c.width, c.height) {
    if (p.string("mapping") == "equalarea")
      map = std::make_unique<EqualArea>();
    else
      map = std::make_unique<Equirectangular>();
  }

  std::optional<CameraRay> sampleRay(const CameraSample& sample) const override {
    const Vec3d direction = map->direction(Vec2d(sample.film) / size);
    CameraRay r;
    r.time = sample.time;
    // Angle of the side of a square pixel with this solid angle [rad].
    r.spread = static_cast<float>(1 / std::sqrt(size.x * size.y * map->pdf(direction)));
    track.at(sample.time, [&](const CameraFrame& frame) {
      r.origin = Vec3f(frame.pointToScene(Vec3d(0)));
      r.direction = Vec3f(glm::normalize(frame.vectorToScene(direction)));
    });
    return r;
  }
  bool usesTime() const override { return track.moves(); }

  bool isConnectable() const override { return true; }
  bool isDeltaPosition() const override { return true; }
  std::optional<WiSample> sampleWi(const Vec3f& point, const Vec2f&, float time) const override {
    return track.at(time, [&](const CameraFrame& frame) -> std::optional<WiSample> {
      const Vec3d seen = frame.pointToCamera(Vec3d(point)), position = frame.pointToScene(Vec3d(0));
      const double distance = glm::distance(position, Vec3d(point)), inCamera = glm::length(seen);
      if (!(distance > 0)) return {};
      return WiSample{.film = map->place(seen / inCamera) * size,
                      .position = position,
                      .direction = (position - Vec3d(point)) / distance,
                      .distance = static_cast<float>(distance),
                      .importance =
                          static_cast<float>(size.x * size.y * pdfDirection(frame, seen / inCamera)),
                      .pdf = static_cast<float>(square(distance))};
    });
  }
  WePdf pdfWe(const Ray& ray) const override {
    return track.at(ray.time, [&](const CameraFrame& frame) {
      const Vec3d direction = glm::normalize(frame.vectorToCamera(Vec3d(ray.direction)));
      return WePdf{1, static_cast<float>(pdfDirection(frame, direction))};
    });
  }

 private:
  double pdfDirection(const CameraFrame& frame, const Vec3d& direction) const {
    return map->pdf(direction) * frame.solidAngleRatio(direction);
  }

  CameraTrack track;
  Vec2d size; ///< size of the film [pixels]
  std::unique_ptr<SphereMap> map;
};

} // namespace

void registerSpherical(PlugIns& plugIns) {
  std::vector<ParameterSpec> parameters = cameraParameters();
  parameters.push_back(
      stringParameter("mapping", "equalarea",
                      "\"equalarea\": the octahedral map of light probes, with up in the middle; "
                      "\"equirectangular\": longitude by polar angle, with up at the top")
          .oneOf({"equalarea", "equirectangular"}));
  plugIns.cameras.add(
      {{.name = "spherical",
        .summary = "Sees all directions around its position.",
        .parameters = parameters,
        .examples = {"", "\"string mapping\" \"equirectangular\""}},
       [](const Parameters& p, const CameraContext& c) { return std::make_unique<Spherical>(p, c); }});
}

} // namespace recurse
