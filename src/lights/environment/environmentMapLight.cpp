/** @file
 * Emission and direct-light sampling of environment maps. Directions are computed in double precision,
 * because a sun may be a single pixel.
 */
#include "lights/environment/environmentMapLight.h"

#include <numbers>

#include "recurse/core/sampling/sampling.h"

namespace recurse {

namespace {

using std::numbers::pi;
/** Fraction of samples beside a portal, so that light from elsewhere is sampled too. */
constexpr double BESIDE_PORTAL = 0.1;
/** Cells of a portal's table along each side. Finer detail is left to the samples beside the portal and to
 * BSDF sampling. */
constexpr int PORTAL_RESOLUTION = 512;

/** Chooses with the given probability, and rescales u to a fresh number in [0, 1). */
bool choose(float& u, double probability) {
  const auto p = static_cast<float>(probability);
  const bool first = u < p;
  u = std::clamp(first ? u / p : (u - p) / (1 - p), 0.0f, ONE_MINUS_EPSILON);
  return first;
}

} // namespace

EnvironmentMapLight::EnvironmentMapLight(EnvironmentMap picture, const Rgb& scale, const Mat4d& transform)
    : map(std::move(picture)), scale(scale), lightFromScene(glm::inverse(Mat3d(transform))),
      sceneFromLight(transform), determinant(std::abs(glm::determinant(lightFromScene))) {}

void EnvironmentMapLight::addPortal(const std::array<Vec3d, 4>& corners) {
  portal.emplace(
      corners, [this](const Vec3d& d) { return radianceFrom(d); }, PORTAL_RESOLUTION);
}

Vec3d EnvironmentMapLight::toLight(const Vec3d& direction, double& stretch) const {
  const Vec3d d = lightFromScene * direction;
  const double length = glm::length(d);
  stretch = determinant / (length * length * length);
  return d / length;
}

bool EnvironmentMapLight::inSun(const Vec3d& direction) const {
  const Vec3d away = direction - sun->direction; // its squared length is 2 (1 - cosine)
  return glm::dot(away, away) <= 2 * sun->opening;
}

Rgb EnvironmentMapLight::radianceFrom(const Vec3d& direction) const {
  double stretch;
  const Rgb sky = map.value(toLight(direction, stretch)) * scale;
  return sun && inSun(direction) ? sky + sun->radiance : sky;
}

double EnvironmentMapLight::sunPart() const {
  if (!sun) return 0;
  const double disc = double(luminance(sun->radiance)) * 2 * pi * sun->opening;
  const double rest = double(luminance(Rgb(map.integral()) * scale));
  return disc + rest > 0 ? disc / (disc + rest) : 0;
}

Vec3d EnvironmentMapLight::sampleSky(float& pick, const Vec2f& u, Sampling sampling) const {
  if (sun && choose(pick, sunPart())) {
    const Frame frame{Vec3f(sun->direction)};
    const Vec3f local = uniformCone(u, static_cast<float>(sun->opening));
    return glm::normalize(Vec3d(frame.x) * double(local.x) + Vec3d(frame.y) * double(local.y) +
                          sun->direction * double(local.z));
  }
  return glm::normalize(sceneFromLight * map.sample(u, sampling).direction);
}

double EnvironmentMapLight::pdfSky(const Vec3d& direction, Sampling sampling) const {
  double stretch;
  const Vec3d d = toLight(direction, stretch);
  const double part = sunPart();
  const double disc = part > 0 && inSun(direction) ? part / (2 * pi * sun->opening) : 0;
  return disc + (part < 1 ? (1 - part) * map.pdf(d, sampling) * stretch : 0);
}

double EnvironmentMapLight::pdfPosition(const Vec3d& origin, const Vec3d& direction) const {
  const auto disc = double(bounds.pdfDisc());
  const double area = portal ? portal->projectedArea(direction) : 0;
  if (!(area > 0)) return disc;
  return BESIDE_PORTAL * disc + (portal->isCrossed(origin, direction) ? (1 - BESIDE_PORTAL) / area : 0);
}

Rgb EnvironmentMapLight::power() const {
  Rgb sum = Rgb(map.integral()) * scale;
  if (sun) sum += sun->radiance * static_cast<float>(2 * pi * sun->opening);
  return sum / bounds.pdfDisc();
}

std::optional<LeSample> EnvironmentMapLight::sampleLe(const LeRandom& sample) const {
  float pick = sample.pick;
  const Vec3d towards = sampleSky(pick, sample.direction, Sampling::COMPLETE), direction = -towards;
  const double pdf = pdfSky(towards, Sampling::COMPLETE);
  if (!(pdf > 0)) return {};
  const auto center = Vec3d(bounds.center);
  const auto radius = double(bounds.radius);
  Vec3d on; // some point of the ray
  if (portal && portal->projectedArea(direction) > 0 && !choose(pick, BESIDE_PORTAL)) {
    on = portal->point(Vec2d(sample.position));
  } else {
    const Frame frame{Vec3f(towards)};
    const Vec2f d = uniformDisk(sample.position) * bounds.radius;
    on = center + Vec3d(frame.x * d.x + frame.y * d.y);
  }
  const Vec3d origin = on - direction * (glm::dot(on - center, direction) + radius);
  LeSample s{{Vec3f(origin), Vec3f(direction)}, radianceFrom(towards), 1, 1, BLACK};
  s.pdfDirection = static_cast<float>(pdf);
  s.pdfPosition = static_cast<float>(pdfPosition(on, direction));
  s.flux = s.radiance * static_cast<float>(1 / (pdf * double(s.pdfPosition)));
  return s;
}

LePdf EnvironmentMapLight::pdfLe(const LeRay& ray) const {
  const Vec3d direction = glm::normalize(Vec3d(ray.direction));
  return {static_cast<float>(pdfPosition(Vec3d(ray.origin), direction)),
          static_cast<float>(pdfSky(-direction, Sampling::COMPLETE))};
}

double EnvironmentMapLight::pdfTowards(const Vec3d& from, const Vec3d& direction) const {
  const double sky = pdfSky(direction, Sampling::COMPENSATED);
  if (!portal) return sky;
  const std::optional<double> through = portal->pdf(from, direction);
  return through ? BESIDE_PORTAL * sky + (1 - BESIDE_PORTAL) * *through : sky;
}

float EnvironmentMapLight::pdfLi(const Vec3f& from, const Vec3f& direction) const {
  return static_cast<float>(pdfTowards(Vec3d(from), glm::normalize(Vec3d(direction))));
}

std::optional<LiSample> EnvironmentMapLight::sampleLi(const Vec3f& point, float pick, const Vec2f& u) const {
  const Vec3d from(point);
  std::optional<Portal::Sample> through;
  if (portal) through = portal->sample(from, Vec2d(u));
  const bool beside = !through || choose(pick, BESIDE_PORTAL);
  const Vec3d direction = beside ? sampleSky(pick, u, Sampling::COMPENSATED) : through->direction;
  const double pdf = pdfTowards(from, direction);
  if (!(pdf > 0)) return {};
  LiSample s;
  s.direction = Vec3f(direction);
  s.target = point;
  s.distance = INFINITE;
  s.radiance = radianceFrom(direction);
  s.pdf = static_cast<float>(pdf);
  return s;
}

} // namespace recurse
