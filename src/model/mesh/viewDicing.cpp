/** @file
 * Dicing of surfaces by the camera's pixels.
 */
#include "model/mesh/viewDicing.h"

#include <algorithm>

namespace recurse {

PixelWidths::PixelWidths(std::unique_ptr<Camera> given, const FilmSettings& film)
    : camera(std::move(given)), size(film.width, film.height) {
  constexpr int GRID = 5; // directions each way: pixel angles differ between centre and corners
  double least = std::numeric_limits<double>::infinity(), leastOffset = least;
  const auto ray = [&](const Vec2d& place) {
    return camera->sampleRay({Vec2f(place), Vec2f(0.5f), camera->timeAt(0)});
  };
  if (const auto middle = ray(size * 0.5)) {
    eye = Vec3d(middle->origin);
    forward = Vec3d(middle->direction);
  }
  for (int y = 0; y < GRID; ++y)
    for (int x = 0; x < GRID; ++x) {
      const Vec2d place = Vec2d(x, y) / double(GRID - 1) * (size - 1.0);
      const auto here = ray(place), across = ray(place + Vec2d(1, 0)), down = ray(place + Vec2d(0, 1));
      if (!here || !across || !down) continue;
      for (const auto& next : {across, down}) {
        const double turned = glm::length(Vec3d(next->direction) - Vec3d(here->direction));
        const double moved = glm::length(Vec3d(next->origin) - Vec3d(here->origin));
        least = std::min(least, turned);
        leastOffset = std::min(leastOffset, moved);
      }
    }
  if (!std::isfinite(least)) return;
  angle = least;
  offset = leastOffset;
}

double PixelWidths::slack(const Vec3d& place) const {
  // Mirrors and shadows show surfaces outside of the film. The slack grows slowly: a jump at the border would
  // let edges that are split on one side of it cause splits on the opposite side without end.
  constexpr double MAX_SLACK = 8, PER_PIXEL = 0.25;
  if (!camera->isConnectable()) return 1;
  const auto wi = camera->sampleWi(Vec3f(place), Vec2f(0.5f), camera->timeAt(0));
  if (!wi) return MAX_SLACK;
  const Vec2d film(wi->film);
  const Vec2d beyond = glm::max(glm::max(-film, film - size), Vec2d(0));
  return std::min(1 + PER_PIXEL * std::max(beyond.x, beyond.y), MAX_SLACK);
}

double PixelWidths::alongEdge(const Vec3d& a, const Vec3d& b) const {
  const Vec3d along = b - a;
  const double length2 = glm::dot(along, along);
  const double nearest = length2 > 0 ? std::clamp(glm::dot(eye - a, along) / length2, 0.0, 1.0) : 0;
  const Vec3d towards = a + along * nearest - eye;
  const double width = offset + angle * glm::length(towards);
  return width * foreshortening(along, offset > 0 ? forward : towards) *
         std::min({slack(a), slack(b), slack(0.5 * (a + b))});
}

double PixelWidths::foreshortening(const Vec3d& along, const Vec3d& view) {
  // Displacement between the ends of an edge is visible from the side: MOST bounds the edge length.
  constexpr double MOST = 4;
  const double lengths = glm::length(along) * glm::length(view), seen = glm::length(glm::cross(along, view));
  return lengths < MOST * seen ? lengths / seen : lengths > 0 ? MOST : 1;
}

bool isDicedByView(const ParsedDirective& shape) {
  const auto has = [&](const char* name) {
    const auto isNamed = [&](const ParsedParameter& p) { return p.name == name; };
    return std::any_of(shape.parameters.begin(), shape.parameters.end(), isNamed) ||
           (shape.attributes && std::any_of(shape.attributes->begin(), shape.attributes->end(), isNamed));
  };
  return has("displacement") && !has("edgelength");
}

ViewDicing::ViewDicing(const PixelWidths& pixels, std::vector<Mat4d> given)
    : pixels(pixels), places(std::move(given)) {
  // Sort key: width of a pixel at the placement [units of the group].
  const auto width = [&](const Mat4d& m) {
    const Vec3d middle(m[3]);
    return pixels.alongEdge(middle, middle) / std::cbrt(std::abs(glm::determinant(Mat3d(m))));
  };
  constexpr size_t MAX_PLACES = 8;
  const size_t count = std::min(MAX_PLACES, places.size());
  std::partial_sort(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(count), places.end(),
                    [&](const Mat4d& a, const Mat4d& b) { return width(a) < width(b); });
  places.resize(count);
}

double ViewDicing::edgeLength(const Vec3d& a, const Vec3d& b) const {
  double least = std::numeric_limits<double>::infinity();
  const double own = glm::length(b - a);
  for (const Mat4d& m : places) {
    const Vec3d from = transformPoint(m, a), to = transformPoint(m, b);
    const double there = glm::length(to - from);
    const double scale = there > 0 ? own / there : 1;
    least = std::min(least, pixels.alongEdge(from, to) * scale);
  }
  return least;
}

} // namespace recurse
