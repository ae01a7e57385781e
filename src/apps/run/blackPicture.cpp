/** @file
 * Probes of a scene without light: what the camera sees, where the lights shine, and what lies between.
 */
#include "apps/run/blackPicture.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "apps/options/optionText.h"
#include "apps/run/firstPicture.h"
#include "recurse/core/sampling/sampling.h"
#include "transport/paths/walk.h"

namespace recurse::apps {

namespace {

/** Probes across the picture, and in all directions from a point. */
constexpr int ACROSS = 64;
/** Samples of each light's emission; lights that are probed. */
constexpr int EMISSIONS = 64;
constexpr size_t MAX_LIGHTS = 256;
/** Tells these samples from all others. */
constexpr uint64_t PROBE_STREAM = 0x4441524bull;

/** Light passes a surface of such a material in some direction. */
bool letsLightPass(const Material* material) {
  return !material || material->opacity || (material->lobes() & (TRANSMISSION | REFRACTION | STRAIGHT)) != 0;
}

/** Probes of a scene in which no light was seen. */
class DarkScene {
 public:
  explicit DarkScene(const LoadedScene& loaded) : loaded(loaded), scene(*loaded.scene) {}

  /** Whether path tracing with at most `maxDepth` scattering events (-1: any) finds light in the picture. */
  bool showsLight(int maxDepth) const {
    const PathClasses all;
    const std::unique_ptr<Integrator> path = pathTracerThatLearnsNothing(maxDepth);
    bool isLit = false;
    TransportCounts counts;
    PathRadiance radiance(all, counts);
    forCameraRays([&](const CameraRay& ray, Sampler& sampler) {
      if (isLit) return;
      radiance.reset();
      path->backward(scene, ray, sampler, radiance);
      isLit = !isBlack(radiance.total());
    });
    return isLit;
  }

  std::string reason() {
    if (const std::string none = withoutLight(); !none.empty()) return none;
    look();
    if (const std::string medium = misplacedMedium(); !medium.empty()) return medium;
    if (seen.empty()) return nothingSeen();
    shine();
    if (emitted > 0 && landed == 0) return lightLeaves();
    // Light of lamps at a point may come by mirrors and glass alone.
    if (scene.contents().deltaLights > 0 && (scene.contents().lobes & DELTA_LOBES)) return "";
    return betweenLightAndCamera();
  }

 private:
  template <class Use> void forCameraRays(const Use& use) const {
    const PixelBounds& film = scene.film().crop;
    for (int y = 0; y < ACROSS; ++y)
      for (int x = 0; x < ACROSS; ++x) {
        Sampler sampler(PROBE_STREAM, static_cast<uint64_t>(y), static_cast<uint32_t>(x));
        CameraSample sample{film.middleOfCell(x, y, ACROSS)};
        if (scene.camera().usesLens()) sample.lens = sampler.next2D();
        sample.time = scene.camera().timeAt(sampler.next1D());
        if (const std::optional<CameraRay> ray = scene.camera().validRay(sample)) use(*ray, sampler);
      }
  }

  /** The first surface along the ray that scatters. */
  bool firstSurface(Ray ray, Hit& hit) {
    while (intersect(scene, ray, hit, counts)) {
      if (hit.material) return true;
      ray.origin = originBehind(ray, hit);
    }
    return false;
  }

  bool hasGlowingMedium() const {
    for (uint16_t i = 1; i <= scene.mediumCount(); ++i)
      if (scene.medium(i)->isEmissive()) return true;
    return false;
  }

  std::string withoutLight() const {
    if (hasGlowingMedium()) return "";
    if (scene.lights().size() == 0)
      return "the scene has no light: give it a LightSource, or a shape an AreaLightSource";
    for (size_t i = 0; i < scene.lights().size(); ++i)
      if (!isBlack(scene.lights()[i].power())) return "";
    return "all lights of the scene have a power of 0: look at \"L\", \"I\", \"scale\" and \"power\" of the "
           "lights";
  }

