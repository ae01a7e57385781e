/** @file
 * Probe rays for the surface geometry around a point.
 */
#include "transport/density/boundaryCorrection.h"

namespace recurse {

namespace {

/** Walls have an angle of more than 45° to the surface; smaller angles are due to curvature. */
constexpr float WALL_COSINE = 0.7f;

/** Height of rays along a surface, relative to the kernel radius: below the top of the search region. */
constexpr float RISE = 0.02f;

/** Height, relative to the kernel radius, at which more rays search for geometry that ends near the surface
 * without contact, like a door below a ceiling: light differs on the two sides of a narrow gap.
 */
constexpr float GAP = 0.2f;

bool holdsPhotons(const Hit& hit) { return hit.material && (hit.material->lobes() & NON_DELTA_LOBES); }

/** Whether the surface casts a shadow: clear glass and boundaries of media without a material do not. */
bool castsShadow(const Hit& hit) {
  return hit.material && (hit.material->lobes() & ALL_LOBES) && !(hit.material->lobes() & REFRACTION);
}

/** Finds the first surface along the ray for which `stops` holds; false if there is none. */
template <class Stops>
bool intersectFirst(const Scene& scene, Ray ray, Hit& hit, TransportCounts& counts, const Stops& stops) {
  constexpr int MAX_PASSED = 8;
  for (int i = 0; i < MAX_PASSED; ++i) {
    if (!probePosition(scene, ray, hit, counts)) return false;
    if (stops(hit)) return true;
    ray = rayBehind(ray, hit);
  }
  return false;
}

/** Finds the first surface along the ray that can hold photons; false if there is none. */
bool intersectNonDelta(const Scene& scene, const Ray& ray, Hit& hit, TransportCounts& counts) {
  return intersectFirst(scene, ray, hit, counts, holdsPhotons);
}

/** Whether a ray along the surface hits a wall. Glass and water are walls: light differs on both sides. */
bool intersectWall(const Scene& scene, const Ray& ray, const Vec3f& normal, Hit& hit,
                   TransportCounts& counts) {
  return probePosition(scene, ray, hit, counts) && hit.material && (hit.material->lobes() & ALL_LOBES) &&
         std::abs(glm::dot(hit.point.geometricNormal, normal)) < WALL_COSINE;
}

/** Height from which rays are traced down to the surface: below any geometry above its centre but glass. */
float freeHeight(const Neighbourhood& around, float radius) {
  return std::min(GAP * radius, around.clearance / 2);
}

/** Distance from a wall below which a point counts as on the wall [scene units]. */
float wallMargin(const GatherRegion& region, float error) { return 1e-3f * region.radius + 2 * error; }

/** Ray from `height` above a point of the region's tangent plane to the same distance below it. */
Ray downThrough(const GatherRegion& region, const Vec3f& position, float height) {
  return {position + region.normal * height, -region.normal, 2 * height, region.time};
}

/** Directions in a plane, at equal angles with a random rotation. */
template <int N> std::array<Vec3f, N> directions(const Vec3f& normal, float turn) {
  const Frame frame(normal);
  std::array<Vec3f, N> all;
  for (int i = 0; i < N; ++i) {
    const float angle = 2 * PI * (static_cast<float>(i) + turn) / N;
    all[size_t(i)] = frame.x * std::cos(angle) + frame.y * std::sin(angle);
  }
  return all;
}

/** Depth of the next surface below a point of the region, up to `most`; infinite if there is none. */
float depthBelow(const Scene& scene, const GatherRegion& region, const Vec3f& position, float error,
                 float most, TransportCounts& counts) {
  const float start = 4 * error; // start below the surface itself
  Hit hit;
  if (!intersectNonDelta(scene, {position - region.normal * start, -region.normal, most - start, region.time},
                         hit, counts))
    return INFINITE;
  return start + hit.t;
}

/** Finds the walls that rays along the surface hit within the region's radius, rising from it or ending just
 * above it. Returns their distances, which are infinite where there is none. */
template <size_t N>
std::array<float, N> findWalls(const Scene& scene, float error, const GatherRegion& region,
                               const std::array<Vec3f, N>& directions, Neighbourhood& found,
                               TransportCounts& counts) {
  std::array<float, N> distances;
  distances.fill(INFINITE);
  const float margin = wallMargin(region, error);
  const auto lookAlong = [&](float height) {
    const Vec3f start = region.center + region.normal * height;
    for (size_t i = 0; i < N; ++i) {
      Hit hit;
      if (!intersectWall(scene, {start, directions[i], std::min(region.radius, distances[i]), region.time},
                         region.normal, hit, counts))
        continue;
      distances[i] = hit.t;
      Vec3f normal = hit.point.geometricNormal;
      if (glm::dot(normal, directions[i]) > 0) normal = -normal;
      const Vec3f position = hit.point.position + normal * margin;
      const bool known = std::any_of(
          found.planes.begin(), found.planes.begin() + found.planeCount,
          [&](const BoundaryPlane& b) { return glm::dot(position, b.normal) < b.offset + 2 * margin; });
      if (!known) found.add({normal, glm::dot(hit.point.position, normal), BoundaryPlane::WALL});
    }
  };
  const float low = std::max(RISE * region.radius, 2 * error);
  lookAlong(low);
  found.depth = depthBelow(scene, region, region.center, error, found.heightKnown(), counts);
  const Vec3f start = region.center + region.normal * low;
  if (Hit above; intersectFirst(scene, {start, region.normal, found.heightKnown() - low, region.time}, above,
                                counts, castsShadow))
    found.clearance = glm::distance(region.center, above.point.position);
  if (const float high = freeHeight(found, region.radius); high > 2 * low) lookAlong(high);
  return distances;
}

/** Slope up to which a surface counts as one plane. */
constexpr float SLOPE = 0.02f;

/** Probe that traces rays down to the plane of a region to find its surface. */
class SurfaceProbe {
 public:
  /** `height`: height from which rays start, see freeHeight(). */
  SurfaceProbe(const Scene& scene, float error, const GatherRegion& region, float height,
               TransportCounts& counts)
      : scene(scene), error(error), region(region), start(std::max(height, 4 * error)), counts(counts) {}

