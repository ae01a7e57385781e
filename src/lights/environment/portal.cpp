/** @file
 * Sampling through portals.
 */
#include "lights/environment/portal.h"

#include <numbers>

#include "recurse/core/threads/parallel.h"

namespace recurse {

namespace {

using std::numbers::pi;

// Coordinates of directions with z > 0: the angles to the yz plane and to the xz plane, scaled to the unit
// square. Lines along x and along y are straight in them.

Vec2d placeOf(const Vec3d& d) { return {std::atan2(d.x, d.z) / pi + 0.5, std::atan2(d.y, d.z) / pi + 0.5}; }

Vec3d directionOf(const Vec2d& place) {
  const double a = pi * (place.x - 0.5), b = pi * (place.y - 0.5);
  const Vec3d d(std::sin(a) * std::cos(b), std::cos(a) * std::sin(b), std::cos(a) * std::cos(b));
  const double length = glm::length(d);
  return length > 0 ? d / length : Vec3d(0, 0, 1);
}

/** Jacobian of the square [sr per unit area]. */
double solidAngle(const Vec3d& d) {
  return d.z > 0 ? square(pi) * (1 - d.x * d.x) * (1 - d.y * d.y) / d.z : 0;
}

} // namespace

Portal::Portal(const std::array<Vec3d, 4>& p, const std::function<Rgb(const Vec3d&)>& radiance,
               int resolution)
    : corner(p[0]), edgeX(p[3] - p[0]), edgeY(p[1] - p[0]), axisX(glm::normalize(edgeX)),
      axisY(glm::normalize(edgeY)), axisZ(glm::cross(axisX, axisY)) {
  constexpr int PARTS = 2; // subsamples of a cell along each side
  const auto n = static_cast<size_t>(resolution);
  std::vector<double> cells(n * n);
  parallelFor(n, [&](size_t y) {
    for (size_t x = 0; x < n; ++x)
      for (int k = 0; k < PARTS * PARTS; ++k) {
        const Vec3d local = directionOf({(double(x) + (k % PARTS + 0.5) / PARTS) / double(n),
                                         (double(y) + (k / PARTS + 0.5) / PARTS) / double(n)});
        cells[y * n + x] += double(luminance(radiance(toScene(local)))) * solidAngle(local);
      }
  });
  table = WindowedDistribution2d(resolution, resolution, cells);
}

std::optional<Portal::Visible> Portal::visibleFrom(const Vec3d& from) const {
  const Vec3d low = toLocal(corner - from), high = toLocal(point(Vec2d(1)) - from);
  if (!(low.z > 0) || !(high.z > 0)) return {};
  Visible v{{placeOf(low), placeOf(high)}, 0};
  v.sum = table.sum(v.window);
  if (!(v.sum > 0)) return {};
  return v;
}

std::optional<Portal::Sample> Portal::sample(const Vec3d& from, const Vec2d& u) const {
  const std::optional<Visible> seen = visibleFrom(from);
  if (!seen) return {};
  const Vec2d place = table.sample(seen->window, u);
  const Vec3d local = directionOf(place);
  const double stretch = solidAngle(local);
  if (!(stretch > 0)) return {};
  return Sample{toScene(local), table.pdf(seen->sum, place) / stretch};
}

std::optional<double> Portal::pdf(const Vec3d& from, const Vec3d& direction) const {
  const std::optional<Visible> seen = visibleFrom(from);
  if (!seen) return {};
  const Vec3d local = toLocal(direction);
  if (!(local.z > 0)) return 0;
  const Vec2d place = placeOf(local);
  if (glm::any(glm::lessThan(place, seen->window.low)) ||
      glm::any(glm::greaterThan(place, seen->window.high)))
    return 0;
  return table.pdf(seen->sum, place) / solidAngle(local);
}

bool Portal::isCrossed(const Vec3d& through, const Vec3d& direction) const {
  const double cosine = glm::dot(direction, axisZ);
  if (cosine == 0) return false;
  const Vec3d p = through + direction * (glm::dot(corner - through, axisZ) / cosine) - corner;
  const double x = glm::dot(p, axisX), y = glm::dot(p, axisY);
  return x >= 0 && y >= 0 && x <= glm::length(edgeX) && y <= glm::length(edgeY);
}

} // namespace recurse
