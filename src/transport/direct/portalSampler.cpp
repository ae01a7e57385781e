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

} // namespace

PortalSampler::Opening PortalSampler::fit(std::span<const CameraExit> exits) {
  constexpr size_t CANDIDATES = 8; // quantiles of the crossings, and of the last vertices (panes)
  constexpr int HALVINGS = 6;
  const size_t outliers = exits.size() / 100;
  Opening best;
  best.area = INFINITE;
  std::vector<float> u, v, coordinates;
  const auto consider = [&](int axis, float at) {
    u.clear();
    v.clear();
    for (const CameraExit& e : exits) {
      const float t = (at - e.position[axis]) / e.direction[axis];
      if (!(t >= -e.along - 1e-3f * e.along && t < INFINITE)) continue;
      u.push_back(e.position[(axis + 1) % 3] + t * e.direction[(axis + 1) % 3]);
      v.push_back(e.position[(axis + 2) % 3] + t * e.direction[(axis + 2) % 3]);
    }
    if (u.size() < exits.size() - 2 * outliers) return false;
    Opening opening{axis, at, Vec2f(0), Vec2f(0), 0};
    for (int k = 0; k < 2; ++k) {
      std::vector<float>& x = k == 0 ? u : v;
      const auto low = x.begin() + std::ptrdiff_t(outliers), high = x.end() - 1 - std::ptrdiff_t(outliers);
      std::nth_element(x.begin(), low, x.end());
      opening.lower[k] = *low;
      std::nth_element(low, high, x.end());
      opening.upper[k] = *high;
    }
    const Vec2f more = (opening.upper - opening.lower) * POSITION_MARGIN;
    opening.lower -= more;
    opening.upper += more;
    opening.area = (opening.upper.x - opening.lower.x) * (opening.upper.y - opening.lower.y);
    if (!(opening.area > 0 && opening.area < best.area)) return false;
    best = opening;
    return true;
  };
  float step = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool atVertex : {false, true}) {
      coordinates.clear();
      for (const CameraExit& e : exits)
        coordinates.push_back(e.position[axis] - (atVertex ? e.along * e.direction[axis] : 0));
      std::sort(coordinates.begin(), coordinates.end());
      for (size_t i = 0; i <= CANDIDATES; ++i)
        if (consider(axis, coordinates[i * (coordinates.size() - 1) / CANDIDATES]))
          step = (coordinates.back() - coordinates.front()) / CANDIDATES;
    }
  for (int i = 0; i < HALVINGS && best.area < INFINITE; ++i, step /= 2)
    if (!consider(best.axis, best.at + step)) consider(best.axis, best.at - step);
  return best;
}

void PortalSampler::divide(std::span<CameraExit> exits, const Opening& whole, int levels) {
  constexpr int CUTS = 8;
  constexpr float SMALLER = 0.7f; // maximum area of two openings, relative to one
  const auto splitAt = [&](int axis, int cut) {
    const size_t left = exits.size() * size_t(cut) / CUTS;
    std::nth_element(exits.begin(), exits.begin() + std::ptrdiff_t(left), exits.end(),
                     [&](const auto& a, const auto& b) { return a.position[axis] < b.position[axis]; });
    return left;
  };
  if (levels > 0 && exits.size() >= ENOUGH_POSITIONS) {
    float least = INFINITE;
    int axis = 0, cut = CUTS / 2;
    for (int a = 0; a < 3; ++a)
      for (int p = 1; p < CUTS; ++p) {
        const size_t left = splitAt(a, p);
        if (std::min(left, exits.size() - left) < ENOUGH_POSITIONS / 2) continue;
        const float area = fit(exits.first(left)).area + fit(exits.subspan(left)).area;
        if (!(area < least)) continue;
        least = area;
        axis = a;
        cut = p;
      }
    if (least < SMALLER * whole.area || whole.area == INFINITE) {
      const size_t left = splitAt(axis, cut);
      divide(exits.first(left), fit(exits.first(left)), levels - 1);
      divide(exits.subspan(left), fit(exits.subspan(left)), levels - 1);
      return;
    }
  }
  if (whole.area < INFINITE) openings.push_back(whole);
}

