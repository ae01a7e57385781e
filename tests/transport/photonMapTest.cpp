/** @file
 * The photon map finds exactly the photons of an exhaustive search, with every index; and its behaviour with
 * unusual input.
 */
#include "kernelTesting.h"
#include "transport/photonmap/photonMapQuery.h"

#include <algorithm>
#include <functional>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "recurse/core/threads/parallel.h"
#include "transport/photonmap/kernel.h"

using namespace recurse;

namespace {

using Random = std::mt19937;

float uniform(Random& random, float low, float high) {
  return low + (high - low) * static_cast<float>(random() >> 8) * 0x1p-24f;
}

Vec3f uniformPoint(Random& random, float low, float high) {
  const float x = uniform(random, low, high), y = uniform(random, low, high);
  return {x, y, uniform(random, low, high)};
}

Vec3f uniformDirection(Random& random) {
  for (;;) {
    const Vec3f v = uniformPoint(random, -1, 1);
    const float length2 = lengthSquared(v);
    if (length2 > 0.01f && length2 < 1) return v / std::sqrt(length2);
  }
}

struct Distribution {
  const char* name;
  std::function<Vec3f(Random&, size_t)> position;
};

const std::vector<Distribution> DISTRIBUTIONS = {
    {"random", [](Random& r, size_t) { return uniformPoint(r, -1, 1); }},
    {"plane", [](Random& r, size_t) { return uniformPoint(r, -1, 1) * Vec3f(1, 1, 0); }},
    {"clustered",
     [](Random& r, size_t) {
       const Vec3f p = uniformPoint(r, -1, 1);
       return r() % 2 ? p : Vec3f(0.3f, -0.2f, 0.1f) + p * 1e-3f;
     }},
    {"collinear", [](Random& r, size_t) { return Vec3f(0.5f, -0.3f, 0.7f) * uniform(r, -1, 1); }},
    {"coincident", [](Random&, size_t) { return Vec3f(0.25f, 0.5f, -0.75f); }},
    {"lattice", [](Random& r, size_t) {
       const auto axis = [&] { return static_cast<float>(r() % 9) * 0.25f - 1; };
       const float x = axis(), y = axis();
       return Vec3f(x, y, axis());
     }}};

const size_t SIZES[] = {0, 1, 2, 31, 32, 33, 255, 256, 257, 1000, 10000};

std::vector<Photon> makePhotons(const Distribution& distribution, size_t n) {
  Random random(static_cast<uint32_t>(n) + 7);
  std::vector<Photon> photons(n);
  for (size_t i = 0; i < n; ++i) {
    photons[i].position = distribution.position(random, i);
    photons[i].direction = packDirection(uniformDirection(random));
    photons[i].normal = packDirection(uniformDirection(random));
    photons[i].power = Rgb(uniformPoint(random, 0, 1));
    photons[i].pathState = static_cast<uint8_t>(random() % 200);
  }
  return photons;
}

/** Photon, identified by its index of emission. */
struct Found {
  float distance2;
  uint32_t index;
  bool operator==(const Found&) const = default;
  bool operator<(const Found& o) const {
    return distance2 < o.distance2 || (distance2 == o.distance2 && index < o.index);
  }
};
using FoundList = std::vector<Found>;

/** Exhaustive search by the definition in the header. */
FoundList bruteForce(const std::vector<Photon>& photons, const GatherRegion& region) {
  FoundList found;
  const Vec3f& n = region.normal;
  const float w = region.flatness < 1 ? 1 / (region.flatness * region.flatness) - 1 : 0;
  for (size_t i = 0; i < photons.size(); ++i) {
    const Vec3f v = photons[i].position - region.center;
    float d2 = v.x * v.x + v.y * v.y + v.z * v.z;
    if (region.flatness < 1) {
      const float h = v.x * n.x + v.y * n.y + v.z * n.z;
      d2 = d2 + w * (h * h);
    }
    if (!(d2 < region.radius * region.radius)) continue;
    if (!region.bothSides && !(glm::dot(unpackDirection(photons[i].normal), n) > 0.5f)) continue;
    bool clipped = false;
    for (size_t c = 0; c < region.clipCount; ++c) {
      const Vec3f& m = region.clips[c].normal;
      clipped = clipped || !(v.x * m.x + v.y * m.y + v.z * m.z > region.clips[c].limit);
    }
    if (clipped) continue;
    found.push_back({d2, static_cast<uint32_t>(i)});
  }
  std::sort(found.begin(), found.end());
  return found;
}

void collect(const PhotonMap& map, const PhotonBlock& block, FoundList& found) {
  ASSERT_NE(block.mask, 0u);
  ASSERT_EQ(block.first % 8, 0u);
  for (int lane = 0; lane < 8; ++lane) {
    if (!(block.mask >> lane & 1)) continue;
    const size_t slot = block.first + static_cast<size_t>(lane);
    ASSERT_LT(slot, map.size());
    ASSERT_EQ(block.power(lane), map.power(slot));
    found.push_back({block.distance2[lane], map.emissionIndex(slot)});
  }
}

FoundList within(const PhotonMap& map, const GatherRegion& region) {
  FoundList found;
  map.visitWithin(region, [&](const PhotonBlock& block) { collect(map, block, found); });
  std::sort(found.begin(), found.end());
  return found;
}

FoundList nearest(const PhotonMap& map, const GatherRegion& region, int k, PhotonScratch& scratch) {
  const NearestPhotons result = map.nearest(region, k, scratch);
  FoundList found;
  map.visitNearest(scratch, [&](const PhotonBlock& block) { collect(map, block, found); });
  std::sort(found.begin(), found.end());
  EXPECT_EQ(result.count, static_cast<int>(found.size()));
  EXPECT_EQ(result.radius2, found.empty() ? 0.0f : found.back().distance2);
  return found;
}

std::vector<GatherRegion> makeRegions(const std::vector<Photon>& photons, size_t n) {
  Random random(99);
  std::vector<GatherRegion> regions;
  for (size_t i = 0; i < n; ++i) {
    GatherRegion region;
    region.center = uniformPoint(random, -1.2f, 1.2f);
    // Queries at photons and beside them: ties, and dense regions.
    if (!photons.empty() && i % 4 != 0) {
      region.center = photons[random() % photons.size()].position;
      if (i % 4 == 2) region.center += uniformPoint(random, -1e-3f, 1e-3f);
    }
    region.normal = i % 3 ? uniformDirection(random) : Vec3f(0, 0, 1);
    region.radius = std::exp(uniform(random, std::log(1e-3f), std::log(3.0f)));
    if (i % 5 == 0) region.radius = 0.25f; // radius equal to the lattice spacing: photons on the border
    region.flatness = i % 2 ? 1 : uniform(random, 0.01f, 1.5f);
    region.bothSides = (i / 2) % 2;
    for (size_t clips = i % 7 == 3 ? 1 + i % GatherRegion::MAX_CLIPS : 0; region.clipCount < clips;)
      region.clips[region.clipCount++] = {uniformDirection(random),
                                          uniform(random, -1, 0.1f) * region.radius};
    regions.push_back(region);
  }
  return regions;
}

class PhotonSets : public ::testing::TestWithParam<std::tuple<size_t, size_t>> {
 protected:
  PhotonSets() {
    const Distribution& distribution = DISTRIBUTIONS[std::get<0>(GetParam())];
    photons = makePhotons(distribution, SIZES[std::get<1>(GetParam())]);
    tree.build(photons);
    flann.build(photons, PhotonIndexKind::FLANN);
    regions = makeRegions(photons, photons.size() > 5000 ? 100 : 200);
  }
  std::vector<Photon> photons;
  PhotonMap tree, flann;
  std::vector<GatherRegion> regions;
};

TEST_P(PhotonSets, keepsEveryPhoton) {
  for (const PhotonMap* map : {&tree, &flann}) {
    ASSERT_EQ(map->size(), photons.size());
    EXPECT_EQ(map->refused(), 0u);
    std::set<uint32_t> seen;
    for (size_t slot = 0; slot < map->size(); ++slot) {
      const uint32_t index = map->emissionIndex(slot);
      ASSERT_LT(index, photons.size());
      seen.insert(index);
      ASSERT_EQ(map->position(slot), photons[index].position);
      ASSERT_EQ(map->power(slot), photons[index].power);
      ASSERT_EQ(map->packedDirection(slot).bits, photons[index].direction.bits);
      ASSERT_EQ(map->packedNormal(slot).bits, photons[index].normal.bits);
      ASSERT_EQ(map->pathState(slot), photons[index].pathState);
      ASSERT_TRUE(map->bounds().contains(map->position(slot)));
    }
    EXPECT_EQ(seen.size(), photons.size());
    EXPECT_EQ(map->bounds().empty(), photons.empty());
  }
}

TEST_P(PhotonSets, withinEqualsBruteForce) {
  for (const GatherRegion& region : regions) {
    const FoundList expected = bruteForce(photons, region);
    ASSERT_EQ(within(tree, region), expected);
    ASSERT_EQ(within(flann, region), expected);
  }
}

TEST_P(PhotonSets, nearestEqualsBruteForce) {
  PhotonScratch scratch;
  for (size_t i = 0; i < regions.size(); ++i) {
    GatherRegion region = regions[i];
    if (i % 3 == 0) region.radius = INFINITE;
    const FoundList all = bruteForce(photons, region);
    for (const int k : {1, 7, 50, 300}) {
      const auto count = static_cast<ptrdiff_t>(std::min(all.size(), static_cast<size_t>(k)));
      const FoundList expected(all.begin(), all.begin() + count);
      ASSERT_EQ(nearest(tree, region, k, scratch), expected);
      ASSERT_EQ(nearest(tree, region, k, scratch), expected) << "starting from its own result";
      ASSERT_EQ(nearest(flann, region, k, scratch), expected);
      PhotonScratch fresh;
      ASSERT_EQ(nearest(tree, region, k, fresh), expected) << "with nothing to start from";
    }
  }
}

TEST_P(PhotonSets, nearestSlotEqualsBruteForce) {
  if (photons.empty()) return;
  Random random(5);
  for (const GatherRegion& r : regions) {
    GatherRegion region;
    region.center = r.center;
    region.bothSides = true;
    for (int step = 0; step < 3; ++step, region.center += uniformPoint(random, -1e-3f, 1e-3f)) {
      const float expected = bruteForce(photons, region).front().distance2;
      const auto distance2 = [&](const PhotonMap& map, size_t slot) {
        return bruteForce({photons[map.emissionIndex(slot)]}, region).front().distance2;
      };
      const size_t slot = tree.nearestSlot(region.center);
      ASSERT_EQ(distance2(tree, slot), expected);
      ASSERT_EQ(distance2(flann, flann.nearestSlot(region.center)), expected);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, PhotonSets,
                         ::testing::Combine(::testing::Range<size_t>(0, 6),
                                            ::testing::Range<size_t>(0, std::size(SIZES))),
                         [](const auto& info) {
                           return DISTRIBUTIONS[std::get<0>(info.param)].name + std::string("_") +
                                  std::to_string(SIZES[std::get<1>(info.param)]);
                         });

TEST(PhotonMap, nearestInOrderOfCoherentQueries) {
  // A reused scratch must not change the photons found, nor the order of the visit.
  const std::vector<Photon> photons = makePhotons(DISTRIBUTIONS[2], 20000);
  PhotonMap map;
  map.build(photons);
  PhotonScratch carried;
  Random random(3);
  GatherRegion region;
  for (int i = 0; i < 300; ++i) {
    region.center = i % 50 == 0 ? uniformPoint(random, -1, 1) : region.center + Vec3f(2e-3f, 1e-3f, 0);
    region.normal = uniformDirection(random);
    region.flatness = i % 3 == 0 ? 0.2f : 1.0f;
    region.bothSides = i % 2;
    const int k = i % 100 < 70 ? 40 : 90;
    const NearestPhotons result = map.nearest(region, k, carried);
    PhotonScratch fresh;
    ASSERT_EQ(map.nearest(region, k, fresh).radius2, result.radius2);
    std::vector<uint32_t> a, b;
    map.visitNearest(carried, [&](const PhotonBlock& block) {
      a.insert(a.end(), {block.first, block.mask});
    });
    map.visitNearest(fresh, [&](const PhotonBlock& block) { b.insert(b.end(), {block.first, block.mask}); });
    ASSERT_EQ(a, b);
    for (size_t j = 2; j < a.size(); j += 2) ASSERT_LT(a[j - 2], a[j]);
  }
}

TEST(PhotonMap, nearestSurvivesFlushToZero) {
  ThreadPool pool(1); // sets the floating-point mode
  const std::vector<Photon> photons = makePhotons(DISTRIBUTIONS[4], 1000);
  PhotonMap map;
  map.build(photons);
  GatherRegion region;
  region.center = photons[0].position;
  region.bothSides = true;
  PhotonScratch scratch;
  for (int repeat = 0; repeat < 3; ++repeat) {
    const FoundList found = nearest(map, region, 10, scratch);
    ASSERT_EQ(found.size(), 10u);
    for (uint32_t i = 0; i < 10; ++i) EXPECT_EQ(found[i], (Found{0.0f, i}));
  }
}

TEST(PhotonMap, refusesAndCountsNonFinitePhotons) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<Photon> photons = makePhotons(DISTRIBUTIONS[0], 1000);
  photons[0].position.x = nan;
  photons[10].position.y = INFINITE;
  photons[500].power.g = nan;
  photons[999].power.b = -INFINITE;
  std::vector<Photon> finite;
  for (const Photon& p : photons)
    if (isFinite(p.position) && isFinite(p.power)) finite.push_back(p);
  for (const PhotonIndexKind kind : {PhotonIndexKind::KDTREE, PhotonIndexKind::FLANN}) {
    PhotonMap map;
    map.build(photons, kind);
    EXPECT_EQ(map.refused(), 4u);
    EXPECT_EQ(map.size(), 996u);
    size_t count = 0;
    map.visitWithin({Vec3f(0), Vec3f(0, 0, 1), INFINITE, 1, true}, [&](const PhotonBlock& block) {
      count += static_cast<size_t>(std::popcount(block.mask));
    });
    EXPECT_EQ(count, 996u);
    for (size_t slot = 0; slot < map.size(); ++slot)
      EXPECT_EQ(map.position(slot), photons[map.emissionIndex(slot)].position);
    // Only photons that are not finite.
    map.build(std::vector<Photon>(40, photons[0]), kind);
    EXPECT_EQ(map.refused(), 40u);
    EXPECT_TRUE(map.empty());
    PhotonScratch scratch;
    EXPECT_EQ(map.nearest({}, 5, scratch).count, 0);
  }
}

TEST(PhotonMap, photonsOfTheFarSideNeverCount) {
  // A thin wall with many photons from below and few from above.
  Random random(5);
  std::vector<Photon> photons;
  for (int i = 0; i < 5000; ++i) {
    Photon p;
    const bool above = i % 20 == 0;
    p.position = Vec3f(uniform(random, -1, 1), uniform(random, -1, 1), above ? 1e-4f : -1e-4f);
    p.direction = packDirection(Vec3f(0.3f, 0.1f, above ? 0.9f : -0.9f) / std::sqrt(0.91f));
    p.normal = packDirection({0, 0, above ? 1.0f : -1.0f});
    p.power = above ? Rgb(1, 0, 0) : Rgb(0, 1, 0);
    photons.push_back(p);
  }
  PhotonScratch scratch;
  for (const PhotonIndexKind kind : {PhotonIndexKind::KDTREE, PhotonIndexKind::FLANN}) {
    PhotonMap map;
    map.build(photons, kind);
    const GatherRegion region{Vec3f(0, 0, 1e-4f), Vec3f(0, 0, 1), 1, 0.1f, false};
    const NearestPhotons result = map.nearest(region, 50, scratch);
    EXPECT_EQ(result.count, 50);
    map.visitNearest(scratch, [&](const PhotonBlock& block) {
      EXPECT_EQ(sum(block.found(block.green())), 0);
      EXPECT_EQ(sum(block.found(block.red())), static_cast<float>(std::popcount(block.mask)));
    });
    // Density: 62.5 photons from above per unit of area.
    EXPECT_NEAR(50 / (PI * result.radius2), 62.5f, 30.0f);
  }
}

TEST(PhotonMap, theSameTreeFromAnyNumberOfThreads) {
  const std::vector<Photon> photons = makePhotons(DISTRIBUTIONS[2], 100000);
  PhotonMap one, two;
  {
    ThreadPool pool(1);
    one.build(photons);
  }
  {
    ThreadPool pool(2);
    two.build(photons);
    two.build(photons);
  }
  ASSERT_EQ(one.size(), two.size());
  for (size_t slot = 0; slot < one.size(); ++slot)
    ASSERT_EQ(one.emissionIndex(slot), two.emissionIndex(slot));
}

TEST(PhotonMap, rebuildsAndMoves) {
  PhotonMap map;
  PhotonScratch scratch;
  for (const size_t n : {1000, 10, 0, 5000, 300}) {
    for (const PhotonIndexKind kind : {PhotonIndexKind::KDTREE, PhotonIndexKind::FLANN}) {
      const std::vector<Photon> photons = makePhotons(DISTRIBUTIONS[0], n);
      map.build(photons, kind);
      const GatherRegion region{Vec3f(0.1f), Vec3f(0, 0, 1), 0.8f, 0.5f, false};
      const FoundList expected = bruteForce(photons, region);
      EXPECT_EQ(within(map, region), expected);
      PhotonMap other = std::move(map);
      EXPECT_EQ(within(other, region), expected);
      EXPECT_EQ(nearest(other, region, 100000, scratch), expected);
      map = PhotonMap();
      map.build(photons, kind);
      EXPECT_EQ(within(map, region), expected);
      map = std::move(other);
    }
  }
}

TEST(PhotonMap, aMillionPhotonsTakeAtMostFortyBytesEach) {
  const std::vector<Photon> photons = makePhotons(DISTRIBUTIONS[1], 1000000);
  PhotonMap map;
  map.build(photons);
  EXPECT_LE(static_cast<double>(map.memoryBytes()), 40e6);
  EXPECT_GE(static_cast<double>(map.memoryBytes()),
            29e6); // lower bound, in case memoryBytes() counts too little
  const size_t before = map.memoryBytes();
  map.build(photons);
  EXPECT_EQ(map.memoryBytes(), before);
  // Flux is conserved.
  Rgbd given(0), kept(0);
  for (const Photon& p : photons) given += Rgbd(p.power);
  map.visitWithin({Vec3f(0), Vec3f(0, 0, 1), INFINITE, 1, true}, [&](const PhotonBlock& block) {
    kept +=
        Rgbd(sum(block.found(block.red())), sum(block.found(block.green())), sum(block.found(block.blue())));
  });
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(kept[c] / given[c], 1, 1e-6);
}

TEST(PhotonBlock, unpacksDirectionsLikeScalarCode) {
  Random random(11);
  for (int i = 0; i < 10000; ++i) {
    alignas(32) uint32_t packed[8];
    for (uint32_t& p : packed)
      p = i % 2 ? packDirection(uniformDirection(random)).bits : random() & 0xfffefffe;
    const Vec3f8 d = unpackDirections(packed);
    for (int lane = 0; lane < 8; ++lane)
      ASSERT_EQ(Vec3f(d.x[lane], d.y[lane], d.z[lane]), unpackDirection({packed[lane]}));
  }
}

TEST(Kernel, integratesToOneOverTheDisc) {
  for (const Kernel kernel : ALL_KERNELS) {
    for (const double r : {0.01, 1.0, 300.0}) {
      double integral = 0;
      constexpr int STEPS = 20000;
      for (int i = 0; i < STEPS; ++i) {
        const double d = (i + 0.5) / STEPS * r;
        integral += kernelValue(kernel, static_cast<float>(d * d), static_cast<float>(r * r)) * 2 * M_PI * d *
                    r / STEPS;
      }
      EXPECT_NEAR(integral, 1, 1e-5) << kernelName(kernel);
      EXPECT_EQ(kernelValue(kernel, static_cast<float>(1.01 * r * r), static_cast<float>(r * r)), 0);
    }
    // Values in batches of eight are the same.
    withKernel(kernel, [](auto k) {
      for (const float q : {0.0f, 0.3f, 1.0f})
        EXPECT_EQ(kernelShape<k.value>(Float8(q))[3], kernelShape<k.value>(q));
    });
  }
}

TEST(Kernel, uniformFieldIsEstimatedWithoutBias) {
  // 400000 photons of unit power on a square of side 2: 100000 W per unit of area.
  Random random(1);
  std::vector<Photon> photons(400000);
  for (Photon& p : photons) {
    p.position = uniformPoint(random, -1, 1) * Vec3f(1, 1, 0);
    p.direction = p.normal = packDirection(Vec3f(0, 0, 1));
    p.power = Rgb(1);
  }
  PhotonMap map;
  map.build(photons);
  for (const Kernel kernel : ALL_KERNELS) {
    withKernel(kernel, [&](auto k) {
      double total = 0;
      constexpr int QUERIES = 2000;
      Random place(2);
      for (int i = 0; i < QUERIES; ++i) {
        const GatherRegion region{uniformPoint(place, -0.9f, 0.9f) * Vec3f(1, 1, 0), Vec3f(0, 0, 1), 0.05f,
                                  0.1f, false};
        const Float8 scale(1 / square(region.radius));
        Float8 estimate(0);
        map.visitWithin(region, [&](const PhotonBlock& block) {
          estimate += block.found(block.red() * kernelShape<k.value>(block.distance2 * scale));
        });
        total += sum(estimate) * INV_PI * scale[0];
      }
      EXPECT_NEAR(total / QUERIES, 1e5, 500) << kernelName(kernel);
    });
  }
}

/** Box of the tree with its range of slots. */
struct TreeBox {
  int level;
  Bounds3f box;
  size_t first, last;
};

/** Boxes of a map in the order of the visit, with their slots: children follow their box in the order of
 * slots. */
std::vector<TreeBox> boxesOf(const PhotonMap& map, int levels) {
  std::vector<TreeBox> all;
  std::vector<size_t> next(size_t(levels), 0); // first slot of the next box at each level
  map.visitBoxes(levels, [&](int level, const Bounds3f& box, size_t photons) {
    const size_t first = next[size_t(level)];
    for (size_t below = size_t(level); below < next.size(); ++below) next[below] = first;
    all.push_back({level, box, first, first + photons});
    next[size_t(level)] = first + photons;
  });
  return all;
}

TEST(PhotonMap, BoxesOfTheTreeAreTightAndSplitAlongTheirWidestAxis) {
  for (const Distribution& distribution : DISTRIBUTIONS)
    for (const size_t n : {1u, 33u, 500u, 20000u}) {
      SCOPED_TRACE(std::string(distribution.name) + " " + std::to_string(n));
      PhotonMap map;
      map.build(makePhotons(distribution, n));
      const std::vector<TreeBox> all = boxesOf(map, 12);
      ASSERT_FALSE(all.empty());
      EXPECT_EQ(all[0].last, n);
      for (size_t i = 0; i < all.size(); ++i) {
        const TreeBox& b = all[i];
        Bounds3f tight;
        for (size_t slot = b.first; slot < b.last; ++slot) tight.add(map.position(slot));
        EXPECT_EQ(tight.lower, b.box.lower);
        EXPECT_EQ(tight.upper, b.box.upper);
        if (i + 1 == all.size() || all[i + 1].level <= b.level) { // a leaf, or the last level
          EXPECT_TRUE(b.level == 11 || b.last - b.first <= 32);
          continue;
        }
        const TreeBox& left = all[i + 1];
        const auto right = std::find_if(all.begin() + std::ptrdiff_t(i) + 2, all.end(),
                                        [&](const TreeBox& o) { return o.level == b.level + 1; });
        ASSERT_NE(right, all.end());
        EXPECT_EQ(left.first, b.first);
        EXPECT_EQ(left.last, right->first);
        EXPECT_EQ(right->last, b.last);
        const int axis = widestAxis(b.box.diagonal());
        EXPECT_LE(left.box.upper[axis], right->box.lower[axis]);
      }
    }
}

TEST(PhotonMap, BoxesNeedATreeAndALevel) {
  PhotonMap map;
  const auto count = [&](int levels) {
    size_t boxes = 0;
    map.visitBoxes(levels, [&](int, const Bounds3f&, size_t) { ++boxes; });
    return boxes;
  };
  EXPECT_EQ(count(5), 0u);
  map.build(makePhotons(DISTRIBUTIONS[0], 1000));
  EXPECT_EQ(count(0), 0u);
  EXPECT_EQ(count(1), 1u);
  EXPECT_EQ(count(3), 7u);
  map.build(makePhotons(DISTRIBUTIONS[0], 1000), PhotonIndexKind::FLANN);
  EXPECT_EQ(count(5), 0u);
}

} // namespace
