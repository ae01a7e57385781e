/** @file The photon map against FLANN: the same photons and the same queries, measured by turns in one run.
 *
 * Photons are on the surfaces of a Cornell box, 70% spread and 30% in one caustic spot, in random order of
 * emission. Queries are at the visible points of the pixels of a picture, line by line. A query sums power
 * times kernel over the photons found; all indices must agree on their number and on the sum. FLANN has no
 * overhead of an adapter: it reads positions in place, and a result set sums during the search. Queries run
 * on one thread, builds on two (FLANN's has one thread only).
 *
 * The last line is for programs: ratios are FLANN's time ÷ ours, the median over the rounds, with 1M photons
 * and 50 found on average. Builds allocate new memory, so their times include page faults. `--large` adds
 * 10M photons.
 */
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <random>
#include <vector>

#include <flann/algorithms/dist.h>
#include <flann/algorithms/kdtree_single_index.h>

#include "recurse/core/threads/parallel.h"
#include "transport/photonmap/kernel.h"
#include "transport/photonmap/photonMapQuery.h"

using namespace recurse;

namespace {

using FlannIndex = flann::KDTreeSingleIndex<flann::L2_3D<float>>;

double seconds() {
  using namespace std::chrono;
  return duration<double>(steady_clock::now().time_since_epoch()).count();
}

double median(std::vector<double> v) {
  std::nth_element(v.begin(), v.begin() + static_cast<ptrdiff_t>(v.size() / 2), v.end());
  return v[v.size() / 2];
}

// ------------------------------------------------------------------------------------------------- scene

/** A box of side 2 around the origin, open towards −z, with one block on its floor. */
constexpr float BLOCK_LOWER[] = {-0.6f, -1, -0.1f}, BLOCK_UPPER[] = {0, 0.1f, 0.5f};
const Vec3f SPOT(0.5f, -1, -0.3f);

class Random {
 public:
  explicit Random(uint64_t seed) : engine(seed) {}
  float uniform(float low, float high) {
    return low + (high - low) * static_cast<float>(engine() >> 40) * 0x1p-24f;
  }
  uint64_t bits() { return engine(); }

