/** @file
 * Shadow rays through learned portals.
 */
#include "recurse/transport/portalSampler.h"

#include <algorithm>
#include <utility>

#include "recurse/core/parallel.h"
#include "recurse/transport/lightPortals.h"
#include "recurse/transport/walker.h"

namespace recurse {

namespace {

constexpr uint64_t SHADOW_PORTAL_STREAM = 0x574e44575321ull;

} // namespace

void PortalSampler::findSides(const Vec3f& point, Sides& sides) const {
  sides.count = 0;
  float sum = 0;
  for (size_t b = 0; b < boxes.size(); ++b) {
    const Bounds3f& box = boxes[b];
    const Vec3f d = box.diagonal(), way = (box.lower + box.upper) * 0.5f - point;
    for (int axis = 0; axis < 3; ++axis) {
      if (point[axis] >= box.lower[axis] && point[axis] <= box.upper[axis]) continue;
      const float at = point[axis] < box.lower[axis] ? box.lower[axis] : box.upper[axis];
      Vec3f towards = way;
      towards[axis] = at - point[axis];
      const float area = d[(axis + 1) % 3] * d[(axis + 2) % 3], distance2 = lengthSquared(towards);
      const float omega = area * std::abs(towards[axis]) / (distance2 * std::sqrt(distance2));
      if (!(omega > 0)) continue;
      sides.all[sides.count++] = {b, axis, at, area, sum += std::min(omega, 2 * PI)};
    }
  }
}

float PortalSampler::pdfThrough(const Sides& sides, const Vec3f& point, const Vec3f& direction) const {
  float sum = 0, before = 0;
  for (size_t i = 0; i < sides.count; ++i) {
    const Side& side = sides.all[i];
    const float part = side.upToHere - std::exchange(before, side.upToHere);
    const float t = (side.at - point[side.axis]) / direction[side.axis];
    if (!(t > 0 && t < INFINITE)) continue;
    const Bounds3f& box = boxes[side.box];
    bool inside = true;
    for (int k = 1; k < 3; ++k) {
      const int axis = (side.axis + k) % 3;
      const float x = point[axis] + t * direction[axis];
      inside = inside && x >= box.lower[axis] && x <= box.upper[axis];
    }
    if (inside) sum += part * square(t) / (side.area * std::abs(direction[side.axis]));
  }
  return sum / sides.solidAngle();
}

std::optional<LiSample> PortalSampler::sampleLi(const EnvironmentLight& light, const Vec3f& point, float pick,
                                                const Vec2f& u) const {
  Sides sides;
  if (active()) findSides(point, sides);
  const float all = sides.solidAngle();
  if (!(all > 0)) return light.sampleLi(point, pick, u);
  if (pick >= throughPortals) {
    pick = std::min((pick - throughPortals) / (1 - throughPortals), ONE_MINUS_EPSILON);
    std::optional<LiSample> beside = light.sampleLi(point, pick, u);
    if (beside)
      beside->pdf = (1 - throughPortals) * beside->pdf +
                    throughPortals * pdfThrough(sides, point, beside->direction);
    return beside;
  }
  const float chosen = pick / throughPortals * all;
  const Side& side = *std::upper_bound(sides.all.begin(), sides.all.begin() + sides.count - 1, chosen,
                                       [](float value, const Side& s) { return value < s.upToHere; });
  const Bounds3f& box = boxes[side.box];
  Vec3f target(0);
  target[side.axis] = side.at;
  for (int k = 1; k < 3; ++k) {
    const int axis = (side.axis + k) % 3;
    target[axis] = box.lower[axis] + u[k - 1] * (box.upper[axis] - box.lower[axis]);
  }
  const Vec3f towards = target - point;
  const float distance = glm::length(towards);
  if (!(distance > 0)) return {};
  LiSample through;
  through.direction = towards / distance;
  through.target = point;
  through.distance = INFINITE;
  through.radiance = light.radiance(through.direction);
  through.pdf = (1 - throughPortals) * light.pdfLi(point, through.direction) +
                throughPortals * pdfThrough(sides, point, through.direction);
  if (!(through.pdf > 0)) return {};
  return through;
}

float PortalSampler::pdfLi(const EnvironmentLight& light, const Vec3f& from, const Vec3f& direction) const {
  const float own = light.pdfLi(from, direction);
  if (!active()) return own;
  Sides sides;
  findSides(from, sides);
  if (!(sides.solidAngle() > 0)) return own;
  return (1 - throughPortals) * own + throughPortals * pdfThrough(sides, from, direction);
}

std::vector<double> PortalSampler::secondMoments(const Scene& scene, const std::vector<float>& parts,
                                                 TransportCounts& counts) {
  constexpr size_t MAX_ACROSS = 48, SAMPLES = 4;
  constexpr int MAX_DEPTH = 3;
  const PathClasses allPaths;
  const auto& lights = scene.environment();
  const auto across = std::min(MAX_ACROSS, static_cast<size_t>(LightPortals::pathsAcross(scene)));
  std::vector<std::vector<double>> rows(across, std::vector<double>(parts.size()));
  std::vector<TransportCounts> rowCounts(across);
  const PixelBounds& crop = scene.film().crop;
  parallelFor(across, [&](size_t y) {
    Walker<CameraState> walker(scene, allPaths, rowCounts[y], MAX_DEPTH, false);
    for (uint32_t x = 0; x < across; ++x) {
      Sampler sampler(SHADOW_PORTAL_STREAM, y, x);
      CameraSample sample;
      sample.film = {float(crop.x0) + (float(x) + 0.5f) / float(across) * float(crop.width()),
                     float(crop.y0) + (float(y) + 0.5f) / float(across) * float(crop.height())};
      const std::optional<CameraRay> ray = scene.camera().validRay(sample);
      if (!ray) continue;
      CameraSubpath path = startCameraSubpath(scene, allPaths, *ray, rowCounts[y]);
      CameraVertex vertex;
      while (walker.next(path, vertex, sampler, [](const Hit*) {})) {
        for (size_t i = 0; vertex.isConnectable() && i < SAMPLES; ++i) {
          const EnvironmentLight& light =
              *lights[std::min(lights.size() - 1, size_t(sampler.next1D() * float(lights.size())))];
          const float pick = sampler.next1D();
          const std::optional<LiSample> s = sampleLi(light, vertex.point().position, pick, sampler.next2D());
          if (!s) continue;
          const ScatteringPoint& scattering = *vertex.scattering;
          const Rgb seen = path.throughput * scattering.evaluate(vertex.wi, s->direction) * s->radiance;
          if (isBlack(seen)) continue;
          const Rgb free = transmittance(scene, vertex.hit, vertex.wi, *s, path.nesting,
                                         std::numeric_limits<int>::max(), rowCounts[y])
                               .value;
          const auto square2 = square(double(maxComponent(seen * free))) / double(s->pdf);
          if (!(square2 > 0)) continue;
          const float byBsdf = scattering.pdf(vertex.wi, s->direction);
          const float own = light.pdfLi(vertex.point().position, s->direction);
          const float portals = (s->pdf - (1 - throughPortals) * own) / throughPortals;
          for (size_t k = 0; k < parts.size(); ++k)
            rows[y][k] += square2 / double((1 - parts[k]) * own + parts[k] * portals + byBsdf);
        }
        if (!walker.scatter(path, vertex, sampler)) break;
      }
    }
  });
  std::vector<double> sums(parts.size());
  for (size_t y = 0; y < across; ++y) {
    for (size_t k = 0; k < parts.size(); ++k) sums[k] += rows[y][k];
    counts.add(rowCounts[y]);
  }
  return sums;
}

TransportCounts PortalSampler::learn(const Scene& scene) {
  constexpr float WORTH_IT = 1.25f; // second moment without portals over that with them
  const std::vector<float> parts{0, 0.25f, 0.5f, 0.75f};
  *this = {};
  TransportCounts counts;
  if (scene.environment().empty()) return counts;
  boxes = LightPortals::openings(scene, SHADOW_PORTAL_STREAM, LEVELS, counts);
  if (boxes.empty()) return counts;
  throughPortals = 0.5f; // of the shadow rays that all parts are judged by
  const std::vector<double> moments = secondMoments(scene, parts, counts);
  const auto least = std::min_element(moments.begin(), moments.end()) - moments.begin();
  throughPortals = *moments.begin() > WORTH_IT * moments[least] ? parts[least] : 0;
  if (!active()) boxes.clear();
  return counts;
}

} // namespace recurse
