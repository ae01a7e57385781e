/** @file
 * Learning which lights reach which places.
 */
#include "recurse/transport/lightGuide.h"

#include <algorithm>

#include "recurse/core/parallel.h"
#include "recurse/transport/walk.h"

namespace recurse {

namespace {

constexpr uint64_t STREAM = 0x4c4947485453ull; ///< tells these photons from all others
/** Most photons of a cell, and how many the guess by power and distance is worth. */
constexpr size_t CELL = 64;
constexpr double PRIOR = 32;
/** Levels of the tree that are tabulated. */
constexpr int TABLE_DEPTH = 6;
/** The part that all clusters share, so that rounding of sums does not make anyone's part 0. */
constexpr double EVEN_PART = 1e-3;

/** The longest side of the box. */
int widest(const Vec3f& low, const Vec3f& high) {
  const Vec3f size = high - low;
  return size.x >= size.y ? (size.x >= size.z ? 0 : 2) : (size.y >= size.z ? 1 : 2);
}

} // namespace

/** A node on a way down the tree. */
class LightGuide::Descent {
 public:
  /** `near2`: lights nearer than its root are not told apart by distance. */
  Descent(const LightGuide& guide, const Vec3f& position, float near2, const Cluster& from)
      : guide(guide), position(position), near2(near2), at(from) {}