  /** Whether the surface continues in the plane at a point of it. */
  bool flat(const Vec3f& position) { return cosine(position) >= 1 - SLOPE * SLOPE / 2 && !isStep(position); }
  /** Height of the last probe above the tangent plane [scene units]. */
  float height() const { return lastHeight; }

  /** Straight line at which the surface ends or folds between the points `in` and `out`; nullopt if it is not
   * straight, or if the surface bends gradually. */
  std::optional<BoundaryPlane> edge(Vec3f in, Vec3f out, float distance) {
    constexpr float CREASE = 0.99f;
    const float tolerance = 1e-4f * distance + 2 * error;
    if (!flat(in)) return {};
    const Vec3f outwards = glm::normalize(out - in), aside = glm::cross(region.normal, outwards);
    for (float between = glm::distance(in, out); between > tolerance; between /= 2) {
      const Vec3f middle = (in + out) * 0.5f;
      (flat(middle) ? in : out) = middle;
    }
    if (cosine(out) > CREASE && !isStep(out)) return {};
    // Intersects the edge with a small circle on both sides.
    const float circle = 0.2f * distance;
    std::array<Vec3f, 2> ends;
    for (const float side : {-1.0f, 1.0f}) {
      const auto onCircle = [&](float angle) {
        return in + (outwards * std::cos(angle) + aside * (side * std::sin(angle))) * circle;
      };
      float empty = 0, full = PI;
      if (flat(onCircle(empty)) || !flat(onCircle(full))) return {};
      while ((full - empty) * circle > tolerance) {
        const float middle = (full + empty) / 2;
        (flat(onCircle(middle)) ? full : empty) = middle;
      }
      ends[side > 0] = onCircle(full);
    }
    Vec3f normal = glm::cross(region.normal, ends[1] - ends[0]);
    if (!(lengthSquared(normal) > 0)) return {};
    normal = glm::normalize(normal);
    if (glm::dot(normal, outwards) > 0) normal = -normal;
    const float offset = glm::dot(ends[0], normal);
    if (std::abs(glm::dot(in, normal) - offset) > 4 * tolerance) return {}; // bent, or a corner
    return BoundaryPlane{normal, std::min(offset, glm::dot(in, normal)) - tolerance, BoundaryPlane::EDGE};
  }

 private:
  /** Whether the last probe is higher or lower than the slope within one plane allows, as on a board on a
   * table. */
  bool isStep(const Vec3f& position) const {
    return lastHeight > SLOPE * glm::distance(position, region.center) + 4 * error;
  }
  /** Cosine between the normals of surface and plane; 0 if there is no surface. */
  float cosine(const Vec3f& position) {
    Hit hit;
    if (!intersectNonDelta(scene, downThrough(region, position, start), hit, counts)) return 0;
    lastHeight = std::abs(glm::dot(hit.point.position - region.center, region.normal));
    return std::abs(glm::dot(hit.point.geometricNormal, region.normal));
  }