 private:
  std::mt19937_64 engine;
};

Vec3f pointOnFace(Random& random, const Vec3f& lower, const Vec3f& upper, int axis, bool top) {
  Vec3f p;
  for (int i = 0; i < 3; ++i) p[i] = random.uniform(lower[i], upper[i]);
  p[axis] = top ? upper[axis] : lower[axis];
  return p;
}

std::vector<Photon> makePhotons(size_t n) {
  Random random(n);
  std::vector<Photon> photons(n);
  for (Photon& photon : photons) {
    Vec3f normal(0);
    if (random.uniform(0, 1) < 0.3f) {
      const float phi = random.uniform(0, 2 * PI),
                  r = 0.15f * std::sqrt(-2 * std::log(random.uniform(1e-4f, 1)));
      photon.position = SPOT + Vec3f(r * std::cos(phi), 0, r * std::sin(phi));
      normal = Vec3f(0, 1, 0);
    } else if (random.uniform(0, 1) < 0.9f) {
      const uint64_t face = random.bits() % 5; // not −z
      const int axis = face == 4 ? 2 : static_cast<int>(face / 2);
      photon.position = pointOnFace(random, Vec3f(-1), Vec3f(1), axis, face % 2 || face == 4);
      normal[axis] = -photon.position[axis];
    } else {
      const uint64_t face = random.bits() % 6;
      const int axis = static_cast<int>(face / 2);
      photon.position = pointOnFace(random, Vec3f(BLOCK_LOWER[0], BLOCK_LOWER[1], BLOCK_LOWER[2]),
                                    Vec3f(BLOCK_UPPER[0], BLOCK_UPPER[1], BLOCK_UPPER[2]), axis, face % 2);
      normal[axis] = face % 2 ? 1.0f : -1.0f;
    }
    const Vec3f jitter(random.uniform(-0.5f, 0.5f), random.uniform(-0.5f, 0.5f), random.uniform(-0.5f, 0.5f));
    photon.direction = packDirection(glm::normalize(normal + jitter));
    photon.normal = packDirection(normal);
    photon.power = Rgb(random.uniform(0, 2), random.uniform(0, 2), random.uniform(0, 2));
  }
  return photons;
}

struct Query {
  Vec3f point, normal;
};

/** Visible points of the pixels of a square picture, line by line. */
std::vector<Query> makeQueries(int resolution) {
  std::vector<Query> queries;
  const Vec3f eye(0, 0, -3.8f);
  const Vec3f blockLower(BLOCK_LOWER[0], BLOCK_LOWER[1], BLOCK_LOWER[2]);
  const Vec3f blockUpper(BLOCK_UPPER[0], BLOCK_UPPER[1], BLOCK_UPPER[2]);
  for (int y = 0; y < resolution; ++y) {
    for (int x = 0; x < resolution; ++x) {
      const auto at = [&](int i) { return (static_cast<float>(i) + 0.5f) / static_cast<float>(resolution); };
      const Vec3f d((at(x) - 0.5f) * 0.7f, (0.5f - at(y)) * 0.7f, 1);
      float enter = 0, leave = INFINITE;
      int axis = 2, enterAxis = 2;
      for (int i = 0; i < 3; ++i) {
        if (d[i] == 0) continue;
        const float far = ((d[i] > 0 ? 1.0f : -1.0f) - eye[i]) / d[i];
        if (far < leave) {
          leave = far;
          axis = i;
        }
      }
      float blockLeave = INFINITE;
      for (int i = 0; i < 3; ++i) {
        const float a = (blockLower[i] - eye[i]) / d[i], b = (blockUpper[i] - eye[i]) / d[i];
        if (std::min(a, b) > enter) {
          enter = std::min(a, b);
          enterAxis = i;
        }
        blockLeave = std::min(blockLeave, std::max(a, b));
      }
      const bool block = enter < blockLeave;
      Query query{eye + d * (block ? enter : leave), Vec3f(0)};
      query.normal[block ? enterAxis : axis] = d[block ? enterAxis : axis] > 0 ? -1.0f : 1.0f;
      queries.push_back(query);
    }
  }
  return queries;
}

/** Photons sorted along a Morton curve, the best input order for FLANN. */
std::vector<Photon> mortonSorted(const std::vector<Photon>& photons) {
  const auto spread = [](float x) {
    uint64_t bits = static_cast<uint64_t>((std::clamp(x, -1.5f, 1.5f) + 1.5f) / 3 * 2097151.0f), code = 0;
    for (int i = 0; i < 21; ++i) code |= (bits >> i & 1) << 3 * i;
    return code;
  };
  std::vector<std::pair<uint64_t, uint32_t>> order;
  for (size_t i = 0; i < photons.size(); ++i) {
    const Vec3f& p = photons[i].position;
    order.emplace_back(spread(p.x) | spread(p.y) << 1 | spread(p.z) << 2, static_cast<uint32_t>(i));
  }
  std::sort(order.begin(), order.end());
  std::vector<Photon> sorted;
  for (const auto& [code, i] : order) sorted.push_back(photons[i]);
  return sorted;
}

// --------------------------------------------------------------------------------------------- estimates

/** Results of all queries of a round. */
struct Total {
  double sum = 0;
  uint64_t found = 0;
  void add(const Rgb& estimate, size_t count) {
    sum +=
        static_cast<double>(estimate.r) + static_cast<double>(estimate.g) + static_cast<double>(estimate.b);
    found += count;
  }
};

/** Power times kernel over blocks. */
struct Estimate {
  Float8 red{0}, green{0}, blue{0};
  size_t count = 0;
  void add(const PhotonBlock& block, float inverseRadius2) {
    const Float8 weight =
        block.found(kernelShape<Kernel::EPANECHNIKOV>(block.distance2 * Float8(inverseRadius2)));
    red += weight * block.red();
    green += weight * block.green();
    blue += weight * block.blue();
    count += static_cast<size_t>(std::popcount(block.mask));
  }
  Rgb rgb() const { return {sum(red), sum(green), sum(blue)}; }
};

Total gatherOurs(const PhotonMap& map, const std::vector<Query>& queries, float radius, bool rejecting) {
  Total total;
  const float inverseRadius2 = 1 / (radius * radius);
  GatherRegion region{Vec3f(0), Vec3f(0), radius, rejecting ? 0.3f : 1.0f, !rejecting};
  for (const Query& query : queries) {
    region.center = query.point;
    region.normal = query.normal;
    const Estimate estimate = map.accumulateWithin(
        region, Estimate(), [=](Estimate& e, const PhotonBlock& block) { e.add(block, inverseRadius2); });
    total.add(estimate.rgb(), estimate.count);
  }
  return total;
}

Total nearestOurs(const PhotonMap& map, const std::vector<Query>& queries, int k, bool rejecting) {
  Total total;
  PhotonScratch scratch;
  for (const Query& query : queries) {
    const GatherRegion region{query.point, query.normal, INFINITE, rejecting ? 0.3f : 1.0f, !rejecting};
    const NearestPhotons nearest = map.nearest(region, k, scratch);
    const float inverseRadius2 = 1 / nearest.radius2;
    const Estimate estimate = map.accumulateNearest(
        scratch, Estimate(), [=](Estimate& e, const PhotonBlock& block) { e.add(block, inverseRadius2); });
    total.add(estimate.rgb(), estimate.count);
  }
  return total;
}

/** Sums while FLANN searches. */
class SumResult final : public flann::ResultSet<float> {
 public:
  SumResult(const Photon* photons, float radius)
      : photons(photons), radius2(radius * radius), inverseRadius2(1 / radius2) {}
  bool full() const override { return true; }
  void addPoint(float distance2, size_t index) override {
    if (!(distance2 < radius2)) return;
    estimate += photons[index].power * kernelShape<Kernel::EPANECHNIKOV>(distance2 * inverseRadius2);
    ++count;
  }
  float worstDist() const override { return radius2 * 1.00001f; } // FLANN's box distances are rounded up
  Rgb estimate{0};
  size_t count = 0;

