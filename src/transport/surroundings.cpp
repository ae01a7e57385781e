/** @file
 * Rays that look at the surface around a point.
 */
#include "recurse/transport/surroundings.h"

namespace recurse {

namespace {

/** Walls rise by more than 45° from a surface; what rises less is its curvature. */
constexpr float WALL_COSINE = 0.7f;

/** Rays along a surface start so far above it, over the disc's radius: below the photons' search region. */
constexpr float RISE = 0.02f;

bool holdsPhotons(const Hit& hit) { return hit.material && (hit.material->lobes() & DIFFUSE_LOBES); }

/** The first surface that can hold photons along the ray; false when there is none. */
bool meetDiffuse(const Scene& scene, Ray ray, Hit& hit, TransportCounts& counts) {
  constexpr int MOST_PASSED = 8;
  for (int i = 0; i < MOST_PASSED; ++i) {
    if (!meet(scene, ray, hit, counts)) return false;
    if (holdsPhotons(hit)) return true;
    const float tMax = ray.tMax - hit.t;
    ray = spawn(hit.point, ray.direction);
    ray.tMax = tMax;
  }
  return false;
}

/** Whether a ray along the surface meets a wall; light may pass through glass, which is none. */
bool meetWall(const Scene& scene, const Ray& ray, const Vec3f& normal, Hit& hit, TransportCounts& counts) {
  return meet(scene, ray, hit, counts) && hit.material &&
         (hit.material->lobes() & (DIFFUSE_LOBES | MIRROR)) && !(hit.material->lobes() & REFRACTION) &&
         std::abs(glm::dot(hit.point.geometricNormal, normal)) < WALL_COSINE;
}

/** What is not this far in front of a wall lies on it. */
float wallMargin(const GatherRegion& region, float error) { return 1e-3f * region.radius + 2 * error; }

/** From above a place of the tangent plane down through it, within `height` of it. */
Ray downThrough(const Vec3f& place, const Vec3f& normal, float height) {
  return {place + normal * height, -normal, 2 * height};
}

/** Directions of a plane, evenly spread and turned at random. */
template <int N> std::array<Vec3f, N> directions(const Vec3f& normal, float turn) {
  const Frame frame(normal);
  std::array<Vec3f, N> all;
  for (int i = 0; i < N; ++i) {
    const float angle = 2 * PI * (static_cast<float>(i) + turn) / N;
    all[size_t(i)] = frame.x * std::cos(angle) + frame.y * std::sin(angle);
  }
  return all;
}

/** The walls that rays along the surface meet within the region's radius; `met` gets the distances, infinite
 * where there is none. */
template <size_t N>
void findWalls(const Scene& scene, float error, const GatherRegion& region,
               const std::array<Vec3f, N>& directions, std::array<float, N>& met, Neighbourhood& found,
               TransportCounts& counts) {
  const Vec3f start = region.center + region.normal * std::max(RISE * region.radius, 2 * error);
  const float margin = wallMargin(region, error);
  for (size_t i = 0; i < N; ++i) {
    met[i] = INFINITE;
    Hit hit;
    if (!meetWall(scene, {start, directions[i], region.radius}, region.normal, hit, counts)) continue;
    met[i] = hit.t;
    Vec3f normal = hit.point.geometricNormal;
    if (glm::dot(normal, directions[i]) > 0) normal = -normal;
    const Vec3f place = hit.point.position + normal * margin;
    const bool known =
        std::any_of(found.walls.begin(), found.walls.begin() + found.wallCount,
                    [&](const Wall& w) { return glm::dot(place, w.normal) < w.offset + 2 * margin; });
    if (!known && found.wallCount < Neighbourhood::MOST_WALLS)
      found.walls[found.wallCount++] = {normal, glm::dot(hit.point.position, normal)};
  }
}

/** Places of a disc by a sunflower's spiral, which covers it evenly: unit vectors of its plane. */
template <int N> struct Spiral {
  std::array<Vec2f, N> places;
  Spiral() {
    constexpr float GOLDEN_ANGLE = 2.39996323f;
    for (int i = 0; i < N; ++i)
      places[size_t(i)] = {std::cos(GOLDEN_ANGLE * static_cast<float>(i)),
                           std::sin(GOLDEN_ANGLE * static_cast<float>(i))};
  }
};

/** The mean of `weight(offset, q)` with the kernel over a disc; q is the offset's squared length in radii. */
template <int N, class Weight>
float overDisc(Kernel kernel, const GatherRegion& region, const Vec2f& u, const Weight& weight) {
  static const Spiral<N> spiral;
  const Frame frame(region.normal);
  const float turn = 2 * PI * u.y;
  const Vec3f x = frame.x * std::cos(turn) + frame.y * std::sin(turn), y = glm::cross(region.normal, x);
  return withKernel(kernel, [&](auto k) {
    const auto shape = [](float q) { return kernelShape<decltype(k)::value>(q); };
    float sum = 0, all = 0;
    for (int i = 0; i < N; ++i) {
      const float q = (static_cast<float>(i) + u.x) / N;
      all += shape(q);
      const Vec2f& at = spiral.places[size_t(i)];
      const Vec3f offset = (x * at.x + y * at.y) * (region.radius * std::sqrt(q));
      if (region.unclipped(offset)) sum += weight(offset, q, shape);
    }
    return sum / all;
  });
}

} // namespace

Neighbourhood lookAround(const Scene& scene, float error, const GatherRegion& region, Sampler& sampler,
                         TransportCounts& counts) {
  constexpr int DIRECTIONS = 12;
  constexpr float RINGS[] = {0.15f, 0.35f, 0.55f, 0.75f, 1};
  constexpr float SAME_PLANE = 0.9995f;
  const auto rays = directions<DIRECTIONS>(region.normal, sampler.next1D());
  Neighbourhood found;
  found.reach = region.radius;
  std::array<float, DIRECTIONS> walls;
  findWalls(scene, error, region, rays, walls, found, counts);
  for (const float ring : RINGS) {
    const float distance = ring * region.radius;
    const float height = std::max(RISE * distance, 4 * error);
    for (size_t i = 0; i < DIRECTIONS; ++i) {
      if (walls[i] <= distance) continue;
      Hit hit;
      if (!meetDiffuse(scene, downThrough(region.center + rays[i] * distance, region.normal, height), hit,
                       counts) ||
          std::abs(glm::dot(hit.point.geometricNormal, region.normal)) < SAME_PLANE)
        return found;
    }
    found.flat = distance * std::cos(PI / DIRECTIONS); // an edge may lie between two directions
  }
  return found;
}

namespace {

/** What a disc bears. */
struct SurfaceInDisc {
  float part = 1;   ///< see fitToSurface()
  float cosine = 1; ///< mean cosine between the surface's normals and the disc's
};

/** Measures the unclipped part of a disc at N places. */
template <int N>
SurfaceInDisc measure(Surroundings& surroundings, float error, Kernel kernel, const GatherRegion& region,
                      TransportCounts& counts) {
  const Vec2f u = surroundings.sampler.next2D();
  if (region.radius <= surroundings.known->flat - surroundings.away) {
    if (region.clipCount == 0) return {};
    return {overDisc<48>(kernel, region, u, [](const Vec3f&, float q, auto shape) { return shape(q); }), 1};
  }
  float cosines = 0;
  int met = 0;
  const float part = overDisc<N>(kernel, region, u, [&](const Vec3f& offset, float q, auto shape) {
    constexpr float LEAST_COSINE = 0.25f; // steeper than this is no part of the surface
    const float height = std::max(region.radius * region.flatness * std::sqrt(1 - q), 4 * error);
    Hit hit;
    if (!meetDiffuse(surroundings.scene, downThrough(region.center + offset, region.normal, height), hit,
                     counts))
      return 0.0f;
    const float cosine = std::abs(glm::dot(hit.point.geometricNormal, region.normal));
    // The error of a plane's place is not to count.
    if (std::abs(hit.t - height) > 4 * error)
      q = region.distance2(hit.point.position - region.center) / square(region.radius);
    if (cosine < LEAST_COSINE || q > 1) return 0.0f;
    cosines += cosine;
    ++met;
    return shape(q) / cosine;
  });
  return {part, met > 0 ? cosines / static_cast<float>(met) : 1};
}

} // namespace

float fitToSurface(Surroundings& surroundings, float error, Kernel kernel, GatherRegion& region,
                   TransportCounts& counts) {
  if (!surroundings.known || region.radius > surroundings.known->reach - surroundings.away) {
    constexpr int DIRECTIONS = 8;
    std::array<float, DIRECTIONS> met;
    surroundings.own = {};
    surroundings.own.reach = region.radius;
    findWalls(surroundings.scene, error, region,
              directions<DIRECTIONS>(region.normal, surroundings.sampler.next1D()), met, surroundings.own,
              counts);
    surroundings.known = &surroundings.own;
    surroundings.away = 0;
  }
  const auto clip = [&] {
    region.clipCount = 0;
    const float margin = wallMargin(region, error);
    for (size_t i = 0; i < surroundings.known->wallCount; ++i) {
      const Wall& wall = surroundings.known->walls[i];
      const float distance = glm::dot(region.center, wall.normal) - wall.offset;
      if (distance > 2 * margin && distance < region.radius)
        region.clips[region.clipCount++] = {wall.normal, margin - distance};
    }
  };
  constexpr float LEAST_PART = 0.2f, LEAST_COSINE = 0.95f, STEP = 0.7f;
  constexpr int MOST_STEPS = 40, FEW = 8, MANY = 32;
  clip();
  SurfaceInDisc disc = measure<FEW>(surroundings, error, kernel, region, counts);
  const auto fits = [&] { return disc.part >= LEAST_PART && disc.cosine >= LEAST_COSINE; };
  if (fits()) return disc.part;
  for (int i = 0; i < MOST_STEPS && !fits(); ++i) {
    region.radius *= STEP;
    clip();
    disc = measure<FEW>(surroundings, error, kernel, region, counts);
  }
  // Once more, for what has stopped the search is likely to be too much.
  disc = measure<MANY>(surroundings, error, kernel, region, counts);
  return disc.part > 0 ? disc.part : 1; // it cannot be seen: nothing is known of it
}

} // namespace recurse
