/** @file
 * Probes of a scene without light: points that the camera sees, points that are lit, and surfaces between.
 */
#include "apps/run/blackPicture.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <vector>

#include "apps/options/optionText.h"
#include "apps/run/firstPicture.h"
#include "recurse/core/sampling/sampling.h"
#include "recurse/core/threads/interrupt.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/core/threads/watchdog.h"
#include "transport/paths/walker.h"

namespace recurse::apps {

namespace {

/** Number of probes across the picture; its square is the number of directions from a point. */
constexpr int ACROSS = 64;
/** Number of samples of each light's emission, and of lights that are probed. */
constexpr int EMISSIONS = 64;
constexpr size_t MAX_LIGHTS = 256;
/** Sampler stream of the probes. */
constexpr uint64_t PROBE_STREAM = 0x4441524bull;
/** A picture is nearly black if its mean is below this fraction of lampRadiance(). */
constexpr double NEARLY_BLACK_PART = 0.1;
constexpr const char* TURN_LAMP =
    "A lamp emits to the side of its normal only: reverse it (ReverseOrientation), or let it emit to both "
    "sides (\"bool twosided\" true)";

/** True if light passes a surface of this material in some direction. */
bool letsLightPass(const Material* material) {
  return !material || material->opacity || (material->lobes() & (TRANSMISSION | REFRACTION | STRAIGHT)) != 0;
}

/** Probes of a scene in which no light was seen. */
class DarkScene {
 public:
  explicit DarkScene(const LoadedScene& loaded) : loaded(loaded), scene(*loaded.scene) {}

  /** True if path tracing with at most `maxDepth` scattering events (-1: any) finds light in the picture. */
  bool showsLight(int maxDepth) const {
    const PathClasses all;
    const std::unique_ptr<Integrator> path = pathTracerThatLearnsNothing(maxDepth);
    std::atomic<bool> isLit{false};
    parallelFor(ACROSS, [&](size_t row) {
      TransportCounts own;
      PathRadiance radiance(all, own);
      forCameraRays(int(row), [&](const CameraRay& ray, Sampler& sampler) {
        if (isLit) return;
        radiance.reset();
        path->backward(scene, ray, sampler, radiance);
        if (!isBlack(radiance.total())) isLit = true;
      });
    });
    return isLit;
  }

  /** Reason why lamps, beside infinite lights, light nothing in a picture that would be much brighter with
   * them; empty if they do. `mean`, `brightest`: luminance of the picture and of its brightest pixel. */
  std::string idleLampsReason(double mean, double brightest) {
    const SceneContents& contents = scene.contents();
    const bool hasLamps = contents.areaLights + contents.deltaLights > 0;
    const bool hasCaustics = contents.deltaLights > 0 && (contents.lobes & DELTA_LOBES);
    if (!hasLamps || hasCaustics || scene.hasEmissiveMedia()) return "";
    shine();
    if (lamps.empty() || !shinesFromAfar) return "";
    look();
    const double expected = lampRadiance();
    if (mean >= NEARLY_BLACK_PART * expected || brightest >= expected || showsLamps()) return "";
    const bool reachVisible = lampsInSight().lit > 0; // lamps far away may reach surfaces by few rays
    if (lampsLanded == 0 && !reachVisible) return std::string("their light hits no surface. ") + TURN_LAMP;
    return areTurnedAway()
               ? std::string("they emit away from all surfaces that the camera sees. ") + TURN_LAMP
               : "";
  }

  /** True if the camera sees surfaces, and all of them are mirrors or glass. Call after reason(). */
  bool showsDeltaSurfacesOnly() const { return !seen.empty() && !seesNonDelta; }

  std::string reason() {
    if (const std::string none = withoutLight(); !none.empty()) return none;
    look();
    if (const std::string medium = misplacedMedium(); !medium.empty()) return medium;
    if (seen.empty()) return nothingSeen();
    shine();
    if (emitted > 0 && landed == 0 && lampsInSight().lit == 0) return lightLeaves();
    // Light of delta lights may arrive by mirrors and glass alone.
    if (scene.contents().deltaLights > 0 && (scene.contents().lobes & DELTA_LOBES)) return "";
    return betweenLightAndCamera();
  }