 private:
  const Photon* photons;
  float radius2, inverseRadius2;
};

struct Flann {
  const std::vector<Photon>& photons;
  FlannIndex index;

  explicit Flann(const std::vector<Photon>& photons)
      : photons(photons), index(flann::Matrix<float>(const_cast<float*>(&photons[0].position.x),
                                                     photons.size(), 3, sizeof(Photon)),
                                flann::KDTreeSingleIndexParams(16)) {
    index.buildIndex();
  }
  Total gather(const std::vector<Query>& queries, float radius) const {
    Total total;
    const flann::SearchParams parameters;
    for (const Query& query : queries) {
      SumResult result(photons.data(), radius);
      index.findNeighbors(result, &query.point.x, parameters);
      total.add(result.estimate, result.count);
    }
    return total;
  }
  template <class ResultSet> Total nearest(const std::vector<Query>& queries, int k) const {
    Total total;
    const auto wanted = static_cast<size_t>(k);
    const flann::SearchParams parameters;
    std::vector<size_t> indices(wanted);
    std::vector<float> distance2(wanted);
    ResultSet result(wanted);
    for (const Query& query : queries) {
      result.clear();
      index.findNeighbors(result, &query.point.x, parameters);
      result.copy(indices.data(), distance2.data(), wanted, false);
      const float inverseRadius2 = 1 / *std::max_element(distance2.begin(), distance2.end());
      Rgb estimate(0);
      for (size_t i = 0; i < wanted; ++i)
        estimate +=
            photons[indices[i]].power * kernelShape<Kernel::EPANECHNIKOV>(distance2[i] * inverseRadius2);
      total.add(estimate, wanted);
    }
    return total;
  }
};

/** A binary heap: faster than FLANN's own result sets, which sort as they insert. */
class HeapResult final : public flann::ResultSet<float> {
 public:
  explicit HeapResult(size_t k) : most(k) { heap.reserve(k); }
  void clear() {
    heap.clear();
    worst = INFINITE;
  }
  bool full() const override { return heap.size() == most; }
  void addPoint(float distance2, size_t index) override {
    if (heap.size() == most) {
      if (!(distance2 < worst)) return; // FLANN asks for it once a leaf only
      std::pop_heap(heap.begin(), heap.end());
      heap.pop_back();
    }
    heap.emplace_back(distance2, static_cast<uint32_t>(index));
    std::push_heap(heap.begin(), heap.end());
    if (heap.size() == most) worst = heap.front().first;
  }
  float worstDist() const override { return worst; }
  void copy(size_t* indices, float* distance2, size_t, bool) const {
    for (size_t i = 0; i < heap.size(); ++i) {
      distance2[i] = heap[i].first;
      indices[i] = heap[i].second;
    }
  }

