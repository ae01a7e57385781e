/** @file
 * Construction of the tree of boxes over volume photons.
 */
#include "transport/media/volumePhotons.h"

#include <algorithm>
#include <bit>

#include "recurse/core/math/float8.h"
#include "recurse/core/threads/parallel.h"

namespace recurse {

namespace {

/** Radius of discs: side of a cube that contains about PHOTONS of the `count` photons in the box. */
float radiusIn(const Bounds3f& box, size_t count) {
  constexpr float PHOTONS = 2;
  const Vec3f sides = thickSides(box);
  return std::cbrt(PHOTONS / static_cast<float>(count)) * std::cbrt(sides.x) * std::cbrt(sides.y) *
         std::cbrt(sides.z);
}

constexpr size_t KERNEL_BLOCKS = 4;

/** Points of a unit disc in blocks of eight, each with the same fraction of the Epanechnikov kernel's
 * integral. */
struct KernelPoints {
  std::array<Float8, KERNEL_BLOCKS> x, y;

  KernelPoints() {
    const float goldenAngle = PI * (3 - std::sqrt(5.0f));
    alignas(32) std::array<float, 8 * KERNEL_BLOCKS> xs, ys;
    for (size_t i = 0; i < xs.size(); ++i) {
      // The kernel's integral over a disc of radius r is 2 r² - r⁴.
      const float u = (static_cast<float>(i) + 0.5f) / static_cast<float>(xs.size());
      const float r = std::sqrt(1 - std::sqrt(1 - u)), phi = goldenAngle * static_cast<float>(i);
      xs[i] = r * std::cos(phi);
      ys[i] = r * std::sin(phi);
    }
    for (size_t block = 0; block < KERNEL_BLOCKS; ++block) {
      x[block] = Float8::load(&xs[8 * block]);
      y[block] = Float8::load(&ys[8 * block]);
    }
  }
};

} // namespace

void DiscBounds::add(const Vec3f& normal, float distance) {
  constexpr float ALIKE = 0.9f; // minimum cosine for one surface, flat or gently curved
  for (size_t i = 0; i < count; ++i)
    if (glm::dot(planes[i].normal, normal) > ALIKE) {
      if (distance < planes[i].distance) planes[i] = {normal, distance};
      return;
    }
  if (!full()) planes[count++] = {normal, distance};
}

bool DiscBounds::cuts(const Vec3f& away) const {
  return std::any_of(planes.begin(), planes.begin() + static_cast<std::ptrdiff_t>(count),
                     [&](const Plane& p) { return glm::dot(p.normal, away) > p.distance; });
}

float DiscBounds::fraction(const Vec3f& direction, float radius) const {
  static const KernelPoints POINTS;
  const Frame frame(direction);
  std::array<uint32_t, KERNEL_BLOCKS> beyond{};
  for (size_t i = 0; i < count; ++i) {
    // The plane cuts the disc along a line.
    const Vec2f normal =
        radius * Vec2f(glm::dot(planes[i].normal, frame.x), glm::dot(planes[i].normal, frame.y));
    if (planes[i].distance >= glm::length(normal)) continue;
    for (size_t block = 0; block < KERNEL_BLOCKS; ++block)
      beyond[block] |= bits(less(Float8(planes[i].distance),
                                 POINTS.x[block] * Float8(normal.x) + POINTS.y[block] * Float8(normal.y)));
  }
  int within = 8 * KERNEL_BLOCKS;
  for (const uint32_t mask : beyond) within -= std::popcount(mask);
  return static_cast<float>(std::max(within, 1)) / (8 * KERNEL_BLOCKS);
}

float DiscBounds::distanceFromSurface(const Vec3f& origin, const Vec3f& direction, float t,
                                      float tolerance) const {
  for (size_t i = 0; i < count; ++i) {
    const float cosine = -glm::dot(planes[i].normal, direction);
    if (cosine > 0 && std::abs(glm::dot(planes[i].normal, origin) - planes[i].distance) < tolerance)
      return planes[i].distance / cosine;
  }
  return t;
}

void VolumePhotonMap::findBounds(const Scene& scene, float time, TransportCounts& counts) {
  constexpr size_t TASKS = 64;
  struct Found {
    std::vector<DiscBounds> bounds;
    TransportCounts counts;
  };
  std::vector<Found> found(TASKS);
  boundsOf.assign(photons.size(), NO_BOUNDS);
  parallelFor(TASKS, [&](size_t task) {
    for (size_t i = photons.size() * task / TASKS; i < photons.size() * (task + 1) / TASKS; ++i) {
      DiscBounds b;
      for (int way = 0; way < 6; ++way) {
        Ray ray{photons[i].position, Vec3f(0), radii[i], time};
        ray.direction[way / 2] = way % 2 ? 1.0f : -1.0f;
        Hit hit;
        ++found[task].counts.rays;
        if (!scene.intersectPosition(ray, hit)) continue;
        const float cosine = glm::dot(hit.point.geometricNormal, ray.direction);
        if (cosine != 0)
          b.add(hit.point.geometricNormal * std::copysign(1.0f, cosine), hit.t * std::abs(cosine));
      }
      if (b.empty()) continue;
      boundsOf[i] = static_cast<uint32_t>(found[task].bounds.size());
      found[task].bounds.push_back(b);
    }
  });
  bounds.clear();
  for (size_t task = 0; task < TASKS; ++task) {
    const auto first = static_cast<uint32_t>(bounds.size());
    for (size_t i = photons.size() * task / TASKS; i < photons.size() * (task + 1) / TASKS; ++i)
      if (boundsOf[i] != NO_BOUNDS) boundsOf[i] += first;
    bounds.insert(bounds.end(), found[task].bounds.begin(), found[task].bounds.end());
    counts.add(found[task].counts);
  }
}

void VolumePhotonMap::build(std::vector<VolumePhoton> all, float scale, float widest) {
  photons = std::move(all);
  boundsOf.clear();
  bounds.clear();
  tree.sort(photons, [](const VolumePhoton& p) { return p.position; });
  radii.resize(photons.size());
  tree.forParts([&](size_t first, size_t end) {
    Bounds3f box;
    float power = 0;
    for (size_t k = first; k < end; ++k) {
      box.add(photons[k].position);
      power += maxComponent(photons[k].power) / static_cast<float>(end - first);
    }
    float radius = end > first ? radiusIn(box, end - first) : 0;
    if (!(radius > 0)) radius = widest; // all in one point
    // Strong photons among many weak ones have wider discs, so that they are not visible as spots.
    for (size_t k = first; k < end; ++k)
      radii[k] = scale *
                 std::min(radius * std::sqrt(std::max(1.0f, maxComponent(photons[k].power) / power)), widest);
  });
  tree.enclose([&](Bounds3f& box, size_t k) {
    box.add(photons[k].position - radii[k]);
    box.add(photons[k].position + radii[k]);
  });
}

} // namespace recurse
