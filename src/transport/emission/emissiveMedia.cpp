/** @file
 * Probes of emissive media, and sampling in proportion to the probed emission.
 */
#include "transport/emission/emissiveMedia.h"

#include <algorithm>
#include <utility>

#include "recurse/core/threads/parallel.h"
#include "recurse/model/scene/surroundingMedium.h"
#include "transport/paths/walk.h"

namespace recurse {

namespace {

Vec3f pointOf(const Bounds3f& box, const Vec3f& fraction) { return box.lower + box.diagonal() * fraction; }

Bounds3f boxAround(const SceneBounds& bounds) {
  return {bounds.center - bounds.radius, bounds.center + bounds.radius};
}

double volumeOf(const Bounds3f& box) {
  const Vec3d d(box.diagonal());
  return d.x * d.y * d.z;
}

/** Bounds of the non-black cells of a box, and one cell more on each side; empty if all are black. */
Bounds3f boxOfCells(const Bounds3f& box, const std::vector<double>& cells, int count) {
  glm::ivec3 first(count), last(0);
  for (int z = 0, i = 0; z < count; ++z)
    for (int y = 0; y < count; ++y)
      for (int x = 0; x < count; ++x, ++i)
        if (cells[size_t(i)] > 0) {
          first = glm::min(first, glm::ivec3(x, y, z) - 1);
          last = glm::max(last, glm::ivec3(x, y, z) + 2);
        }
  if (first.x > last.x) return {};
  first = glm::max(first, glm::ivec3(0));
  last = glm::min(last, glm::ivec3(count));
  return {pointOf(box, Vec3f(first) / float(count)), pointOf(box, Vec3f(last) / float(count))};
}

/** Calls visit(ray) for rays of unit direction through a box along its axes, in both directions. */
template <class Visit>
void forLinesThrough(const Bounds3f& box, int resolution, float time, const Visit& visit) {
  const Vec3f spacing = box.diagonal() / static_cast<float>(resolution);
  for (int way = 0; way < 6; ++way)
    for (int line = 0; line < square(resolution); ++line) {
      const int axis = way / 2;
      Vec3f origin = way % 2 ? box.upper : box.lower, direction(0);
      for (const auto& [side, cell] :
           {std::pair((axis + 1) % 3, line % resolution), {(axis + 2) % 3, line / resolution}})
        origin[side] = box.lower[side] + (static_cast<float>(cell) + 0.5f) * spacing[side];
      direction[axis] = way % 2 ? -1.0f : 1.0f;
      visit(Ray{origin, direction, INFINITE, time});
    }
}

/** Bounds of the boundaries of a medium: whole shapes, and the points of objects that a grid of rays hits.
 * Empty if no boundary is hit. */
Bounds3f boundsOfBoundary(const Scene& scene, uint16_t medium, const Bounds3f& box, float time,
                          TransportCounts& counts) {
  constexpr int LINES = 128, LINES_OF_SHAPE = 4; // rays along each side
  Bounds3f found;
  const auto forBoundaries = [&](Ray ray, const auto& visit) {
    for (Hit hit; intersectPosition(scene, ray, hit, counts); ray = rayBehind(ray, hit))
      if (hit.media.isBoundary() && (hit.media.inside == medium || hit.media.outside == medium)) visit(hit);
  };
  const Vec3f spacing = box.diagonal() / static_cast<float>(LINES);
  forLinesThrough(box, LINES, time, [&](const Ray& ray) {
    forBoundaries(ray, [&](const Hit& hit) {
      if (hit.shape >= 0) return;
      found.add(hit.point.position - spacing);
      found.add(hit.point.position + spacing);
    });
  });
  for (size_t i = 0; i < scene.shapes().size(); ++i) {
    if (isOpaque(scene.shapes()[i].material)) continue;
    const Bounds3f bounds = scene.shapes()[i].shape->bounds();
    bool isHit = false;
    forLinesThrough(bounds, LINES_OF_SHAPE, time, [&](const Ray& ray) {
      if (!isHit)
        forBoundaries(ray, [&](const Hit& hit) { isHit = isHit || hit.shape == static_cast<int>(i); });
    });
    if (isHit) found.add(bounds);
  }
  return found;
}

} // namespace

uint16_t mediumOutside(const Scene& scene, TransportCounts& counts) {
  constexpr int LINES = 64; // rays along each side
  std::vector<size_t> seen(scene.mediumCount() + 1);
  bool areBounded = false; // boundaries anywhere on the lines
  forLinesThrough(boxAround(scene.bounds()), LINES, 0, [&](Ray ray) {
    bool isVisible = true;
    for (Hit hit; intersectPosition(scene, ray, hit, counts); ray = rayBehind(ray, hit)) {
      areBounded = areBounded || hit.media.isBoundary();
      if (hit.media.isBoundary() && isVisible) ++seen[mediumBefore(hit, ray.direction)];
      if (hit.media.isBoundary()) return;
      isVisible = isVisible && !isOpaque(hit.material);
    }
  });
  const auto most = std::max_element(seen.begin(), seen.end());
  if (*most > 0) return static_cast<uint16_t>(most - seen.begin());
  return areBounded ? uint16_t(0) : scene.cameraMedium();
}

Rgb EmissiveMedia::emissionAt(const Scene& scene, uint16_t medium, const Vec3f& position, float time,
                              Nesting& nesting, TransportCounts& counts) const {
  const Rgb emission = scene.medium(medium)->at(position).emission * (4 * PI);
  if (isBlack(emission)) return emission;
  const Ray ray{position, glm::normalize(Vec3f(0.61f, 0.47f, 0.83f)), INFINITE, time};
  nesting = nestingAt(scene, ray, counts);
  nesting.startIn(mediumAround(scene, {&ray, 1}, outside, counts.rays).index);
  return nesting.medium(scene) == medium ? emission : BLACK;
}

std::vector<double> EmissiveMedia::probe(const Scene& scene, uint16_t medium, const Bounds3f& box,
                                         uint64_t seed, float time, TransportCounts& counts) const {
  constexpr uint32_t PROBES = 4; // probes of a cell
  std::vector<double> cells(size_t(CELLS) * CELLS * CELLS);
  std::vector<TransportCounts> spent(CELLS);
  parallelFor(CELLS, [&](size_t z) {
    for (size_t i = z * CELLS * CELLS; i < (z + 1) * CELLS * CELLS; ++i)
      for (uint32_t k = 0; k < PROBES; ++k) {
        Sampler sampler(seed, i, k);
        const Vec2f u = sampler.next2D();
        const Vec3f position(float(i % CELLS) + u.x, float(i / CELLS % CELLS) + u.y,
                             float(z) + sampler.next1D());
        Nesting nesting;
        const Rgb emission =
            emissionAt(scene, medium, pointOf(box, position / float(CELLS)), time, nesting, spent[z]);
        cells[i] += double(maxComponent(emission)) / PROBES;
      }
  });
  for (const TransportCounts& s : spent) counts.add(s);
  return cells;
}

std::vector<double> EmissiveMedia::probeCloser(const Scene& scene, Source& source, uint64_t seed, float time,
                                               TransportCounts& counts) const {
  constexpr uint64_t MAX_ROUNDS = 5;
  constexpr double SMALLER = 0.5; // maximum ratio of volumes for a further round
  source.probed = source.whole;
  for (uint64_t round = 1;; ++round) {
    std::vector<double> cells =
        probe(scene, source.medium, source.probed, hashCombine(seed, round), time, counts);
    Bounds3f glows = boxOfCells(source.probed, cells, CELLS);
    // The boundaries find a small medium in a large room that point probes miss.
    if (round == 1) glows.add(boundsOfBoundary(scene, source.medium, source.whole, time, counts));
    const double volume = volumeOf(glows);
    if (round == MAX_ROUNDS || glows.empty() || !(volume > 0) ||
        !(volume < SMALLER * volumeOf(source.probed)))
      return cells;
    source.probed = glows;
  }
}

bool EmissiveMedia::learn(const Scene& scene, uint16_t around, uint64_t seed, float time,
                          TransportCounts& counts) {
  sources.clear();
  outside = around;
  bool all = true;
  for (uint16_t number = 1; number <= scene.mediumCount(); ++number) {
    if (!scene.medium(number)->isEmissive()) continue;
    Source source;
    source.medium = number;
    source.whole = scene.medium(number)->bounds();
    if (!(glm::length(source.whole.diagonal()) < INFINITE)) source.whole = boxAround(scene.bounds());
    const std::vector<double> cells = probeCloser(scene, source, hashCombine(seed, number), time, counts);
    double sum = 0;
    for (const double c : cells) source.cumulative.push_back(sum += c);
    all = all && sum > 0;
    if (!(sum > 0)) continue;
    for (double& c : source.cumulative) c /= sum;
    source.powers = power() + sum * volumeOf(source.probed) / double(cells.size());
    sources.push_back(std::move(source));
  }
  return all;
}

EmissiveMedia::Sample EmissiveMedia::sample(const Scene& scene, float time, float choice,
                                            const Vec3f& uPosition, TransportCounts& counts) const {
  const double at = double(choice) * power();
  const auto source = std::upper_bound(sources.begin(), sources.end() - 1, at,
                                       [](double value, const Source& s) { return value < s.powers; });
  const double before = source == sources.begin() ? 0 : std::prev(source)->powers;
  const double chance = (source->powers - before) / power();
  double u = (at - before) / (source->powers - before);
  Sample sample;
  if (u < double(EVEN_PART)) {
    sample.position = pointOf(source->whole, uPosition);
  } else {
    u = (u - double(EVEN_PART)) / (1 - double(EVEN_PART));
    const auto cell =
        static_cast<size_t>(std::upper_bound(source->cumulative.begin(), source->cumulative.end() - 1, u) -
                            source->cumulative.begin());
    const Vec3f corner(float(cell % CELLS), float(cell / CELLS % CELLS), float(cell / CELLS / CELLS));
    sample.position = pointOf(source->probed, (corner + uPosition) / float(CELLS));
  }
  sample.medium = source->medium;
  sample.power = emissionAt(scene, source->medium, sample.position, time, sample.nesting, counts);
  double density = double(EVEN_PART) / volumeOf(source->whole);
  const Vec3f cell = (sample.position - source->probed.lower) / source->probed.diagonal() * float(CELLS);
  if (glm::all(glm::greaterThanEqual(cell, Vec3f(0))) && glm::all(glm::lessThan(cell, Vec3f(CELLS)))) {
    const auto i = (size_t(cell.z) * CELLS + size_t(cell.y)) * CELLS + size_t(cell.x);
    const double probability = source->cumulative[i] - (i > 0 ? source->cumulative[i - 1] : 0);
    density +=
        (1 - double(EVEN_PART)) * probability * double(source->cumulative.size()) / volumeOf(source->probed);
  }
  sample.power *= static_cast<float>(1 / (density * chance));
  return sample;
}

} // namespace recurse