 private:
  size_t most;
  float worst = INFINITE;
  std::vector<std::pair<float, uint32_t>> heap;
};

/** Radius with which the queries find `mean` photons on average. */
float radiusFor(const PhotonMap& map, const std::vector<Query>& queries, double mean) {
  std::vector<Query> some;
  for (size_t i = 0; i < queries.size(); i += 37) some.push_back(queries[i]);
  float low = 1e-5f, high = 1;
  for (int i = 0; i < 30; ++i) {
    const float middle = std::sqrt(low * high);
    const Total total = gatherOurs(map, some, middle, false);
    (static_cast<double>(total.found) < mean * static_cast<double>(some.size()) ? low : high) = middle;
  }
  return high;
}

bool allEqual = true;

void checkEqual(const char* what, const Total& a, const Total& b) {
  if (a.found == b.found && std::abs(a.sum - b.sum) <= 1e-5 * std::abs(a.sum)) return;
  allEqual = false;
  std::printf("!! %s differ: found %llu and %llu, sums %.9g and %.9g\n", what,
              static_cast<unsigned long long>(a.found), static_cast<unsigned long long>(b.found), a.sum,
              b.sum);
}

/** Runs all by turns; returns the times of each, one for each round. */
std::vector<std::vector<double>> byTurns(int rounds, const std::vector<std::function<void()>>& runs) {
  std::vector<std::vector<double>> times(runs.size());
  for (int round = 0; round < rounds; ++round) {
    for (size_t i = 0; i < runs.size(); ++i) {
      const double start = seconds();
      runs[i]();
      times[i].push_back(seconds() - start);
    }
  }
  return times;
}

double medianRatio(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> ratios;
  for (size_t i = 0; i < a.size(); ++i) ratios.push_back(a[i] / b[i]);
  return median(ratios);
}

struct Ratios {
  double gather = 0, gatherMorton = 0, nearest = 0, build = 0, bytes = 0;
};

Ratios measure(size_t n, int rounds, int resolution) {
  Ratios ratios;
  const std::vector<Photon> photons = makePhotons(n);
  const std::vector<Photon> sorted = mortonSorted(photons);
  const std::vector<Query> queries = makeQueries(resolution);
  const double perQuery = 1e9 / static_cast<double>(queries.size());

  PhotonMap map;
  {
    ThreadPool two(2);
    std::unique_ptr<Flann> flann;
    std::unique_ptr<PhotonMap> fresh;
    const auto times =
        byTurns(rounds, {[&] { fresh = std::make_unique<PhotonMap>(), fresh->build(photons); },
                         [&] { flann = std::make_unique<Flann>(photons); }, [&] { map.build(photons); }});
    ratios.build = medianRatio(times[1], times[0]);
    ratios.bytes = static_cast<double>(map.memoryBytes()) / static_cast<double>(n);
    std::printf("%zu photons: build %.1f ms, again into the same buffers %.1f ms; FLANN %.1f ms (%.1fx); "
                "%.1f bytes a photon\n",
                n, 1e3 * median(times[0]), 1e3 * median(times[2]), 1e3 * median(times[1]), ratios.build,
                ratios.bytes);
  }
  ThreadPool one(1);
  {
    const auto times = byTurns(std::min(rounds, 3), {[&] { map.build(photons); }});
    std::printf("  build on one thread, same buffers: %.1f ms\n", 1e3 * median(times[0]));
  }
  const Flann flann(photons), morton(sorted);
  std::printf("  %-10s %8s %9s %9s %9s | %7s %7s | %s\n", "ns a query", "found", "ours", "FLANN", "Morton",
              "ratio", "ratio", "ours, flattened and one-sided");
  for (const int mean : {10, 50, 200}) {
    const float radius = radiusFor(map, queries, mean);
    Total ours, theirs, theirsSorted, rejecting;
    const auto times =
        byTurns(mean == 50 ? rounds : 3, {[&] { ours = gatherOurs(map, queries, radius, false); },
                                          [&] { theirs = flann.gather(queries, radius); },
                                          [&] { theirsSorted = morton.gather(queries, radius); },
                                          [&] { rejecting = gatherOurs(map, queries, radius, true); }});
    checkEqual("gather", ours, theirs);
    checkEqual("gather in Morton order", ours, theirsSorted);
    const double ratio = medianRatio(times[1], times[0]), ratioSorted = medianRatio(times[2], times[0]);
    std::printf("  radius     %8.1f %9.1f %9.1f %9.1f | %6.2fx %6.2fx | %.1f\n",
                static_cast<double>(ours.found) / static_cast<double>(queries.size()),
                perQuery * median(times[0]), perQuery * median(times[1]), perQuery * median(times[2]), ratio,
                ratioSorted, perQuery * median(times[3]));
    if (mean == 50) {
      ratios.gather = ratio;
      ratios.gatherMorton = ratioSorted;
    }
  }
  for (const int k : {10, 50, 200}) {
    Total ours, simple, heap, heapSorted, rejecting;
    const auto times = byTurns(k == 50 ? rounds : 3,
                               {[&] { ours = nearestOurs(map, queries, k, false); },
                                [&] { simple = flann.nearest<flann::KNNSimpleResultSet<float>>(queries, k); },
                                [&] { heap = flann.nearest<HeapResult>(queries, k); },
                                [&] { heapSorted = morton.nearest<HeapResult>(queries, k); },
                                [&] { rejecting = nearestOurs(map, queries, k, true); }});
    checkEqual("nearest", ours, simple);
    checkEqual("nearest by heap", ours, heap);
    checkEqual("nearest in Morton order", ours, heapSorted);
    const double bestFlann = std::min(medianRatio(times[1], times[0]), medianRatio(times[2], times[0]));
    std::printf("  nearest    %8d %9.1f %9.1f %9.1f | %6.2fx %6.2fx | %.1f\n", k, perQuery * median(times[0]),
                perQuery * std::min(median(times[1]), median(times[2])), perQuery * median(times[3]),
                bestFlann, medianRatio(times[3], times[0]), perQuery * median(times[4]));
    if (k == 50) ratios.nearest = bestFlann;
  }
  std::fflush(stdout);
  return ratios;
}

} // namespace

int main(int argc, char** argv) {
  bool large = false;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--large") == 0) {
      large = true;
    } else {
      std::fprintf(stderr, "usage: %s [--large]\n", argv[0]);
      return 2;
    }
  }
  setThreadFloatMode();
  measure(100000, 3, 512);
  const Ratios ratios = measure(1000000, 5, 512);
  if (large) measure(10000000, 3, 512);
  if (!allEqual) return 1;
  std::printf("photon_map: gather_vs_flann=%.2f gather_vs_flann_morton=%.2f knn_vs_flann=%.2f "
              "build_vs_flann=%.2f bytes_per_photon=%.1f\n",
              ratios.gather, ratios.gatherMorton, ratios.nearest, ratios.build, ratios.bytes);
  return 0;
}