 private:
  /** Calls use(ray, sampler) for the rays of one row of cells of the picture. */
  template <class Use> void forCameraRays(int row, const Use& use) const {
    for (int x = 0; x < ACROSS; ++x) {
      Sampler sampler(PROBE_STREAM, static_cast<uint64_t>(row), static_cast<uint32_t>(x));
      CameraSample sample{scene.film().crop.middleOfCell(x, row, ACROSS)};
      if (scene.camera().usesLens()) sample.lens = sampler.next2D();
      sample.time = scene.camera().timeAt(sampler.next1D());
      if (const std::optional<CameraRay> ray = scene.camera().validRay(sample)) use(*ray, sampler);
    }
  }
  template <class Use> void forCameraRays(const Use& use) const {
    for (int row = 0; row < ACROSS; ++row) forCameraRays(row, use);
  }

  /** Finds the first surface along the ray that scatters. False if there is none. */
  bool firstSurface(Ray ray, Hit& hit) {
    while (intersect(scene, ray, hit, counts)) {
      if (hit.material) return true;
      ray = rayBehind(ray, hit);
    }
    return false;
  }

  std::string withoutLight() const {
    if (scene.hasEmissiveMedia()) return "";
    if (scene.lights().size() == 0)
      return "the scene has no light: add a LightSource, or an AreaLightSource to a shape";
    for (size_t i = 0; i < scene.lights().size(); ++i)
      if (!isBlack(scene.lights()[i].power())) return "";
    return "all lights of the scene have a power of 0: check \"L\", \"I\", \"scale\" and \"power\" of the "
           "lights";
  }

  /** Collects the points that the camera sees, and counts the media that its rays pass. */
  void look() {
    passed.assign(scene.mediumCount() + 1u, 0);
    filled.assign(scene.mediumCount() + 1u, 0);
    forCameraRays([&](const CameraRay& cameraRay, Sampler&) {
      ++rays;
      Ray ray = cameraRay;
      if (!eye) eye = ray.origin;
      uint16_t medium = scene.cameraMedium();
      for (Hit hit;; ray = rayBehind(ray, hit)) {
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
          seesNonDelta = seesNonDelta || (hit.material->lobes() & NON_DELTA_LOBES);
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
        return "the grid of a medium is outside of the shape that bounds it. MakeNamedMedium uses the "
               "transform of its line, which after LookAt is that of the camera: move it before LookAt, or "
               "after WorldBegin";
    return "";
  }

  std::string nothingSeen() const {
    const Vec3d center = scene.origin() + Vec3d(scene.bounds().center);
    const Vec3d inCamera = Vec3d(glm::inverse(loaded.description.worldFromCamera) * Vec4d(center, 1));
    const double radius = double(scene.bounds().radius);
    return formatted(
        "none of %zu rays from the camera hits a surface: the scene, of diameter %.3g and center (%.3g, "
        "%.3g, %.3g), is %s. Check LookAt (eye, target, up), \"fov\" and \"screenwindow\"",
        rays, 2 * radius, center.x, center.y, center.z,
        inCamera.z < 0 ? "behind the camera" : "outside of the picture");
  }

  /** Traces photons to the first surface, and collects points on lamps. */
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
        const bool lands = firstSurface({photon->origin, photon->direction, INFINITE, photon->time}, hit);
        landed += lands;
        shinesFromAfar = shinesFromAfar || light.isInfinite();
        if (light.isInfinite()) continue;
        lampsLanded += lands;
        lamps.push_back({&light, photon->origin});
      }
    }
  }

  std::string lightLeaves() const {
    const std::string hits = formatted("none of %zu rays from the lights hits a surface. ", emitted);
    return hits +
           (scene.contents().areaLights > 0 ? TURN_LAMP : "Check the positions and directions of the lights");
  }

  /** Median radiance of the points that the camera sees, if the lamps emitted uniformly in all directions,
   * without occlusion, and half of the light were scattered. */
  double lampRadiance() const {
    if (seen.empty()) return 0;
    double power = 0;
    for (size_t i = 0; i < scene.lights().size(); ++i)
      if (!scene.lights()[i].isInfinite()) power += double(luminance(scene.lights()[i].power()));
    std::vector<double> all;
    for (size_t i = 0; i < seen.size(); ++i) {
      const Vec3f& lamp = lamps[i * lamps.size() / seen.size()].position;
      all.push_back(power / (4 * M_PI * double(lengthSquared(lamp - seen[i].position))) / (2 * M_PI));
    }
    const auto middle = all.begin() + std::ptrdiff_t(all.size() / 2);
    std::nth_element(all.begin(), middle, all.end());
    return *middle;
  }

