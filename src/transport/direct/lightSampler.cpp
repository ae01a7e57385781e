/** @file
 * Choice of lights, and the tables that it is learned in.
 */
#include "transport/direct/lightSampler.h"

#include <algorithm>
#include <numeric>

#include "recurse/core/threads/parallel.h"

namespace recurse {

namespace {

/** Sampler stream of the prior, distinct from all others. */
constexpr uint64_t PLACE_STREAM = 0x504c41434553ull;
/** Maximum arrivals in a cell, which is as many as the prior by power and distance is equivalent to. */
constexpr size_t MAX_ARRIVALS = 64;
/** Fraction spread evenly over all clusters, so that rounding leaves none with probability 0. */
constexpr double EVEN_PART = 1e-3;

} // namespace

double irradianceBy(const LiSample& light, const Vec3f& normal, bool bothSides) {
  const float cosine = glm::dot(light.direction, normal);
  if (!(light.pdf > 0) || (!bothSides && cosine < 0)) return 0;
  const double e = double(maxComponent(light.radiance)) * double(std::abs(cosine)) / double(light.pdf);
  return std::isfinite(e) ? e : 0;
}

LightSampleContext LightSampler::at(const Vec3f& position, const Vec3f& normal) const {
  LightSampleContext context{position};
  const std::vector<Cell>& side = cells[signedAxis(normal)];
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
  for (size_t end = tree.clusters.size() - 1; c < end;) {
    const size_t middle = c + (end - c) / 2;
    if (double(u) < upTo(context, middle))
      end = middle;
    else
      c = middle + 1;
  }
  const double below = c > 0 ? upTo(context, c - 1) : 0, clusterProbability = upTo(context, c) - below;
  double rest = (double(u) - below) / clusterProbability;
  const auto [leaf, probability] = tree.choose(tree.clusters[c], context.position, rest);
  u = std::min(static_cast<float>(rest), ONE_MINUS_EPSILON);
  const uint32_t light = tree.order[leaf];
  return {&lights[light], static_cast<float>(clusterProbability * probability), light};
}

float LightSampler::probabilityLearned(const LightSampleContext& context, uint32_t light) const {
  const uint32_t leaf = tree.rank[light];
  if (tree.order[leaf] != light) return 0; // the light has no power
  const uint32_t c = tree.clusterOf[leaf];
  const double ofCluster = upTo(context, c) - (c > 0 ? upTo(context, c - 1) : 0);
  return static_cast<float>(ofCluster * tree.probability(context.position, leaf));
}

void LightSampler::buildCells(Arrivals arrivals, std::vector<Cell>& cells, std::vector<Arrivals>& leaves) {
  const size_t cell = cells.size();
  cells.emplace_back();
  if (arrivals.size() > MAX_ARRIVALS) {
    Bounds3f box;
    for (const LightArrivals::Arrival& a : arrivals) box.add(a.position);
    const int axis = widestAxis(box.diagonal());
    const auto half = arrivals.begin() + static_cast<std::ptrdiff_t>(arrivals.size() / 2);
    std::nth_element(arrivals.begin(), half, arrivals.end(),
                     [&](const LightArrivals::Arrival& a, const LightArrivals::Arrival& b) {
                       return a.position[axis] < b.position[axis];
                     });
    // The border is placed between two positions, so that no wall coincides with it.
    float beyond = half->position[axis], before = box.lower[axis];
    if (beyond == before) { // more than half are in one plane: separates the remaining ones
      beyond = box.upper[axis];
      for (const LightArrivals::Arrival& a : arrivals)
        if (a.position[axis] > before) beyond = std::min(beyond, a.position[axis]);
    }
    for (const LightArrivals::Arrival& a : arrivals)
      if (a.position[axis] < beyond) before = std::max(before, a.position[axis]);
    if (beyond > before) { // else all positions coincide
      const float at = before + (beyond - before) / 2;
      const auto below = static_cast<size_t>(
          std::partition(arrivals.begin(), arrivals.end(),
                         [&](const LightArrivals::Arrival& a) { return a.position[axis] < beyond; }) -
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
  std::vector<double> all(tree.clusters.size(), 0);
  const size_t every = (arrivals.size() + PLACES - 1) / PLACES;
  for (size_t i = 0; i < arrivals.size(); i += every)
    for (size_t c = 0; c < tree.clusters.size(); ++c) {
      auto pick = double(sampler.next1D());
      const Vec2f u = sampler.next2D();
      const auto [leaf, probability] = tree.choose(tree.clusters[c], arrivals[i].position, pick);
      const auto light = lights[tree.order[leaf]].sampleLi(arrivals[i].position, static_cast<float>(pick), u);
      if (light) all[c] += irradianceBy(*light, arrivals[i].normal, false) / probability;
    }
  return all;
}

void LightSampler::buildTable(const LightTable& lights, Arrivals arrivals, Sampler sampler,
                              float* table) const {
  const size_t count = tree.clusters.size();
  Bounds3f box;
  for (const LightArrivals::Arrival& a : arrivals) box.add(a.position);
  // Distributes probability 1 over the clusters from the root down.
  const auto dealOut = [&](const auto& left, const auto& deal) {
    const auto visit = [&](const auto& self, LightTree::Descent way, double probability) -> void {
      const size_t c = tree.clusterOf[way.where().first];
      if (way.where().node == tree.clusters[c].node) return deal(c, probability);
      const double toTheLeft = left(way);
      LightTree::Descent other = way;
      way.go(true);
      other.go(false);
      self(self, way, probability * toTheLeft);
      self(self, other, probability * (1 - toTheLeft));
    };
    visit(visit, LightTree::Descent(tree, box.center(), lengthSquared(box.diagonal() / 2.0f), tree.root()),
          1);
  };
  // The prior is the unoccluded irradiance from the clusters. Its few samples may all be zero, so a fraction
  // is by distance alone.
  std::vector<double> guess = irradiances(lights, arrivals, sampler);
  const double all = std::accumulate(guess.begin(), guess.end(), 0.0);
  constexpr double BY_DISTANCE = 0.1;
  dealOut([](const LightTree::Descent& way) { return way.left(); },
          [&](size_t c, double probability) {
            guess[c] = all > 0 ? BY_DISTANCE * probability + (1 - BY_DISTANCE) * guess[c] / all : probability;
          });
  std::vector<double> guesses(count + 1, 0),
      photons(count + 1, 0); // prefix sums: entry c is the sum before cluster c
  for (const LightArrivals::Arrival& a : arrivals) photons[tree.clusterOf[a.leaf] + 1] += 1;
  for (size_t c = 0; c < count; ++c) {
    guesses[c + 1] = guesses[c] + guess[c];
    photons[c + 1] += photons[c];
  }
  double sum = 0;
  dealOut(
      [&](const LightTree::Descent& way) {
        const size_t first = tree.clusterOf[way.where().first], middle = tree.clusterOf[way.middle()],
                     end = tree.clusterOf[way.where().end - 1] + 1;
        const double guessed = guesses[end] - guesses[first];
        const double prior = guessed > 0 ? (guesses[middle] - guesses[first]) / guessed : way.left();
        return (photons[middle] - photons[first] + MAX_ARRIVALS * prior) /
               (photons[end] - photons[first] + MAX_ARRIVALS);
      },
      [&](size_t c, double probability) {
        sum += (1 - EVEN_PART) * probability + EVEN_PART / double(count);
        table[c] = static_cast<float>(sum);
      });
}

TransportCounts LightSampler::prepare(const Scene& scene, bool withPortals) {
  *this = {};
  TransportCounts counts;
  if (withPortals) counts = portals.learn(scene);
  if (scene.lights().size() > 1) tree.build(scene.lights());
  return counts;
}

void LightSampler::learn(const LightTable& lights, LightArrivals& arrivals) {
  std::vector<Arrivals> leaves;
  for (size_t side = 0; side < SIGNED_AXES; ++side)
    if (!arrivals.bySide[side].empty()) buildCells(arrivals.bySide[side], cells[side], leaves);
  const size_t count = tree.clusters.size();
  tables.resize((leaves.size() + 1) * count);
  parallelFor(leaves.size() + 1, [&](size_t i) {
    if (i > 0)
      return buildTable(lights, leaves[i - 1], Sampler(0, PLACE_STREAM, static_cast<uint32_t>(i)),
                        &tables[i * count]);
    // Only this table serves points in media: a sun that does not reach them must leave some to lamps.
    constexpr double EVENLY = 0.25;
    double sum = 0;
    for (size_t c = 0; c < count; ++c) {
      sum += (1 - EVENLY) * double(tree.nodes[tree.clusters[c].node].power) + EVENLY / double(count);
      tables[c] = static_cast<float>(sum);
    }
  });
}

} // namespace recurse
