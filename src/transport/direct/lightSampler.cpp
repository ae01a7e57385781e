/** @file
 * Learning of the light selection from photons and camera rays.
 */
#include "transport/direct/lightSampler.h"

#include <algorithm>
#include <numeric>

#include "recurse/core/threads/interrupt.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/model/bsdf/scatteringPoint.h"
#include "transport/paths/walk.h"

namespace recurse {

namespace {

/** Sampler streams of the learning, distinct from all others. */
constexpr uint64_t FIRST_LIGHT_STREAM = 0x4c4947485453ull, LOOK_STREAM = 0x4c4f4f4b53ull,
                   PLACE_STREAM = 0x504c41434553ull;
/** Maximum photons in a cell, and photons that the prior by power and distance is equivalent to. */
constexpr size_t MAX_ARRIVALS = 64;
constexpr double PRIOR = 64;
/** Number of levels of the tree that are tabulated. */
constexpr int TABLE_DEPTH = 6;
/** Fraction spread evenly over all clusters, so that rounding leaves none with probability 0. */
constexpr double EVEN_PART = 1e-3;

/** Irradiance from a light sample, in its strongest channel; 0 behind the surface or if not finite. */
double irradiance(const LiSample& light, const Vec3f& normal, bool bothSides) {
  const float cosine = glm::dot(light.direction, normal);
  if (!(light.pdf > 0) || (!bothSides && cosine < 0)) return 0;
  const double e = double(maxComponent(light.radiance)) * double(std::abs(cosine)) / double(light.pdf);
  return std::isfinite(e) ? e : 0;
}

} // namespace

/** Descent of the tree from a node to a light. */
class LightSampler::Descent {
 public:
  /** `near2`: squared distance below which lights are not distinguished by distance. */
  Descent(const LightSampler& guide, const Vec3f& position, float near2, const Cluster& from)
      : guide(guide), position(position), near2(near2), at(from) {}

  bool atLight() const { return at.end - at.first == 1; }
  const Cluster& where() const { return at; }
  uint32_t middle() const { return at.first + (at.end - at.first) / 2; }
  uint32_t right() const { return at.node + 2 * (middle() - at.first); }
  /** Probability of the left child, by power over distance². */
  double left() const {
    const Node &whole = guide.nodes[at.node], &l = guide.nodes[at.node + 1], &r = guide.nodes[right()];
    // Bounds the distance from below: next to a light, or in its box, its sibling keeps some probability.
    const float least = std::max(whole.radius2 / 16, near2);
    const auto distance2 = [&](const Node& n) {
      return double(std::max(lengthSquared(n.center - position), std::max(n.radius2, least)));
    };
    double a = double(l.power), b = double(r.power);
    if (least > 0) {
      a *= distance2(r);
      b *= distance2(l);
    }
    return a / (a + b);
  }
  void go(bool toTheLeft) {
    if (toTheLeft)
      at = {at.node + 1, at.first, middle()};
    else
      at = {right(), middle(), at.end};
  }