  /** True if paths from the camera find light of lamps. */
  bool showsLamps() const {
    std::atomic<bool> isLit{false};
    parallelFor(ACROSS, [&](size_t row) {
      TransportCounts own;
      forCameraRays(int(row), [&](const CameraRay& ray, Sampler& sampler) {
        if (!isLit && findsLamp(ray, sampler, own)) isLit = true;
      });
    });
    return isLit;
  }

  /** Follows one path, with a shadow ray to some lamp at each vertex. */
  bool findsLamp(const CameraRay& ray, Sampler& sampler, TransportCounts& own) const {
    const PathClasses all;
    CameraWalker walker(scene, all, own, -1);
    CameraSubpath path = startCameraSubpath(scene, all, ray, own);
    CameraVertex vertex;
    bool isFound = false;
    const auto onEmission = [&](const Hit* hit) {
      isFound = isFound || (hit && !isBlack(hit->areaLight->radiance(hit->point, -path.ray.direction)));
    };
    while (walker.next(path, vertex, sampler, onEmission) && !isFound) {
      const Light& light = *lamps[lampIndex(sampler)].light;
      const float pick = sampler.next1D();
      const auto sample =
          light.sampleLiAt(vertex.hit.point.time, vertex.hit.point.position, pick, sampler.next2D());
      const bool mayScatter =
          sample && !isBlack(sample->radiance) &&
          (vertex.medium || !isBlack(vertex.scattering->evaluate(vertex.wi, sample->direction)));
      if (mayScatter && !isBlack(transmittance(scene, vertex.hit, vertex.wi, *sample, path.nesting,
                                               panesLeft(-1, vertex.depth), own)))
        return true;
      if (!walker.scatter(path, vertex, sampler)) break;
    }
    return isFound;
  }

  size_t lampIndex(Sampler& sampler) const {
    return std::min(lamps.size() - 1, size_t(sampler.next1D() * float(lamps.size())));
  }

  /** True if no opaque surface is between the points. */
  bool isFree(const SurfacePoint& from, const Vec3f& to) {
    Ray ray = spawn(from, to - from.position);
    ray.direction = to - ray.origin;
    ray.tMax = 1 - 1e-3f; // the lamp's own surface does not occlude it
    for (Hit hit; ray.tMax > 0 && intersect(scene, ray, hit, counts);) {
      if (!letsLightPass(hit.material)) return false;
      ray = rayBehind(ray, hit);
    }
    return true;
  }

  /** True if rays in all directions from the camera hit opaque surfaces; `object`: theirs, if it is one. */
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

  /** Pairs of a visible point and a point on a lamp: without occlusion, and the lit ones among them. */
  struct LampsInSight {
    size_t free = 0, lit = 0;
  };
  LampsInSight lampsInSight() {
    Sampler sampler(PROBE_STREAM, 3 * uint64_t(ACROSS) + MAX_LIGHTS, 0);
    LampsInSight out;
    for (const SurfacePoint& point : seen) {
      if (lamps.empty()) break;
      const auto& [light, at] = lamps[lampIndex(sampler)];
      const float pick = sampler.next1D();
      const Vec2f u = sampler.next2D();
      if (!isFree(point, at)) continue;
      ++out.free;
      const auto arriving = light->sampleLi(point.position, pick, u);
      out.lit += arriving && !isBlack(arriving->radiance);
    }
    return out;
  }
  bool areTurnedAway() {
    const LampsInSight lampsSeen = lampsInSight();
    return lampsSeen.free > 0 && lampsSeen.lit == 0;
  }

  std::string betweenLightAndCamera() {
    const LampsInSight lampsSeen = lampsInSight();
    if (lampsSeen.free > 0 && lampsSeen.lit == 0)
      return std::string("the lamps emit away from all surfaces that the camera sees. ") + TURN_LAMP;
    if (lampsSeen.free > 0) return "";
    std::optional<uint32_t> object;
    if (!eye || !isShutIn(object)) return "";
    if (object)
      return "the camera is inside of " + scene.objectName(*object) +
             ", which is opaque, and all light is outside: move the camera (LookAt), or the light";
    return "the camera is in a closed room, and all light is outside of it: put a lamp inside, or open the "
           "room";
  }