  /** What the camera sees, and which media its rays pass. */
  void look() {
    passed.assign(scene.mediumCount() + 1u, 0);
    filled.assign(scene.mediumCount() + 1u, 0);
    forCameraRays([&](const CameraRay& cameraRay, Sampler&) {
      ++rays;
      Ray ray = cameraRay;
      if (!eye) eye = ray.origin;
      uint16_t medium = scene.cameraMedium();
      for (Hit hit;; ray.origin = originBehind(ray, hit)) {
        const bool isHit = intersect(scene, ray, hit, counts);
        if (isHit && hit.media.isBoundary())
          medium =
              glm::dot(ray.direction, hit.point.geometricNormal) < 0 ? hit.media.outside : hit.media.inside;
        if (const Medium* within = scene.medium(medium)) {
          ++passed[medium];
          filled[medium] += meets(within->bounds(), ray, isHit ? hit.t : INFINITE);
        }
        if (!isHit) return;
        if (hit.material) {
          seen.push_back(hit.point);
          seen.back().geometricNormal = hit.point.normalTowards(-ray.direction);
          return;
        }
        if (hit.media.isBoundary())
          medium =
              glm::dot(ray.direction, hit.point.geometricNormal) > 0 ? hit.media.outside : hit.media.inside;
      }
    });
  }

  static bool meets(const Bounds3f& box, const Ray& ray, float end) {
    float t0 = 0, t1 = end;
    for (int i = 0; i < 3; ++i) {
      const float a = (box.lower[i] - ray.origin[i]) / ray.direction[i],
                  b = (box.upper[i] - ray.origin[i]) / ray.direction[i];
      t0 = std::max(t0, std::min(a, b));
      t1 = std::min(t1, std::max(a, b));
    }
    return t0 < t1;
  }

  std::string misplacedMedium() const {
    for (uint16_t i = 1; i <= scene.mediumCount(); ++i)
      if (passed[i] > 0 && filled[i] == 0)
        return "the shape of a medium is empty: the medium's grid lies elsewhere. MakeNamedMedium has the "
               "coordinates of its line; after LookAt those are the camera's. Move it in front of LookAt, or "
               "behind WorldBegin";
    return "";
  }

  std::string nothingSeen() const {
    const Vec3d center = scene.origin() + Vec3d(scene.bounds().center);
    const Vec3d inCamera = Vec3d(glm::inverse(loaded.description.worldFromCamera) * Vec4d(center, 1));
    const double radius = double(scene.bounds().radius);
    return formatted("none of %zu rays from the camera hits a surface: the scene, %.3g wide around (%.3g, "
                     "%.3g, %.3g), lies %s. Look at LookAt (eye, target, up), \"fov\" and \"screenwindow\"",
                     rays, 2 * radius, center.x, center.y, center.z,
                     inCamera.z < 0 ? "behind the camera" : "outside of the picture");
  }

  /** Where light goes that leaves the lights. */
  void shine() {
    const size_t every = (scene.lights().size() + MAX_LIGHTS - 1) / MAX_LIGHTS;
    for (size_t i = 0; i < scene.lights().size(); i += every) {
      const Light& light = scene.lights()[i];
      for (int n = 0; n < EMISSIONS; ++n) {
        Sampler sampler(PROBE_STREAM, uint64_t(ACROSS) + i, static_cast<uint32_t>(n));
        const float pick = sampler.next1D();
        const Vec2f place = sampler.next2D(), direction = sampler.next2D();
        const auto photon = light.sampleLe({pick, place, direction, scene.camera().timeAt(0)});
        if (!photon || isBlack(photon->flux)) continue;
        ++emitted;
        Hit hit;
        landed += firstSurface({photon->origin, photon->direction, INFINITE, photon->time}, hit);
        if (!light.isInfinite()) lamps.push_back({&light, photon->origin});
      }
    }
  }

  std::string lightLeaves() const {
    const std::string hits = "no light falls on a surface: all that the lights send out leaves the scene. ";
    if (scene.contents().areaLights > 0)
      return hits + "A lamp shines to the side of its normal: turn it round (ReverseOrientation), or let it "
                    "shine to both sides (\"bool twosided\" true)";
    return hits + "Look at where the lights stand and point to";
  }

  /** True where nothing opaque lies between. */
  bool isFree(const SurfacePoint& from, const Vec3f& to) {
    Ray ray = spawn(from, to - from.position);
    ray.direction = to - ray.origin;
    ray.tMax = 1 - 1e-3f; // a lamp's surface is not in its way
    for (Hit hit; ray.tMax > 0 && intersect(scene, ray, hit, counts);) {
      if (!letsLightPass(hit.material)) return false;
      ray.origin = originBehind(ray, hit);
      ray.tMax -= hit.t;
    }
    return true;
  }