  bool atLight() const { return at.end - at.first == 1; }
  const Cluster& where() const { return at; }
  uint32_t middle() const { return at.first + (at.end - at.first) / 2; }
  uint32_t right() const { return at.node + 2 * (middle() - at.first); }
  /** The left child's part by power over distance². */
  double left() const {
    const Node &whole = guide.nodes[at.node], &l = guide.nodes[at.node + 1], &r = guide.nodes[right()];
    // Next to one of two lights, or inside its box, the other one still counts for something.
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
  const LightGuide& guide;
  const Vec3f position;
  const float near2;
  Cluster at;
};

size_t LightGuide::sideOf(const Vec3f& normal) {
  const Vec3f a = glm::abs(normal);
  const int axis = a.x >= a.y ? (a.x >= a.z ? 0 : 2) : (a.y >= a.z ? 1 : 2);
  return size_t(2 * axis + (normal[axis] < 0));
}

LitPlace LightGuide::at(const Vec3f& position, const Vec3f& normal) const {
  LitPlace place{position};
  if (!active()) return place;
  const std::vector<Cell>& side = cells[sideOf(normal)];
  if (side.empty()) return place;
  size_t i = 0;
  while (side[i].axis < 3) i = position[int(side[i].axis)] < side[i].at ? i + 1 : side[i].other;
  place.cell = side[i].other;
  return place;
}

ChosenLight LightGuide::chooseLearned(const LightTable& lights, const LitPlace& place, float& u) const {
  const float* const table = &tables[place.cell * clusters.size()];
  const auto c = static_cast<size_t>(std::upper_bound(table, table + clusters.size() - 1, u) - table);
  const float below = c > 0 ? table[c - 1] : 0;
  double probability = double(table[c] - below), rest = double(u - below) / probability;
  Descent way(*this, place.position, 0, clusters[c]);
  while (!way.atLight()) {
    const double left = way.left();
    const bool toTheLeft = rest < left;
    const double part = toTheLeft ? left : 1 - left;
    rest = (toTheLeft ? rest : rest - left) / part;
    probability *= part;
    way.go(toTheLeft);
  }
  u = std::min(static_cast<float>(rest), ONE_MINUS_EPSILON);
  return {&lights[order[way.where().first]], static_cast<float>(probability)};
}

float LightGuide::probabilityLearned(const LitPlace& place, uint32_t light) const {
  const uint32_t wanted = rank[light];
  if (order[wanted] != light) return 0; // it has no power
  const float* const table = &tables[place.cell * clusters.size()];
  const uint32_t c = clusterOf[wanted];
  double probability = double(table[c] - (c > 0 ? table[c - 1] : 0));
  Descent way(*this, place.position, 0, clusters[c]);
  while (!way.atLight()) {
    const double left = way.left();
    const bool toTheLeft = wanted < way.middle();
    probability *= toTheLeft ? left : 1 - left;
    way.go(toTheLeft);
  }
  return static_cast<float>(probability);
}

void LightGuide::buildTree(const LightTable& lights) {
  // Where photons start is all that is asked of a light; a box that is too small costs no more than noise.
  constexpr int STARTS = 4;
  std::vector<std::array<Vec3f, 2>> boxes(lights.size());
  for (size_t i = 0; i < lights.size(); ++i) {
    if (!(lights.probability(i) > 0)) continue; // no photon starts here
    order.push_back(static_cast<uint32_t>(i));
    auto& [low, high] = boxes[i];
    low = Vec3f(INFINITE);
    high = Vec3f(-INFINITE);
    for (int k = 0; k < STARTS; ++k) {
      const float a = (static_cast<float>(k) + 0.5f) / STARTS, b = std::fmod(a + 0.5f, 1.0f);
      const std::optional<Emission> e = lights[i].emit({a, {a, k % 2 ? 0.25f : 0.75f}, {b, a}});
      if (!e) continue;
      low = glm::min(low, e->origin);
      high = glm::max(high, e->origin);
    }
    if (low.x > high.x) low = high = Vec3f(0);
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

void LightGuide::buildNode(std::span<const std::array<Vec3f, 2>> boxes, const LightTable& lights,
                           size_t first, size_t end, int depth) {
  Vec3f low(INFINITE), high(-INFINITE);
  double power = 0;
  for (size_t i = first; i < end; ++i) {
    low = glm::min(low, boxes[order[i]][0]);
    high = glm::max(high, boxes[order[i]][1]);
    power += double(lights.probability(order[i]));
  }
  if (depth == TABLE_DEPTH || (depth < TABLE_DEPTH && end - first == 1))
    clusters.push_back(
        {static_cast<uint32_t>(nodes.size()), static_cast<uint32_t>(first), static_cast<uint32_t>(end)});
  nodes.push_back({(low + high) / 2.0f, lengthSquared((high - low) / 2.0f), static_cast<float>(power)});
  if (end - first == 1) return;
  const int axis = widest(low, high);
  const auto place = [&](uint32_t light) { return boxes[light][0][axis] + boxes[light][1][axis]; };
  const size_t middle = first + (end - first) / 2;
  const auto at = [&](size_t i) { return order.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(first), at(middle), at(end), [&](uint32_t a, uint32_t b) {
    return place(a) != place(b) ? place(a) < place(b) : a < b;
  });
  buildNode(boxes, lights, first, middle, depth + 1);
  buildNode(boxes, lights, middle, end, depth + 1);
}

void LightGuide::buildCells(Arrivals arrivals, std::vector<Cell>& cells, std::vector<Arrivals>& leaves) {
  const size_t cell = cells.size();
  cells.emplace_back();
  if (arrivals.size() > CELL) {
    Vec3f low(INFINITE), high(-INFINITE);
    for (const Arrival& a : arrivals) {
      low = glm::min(low, a.position);
      high = glm::max(high, a.position);
    }
    const int axis = widest(low, high);
    const size_t half = arrivals.size() / 2;
    std::nth_element(arrivals.begin(), arrivals.begin() + static_cast<std::ptrdiff_t>(half), arrivals.end(),
                     [&](const Arrival& a, const Arrival& b) { return a.position[axis] < b.position[axis]; });
    const float at = arrivals[half].position[axis];
    if (at > low[axis]) { // else all are at the same place
      buildCells(arrivals.first(half), cells, leaves);
      cells[cell] = {static_cast<uint32_t>(axis), at, static_cast<uint32_t>(cells.size())};
      buildCells(arrivals.subspan(half), cells, leaves);
      return;
    }
  }
  leaves.push_back(arrivals);
  cells[cell].other = static_cast<uint32_t>(leaves.size()); // table 0 is not a cell's
}

void LightGuide::buildTable(Arrivals arrivals, float* table) const {
  Vec3f low(INFINITE), high(-INFINITE);
  for (const Arrival& a : arrivals) {
    low = glm::min(low, a.position);
    high = glm::max(high, a.position);
  }
  std::sort(arrivals.begin(), arrivals.end(),
            [](const Arrival& a, const Arrival& b) { return a.light < b.light; });
  double sum = 0;
  size_t count = 0;
  const auto visit = [&](const auto& self, Descent way, Arrivals photons, double probability) -> void {
    if (count < clusters.size() && way.where().node == clusters[count].node) {
      sum += (1 - EVEN_PART) * probability + EVEN_PART / double(clusters.size());
      table[count++] = static_cast<float>(sum);
      return;
    }
    const auto split = std::partition_point(photons.begin(), photons.end(),
                                            [&](const Arrival& a) { return a.light < way.middle(); });
    const auto onTheLeft = static_cast<size_t>(split - photons.begin());
    const double left = (double(onTheLeft) + PRIOR * way.left()) / (double(photons.size()) + PRIOR);
    Descent other = way;
    way.go(true);
    other.go(false);
    self(self, way, photons.first(onTheLeft), probability * left);
    self(self, other, photons.subspan(onTheLeft), probability * (1 - left));
  };
  visit(visit,
        Descent(*this, (low + high) / 2.0f, lengthSquared((high - low) / 2.0f),
                {0, 0, static_cast<uint32_t>(order.size())}),
        arrivals, 1);
}

void LightGuide::learn(const Scene& scene) {
  *this = {};
  const LightTable& lights = scene.lights();
  if (lights.size() < 2) return;
  buildTree(lights);
  if (!active()) return;
  // More than what a picture of so many pixels takes a small part of the time for is not worth it.
  constexpr size_t LEAST = 16384, MOST = 262144, BATCH = 2048;
  const size_t pixels = size_t(scene.film().width) * size_t(scene.film().height);
  const size_t batches = std::clamp(4 * pixels, LEAST, MOST) / BATCH;
  std::vector<std::array<std::vector<Arrival>, SIDES>> found(batches);
  parallelFor(batches, [&](size_t b) {
    TransportCounts counts;
    BsdfArena arena;
    for (size_t i = b * BATCH; i < (b + 1) * BATCH; ++i) {
      Sampler sampler(0, STREAM, static_cast<uint32_t>(i));
      float pick = sampler.next1D();
      const auto light = static_cast<uint32_t>(lights.chooseIndex(pick));
      const float part = sampler.next1D();
      const Vec2f place = sampler.next2D(), direction = sampler.next2D();
      if (!(lights.probability(light) > 0)) continue;
      const std::optional<Emission> emission = lights[light].emit({part, place, direction});
      if (!emission || isBlack(emission->flux)) continue;
      Ray ray{emission->origin, emission->direction, INFINITE};
      Nesting nesting = nestingAt(scene, ray, counts);
      Hit hit;
      while (intersect(scene, ray, hit, counts)) {
        arena.reset();
        if (!bsdfAt(scene, hit, ray.direction, Footprint(), nesting, arena)) {
          ray = spawn(hit.point, ray.direction);
          continue;
        }
        const Vec3f& normal = hit.point.geometricNormal;
        const Arrival arrival{hit.point.position, rank[light]};
        const bool outside = glm::dot(normal, ray.direction) < 0, both = hit.material->lobes() & TRANSMISSION;
        if (outside || both) found[b][sideOf(normal)].push_back(arrival);
        if (!outside || both) found[b][sideOf(-normal)].push_back(arrival);
        break;
      }
    }
  });
  std::array<std::vector<Arrival>, SIDES> all;
  std::vector<Arrivals> leaves;
  for (size_t side = 0; side < SIDES; ++side) {
    for (const auto& f : found) all[side].insert(all[side].end(), f[side].begin(), f[side].end());
    if (!all[side].empty()) buildCells(all[side], cells[side], leaves);
  }
  tables.resize((leaves.size() + 1) * clusters.size());
  parallelFor(leaves.size() + 1, [&](size_t i) {
    if (i > 0) return buildTable(leaves[i - 1], &tables[i * clusters.size()]);
    double sum = 0; // by power alone
    for (size_t c = 0; c < clusters.size(); ++c)
      tables[c] = static_cast<float>(sum += double(nodes[clusters[c].node].power));
  });
}

} // namespace recurse