  struct Lamp {
    const Light* light;
    Vec3f position;
  };

  const LoadedScene& loaded;
  const Scene& scene;
  TransportCounts counts;
  size_t rays = 0, emitted = 0, landed = 0, lampsLanded = 0;
  bool shinesFromAfar = false, seesNonDelta = false;
  std::optional<Vec3f> eye;
  std::vector<SurfacePoint> seen;
  std::vector<size_t> passed, filled; ///< by medium: rays in its shape, and rays that hit its grid
  std::vector<Lamp> lamps;            ///< points of finite lights
};

/** Result of the probes; empty if `stop` became true or they took too long. */
template <class Probe>
std::string unlessStopped(const std::atomic<bool>& stop, double seconds, const Probe& probe) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  std::atomic<bool> enough{stop.load()};
  const Watchdog watchdog([&] {
    if (stop || Clock::now() > end) enough = true;
  });
  const InterruptibleWork probing(&enough);
  try {
    checkInterrupted();
    return probe();
  } catch (const Interrupted&) {
    return "";
  }
}

/** Luminance of a picture. */
struct Brightness {
  explicit Brightness(const Film& film) : pixels(film.bounds().area()) {
    for (size_t i = 0; i < pixels; ++i) {
      const double y = film.luminanceOf(i);
      lit += y > 0;
      mean += y / double(pixels);
      brightest = std::max(brightest, y);
    }
  }
  /** True if fewer than one pixel in a thousand has light. */
  bool isNone() const { return lit * 1000 < pixels; }
  size_t pixels, lit = 0;
  double mean = 0, brightest = 0;
};

std::string noLightText(const LoadedScene& loaded, const PathClasses& classes, bool isAllBlack) {
  const std::string what = isAllBlack ? "the picture is black: " : "the picture is nearly black: ";
  DarkScene dark(loaded);
  if (dark.showsLight(-1)) {
    if (!isAllBlack) return "";
    if (classes.lightStateCount() > 1)
      return what + "no light arrives by the paths " + classes.classes()[0].expression +
             " of --paths, but by other paths";
    for (const ParsedParameter& p : loaded.integratorDirective.parameters)
      if (p.name == "maxdepth" && p.numbers.size() == 1 && p.numbers[0] >= 0 &&
          !dark.showsLight(static_cast<int>(p.numbers[0])))
        return what + formatted("all paths with light have more scattering events than \"maxdepth\" %.0f "
                                "allows: increase \"maxdepth\"",
                                p.numbers[0]);
    return what + "\"" + loaded.integratorDirective.type +
           "\" found no light, but path tracing does: take more samples (--spp), or --integrator photonmap";
  }
  const std::string reason = dark.reason();
  if (!reason.empty()) return what + reason;
  if (!isAllBlack) return "";
  if (dark.showsDeltaSurfacesOnly())
    return what +
           "the camera sees only glass and mirrors, in which nothing lit or bright appears: add a floor "
           "or an environment";
  return what + "no light arrives at the surfaces that the camera sees: are the lights enclosed, or the "
                "surfaces black?";
}

} // namespace

std::string darknessReason(const LoadedScene& loaded) {
  return unlessStopped(std::atomic<bool>{false}, PROBE_SECONDS, [&] {
    DarkScene dark(loaded);
    return dark.showsLight(-1) ? "" : dark.reason();
  });
}

std::string blackPictureText(const LoadedScene& loaded, const PathClasses& classes, const Film& film,
                             const std::atomic<bool>& stop, double seconds) {
  const Brightness brightness(film);
  return unlessStopped(stop, seconds, [&]() -> std::string {
    if (brightness.isNone()) return noLightText(loaded, classes, brightness.lit == 0);
    if (classes.lightStateCount() > 1) return "";
    const std::string reason = DarkScene(loaded).idleLampsReason(brightness.mean, brightness.brightest);
    return reason.empty() ? "" : "the lamps illuminate no surface that the camera sees: " + reason;
  });
}

} // namespace recurse::apps