  /** Whether all directions from the camera end at opaque surfaces; their object where it is one. */
  bool isShutIn(std::optional<uint32_t>& object) {
    bool isOne = true;
    for (int i = 0; i < ACROSS * ACROSS; ++i) {
      Sampler sampler(PROBE_STREAM, 2 * uint64_t(ACROSS) + MAX_LIGHTS, static_cast<uint32_t>(i));
      Hit hit;
      if (!firstSurface({*eye, uniformSphere(sampler.next2D()), INFINITE, 0}, hit)) return false;
      if (letsLightPass(hit.material)) return false;
      isOne = isOne && (!object || *object == hit.object);
      object = hit.object;
    }
    if (!isOne) object.reset();
    return true;
  }

  std::string betweenLightAndCamera() {
    Sampler sampler(PROBE_STREAM, 3 * uint64_t(ACROSS) + MAX_LIGHTS, 0);
    size_t free = 0, lit = 0;
    for (const SurfacePoint& point : seen) {
      if (lamps.empty()) break;
      const auto& [light, at] =
          lamps[std::min(lamps.size() - 1, size_t(sampler.next1D() * float(lamps.size())))];
      const float pick = sampler.next1D();
      const Vec2f u = sampler.next2D();
      if (!isFree(point, at)) continue;
      ++free;
      const auto light2 = light->sampleLi(point.position, pick, u);
      lit += light2 && !isBlack(light2->radiance);
    }
    if (free > 0 && lit == 0)
      return "the lamps are turned away from all that the camera sees: a lamp shines to the side of its "
             "normal. "
             "Turn it round (ReverseOrientation), or let it shine to both sides (\"bool twosided\" true)";
    if (free > 0) return "";
    std::optional<uint32_t> object;
    if (!eye || !isShutIn(object)) return "";
    if (object)
      return "the camera stands inside of " + scene.objectName(*object) +
             ", which is opaque, and no light is in there with it: move the camera (LookAt), or the light";
    return "the camera stands in a room that is closed on all sides, and all light is outside of it: put a "
           "lamp "
           "inside, or open the room";
  }

  struct Lamp {
    const Light* light;
    Vec3f position;
  };

  const LoadedScene& loaded;
  const Scene& scene;
  TransportCounts counts;
  size_t rays = 0, emitted = 0, landed = 0;
  std::optional<Vec3f> eye;
  std::vector<SurfacePoint> seen;
  std::vector<size_t> passed, filled; ///< by media: rays in their shapes, and those that meet their grids
  std::vector<Lamp> lamps;            ///< points of finite lights
};

} // namespace

bool isNearlyBlack(const Film& film) {
  constexpr size_t PART = 1000;
  size_t lit = 0;
  const size_t pixels = film.bounds().area();
  for (size_t i = 0; i < pixels; ++i) lit += film.luminanceOf(i) > 0;
  return lit * PART < pixels;
}

std::string darknessReason(const LoadedScene& loaded) {
  DarkScene dark(loaded);
  return dark.showsLight(-1) ? "" : dark.reason();
}

std::string blackPictureText(const LoadedScene& loaded, const PathClasses& classes, const Film& film) {
  size_t lit = 0;
  for (size_t i = 0; i < film.bounds().area(); ++i) lit += film.luminanceOf(i) > 0;
  const std::string what = lit == 0 ? "the picture is black: " : "the picture is nearly black: ";
  DarkScene dark(loaded);
  if (dark.showsLight(-1)) {
    if (lit > 0) return "";
    if (classes.lightStateCount() > 1)
      return what + "no light comes by the paths " + classes.classes()[0].expression +
             " of --paths; without it there is light";
    for (const ParsedParameter& p : loaded.integratorDirective.parameters)
      if (p.name == "maxdepth" && p.numbers.size() == 1 && p.numbers[0] >= 0 &&
          !dark.showsLight(static_cast<int>(p.numbers[0])))
        return what + formatted("light scatters more often than \"maxdepth\" %.0f allows", p.numbers[0]);
    return what + "\"" + loaded.integratorDirective.type +
           "\" found none of the light that a path tracer finds; take more samples (--spp), or --integrator "
           "photonmap";
  }
  const std::string reason = dark.reason();
  if (!reason.empty()) return what + reason;
  if (lit > 0) return "";
  return what + "light does not reach what the camera sees; are the lights shut in, or the surfaces black?";
}

} // namespace recurse::apps