  const Scene& scene;
  float error;
  const GatherRegion& region;
  float start;
  TransportCounts& counts;
  float lastHeight = 0;
};

/** Fraction of the kernel's weight inside of the region's half-spaces. It is star-shaped about the centre,
 * bounded by the nearest plane in each direction. */
float unclippedPart(Kernel kernel, const GatherRegion& region, float turn) {
  constexpr int ANGLES = 64;
  struct Circle {
    alignas(32) float cosine[ANGLES], sine[ANGLES];
    Circle() {
      for (int i = 0; i < ANGLES; ++i) {
        cosine[i] = std::cos(2 * PI * static_cast<float>(i) / ANGLES);
        sine[i] = std::sin(2 * PI * static_cast<float>(i) / ANGLES);
      }
    }
  };
  static const Circle circle;
  const Frame frame(region.normal);
  const float angle = 2 * PI * turn / ANGLES;
  const Vec3f x = frame.x * std::cos(angle) + frame.y * std::sin(angle), y = glm::cross(region.normal, x);
  return withKernel(kernel, [&](auto k) {
    Float8 fraction(0);
    for (int i = 0; i < ANGLES; i += 8) {
      Float8 inverse(1); // reciprocal of the remaining distance in radii
      for (size_t j = 0; j < region.clipCount; ++j) {
        const auto& clip = region.clips[j];
        const float scale = region.radius / clip.limit;
        inverse = max(inverse, Float8::load(circle.cosine + i) * Float8(glm::dot(clip.normal, x) * scale) +
                                   Float8::load(circle.sine + i) * Float8(glm::dot(clip.normal, y) * scale));
      }
      fraction += kernelPart<decltype(k)::value>(Float8(1) / (inverse * inverse));
    }
    return sum(fraction) / ANGLES;
  });
}

} // namespace

Neighbourhood probeNeighbourhood(const Scene& scene, float error, const GatherRegion& region,
                                 Sampler& sampler, TransportCounts& counts) {
  constexpr float RINGS[] = {0.05f, 0.15f, 0.35f, 0.55f, 0.75f, 1};
  const auto rays = directions<12>(region.normal, sampler.next1D());
  Neighbourhood found;
  found.reach = region.radius;
  const auto walls = findWalls(scene, error, region, rays, found, counts);
  const float height = freeHeight(found, region.radius);
  for (size_t i = 0; i < rays.size(); ++i) {
    const float distance = RINGS[i % 2 == 0 ? 1 : 2] * region.radius;
    Hit hit;
    if (walls[i] > distance &&
        intersectNonDelta(scene, downThrough(region, region.center + rays[i] * distance, height), hit,
                          counts))
      found.depth = std::min(
          found.depth, depthBelow(scene, region, hit.point.position, error, found.heightKnown(), counts));
  }
  SurfaceProbe probe(scene, error, region, height, counts);
  float before = 0;
  for (const float ring : RINGS) {
    const float distance = ring * region.radius;
    for (size_t i = 0; i < rays.size(); ++i) {
      if (walls[i] <= distance) continue;
      const Vec3f position = region.center + rays[i] * distance;
      if (!found.sees(position)) continue;
      if (probe.flat(position)) {
        found.relief = std::max(found.relief, probe.height());
        continue;
      }
      const auto edge = probe.edge(region.center + rays[i] * before, position, distance);
      if (!edge || found.planeCount == Neighbourhood::MAX_PLANES) return found;
      found.add(*edge);
    }
    found.flat = distance * std::cos(PI / rays.size()); // an edge may be between two directions
    before = distance;
  }
  return found;
}

namespace {

/** Numbers of points at which a support is measured, and once it is reduced. */
constexpr int FEW_POINTS = 8, MANY_POINTS = 16;

/** Surface within a kernel support. */
struct SurfaceInSupport {
  float fraction = 1; ///< fraction of the kernel's weight
  float cosine = 1;   ///< mean cosine between the surface's normals and the region's
};

/** Measures the unclipped support at `count` points, uniform by a sunflower spiral. */
SurfaceInSupport measure(BoundaryCorrection& boundary, float error, Kernel kernel, const GatherRegion& region,
                         int count, TransportCounts& counts) {
  static const std::array<Vec2f, MANY_POINTS> spiral = [] {
    std::array<Vec2f, MANY_POINTS> made;
    const float goldenAngle = PI * (3 - std::sqrt(5.0f));
    for (size_t i = 0; i < made.size(); ++i)
      made[i] = {std::cos(goldenAngle * static_cast<float>(i)),
                 std::sin(goldenAngle * static_cast<float>(i))};
    return made;
  }();
  const Vec2f u = boundary.sampler.next2D();
  const Frame frame(region.normal);
  const float turn = 2 * PI * u.y, free = freeHeight(*boundary.known, region.radius);
  const Vec3f x = frame.x * std::cos(turn) + frame.y * std::sin(turn), y = glm::cross(region.normal, x);
  return withKernel(kernel, [&](auto k) {
    float sum = 0, all = 0, cosines = 0;
    int hitCount = 0;
    for (int i = 0; i < count; ++i) {
      float q = (static_cast<float>(i) + u.x) / static_cast<float>(count); // squared distance in radii
      all += kernelShape<k.value>(q);
      const Vec2f& at = spiral[size_t(i)];
      const Vec3f offset = (x * at.x + y * at.y) * (region.radius * std::sqrt(q));
      const float height = std::max(region.radius * region.flatness * std::sqrt(1 - q), 4 * error);
      const float start = std::max(height, free); // geometry above the support hides the surface below
      Hit hit;
      if (!intersectNonDelta(
              boundary.scene,
              {region.center + offset + region.normal * start, -region.normal, start + height, region.time},
              hit, counts) ||
          !region.unclipped(hit.point.position - region.center))
        continue;
      const float cosine = std::abs(glm::dot(hit.point.geometricNormal, region.normal));
      // Ignores differences within the position error of a plane.
      if (std::abs(hit.t - start) > 4 * error)
        q = region.distance2(hit.point.position - region.center) / square(region.radius);
      if (cosine <= GatherRegion::MIN_COSINE || q > 1) continue;
      cosines += cosine;
      ++hitCount;
      sum += kernelShape<k.value>(q) / cosine;
    }
    return SurfaceInSupport{sum / all, hitCount > 0 ? cosines / static_cast<float>(hitCount) : 1};
  });
}

/** Radius over that of a measured support in which the mean cosine would be `minCosine`: on a sphere, 1 -
 * cosine grows as the square of the radius. */
float reductionOf(float cosine, float minCosine) {
  return std::sqrt((1 - minCosine) / std::max(1 - cosine, 1e-6f));
}

} // namespace

float coveredFraction(BoundaryCorrection& boundary, float error, Kernel kernel, GatherRegion& region,
                      TransportCounts& counts) {
  if (!boundary.known || region.radius > boundary.known->reach - boundary.away) {
    boundary.probed = {};
    boundary.probed.reach = region.radius;
    findWalls(boundary.scene, error, region, directions<8>(region.normal, boundary.sampler.next1D()),
              boundary.probed, counts);
    boundary.known = &boundary.probed;
    boundary.away = 0;
  }
  constexpr float MAX_CLEARANCES = 2; // in a gap, light varies over distances of its height
  region.radius = std::min(region.radius, MAX_CLEARANCES * boundary.known->clearance + boundary.away);
  // Half the distance to the next layer, which may be closer elsewhere.
  const float lowest = std::max(boundary.known->depth / 2, 8 * error) / region.radius;
  region.flatness = std::min(region.flatness, std::max(lowest, FLATTEST));
  const auto clip = [&] {
    region.clipCount = 0;
    for (size_t i = 0; i < boundary.known->planeCount; ++i) {
      const BoundaryPlane& plane = boundary.known->planes[i];
      const float distance = glm::dot(region.center, plane.normal) - plane.offset;
      if (distance < -2 * error || distance > region.radius) continue; // beyond it, or far from it
      const float margin =
          plane.kind == BoundaryPlane::WALL ? std::min(wallMargin(region, error), distance / 2) : 0;
      region.clips[region.clipCount++] = {plane.normal, std::min(margin - distance, -error)};
    }
  };
  // Few rays cannot distinguish small fractions, and dividing by one that is too small gives bright spots.
  constexpr float MIN_FRACTION = 0.2f, MIN_COSINE = 0.95f, STEP = 0.7f, MIN_WEDGE = 1.0f / 16;
  constexpr int MAX_STEPS = 40;
  SurfaceInSupport surface;
  float before = 0;
  for (int step = 0; step < MAX_STEPS; ++step) {
    clip();
    if (region.radius <= boundary.flat()) {
      if (region.clipCount == 0) return 1;
      const float fraction = unclippedPart(kernel, region, boundary.sampler.next1D());
      // Reduction is of no help where the fraction stays the same, as in the tip of a wedge.
      if (fraction >= MIN_FRACTION || fraction < 1.05f * before) return std::max(MIN_WEDGE, fraction);
      before = fraction;
      region.radius *= STEP;
      continue;
    }
    surface = measure(boundary, error, kernel, region, FEW_POINTS, counts);
    if (surface.fraction >= MIN_FRACTION && surface.cosine >= MIN_COSINE) {
      if (step == 0) return surface.fraction;
      break;
    }
    region.radius *= std::min(STEP, reductionOf(surface.cosine, MIN_COSINE));
  }
  // Measured again with more points, since the fraction that ended the loop is biased upwards.
  surface = measure(boundary, error, kernel, region, MANY_POINTS, counts);
  return surface.fraction > 0 ? std::max(surface.fraction, MIN_FRACTION / 2)
                              : 1; // 0: not visible, nothing is known
}

} // namespace recurse
