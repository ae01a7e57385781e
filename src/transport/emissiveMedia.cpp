/** @file
 * Probes of glowing media, and places by what they have found.
 */
#include "recurse/transport/emissiveMedia.h"

#include <algorithm>

#include "recurse/core/parallel.h"
#include "recurse/transport/walk.h"

namespace recurse {

namespace {

Vec3f pointOf(const Bounds3f& box, const Vec3f& part) { return box.lower + box.diagonal() * part; }

double volumeOf(const Bounds3f& box) {
  const Vec3d d(box.diagonal());
  return d.x * d.y * d.z;
}

/** The cells of a box that are not black, and one more on each side. */
Bounds3f boxOfCells(const Bounds3f& box, const std::vector<double>& cells, int count) {
  glm::ivec3 first(count), last(0);
  for (int z = 0, i = 0; z < count; ++z)
    for (int y = 0; y < count; ++y)
      for (int x = 0; x < count; ++x, ++i)
        if (cells[size_t(i)] > 0) {
          first = glm::min(first, glm::ivec3(x, y, z) - 1);
          last = glm::max(last, glm::ivec3(x, y, z) + 2);
        }
  first = glm::max(first, glm::ivec3(0));
  last = glm::min(last, glm::ivec3(count));
  return {pointOf(box, Vec3f(first) / float(count)), pointOf(box, Vec3f(last) / float(count))};
}

} // namespace

uint16_t mediumAround(const Scene& scene, Ray ray, uint16_t outside, TransportCounts& counts) {
  for (Hit hit; intersectPosition(scene, ray, hit, counts); ray.origin = originBehind(ray, hit))
    if (hit.media.isBoundary())
      return isNested(hit) || glm::dot(ray.direction, hit.point.geometricNormal) < 0 ? hit.media.outside
                                                                                     : hit.media.inside;
  return outside;
}

uint16_t mediumOutside(const Scene& scene, TransportCounts& counts) {
  constexpr float FAR_OUT = 2; // times the scene's radius
  constexpr uint16_t UNKNOWN = 0xffff;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3f towards = glm::normalize(
        Vec3f(corner & 1 ? 0.61f : -0.61f, corner & 2 ? 0.47f : -0.47f, corner & 4 ? 0.83f : -0.83f));
    const SceneBounds& bounds = scene.bounds();
    const Ray ray{bounds.center - towards * (FAR_OUT * bounds.radius), towards, INFINITE, 0};
    const uint16_t found = mediumAround(scene, ray, UNKNOWN, counts);
    if (found != UNKNOWN) return found;
  }
  return scene.cameraMedium();
}

Rgb EmissiveMedia::emissionAt(const Scene& scene, uint16_t medium, const Vec3f& position, float time,
                              Nesting& nesting, TransportCounts& counts) const {
  const Rgb emission = scene.medium(medium)->at(position).emission * (4 * PI);
  if (isBlack(emission)) return emission;
  const Ray ray{position, glm::normalize(Vec3f(0.61f, 0.47f, 0.83f)), INFINITE, time};
  nesting = nestingAt(scene, ray, counts);
  nesting.startIn(mediumAround(scene, ray, outside, counts));
  return nesting.medium(scene) == medium ? emission : BLACK;
}

std::vector<double> EmissiveMedia::probe(const Scene& scene, uint16_t medium, const Bounds3f& box,
                                         uint64_t seed, float time, TransportCounts& counts) const {
  constexpr uint32_t PROBES = 4; // of a cell
  std::vector<double> cells(CELL_COUNT);
  std::vector<TransportCounts> spent(CELLS);
  parallelFor(CELLS, [&](size_t z) {
    for (size_t i = z * CELLS * CELLS; i < (z + 1) * CELLS * CELLS; ++i)
      for (uint32_t k = 0; k < PROBES; ++k) {
        Sampler sampler(seed, i, k);
        const Vec2f u = sampler.next2D();
        const Vec3f place(float(i % CELLS) + u.x, float(i / CELLS % CELLS) + u.y,
                          float(z) + sampler.next1D());
        Nesting nesting;
        const Rgb emission =
            emissionAt(scene, medium, pointOf(box, place / float(CELLS)), time, nesting, spent[z]);
        cells[i] += double(maxComponent(emission)) / PROBES;
      }
  });
  for (const TransportCounts& s : spent) counts.add(s);
  return cells;
}