 private:
  const LightSampler& guide;
  const Vec3f position;
  const float near2;
  Cluster at;
};

size_t LightSampler::sideOf(const Vec3f& normal) {
  const int axis = widestAxis(magnitude(normal));
  return size_t(2 * axis + (normal[axis] < 0));
}

LightSampleContext LightSampler::at(const Vec3f& position, const Vec3f& normal) const {
  LightSampleContext context{position};
  const std::vector<Cell>& side = cells[sideOf(normal)];
  if (side.empty()) return context;
  // Pending descents and their weights; near a border both children are followed.
  struct Way {
    size_t cell;
    float weight;
  };
  std::array<Way, LightSampleContext::MAX_CELLS> ways{{{0, 1}}};
  size_t left = 1;
  context.count = 0;
  while (left > 0) {
    auto [i, weight] = ways[--left];
    while (side[i].axis < 3) {
      const Cell& c = side[i];
      const float beyond = position[int(c.axis)] - c.at;
      const bool isNear = std::abs(beyond) < c.band && context.count + left + 1 < ways.size();
      if (isNear) {
        const float other = weight * (0.5f - 0.5f * std::abs(beyond) / c.band);
        ways[left++] = {beyond < 0 ? c.other : i + 1, other};
        weight -= other;
      }
      i = beyond < 0 ? i + 1 : c.other;
    }
    context.shares[context.count++] = {side[i].other, weight};
  }
  return context;
}

ChosenLight LightSampler::chooseLearned(const LightTable& lights, const LightSampleContext& context,
                                        float& u) const {
  size_t c = 0;
  for (size_t end = clusters.size() - 1; c < end;) {
    const size_t middle = c + (end - c) / 2;
    if (double(u) < upTo(context, middle))
      end = middle;
    else
      c = middle + 1;
  }
  const double below = c > 0 ? upTo(context, c - 1) : 0, clusterProbability = upTo(context, c) - below;
  const auto [light, probability] = chooseBelow(
      clusters[c], context.position, (double(u) - below) / clusterProbability, clusterProbability, u);
  return {&lights[order[light]], static_cast<float>(probability), order[light]};
}

LightSampler::Chosen LightSampler::chooseBelow(const Cluster& cluster, const Vec3f& position, double uCluster,
                                               double probability, float& u) const {
  Descent way(*this, position, 0, cluster);
  while (!way.atLight()) {
    const double left = way.left();
    const bool toTheLeft = uCluster < left;
    const double branchProbability = toTheLeft ? left : 1 - left;
    uCluster = (toTheLeft ? uCluster : uCluster - left) / branchProbability;
    probability *= branchProbability;
    way.go(toTheLeft);
  }
  u = std::min(static_cast<float>(uCluster), ONE_MINUS_EPSILON);
  return {way.where().first, probability};
}

float LightSampler::probabilityLearned(const LightSampleContext& context, uint32_t light) const {
  const uint32_t wanted = rank[light];
  if (order[wanted] != light) return 0; // the light has no power
  const uint32_t c = clusterOf[wanted];
  double probability = upTo(context, c) - (c > 0 ? upTo(context, c - 1) : 0);
  Descent way(*this, context.position, 0, clusters[c]);
  while (!way.atLight()) {
    const double left = way.left();
    const bool toTheLeft = wanted < way.middle();
    probability *= toTheLeft ? left : 1 - left;
    way.go(toTheLeft);
  }
  return static_cast<float>(probability);
}

void LightSampler::buildTree(const LightTable& lights) {
  // Only emission positions of a light are needed. A box that is too small costs only noise.
  constexpr int STARTS = 4;
  std::vector<Bounds3f> boxes(lights.size());
  for (size_t i = 0; i < lights.size(); ++i) {
    if (!(lights.probability(i) > 0)) continue; // no photon starts here
    order.push_back(static_cast<uint32_t>(i));
    for (int k = 0; k < STARTS; ++k) {
      const float a = (static_cast<float>(k) + 0.5f) / STARTS, b = std::fmod(a + 0.5f, 1.0f);
      if (const auto e = lights[i].sampleLe({a, {a, k % 2 ? 0.25f : 0.75f}, {b, a}, a}))
        boxes[i].add(e->origin);
    }
    if (boxes[i].empty()) boxes[i].add(Vec3f(0));
  }
  if (order.size() < 2) {
    order.clear();
    return;
  }
  nodes.reserve(2 * order.size());
  buildNode(boxes, lights, 0, order.size(), 0);
  for (uint32_t c = 0; c < clusters.size(); ++c)
    for (uint32_t i = clusters[c].first; i < clusters[c].end; ++i) clusterOf.push_back(c);
  rank.assign(lights.size(), 0);
  for (size_t i = 0; i < order.size(); ++i) rank[order[i]] = static_cast<uint32_t>(i);
}

void LightSampler::buildNode(std::span<const Bounds3f> boxes, const LightTable& lights, size_t first,
                             size_t end, int depth) {
  Bounds3f box;
  double power = 0;
  for (size_t i = first; i < end; ++i) {
    box.add(boxes[order[i]]);
    power += double(lights.probability(order[i]));
  }
  if (depth == TABLE_DEPTH || (depth < TABLE_DEPTH && end - first == 1))
    clusters.push_back(
        {static_cast<uint32_t>(nodes.size()), static_cast<uint32_t>(first), static_cast<uint32_t>(end)});
  nodes.push_back({box.center(), lengthSquared(box.diagonal() / 2.0f), static_cast<float>(power)});
  if (end - first == 1) return;
  const int axis = widestAxis(box.diagonal());
  const auto doubledCenter = [&](uint32_t light) {
    return boxes[light].lower[axis] + boxes[light].upper[axis];
  };
  const size_t middle = first + (end - first) / 2;
  const auto at = [&](size_t i) { return order.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(first), at(middle), at(end), [&](uint32_t a, uint32_t b) {
    return doubledCenter(a) != doubledCenter(b) ? doubledCenter(a) < doubledCenter(b) : a < b;
  });
  buildNode(boxes, lights, first, middle, depth + 1);
  buildNode(boxes, lights, middle, end, depth + 1);
}

void LightSampler::buildCells(Arrivals arrivals, std::vector<Cell>& cells, std::vector<Arrivals>& leaves) {
  const size_t cell = cells.size();
  cells.emplace_back();
  if (arrivals.size() > MAX_ARRIVALS) {
    Bounds3f box;
    for (const Arrival& a : arrivals) box.add(a.position);
    const int axis = widestAxis(box.diagonal());
    const auto half = arrivals.begin() + static_cast<std::ptrdiff_t>(arrivals.size() / 2);
    std::nth_element(arrivals.begin(), half, arrivals.end(),
                     [&](const Arrival& a, const Arrival& b) { return a.position[axis] < b.position[axis]; });
    // The border is placed between two positions, so that no wall coincides with it.
    float beyond = half->position[axis], before = box.lower[axis];
    if (beyond == before) { // more than half are in one plane: separates the remaining ones
      beyond = box.upper[axis];
      for (const Arrival& a : arrivals)
        if (a.position[axis] > before) beyond = std::min(beyond, a.position[axis]);
    }
    for (const Arrival& a : arrivals)
      if (a.position[axis] < beyond) before = std::max(before, a.position[axis]);
    if (beyond > before) { // else all positions coincide
      const float at = before + (beyond - before) / 2;
      const auto below =
          static_cast<size_t>(std::partition(arrivals.begin(), arrivals.end(),
                                             [&](const Arrival& a) { return a.position[axis] < beyond; }) -
                              arrivals.begin());
      buildCells(arrivals.first(below), cells, leaves);
      // Half the width of a leaf, since a surface of this extent has `leaves1d` leaves along it.
      const double leaves1d = std::sqrt(double(arrivals.size()) / double(MAX_ARRIVALS / 2));
      const auto band = static_cast<float>(0.5 * double(box.diagonal()[axis]) / leaves1d);
      cells[cell] = {static_cast<uint32_t>(axis), at, band, static_cast<uint32_t>(cells.size())};
      buildCells(arrivals.subspan(below), cells, leaves);
      return;
    }
  }
  leaves.push_back(arrivals);
  cells[cell].other = static_cast<uint32_t>(leaves.size()); // table 0 belongs to no cell
}

std::vector<double> LightSampler::irradiances(const LightTable& lights, Arrivals arrivals,
                                              Sampler sampler) const {
  constexpr size_t PLACES = 8;
  std::vector<double> all(clusters.size(), 0);
  const size_t every = (arrivals.size() + PLACES - 1) / PLACES;
  for (size_t i = 0; i < arrivals.size(); i += every)
    for (size_t c = 0; c < clusters.size(); ++c) {
      float pick = sampler.next1D();
      const Vec2f u = sampler.next2D();
      const auto [light, probability] = chooseBelow(clusters[c], arrivals[i].position, double(pick), 1, pick);
      if (const auto illumination = lights[order[light]].sampleLi(arrivals[i].position, pick, u))
        all[c] += irradiance(*illumination, arrivals[i].normal, false) / probability;
    }
  return all;
}

void LightSampler::buildTable(const LightTable& lights, Arrivals arrivals, Sampler sampler,
                              float* table) const {
  const size_t count = clusters.size();
  Bounds3f box;
  for (const Arrival& a : arrivals) box.add(a.position);
  // Distributes probability 1 over the clusters from the root down.
  const auto dealOut = [&](const auto& left, const auto& deal) {
    const auto visit = [&](const auto& self, Descent way, double probability) -> void {
      const size_t c = clusterOf[way.where().first];
      if (way.where().node == clusters[c].node) return deal(c, probability);
      const double toTheLeft = left(way);
      Descent other = way;
      way.go(true);
      other.go(false);
      self(self, way, probability * toTheLeft);
      self(self, other, probability * (1 - toTheLeft));
    };
    visit(visit,
          Descent(*this, box.center(), lengthSquared(box.diagonal() / 2.0f),
                  {0, 0, static_cast<uint32_t>(order.size())}),
          1);
  };
  // The prior is the unoccluded irradiance from the clusters. Its few samples may all be zero, so a fraction
  // is by distance alone.
  std::vector<double> guess = irradiances(lights, arrivals, sampler);
  const double all = std::accumulate(guess.begin(), guess.end(), 0.0);
  constexpr double BY_DISTANCE = 0.1;
  dealOut([](const Descent& way) { return way.left(); },
          [&](size_t c, double probability) {
            guess[c] = all > 0 ? BY_DISTANCE * probability + (1 - BY_DISTANCE) * guess[c] / all : probability;
          });
  std::vector<double> guesses(count + 1, 0),
      photons(count + 1, 0); // prefix sums: entry c is the sum before cluster c
  for (const Arrival& a : arrivals) photons[clusterOf[a.light] + 1] += 1;
  for (size_t c = 0; c < count; ++c) {
    guesses[c + 1] = guesses[c] + guess[c];
    photons[c + 1] += photons[c];
  }
  double sum = 0;
  dealOut(
      [&](const Descent& way) {
        const size_t first = clusterOf[way.where().first], middle = clusterOf[way.middle()],
                     end = clusterOf[way.where().end - 1] + 1;
        const double guessed = guesses[end] - guesses[first];
        const double prior = guessed > 0 ? (guesses[middle] - guesses[first]) / guessed : way.left();
        return (photons[middle] - photons[first] + PRIOR * prior) / (photons[end] - photons[first] + PRIOR);
      },
      [&](size_t c, double probability) {
        sum += (1 - EVEN_PART) * probability + EVEN_PART / double(count);
        table[c] = static_cast<float>(sum);
      });
}

void LightSampler::keep(const Hit& hit, const Vec3f& direction, uint32_t light, Found& found) const {
  const Vec3f& normal = hit.point.geometricNormal;
  const bool outside = glm::dot(normal, direction) < 0, both = hit.material->lobes() & TRANSMISSION;
  if (outside || both) found.arrivals[sideOf(normal)].push_back({hit.point.position, normal, light});
  if (!outside || both) found.arrivals[sideOf(-normal)].push_back({hit.point.position, -normal, light});
}

void LightSampler::shoot(const Scene& scene, uint32_t index, Found& found) const {
  const LightTable& lights = scene.lights();
  Sampler sampler(0, FIRST_LIGHT_STREAM, index);
  float pick = sampler.next1D();
  const size_t light = lights.chooseIndex(pick);
  const float pickOnLight = sampler.next1D();
  const Vec2f position = sampler.next2D(), direction = sampler.next2D();
  if (!(lights.probability(light) > 0)) return;
  const float time = scene.moves() ? scene.camera().timeAt(sampler.next1D()) : 0;
  const std::optional<LeSample> emission = lights[light].sampleLe({pickOnLight, position, direction, time});
  if (!emission || isBlack(emission->flux)) return;
  BsdfArena arena;
  Ray ray{emission->origin, emission->direction, INFINITE, time};
  Nesting nesting = nestingAt(scene, ray, found.counts);
  for (Hit hit; intersect(scene, ray, hit, found.counts); ray = spawn(hit.point, ray.direction)) {
    arena.reset();
    const Bsdf* bsdf = bsdfAt(scene, hit, ray.direction, Footprint(), nesting, arena);
    const LobeSet lobes = bsdf ? bsdf->lobes() : LobeSet(STRAIGHT);
    if (!(lobes & STRAIGHT) || (lobes & NON_DELTA_LOBES)) // a pane alone lets shadow rays pass
      return keep(hit, ray.direction, rank[light], found);
  }
}

void LightSampler::look(const Scene& scene, uint32_t index, Found& found) const {
  Sampler sampler(0, LOOK_STREAM, index);
  BsdfArena arena;
  const Vec2f filmSize(scene.film().width, scene.film().height);
  CameraSample sample{sampler.next2D() * filmSize};
  if (scene.camera().usesLens()) sample.lens = sampler.next2D();
  if (scene.moves()) sample.time = scene.camera().timeAt(sampler.next1D());
  const std::optional<CameraRay> seen = scene.camera().validRay(sample);
  if (!seen) return;
  Ray ray = *seen;
  Nesting nesting = nestingAt(scene, ray, found.counts);
  Hit hit;
  for (int depth = 0; depth < MAX_BRANCHING_DEPTH && intersect(scene, ray, hit, found.counts); ++depth) {
    arena.reset();
    const Bsdf* bsdf = bsdfAt(scene, hit, ray.direction, Footprint(), nesting, arena);
    Vec3f direction = ray.direction;
    if (bsdf) {
      const ScatteringPoint scattering(*bsdf, hit.point);
      if (scattering.hasNonDelta()) return lookForLight(scene, hit, ray.direction, nesting, sampler, found);
      const auto s = scattering.scatter(-ray.direction, Transport::FLUX, sampler, DELTA_LOBES);
      if (!s) return;
      direction = s->direction;
      nesting.scatters(hit, -ray.direction, direction);
    }
    ray = spawn(hit.point, direction);
  }
}

void LightSampler::lookForLight(const Scene& scene, const Hit& hit, const Vec3f& direction,
                                const Nesting& nesting, Sampler& sampler, Found& found) const {
  constexpr int TRIALS = 6;
  const LightTable& lights = scene.lights();
  const Vec3f& n = hit.point.geometricNormal;
  const Vec3f normal = glm::dot(n, direction) < 0 ? n : -n;
  const bool both = hit.material->lobes() & TRANSMISSION;
  const Cluster all{0, 0, static_cast<uint32_t>(order.size())};
  // Reservoir sampling of one trial by its irradiance. If trials were by power alone, the sky, which may be
  // hidden, would take nearly all of them.
  std::optional<uint32_t> kept;
  double sum = 0;
  for (int i = 0; i < TRIALS; ++i) {
    float pick = sampler.next1D();
    const Vec2f u = sampler.next2D();
    const double keeps = double(sampler.next1D());
    const bool byPower = i % 2 == 0;
    const double which = byPower ? 0 : double(pick) * double(clusters.size());
    const Cluster& from = byPower ? all : clusters[static_cast<size_t>(which)];
    const double uCluster = byPower ? double(pick) : which - std::floor(which);
    const auto [light, probability] =
        chooseBelow(from, hit.point.position, uCluster, byPower ? 1 : 1 / double(clusters.size()), pick);
    const auto illumination = sampleLi(lights[order[light]], hit.point.time, hit.point.position, pick, u);
    double e = illumination ? irradiance(*illumination, normal, both) / probability : 0;
    if (e > 0)
      e *= double(maxComponent(
          transmittance(scene, hit, -direction, *illumination, nesting, panesLeft(-1, 0), found.counts)
              .value));
    sum += e;
    if (keeps * sum < e) kept = light;
  }
  if (kept) keep(hit, direction, *kept, found);
}

/** Interruption leaves nothing learned: lights are then chosen by power. */
TransportCounts LightSampler::learn(const Scene& scene, bool withPortals) try {
  *this = {};
  TransportCounts counts;
  if (withPortals) counts = portals.learn(scene);
  const LightTable& lights = scene.lights();
  if (lights.size() < 2) return counts;
  buildTree(lights);
  if (!active()) return counts;
  // Limited by the number of pixels, so that learning takes a small fraction of the render time.
  constexpr size_t MIN_COUNT = 4096, MAX_COUNT = 131072, BATCH = 1024, LOOKS = 4;
  const size_t pixels = size_t(scene.film().width) * size_t(scene.film().height);
  const size_t batches = std::clamp(pixels, MIN_COUNT, MAX_COUNT) / BATCH;
  std::vector<Found> found(batches);
  parallelFor(batches, [&](size_t b) {
    for (size_t i = b * BATCH; i < (b + 1) * BATCH; ++i) shoot(scene, static_cast<uint32_t>(i), found[b]);
    for (size_t i = b * BATCH / LOOKS; i < (b + 1) * BATCH / LOOKS; ++i)
      look(scene, static_cast<uint32_t>(i), found[b]);
  });
  std::array<std::vector<Arrival>, SIDES> all;
  std::vector<Arrivals> leaves;
  for (size_t side = 0; side < SIDES; ++side) {
    for (const Found& f : found)
      all[side].insert(all[side].end(), f.arrivals[side].begin(), f.arrivals[side].end());
    if (!all[side].empty()) buildCells(all[side], cells[side], leaves);
  }
  tables.resize((leaves.size() + 1) * clusters.size());
  parallelFor(leaves.size() + 1, [&](size_t i) {
    if (i > 0)
      return buildTable(lights, leaves[i - 1], Sampler(0, PLACE_STREAM, static_cast<uint32_t>(i)),
                        &tables[i * clusters.size()]);
    // Only this table serves points in media: a sun that does not reach them must leave some to lamps.
    constexpr double EVENLY = 0.25;
    double sum = 0;
    for (size_t c = 0; c < clusters.size(); ++c) {
      sum += (1 - EVENLY) * double(nodes[clusters[c].node].power) + EVENLY / double(clusters.size());
      tables[c] = static_cast<float>(sum);
    }
  });
  for (const Found& f : found) counts.add(f.counts);
  return counts;
} catch (const Interrupted&) {
  *this = {};
  return {};
}

} // namespace recurse