float PortalSampler::solidAngles(const Vec3f& point, SolidAngles& upToHere) const {
  float sum = 0;
  for (size_t i = 0; i < openings.size(); ++i) {
    const Opening& o = openings[i];
    const float away = o.at - point[o.axis];
    const Vec2f aside = (o.lower + o.upper) * 0.5f - Vec2f(point[(o.axis + 1) % 3], point[(o.axis + 2) % 3]);
    const float distance2 = square(away) + glm::dot(aside, aside);
    if (away != 0) sum += std::min(o.area * std::abs(away) / (distance2 * std::sqrt(distance2)), 2 * PI);
    upToHere[i] = sum;
  }
  return sum;
}

float PortalSampler::pdfThrough(const SolidAngles& upToHere, const Vec3f& point,
                                const Vec3f& direction) const {
  float sum = 0, before = 0;
  for (size_t i = 0; i < openings.size(); ++i) {
    const Opening& o = openings[i];
    const float solidAngle = upToHere[i] - std::exchange(before, upToHere[i]);
    const float t = (o.at - point[o.axis]) / direction[o.axis];
    if (!(t > 0 && t < INFINITE)) continue;
    const int a = (o.axis + 1) % 3, b = (o.axis + 2) % 3;
    const Vec2f at(point[a] + t * direction[a], point[b] + t * direction[b]);
    if (at.x >= o.lower.x && at.x <= o.upper.x && at.y >= o.lower.y && at.y <= o.upper.y)
      sum += solidAngle * square(t) / (o.area * std::abs(direction[o.axis]));
  }
  return sum / before;
}

std::optional<LiSample> PortalSampler::sampleLi(const EnvironmentLight& light, const Vec3f& point, float pick,
                                                const Vec2f& u) const {
  SolidAngles upToHere;
  const float all = active() ? solidAngles(point, upToHere) : 0;
  if (!(all > 0)) return light.sampleLi(point, pick, u);
  if (pick >= throughPortals) {
    pick = std::min((pick - throughPortals) / (1 - throughPortals), ONE_MINUS_EPSILON);
    std::optional<LiSample> beside = light.sampleLi(point, pick, u);
    if (beside)
      beside->pdf = (1 - throughPortals) * beside->pdf +
                    throughPortals * pdfThrough(upToHere, point, beside->direction);
    return beside;
  }
  const float* const last = upToHere.begin() + std::ptrdiff_t(openings.size()) - 1;
  const float* const chosen = std::upper_bound(upToHere.cbegin(), last, pick / throughPortals * all);
  const Opening& o = openings[size_t(chosen - upToHere.begin())];
  const Vec2f at = o.lower + u * (o.upper - o.lower);
  Vec3f towards(0);
  towards[o.axis] = o.at - point[o.axis];
  towards[(o.axis + 1) % 3] = at.x - point[(o.axis + 1) % 3];
  towards[(o.axis + 2) % 3] = at.y - point[(o.axis + 2) % 3];
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
  SolidAngles upToHere;
  if (!active() || !(solidAngles(from, upToHere) > 0)) return byLight;
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
  if (scene.environment().empty()) return counts;
  std::vector<CameraExit> exits = exitCrossings(scene, SHADOW_PORTAL_STREAM, counts);
  for (size_t i = 0; exits.size() > MANY_POSITIONS && i < MANY_POSITIONS; ++i)
    exits[i] = exits[i * exits.size() / MANY_POSITIONS];
  exits.resize(std::min(exits.size(), MANY_POSITIONS));
  if (!exits.empty()) divide(exits, fit(exits), LEVELS);
  if (openings.empty()) return counts;
  throughPortals = 0.5f; // mixture weight of the trial shadow rays
  const auto [absolute, relative] = secondMoments(scene, counts);
  const auto least = size_t(std::min_element(absolute.begin(), absolute.end()) - absolute.begin());
  if (absolute[0] > WORTH_IT * absolute[least])
    throughPortals = PARTS[least];
  else
    throughPortals = relative[0] > WORTH_IT_ELSEWHERE * relative[1] ? PARTS[1] : 0;
  if (!active()) openings.clear();
  return counts;
}

} // namespace recurse
