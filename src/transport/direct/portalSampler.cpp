/** @file
 * Learning and sampling of portals for shadow rays.
 */
#include "transport/direct/portalSampler.h"

#include <algorithm>
#include <utility>

#include "transport/direct/cameraPaths.h"

namespace recurse {

namespace {

constexpr uint64_t SHADOW_PORTAL_STREAM = 0x574e44575321ull;

/** Sum of the surface areas. */
double area(const std::vector<NestedBox>& boxes) {
  double sum = 0;
  for (const NestedBox& box : boxes) {
    const Vec3d d(box.bounds.diagonal());
    sum += 2 * (d.x * d.y + d.y * d.z + d.z * d.x);
  }
  return sum;
}

} // namespace

float PortalSampler::shares(const Vec3f& point, Shares& upToHere) const {
  float sum = 0;
  for (size_t i = 0; i < boxes.size(); ++i) {
    const Bounds3f& b = boxes[i].bounds;
    const Vec3f away = point - b.center();
    sum += boxes[i].chance / std::max(lengthSquared(away), lengthSquared(b.diagonal()) / 4);
    upToHere[i] = sum;
  }
  return sum;
}

float PortalSampler::pdfThrough(const Shares& upToHere, const Vec3f& point, const Vec3f& direction) const {
  // A point that is uniform in a volume V has, in a direction that is inside from t0 to t1, the density
  // (t1³ - t0³) / 3V [1/sr].
  const Vec3f inverse = Vec3f(1) / direction;
  float sum = 0, before = 0;
  for (size_t i = 0; i < boxes.size(); ++i) {
    const float share = upToHere[i] - std::exchange(before, upToHere[i]);
    const Bounds3f& b = boxes[i].bounds;
    const Vec3f a = (b.lower - point) * inverse, c = (b.upper - point) * inverse;
    const Vec3f near = glm::min(a, c), far = glm::max(a, c);
    const float t0 = std::max({near.x, near.y, near.z, 0.0f}), t1 = std::min({far.x, far.y, far.z});
    if (!(t1 > t0)) continue;
    const Vec3f d = b.diagonal();
    sum += share * ((t1 - t0) / (3 * d.x)) * ((t1 * t1 + t1 * t0 + t0 * t0) / (d.y * d.z));
  }
  return sum / before;
}

std::optional<LiSample> PortalSampler::sampleLi(const EnvironmentLight& light, const Vec3f& point, float pick,
                                                const Vec2f& u) const {
  if (!active()) return light.sampleLi(point, pick, u);
  Shares upToHere;
  const float all = shares(point, upToHere);
  if (pick >= throughPortals) {
    pick = std::min((pick - throughPortals) / (1 - throughPortals), ONE_MINUS_EPSILON);
    std::optional<LiSample> beside = light.sampleLi(point, pick, u);
    if (beside)
      beside->pdf = (1 - throughPortals) * beside->pdf +
                    throughPortals * pdfThrough(upToHere, point, beside->direction);
    return beside;
  }
  const float target = pick / throughPortals * all;
  const float* const last = upToHere.begin() + std::ptrdiff_t(boxes.size()) - 1;
  const auto chosen = size_t(std::upper_bound(upToHere.cbegin(), last, target) - upToHere.cbegin());
  const float below = chosen > 0 ? upToHere[chosen - 1] : 0;
  const float rest = std::clamp((target - below) / (upToHere[chosen] - below), 0.0f, 1.0f);
  const Bounds3f& b = boxes[chosen].bounds;
  const Vec3f towards = b.lower + Vec3f(u, rest) * b.diagonal() - point;
  const float distance = glm::length(towards);
  if (!(distance > 0)) return {};
  LiSample through;
  through.direction = towards / distance;
  through.target = point;
  through.distance = INFINITE;
  through.radiance = light.radiance(through.direction);
  through.pdf = (1 - throughPortals) * light.pdfLi(point, through.direction) +
                throughPortals * pdfThrough(upToHere, point, through.direction);
  if (!(through.pdf > 0)) return {};
  return through;
}

float PortalSampler::pdfLi(const EnvironmentLight& light, const Vec3f& from, const Vec3f& direction) const {
  const float byLight = light.pdfLi(from, direction);
  if (!active()) return byLight;
  Shares upToHere;
  shares(from, upToHere);
  return (1 - throughPortals) * byLight + throughPortals * pdfThrough(upToHere, from, direction);
}

PortalSampler::SecondMoments PortalSampler::secondMoments(const Scene& scene, TransportCounts& counts) const {
  constexpr int MAX_ACROSS = 32, MAX_DEPTH = 3;
  constexpr int SAMPLES = 16; // enough to estimate the square of their mean
  const auto& lights = scene.environment();
  const auto follow = [&](SecondMoments& moments, CameraSubpath& path, CameraWalker& walker, Sampler& sampler,
                          TransportCounts& pathCounts) {
    CameraVertex vertex;
    std::array<double, PARTS.size()> ofPath{};
    double radiance = 0; // radiance of the path, times SAMPLES
    while (walker.next(path, vertex, sampler)) {
      for (int i = 0; vertex.isConnectable() && i < SAMPLES; ++i) {
        const EnvironmentLight& light =
            *lights[std::min(lights.size() - 1, size_t(sampler.next1D() * float(lights.size())))];
        const float pick = sampler.next1D();
        const std::optional<LiSample> s = sampleLi(light, vertex.point().position, pick, sampler.next2D());
        if (!s) continue;
        const ScatteringPoint& scattering = *vertex.scattering;
        const Rgb seen = path.throughput * scattering.evaluate(vertex.wi, s->direction) * s->radiance;
        if (isBlack(seen)) continue;
        const Rgb free = transmittance(scene, vertex.hit, vertex.wi, *s, path.nesting,
                                       std::numeric_limits<int>::max(), pathCounts);
        const auto arriving = double(maxComponent(seen * free)), estimate = arriving / double(s->pdf);
        if (!(estimate > 0)) continue;
        radiance += estimate;
        const float byBsdf = scattering.pdf(vertex.wi, s->direction);
        const float byLight = light.pdfLi(vertex.point().position, s->direction);
        const float portals = (s->pdf - (1 - throughPortals) * byLight) / throughPortals;
        for (size_t k = 0; k < PARTS.size(); ++k)
          ofPath[k] += arriving * estimate / double((1 - PARTS[k]) * byLight + PARTS[k] * portals + byBsdf);
      }
      if (!walker.scatter(path, vertex, sampler)) break;
    }
    for (size_t k = 0; radiance > 0 && k < PARTS.size(); ++k) {
      moments.absolute[k] += ofPath[k];
      moments.relative[k] += ofPath[k] / square(radiance);
    }
  };
  const int resolution =
      std::min(MAX_ACROSS, static_cast<int>(std::sqrt(double(scene.film().whole().area()))));
  SecondMoments sums;
  for (const SecondMoments& row :
       followCameraPaths(scene, resolution, MAX_DEPTH, SHADOW_PORTAL_STREAM, counts, sums, follow))
    for (size_t k = 0; k < PARTS.size(); ++k) {
      sums.absolute[k] += row.absolute[k];
      sums.relative[k] += row.relative[k];
    }
  return sums;
}

TransportCounts PortalSampler::learn(const Scene& scene) {
  constexpr float WORTH_IT = 1.25f; // minimum ratio of second moments without and with portals
  // A mixture weight of 1/4 raises the second moment by at most a third. Without windows, the seeming
  // reduction of relative second moments is a half or less.
  constexpr float WORTH_IT_ELSEWHERE = 4;
  *this = {};
  TransportCounts counts;
  constexpr int MAX_ACROSS = 128;
  if (scene.environment().empty()) return counts;
  const double pixels = double(scene.film().width) * double(scene.film().height);
  const int resolution = std::clamp(static_cast<int>(std::sqrt(pixels)), 1, MAX_ACROSS);
  CameraExits exits = findExits(scene, false, resolution, SHADOW_PORTAL_STREAM, counts);
  if (exits.vertices.empty()) return counts;
  boxes = nestedBoxes(std::move(exits.vertices), LEVELS, flatness(scene), 0);
  std::vector<NestedBox> others = nestedBoxes(std::move(exits.crossings), LEVELS, flatness(scene), 0);
  if (!others.empty() && area(others) < area(boxes)) boxes = std::move(others);
  throughPortals = 0.5f; // mixture weight of the trial shadow rays
  const auto [absolute, relative] = secondMoments(scene, counts);
  const auto least = size_t(std::min_element(absolute.begin(), absolute.end()) - absolute.begin());
  if (absolute[0] > WORTH_IT * absolute[least])
    throughPortals = PARTS[least];
  else
    throughPortals = relative[0] > WORTH_IT_ELSEWHERE * relative[1] ? PARTS[1] : 0;
  if (!active()) boxes.clear();
  return counts;
}

} // namespace recurse