bool EmissiveMedia::learn(const Scene& scene, uint64_t seed, float time, TransportCounts& counts) {
  constexpr int MOST_ROUNDS = 4;
  constexpr double SMALLER = 0.5; // by this much, else it is not worth another round
  sources.clear();
  outside = mediumOutside(scene, counts);
  bool all = true;
  for (uint16_t number = 1; number <= scene.mediumCount(); ++number) {
    if (!scene.medium(number)->isEmissive()) continue;
    Source source;
    source.medium = number;
    source.whole = scene.medium(number)->bounds();
    if (!(glm::length(source.whole.diagonal()) < INFINITE)) {
      const SceneBounds& bounds = scene.bounds();
      source.whole = {bounds.center - bounds.radius, bounds.center + bounds.radius};
    }
    source.probed = source.whole;
    std::vector<double> cells;
    for (int round = 0;; ++round) {
      cells = probe(scene, number, source.probed, hashCombine(seed, uint64_t(number) * MOST_ROUNDS + round),
                    time, counts);
      const Bounds3f glows = boxOfCells(source.probed, cells, CELLS);
      if (round + 1 == MOST_ROUNDS || !(volumeOf(glows) < SMALLER * volumeOf(source.probed)) ||
          !(volumeOf(glows) > 0))
        break;
      source.probed = glows;
    }
    double sum = 0;
    for (const double c : cells) source.cumulative.push_back(sum += c);
    all = all && sum > 0;
    if (!(sum > 0)) continue;
    for (double& c : source.cumulative) c /= sum;
    source.powers = power() + sum * volumeOf(source.probed) / double(CELL_COUNT);
    sources.push_back(std::move(source));
  }
  return all;
}

EmissiveMedia::Sample EmissiveMedia::sample(const Scene& scene, float time, float choice, const Vec3f& place,
                                            TransportCounts& counts) const {
  const double at = double(choice) * power();
  const auto source = std::upper_bound(sources.begin(), sources.end() - 1, at,
                                       [](double value, const Source& s) { return value < s.powers; });
  const double before = source == sources.begin() ? 0 : std::prev(source)->powers;
  const double chance = (source->powers - before) / power();
  double u = (at - before) / (source->powers - before);
  Sample sample;
  if (u < double(EVEN_PART)) {
    sample.position = pointOf(source->whole, place);
  } else {
    u = (u - double(EVEN_PART)) / (1 - double(EVEN_PART));
    const auto cell =
        static_cast<size_t>(std::upper_bound(source->cumulative.begin(), source->cumulative.end() - 1, u) -
                            source->cumulative.begin());
    const Vec3f corner(float(cell % CELLS), float(cell / CELLS % CELLS), float(cell / CELLS / CELLS));
    sample.position = pointOf(source->probed, (corner + place) / float(CELLS));
  }
  sample.power = emissionAt(scene, source->medium, sample.position, time, sample.nesting, counts);
  double density = double(EVEN_PART) / volumeOf(source->whole);
  const Vec3f cell = (sample.position - source->probed.lower) / source->probed.diagonal() * float(CELLS);
  if (glm::all(glm::greaterThanEqual(cell, Vec3f(0))) && glm::all(glm::lessThan(cell, Vec3f(CELLS)))) {
    const auto i = (size_t(cell.z) * CELLS + size_t(cell.y)) * CELLS + size_t(cell.x);
    const double probability = source->cumulative[i] - (i > 0 ? source->cumulative[i - 1] : 0);
    density += (1 - double(EVEN_PART)) * probability * double(CELL_COUNT) / volumeOf(source->probed);
  }
  sample.power *= static_cast<float>(1 / (density * chance));
  return sample;
}

} // namespace recurse
