/** @file
 * Every registered material, made from its own examples: sampling against density, energy, reciprocity, and
 * the forward pass against the backward pass. New materials are covered without a change of this file.
 */
#include <array>
#include <cstdlib>

#include "model/bsdfTesting.h"
#include "recurse/core/sampling/sampling.h"
#include "recurse/core/threads/parallel.h"
#include "sanitized.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Direction as hemisphere, 1 - |z| and azimuth: equal areas are equal solid angles. */
struct MapPoint {
  int side = 0;
  Vec2d p{0};
};

/** Map of directions whose azimuth starts near the plane of incidence, where most lobes are. */
class Map {
 public:
  explicit Map(const Vec3f& wi) : azimuth(std::atan2(double(wi.y), double(wi.x)) + M_PI + 0.3) {}
  MapPoint point(const Vec3f& w) const {
    const double z = std::abs(double(w.z)), phi = std::atan2(double(w.y), double(w.x)) - azimuth;
    // Different from 1 - z, to keep the digits near the pole.
    return {w.z < 0 ? 1 : 0,
            {(square(double(w.x)) + square(double(w.y))) / (1 + z), std::remainder(phi, 2 * M_PI)}};
  }
  Vec3f direction(int side, const Vec2d& p) const {
    const double r = std::sqrt(p.x * (2 - p.x)), phi = p.y + azimuth;
    return Vec3f(Vec3d(r * std::cos(phi), r * std::sin(phi), (1 - p.x) * (side ? -1 : 1)));
  }

 private:
  double azimuth;
};

/** Cells of a hemisphere with about the same number of samples each. */
class CellTree {
 public:
  struct Cell {
    int side = 0;
    Vec2d low{0, -M_PI}, high{1, M_PI};
    Vec2d first{1e9}, last{-1e9}; ///< range of the densest samples
    double found = 0;
  };

  CellTree(std::vector<MapPoint> samples, size_t most) {
    for (int side = 0; side < 2; ++side) {
      const auto middle =
          std::partition(samples.begin(), samples.end(), [&](const MapPoint& s) { return s.side == side; });
      Cell whole;
      whole.side = side;
      roots[size_t(side)] = build(std::vector<MapPoint>(samples.begin(), middle), whole, most);
      samples.erase(samples.begin(), middle);
    }
  }
  void count(const MapPoint& s) {
    int n = roots[size_t(s.side)];
    while (nodes[size_t(n)].axis >= 0) {
      const Node& node = nodes[size_t(n)];
      n = node.child[s.p[node.axis] < node.split ? 0 : 1];
    }
    cells[size_t(nodes[size_t(n)].child[0])].found += 1;
  }
  std::vector<Cell> cells;

 private:
  static constexpr size_t NEVER = size_t(-1); ///< marks cells that are not divided
  struct Node {
    int axis = -1;
    double split = 0;
    int child[2] = {-1, -1}; ///< of a leaf: index of the cell
  };
  /** Smallest range of a coordinate that contains a quarter of the samples; the whole range if there are
   * few. */
  static Vec2d densest(const std::vector<MapPoint>& samples, int axis) {
    std::vector<double> v;
    for (const MapPoint& s : samples) v.push_back(s.p[axis]);
    std::sort(v.begin(), v.end());
    Vec2d best(v.front(), v.back());
    const size_t quarter = v.size() / 4;
    for (size_t i = 0; quarter > 1 && i + quarter < v.size(); ++i)
      if (v[i + quarter] - v[i] < best[1] - best[0]) best = {v[i], v[i + quarter]};
    return best;
  }
  /** Whether the density varies strongly over the bounding box of the samples. */
  static bool concentrated(const std::vector<MapPoint>& samples, const Vec2d& extent) {
    constexpr size_t FEW = 12;
    if (samples.size() < FEW) return false;
    for (int axis = 0; axis < 2; ++axis) {
      const Vec2d d = densest(samples, axis);
      if (d[1] - d[0] < extent[axis] / 24) return true;
    }
    return false;
  }
  int build(std::vector<MapPoint> samples, const Cell& cell, size_t most, int axis = 0) {
    const int index = int(nodes.size());
    nodes.emplace_back();
    Vec2d low(1e9), high(-1e9);
    for (const MapPoint& s : samples) {
      low = glm::min(low, s.p);
      high = glm::max(high, s.p);
    }
    if (!(high[axis] > low[axis])) axis = 1 - axis;
    if ((samples.size() <= most && (most == NEVER || !concentrated(samples, high - low))) ||
        !(high[axis] > low[axis])) {
      nodes[size_t(index)].child[0] = int(cells.size());
      cells.push_back(cell);
      for (int a = 0; a < 2 && !samples.empty(); ++a) {
        const Vec2d range = densest(samples, a);
        cells.back().first[a] = range[0];
        cells.back().last[a] = range[1];
      }
      return index;
    }
    std::nth_element(samples.begin(), samples.begin() + std::ptrdiff_t(samples.size() / 2), samples.end(),
                     [&](const MapPoint& a, const MapPoint& b) { return a.p[axis] < b.p[axis]; });
    const double split = samples[samples.size() / 2].p[axis];
    std::vector<MapPoint> parts[2];
    for (const MapPoint& s : samples) parts[s.p[axis] < split ? 0 : 1].push_back(s);
    Cell halves[2] = {cell, cell};
    halves[0].high[axis] = halves[1].low[axis] = split;
    int child[2];
    for (int i = 0; i < 2; ++i) {
      // All samples have the same coordinates: no further split separates them.
      const bool stuck = parts[1 - i].empty();
      child[i] = build(std::move(parts[i]), halves[i], stuck ? NEVER : most, 1 - axis);
    }
    Node& node = nodes[size_t(index)];
    node.axis = axis;
    node.split = split;
    node.child[0] = child[0];
    node.child[1] = child[1];
    return index;
  }
  std::vector<Node> nodes;
  int roots[2] = {-1, -1};
};

constexpr int MAX_DEPTH = 12;

/** Integral of a density over a cell, or over a part of it, by at least 16 parts of 9 points each. */
template <class F>
double integrate(const F& density, const Map& map, const CellTree::Cell& cell, const Vec2d& low,
                 const Vec2d& high, double error, int depth, double coarse) {
  const auto rule = [&](const Vec2d& a, const Vec2d& b) {
    static const double X[3] = {-0.7745966692414834, 0, 0.7745966692414834},
                        W[3] = {5 / 18., 8 / 18., 5 / 18.};
    const Vec2d c = (a + b) * 0.5, h = (b - a) * 0.5;
    double sum = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        sum += W[i] * W[j] * density(map.direction(cell.side, c + h * Vec2d(X[i], X[j])));
    return sum * 4 * h.x * h.y;
  };
  const Vec2d middle = (low + high) * 0.5;
  // A cell much wider than its samples could be missed: it is first halved around them.
  if (glm::all(glm::lessThanEqual(low, cell.last)) && glm::all(glm::greaterThanEqual(high, cell.first))) {
    const Vec2d ratio = (high - low) / glm::max(cell.last - cell.first, Vec2d(1e-12, 1e-7));
    if (std::max(ratio.x, ratio.y) > 2) {
      Vec2d below = high, above = low;
      const int axis = ratio.x > ratio.y ? 0 : 1;
      below[axis] = above[axis] = middle[axis];
      return integrate(density, map, cell, low, below, error, depth, -1) +
             integrate(density, map, cell, above, high, error, depth, -1);
    }
  }
  double parts[4], sum = 0;
  const auto part = [&](int i, Vec2d& a, Vec2d& b) {
    a = {i & 1 ? middle.x : low.x, i & 2 ? middle.y : low.y};
    b = {i & 1 ? high.x : middle.x, i & 2 ? high.y : middle.y};
  };
  for (int i = 0; i < 4; ++i) {
    Vec2d a, b;
    part(i, a, b);
    sum += parts[i] = rule(a, b);
  }
  if (depth <= 0 || (depth <= MAX_DEPTH - 1 && std::abs(sum - coarse) <= error)) return sum;
  sum = 0;
  for (int i = 0; i < 4; ++i) {
    Vec2d a, b;
    part(i, a, b);
    sum += integrate(density, map, cell, a, b, error * 0.5, depth - 1, parts[i]);
  }
  return sum;
}

/** Width of the middle half of the samples, in the plane of incidence or perpendicular to it, whichever is
 * smaller. */
double narrowest(const Vec3f& wi, const std::vector<Vec3f>& samples) {
  const Frame frame({0, 0, 1}, wi);
  double width = INFINITY;
  for (const Vec3f& axis : {frame.x, frame.y}) {
    std::vector<float> v;
    for (const Vec3f& w : samples) v.push_back(glm::dot(w, axis));
    const auto quantile = [&](size_t i) {
      std::nth_element(v.begin(), v.begin() + std::ptrdiff_t(i), v.end());
      return double(v[i]);
    };
    const double low = quantile(v.size() / 4);
    width = std::min(width, quantile(v.size() * 3 / 4) - low);
  }
  return width;
}

bool hasNonDelta(const Bsdf& bsdf) { return (bsdf.lobes() & NON_DELTA_LOBES) != 0; }

/** Refractive index on the side of w. */
float indexAt(const Bsdf& bsdf, const Vec3f& w) { return w.z > 0 ? 1 : bsdf.eta(); }

/** Mean and standard error of the flux that all lobes scatter from wi; for BSDFs without reciprocity, of the
 * radiance towards wi in light of radiance 1. */
struct Albedo {
  Rgbd mean{0}, error{0};
};
Albedo scatteredFlux(const Bsdf& bsdf, const Vec3f& wi, int n, uint32_t seed) {
  Albedo out;
  if (hasNonDelta(bsdf)) {
    TestRandom random(seed);
    Rgbd sum(0), sum2(0);
    for (int i = 0; i < n; ++i) {
      // Stratified into halves only, so that the error estimate is correct.
      const Vec2f u = random.next2();
      const auto wo = bsdf.sample(wi, u, random.next());
      const float pdf = wo ? bsdf.pdf(wi, *wo) : 0;
      if (!(pdf > 0)) continue;
      const Rgb value = bsdf.isReciprocal() ? bsdf.value(wi, *wo) : bsdf.value(*wo, wi);
      const Rgbd w(value * (std::abs(wo->z) / pdf));
      sum += w;
      sum2 += w * w;
    }
    out.mean = sum / double(n);
    out.error = sqrt(max(sum2 / double(n) - out.mean * out.mean, 0.0) / double(n));
  }
  DeltaScatters deltas;
  bsdf.deltas(wi, deltas);
  for (const DeltaScatter& d : deltas) out.mean += Rgbd(d.weight);
  return out;
}

} // namespace

TEST(BsdfSampling, FollowsTheDensity) {
  // Chi-square test over cells that adapt to the lobe; the density is integrated in each with a known error.
  const int N = samples(6000);
  constexpr size_t IN_A_CELL = 156;
  forEachBsdf([&](const Bsdf& bsdf) {
    if (!hasNonDelta(bsdf)) return;
    for (const Vec3f& wi : incidentDirections()) {
      TestRandom random(7);
      const Map map(wi);
      const auto draw = [&] {
        std::vector<Vec3f> out;
        for (int i = 0; i < N; ++i) {
          const Vec2f u = random.next2();
          const auto wo = bsdf.sample(wi, u, random.next());
          if (!wo) continue;
          EXPECT_NEAR(glm::length(*wo), 1, 1e-5);
          EXPECT_GT(bsdf.pdf(wi, *wo), 0);
          out.push_back(*wo);
        }
        return out;
      };
      const std::vector<Vec3f> shape = draw();
      // In a lobe of at most a thousand roundings, cells would count the grid of floats.
      if (shape.empty() || narrowest(wi, shape) < 1024 * 0x1p-24) continue;
      std::vector<MapPoint> points;
      for (const Vec3f& w : shape) points.push_back(map.point(w));
      CellTree tree(points, IN_A_CELL);
      const std::vector<Vec3f> samples = draw();
      for (const Vec3f& w : samples) tree.count(map.point(w));
      double total = 0, chi2 = 0;
      int cells = 0;
      for (const CellTree::Cell& cell : tree.cells) {
        const double mass = integrate([&](const Vec3f& wo) { return double(bsdf.pdf(wi, wo)); }, map, cell,
                                      cell.low, cell.high, 1e-5, MAX_DEPTH, -1);
        total += mass;
        if (mass * N < 5) continue;
        chi2 += square(cell.found - mass * N) / (mass * N);
        ++cells;
      }
      const double chance = double(samples.size()) / N;
      EXPECT_NEAR(total, chance, 0.004 + 5 * std::sqrt(chance * (1 - chance) / N))
          << "the density's integral is the chance of a sample; wi.z " << wi.z;
      // The mean of chi-square is the number of cells, its standard deviation the root of twice the number.
      EXPECT_LT(chi2, cells + 6 * std::sqrt(2.0 * cells) + 5) << "wi.z " << wi.z;
    }
  });
}

TEST(BsdfEnergy, NoMoreThanArrives) {
  forEachBsdf([](const Bsdf& bsdf) {
    for (const Vec3f& wi : incidentDirections()) {
      const Albedo a = scatteredFlux(bsdf, wi, bsdf.lossless() ? 20000 : samples(4000), 3);
      for (int k = 0; k < 3; ++k) {
        EXPECT_LE(a.mean[k], 1 + 4 * a.error[k] + 2e-4) << "wi.z " << wi.z;
        if (bsdf.lossless()) {
          EXPECT_GE(a.mean[k], 0.99 - 4 * a.error[k]) << "white furnace; wi.z " << wi.z;
        }
      }
    }
  });
}

/** Near the normal a smooth metal loses light in the tail of its lobe only. */
TEST(BsdfEnergy, SmoothMetalsLoseNothing) {
  const NamedMaterials named;
  for (const char* roughness : {".02", ".05", ".1", ".2"}) {
    const auto metal = makeMaterial("conductor",
                                    std::string("\"rgb reflectance\" [1 1 1] \"bool multiscatter\" true "
                                                "\"bool remaproughness\" false \"float roughness\" ") +
                                        roughness,
                                    named.context());
    BsdfArena arena;
    const Bsdf* bsdf = metal->bsdfAt(flatPoint(), arena);
    ASSERT_TRUE(bsdf);
    for (const float cosine : {1.0f, 0.9f, 0.6f, 0.3f}) {
      const Vec3f wi(std::sqrt(1 - square(cosine)), 0, cosine);
      const Albedo a = scatteredFlux(*bsdf, wi, 200000, 11);
      EXPECT_NEAR(a.mean[0], 1, 2e-3 + 3 * a.error[0]) << roughness << " " << cosine;
    }
  }
}

TEST(BsdfEnergy, AlbedoSteersTheChoice) {
  forEachBsdf([](const Bsdf& bsdf) {
    if (!hasNonDelta(bsdf)) return;
    for (const Vec3f& wi : incidentDirections()) {
      DeltaScatters deltas;
      bsdf.deltas(wi, deltas);
      Rgbd own = scatteredFlux(bsdf, wi, samples(4000), 5).mean;
      for (const DeltaScatter& d : deltas) own -= Rgbd(d.weight);
      const Rgb told = bsdf.albedo(wi);
      for (int k = 0; k < 3; ++k) {
        EXPECT_LE(told[k], 1);
        if (bsdf.lobes() & LAMBERTIAN) {
          EXPECT_NEAR(own[k], double(told[k]), 1e-4);
        } else {
          EXPECT_LE(own[k], 3 * double(told[k]) + 0.02) << "wi.z " << wi.z;
          EXPECT_GE(own[k], double(told[k]) / 4 - 0.05) << "wi.z " << wi.z;
        }
      }
    }
  });
}

TEST(BsdfDelta, LobesAreWellFormedAndReversible) {
  forEachBsdf([](const Bsdf& bsdf) {
    for (const Vec3f& wi : incidentDirections()) {
      DeltaScatters there;
      bsdf.deltas(wi, there);
      EXPECT_EQ(there.count > 0, (bsdf.lobes() & DELTA_LOBES) != 0);
      for (const DeltaScatter& d : there) {
        EXPECT_NEAR(glm::length(d.wo), 1, 1e-5);
        EXPECT_EQ(d.lobe == MIRROR, d.wo.z * wi.z > 0);
        EXPECT_NE(bsdf.lobes() & d.lobe, 0);
        for (int k = 0; k < 3; ++k) EXPECT_GE(d.weight[k], 0);
        // The reverse path has the same weight and the inverse refraction.
        DeltaScatters back;
        bsdf.deltas(d.wo, back);
        double best = INFINITY;
        for (const DeltaScatter& e : back)
          if (glm::length(e.wo - wi) < 2e-3f)
            best = std::min(best, double(maxComponent(abs(e.weight - d.weight))));
        EXPECT_LT(best, 2e-2) << "angle " << wi.z;
      }
    }
  });
}

TEST(BsdfDelta, RoughnessGoesOverIntoTheMirrorWithoutAStep) {
  // Response of all lobes to smooth illumination, for every material with a roughness.
  const auto seen = [](const Bsdf& bsdf, const Vec3f& wi, double& error) {
    const auto light = [](const Vec3f& w) {
      return 1 + 0.5 * double(w.x) - 0.3 * double(w.y) + 0.4 * double(w.z);
    };
    DeltaScatters deltas;
    bsdf.deltas(wi, deltas);
    double sum = 0, sum2 = 0, delta = 0;
    for (const DeltaScatter& d : deltas) delta += double(d.weight.g) * light(d.wo);
    const int n = hasNonDelta(bsdf) ? samples(8000) : 1;
    TestRandom random(17);
    for (int i = 0; i < n && hasNonDelta(bsdf); ++i) {
      const Vec2f u = random.next2();
      const auto wo = bsdf.sample(wi, u, random.next());
      if (!wo) continue;
      const double x =
          double(bsdf.value(wi, *wo).g) * double(std::abs(wo->z) / bsdf.pdf(wi, *wo)) * light(*wo);
      sum += x;
      sum2 += x * x;
    }
    error = std::sqrt(std::max(0.0, sum2 / n - square(sum / n)) / n);
    return delta + sum / n;
  };
  const NamedMaterials named;
  int found = 0;
  for (const auto& entry : plugIns().materials.entries()) {
    const auto withRoughness = [&](double alpha) {
      std::string text;
      for (const ParameterSpec& p : entry.parameters)
        if (p.name == "roughness" || p.name.ends_with(".roughness"))
          text += "\"float " + p.name + "\" " + std::to_string(alpha) + " ";
      return text.empty() ? nullptr
                          : makeMaterial(entry.name, text + "\"bool remaproughness\" false", named.context());
    };
    bool remaps = false;
    for (const ParameterSpec& p : entry.parameters) remaps = remaps || p.name == "remaproughness";
    if (!remaps) continue; // a different kind of roughness, with a minimum
    ++found;
    const auto mirror = withRoughness(0);
    BsdfArena arena;
    for (const double alpha : {0.0009, 0.0011, 0.003, 0.01}) {
      SCOPED_TRACE(entry.name + " " + std::to_string(alpha));
      const auto rough = withRoughness(alpha);
      for (const Vec3f& wi : incidentDirections()) {
        if (std::abs(wi.z) < 0.3f) continue;
        arena.reset();
        const Bsdf* a = mirror->bsdfAt(flatPoint(), arena);
        const Bsdf* b = rough->bsdfAt(flatPoint(), arena);
        EXPECT_EQ((b->lobes() & DELTA_LOBES) != 0, alpha < 0.001);
        double errorA = 0, errorB = 0;
        const double there = seen(*a, wi, errorA), here = seen(*b, wi, errorB);
        EXPECT_NEAR(here, there, 5 * std::hypot(errorA, errorB) + (alpha < 0.001 ? 1e-5 : 2 * alpha))
            << "wi.z " << wi.z;
      }
    }
  }
  EXPECT_GE(found, 5);
}

TEST(BsdfReciprocity, ValuesAndDensities) {
  forEachBsdf([](const Bsdf& bsdf) {
    if (!hasNonDelta(bsdf)) return;
    TestRandom random(5);
    if (!bsdf.isReciprocal()) { // isReciprocal() must not be false without reason
      const Vec3f a = random.direction(), b = random.direction();
      EXPECT_GT(maxComponent(abs(bsdf.value(a, b) - bsdf.value(b, a))),
                0.01f * maxComponent(bsdf.value(a, b)));
      return;
    }
    const auto check = [&](const Vec3f& a, const Vec3f& b) {
      const double na = double(indexAt(bsdf, a)), nb = double(indexAt(bsdf, b));
      const Rgbd ab = Rgbd(bsdf.value(a, b)) * (na / nb), ba = Rgbd(bsdf.value(b, a)) * (nb / na);
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(ab[k], ba[k], 1e-6 + 1e-3 * ab[k]) << a.z << " " << b.z;
      if (ab != Rgbd(0)) {
        EXPECT_GT(bsdf.pdf(a, b), 0) << "would never be sampled " << a.z << " " << b.z;
      }
      const LobeSet lobe = a.z * b.z > 0 ? REFLECTION : TRANSMISSION;
      if (!(bsdf.lobes() & lobe)) {
        EXPECT_EQ(ab, Rgbd(0));
      }
    };
    for (int i = 0; i < samples(2000); ++i) {
      const Vec3f a = random.direction();
      check(a, random.direction());
      const Vec2f u = random.next2();
      if (const auto b = bsdf.sample(a, u, random.next())) check(a, *b); // inside the lobe
    }
  });
}

TEST(BsdfPasses, WeightsAreValueTimesCosineOverDensity) {
  forEachBsdf([](const Bsdf& bsdf) {
    if (!hasNonDelta(bsdf)) return;
    const SurfacePoint point = flatPoint();
    const ScatteringPoint s(bsdf, point);
    for (const Vec3f& wi : incidentDirections())
      for (uint32_t i = 0; i < 20; ++i) {
        Sampler sampler(1, 2, i);
        const auto eye = s.scatterNonDelta(wi, Transport::RADIANCE, sampler);
        if (!eye) continue;
        EXPECT_NEAR(s.pdfNonDelta(wi, eye->direction), eye->pdf, 1e-4f * eye->pdf);
        const Rgb f = s.evaluate(wi, eye->direction) / eye->pdf;
        Sampler again(1, 2, i);
        const auto photon = s.diffuseForwardScatter(wi, again);
        ASSERT_TRUE(photon);
        EXPECT_EQ(photon->direction, eye->direction);
        const Rgb flux = s.evaluateFlux(wi, eye->direction) / eye->pdf;
        for (int k = 0; k < 3; ++k) {
          EXPECT_NEAR(eye->weight[k], f[k], 1e-4f * (f[k] + 1e-3f));
          EXPECT_NEAR(photon->weight[k], flux[k], 1e-4f * (flux[k] + 1e-3f));
          // Flux and radiance differ by the squares of the refractive indices.
          if (bsdf.isReciprocal()) {
            EXPECT_NEAR(photon->weight[k], f[k] * square(eye->eta), 1e-3f * (photon->weight[k] + 1e-3f));
          }
        }
      }
  });
}

TEST(BsdfPasses, NamedOperationsAreViewsOfTheSameDeltas) {
  forEachBsdf([](const Bsdf& bsdf) {
    const SurfacePoint point = flatPoint();
    const ScatteringPoint s(bsdf, point);
    for (const Vec3f& wi : incidentDirections()) {
      std::array<Scatter, DeltaScatters::MAX_COUNT> flux, radiance;
      const int n = s.deltaScatters(wi, Transport::FLUX, flux);
      ASSERT_EQ(n, s.deltaScatters(wi, Transport::RADIANCE, radiance));
      for (int i = 0; i < n; ++i) {
        const Rgb expected = flux[size_t(i)].weight / square(flux[size_t(i)].eta);
        for (int k = 0; k < 3; ++k)
          EXPECT_NEAR(radiance[size_t(i)].weight[k], expected[k], 1e-5f * (1 + expected[k]));
      }
      // Each operation is the first radiance sample of its lobe, in direction and in value.
      for (const auto& [lobe, named] : {std::pair(MIRROR, s.specularReflectionBackwardScatter(wi)),
                                        std::pair(REFRACTION, s.specularRefractionBackwardScatter(wi))}) {
        const auto first = std::find_if(radiance.begin(), radiance.begin() + n,
                                        [lobe = lobe](const Scatter& r) { return r.lobe == lobe; });
        ASSERT_EQ(named.has_value(), first != radiance.begin() + n);
        if (!named) continue;
        EXPECT_EQ(named->lobe, lobe);
        EXPECT_EQ(named->direction, first->direction);
        EXPECT_EQ(named->weight, first->weight);
        EXPECT_EQ(named->eta, first->eta);
        EXPECT_EQ(glm::dot(named->direction, s.normal()) * glm::dot(wi, s.normal()) > 0, lobe == MIRROR);
      }
    }
  });
}

TEST(BsdfPasses, OneOfSeveralRefractionsStandsForAll) {
  forEachBsdf([](const Bsdf& bsdf) {
    const SurfacePoint point = flatPoint();
    const ScatteringPoint s(bsdf, point);
    for (const Vec3f& wi : incidentDirections()) {
      std::array<Scatter, DeltaScatters::MAX_COUNT> all;
      const int n = s.deltaScatters(wi, Transport::RADIANCE, all);
      Rgbd expected(0), mean(0);
      int refractions = 0;
      for (int i = 0; i < n; ++i)
        if (all[size_t(i)].lobe == REFRACTION && maxComponent(all[size_t(i)].weight) > 0) {
          expected += Rgbd(all[size_t(i)].weight);
          ++refractions;
        }
      const uint32_t draws = refractions > 1 ? 4096 : 1;
      for (uint32_t i = 0; i < draws; ++i) {
        Sampler sampler(1, 4, i);
        if (const auto step = s.specularRefractionBackwardScatter(wi, sampler))
          mean += Rgbd(step->weight) / double(draws);
      }
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(mean[k], expected[k], (refractions > 1 ? 0.05 : 1e-6) * expected[k]);
    }
  });
}

TEST(BsdfPasses, LambertianMeansThatTheValueIsOneConstant) {
  forEachBsdf([](const Bsdf& bsdf) {
    if (!(bsdf.lobes() & LAMBERTIAN)) return;
    const Vec3f up(0, 0, 1);
    EXPECT_FALSE(isBlack(bsdf.value(up, up)));
    for (const Vec3f& wi : incidentDirections())
      for (const Vec3f& wo : incidentDirections()) {
        const Rgb value = bsdf.value(wi, wo), expected = wi.z * wo.z > 0 ? bsdf.value(up, up) : BLACK;
        for (int k = 0; k < 3; ++k)
          EXPECT_NEAR(value[k], expected[k], 1e-6f) << "a BSDF like this must not say that it is LAMBERTIAN";
      }
  });
}

TEST(BsdfPasses, TheShortCutOfLambertianBsdfsGoesByTheirValue) {
  // DiffuseBsdf after a change of value() alone.
  class Edited final : public Bsdf {
   public:
    LobeSet lobes() const override { return REFLECTION | LAMBERTIAN; }
    Rgb value(const Vec3f& wi, const Vec3f& wo) const override {
      return wi.z * wo.z > 0 ? Rgb(.3f, .2f, .1f) * INV_PI : BLACK;
    }
    float pdf(const Vec3f& wi, const Vec3f& wo) const override {
      return wi.z * wo.z > 0 ? std::abs(wo.z) * INV_PI : 0;
    }
    Rgb albedo(const Vec3f&) const override { return Rgb(1); }
  };
  const Edited bsdf;
  const SurfacePoint point = flatPoint();
  const ScatteringPoint s(bsdf, point);
  const Vec3f wi = glm::normalize(Vec3f(1, 2, 3)), wo = glm::normalize(Vec3f(-2, 1, 2));
  Sampler sampler(1, 5, 0);
  const auto step = s.diffuseForwardScatter(wi, sampler);
  ASSERT_TRUE(step);
  for (int k = 0; k < 3; ++k) {
    const float albedo = .3f - .1f * float(k);
    EXPECT_NEAR(s.evaluate(wi, wo)[k], albedo * INV_PI * wo.z, 1e-6f);
    EXPECT_NEAR(step->weight[k], albedo, 1e-6f);
  }
}

TEST(BsdfPasses, ForwardEqualsBackward) {
  // <h, forward g> = <backward h, g>: emission g and importance h give the same integral in both directions
  // of transport, including delta lobes, refraction and tilted shading normals.
  const auto g = [](const Vec3f& w) {
    return 1 + 0.5 * double(w.x) + 0.3 * double(w.y * w.z) + 0.4 * double(w.z);
  };
  const auto h = [](const Vec3f& w) {
    return 1 - 0.6 * double(w.y) + 0.2 * double(w.x * w.x) - 0.3 * double(w.z);
  };
  const auto N = uint32_t(samples(1 << 13));
  forEachBsdf([&](const Bsdf& bsdf) {
    for (const float tilt : {0.0f, 0.4f}) {
      SurfacePoint point = flatPoint();
      point.shadingNormal = glm::normalize(Vec3f(tilt, 0.3f * tilt, 1));
      const ScatteringPoint s(bsdf, point);
      Rgbd mean[2], variance[2];
      for (int pass = 0; pass < 2; ++pass) {
        Rgbd sum(0), sum2(0);
        TestRandom random(11 + uint32_t(pass));
        for (uint32_t i = 0; i < N; ++i) {
          Vec3f from = cosineHemisphere(random.next2());
          if (i & 1) from.z = -from.z;
          Sampler sampler(random.below(1u << 30), 5, i);
          const auto step = s.scatter(from, pass ? Transport::RADIANCE : Transport::FLUX, sampler);
          if (!step) continue;
          const Rgbd x =
              Rgbd(step->weight) * (pass ? h(from) * g(step->direction) : g(from) * h(step->direction));
          sum += x;
          sum2 += x * x;
        }
        mean[pass] = sum / double(N);
        variance[pass] = max(sum2 / double(N) - mean[pass] * mean[pass], 0.0) / double(N);
      }
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(mean[0][k], mean[1][k], 4.5 * std::sqrt(variance[0][k] + variance[1][k]) + 1e-5)
            << "tilt " << tilt;
    }
  });
}

TEST(BsdfPasses, HairThatTurnsToTheRayIsTheSameFromEitherEnd) {
  // Adjointness for a curve along x that always faces the ray, so that its width is constant; the normals of
  // a tube vary across it.
  const auto g = [](const Vec3f& w) { return 1 + 0.5 * double(w.x) + 0.6 * double(w.y * w.z); };
  const auto h = [](const Vec3f& w) { return 1 - 0.4 * double(w.x * w.y) + 0.7 * double(w.z); };
  const auto N = uint32_t(samples(1 << 14));
  BsdfArena arena;
  for (const MaterialUse& use : everyUse())
    for (const bool tube : {false, true}) {
      if (!(use.material->lobes() & (FIBRE | LAMBERTIAN))) continue;
      SCOPED_TRACE(use.text + (tube ? " tube" : " flat"));
      Rgbd mean[2], variance[2];
      for (int pass = 0; pass < 2; ++pass) {
        Rgbd sum(0), sum2(0);
        TestRandom random(31 + uint32_t(pass));
        for (uint32_t i = 0; i < N; ++i) {
          const Vec3f from = random.direction();
          const float across = random.next(), width = std::sqrt(1 - square(from.x));
          SurfacePoint point = flatPoint();
          point.curve = SurfacePoint::Curve::FACES_RAY;
          point.uv = {0.5f, across};
          const float turned = std::atan2(from.z, from.y) + (tube ? float(M_PI) * (across - 0.5f) : 0.0f);
          point.geometricNormal = point.shadingNormal = {0, std::cos(turned), std::sin(turned)};
          arena.reset();
          const Bsdf* bsdf = use.material->bsdfAt(point, arena);
          if (!bsdf || !hasNonDelta(*bsdf)) break;
          Sampler sampler(random.below(1u << 30), 5, i);
          const ScatteringPoint s(*bsdf, point);
          EXPECT_FALSE(s.keepsPhotons());
          const auto step = s.scatterNonDelta(from, pass ? Transport::RADIANCE : Transport::FLUX, sampler);
          if (!step) continue;
          const Rgbd x = Rgbd(step->weight) * double(width) *
                         (pass ? h(from) * g(step->direction) : g(from) * h(step->direction));
          ASSERT_TRUE(isFinite(Rgb(x)));
          sum += x;
          sum2 += x * x;
        }
        mean[pass] = sum / double(N);
        variance[pass] = max(sum2 / double(N) - mean[pass] * mean[pass], 0.0) / double(N);
      }
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(mean[0][k], mean[1][k], 4.5 * std::sqrt(variance[0][k] + variance[1][k]) + 1e-5);
    }
}

TEST(BsdfPasses, ScatterTakesAllLobesInProportion) {
  forEachBsdf([](const Bsdf& bsdf) {
    const ScatteringPoint s(bsdf, flatPoint());
    for (const Vec3f& wi : incidentDirections()) {
      constexpr uint32_t N = 2048; // sanitizers need as many: a bubble transmits little at grazing angles
      Rgbd sum(0), sum2(0);
      for (uint32_t i = 0; i < N; ++i) {
        Sampler each(9, 1, i);
        const auto step = s.scatter(wi, bsdf.isReciprocal() ? Transport::FLUX : Transport::RADIANCE, each);
        if (!step) continue;
        const Rgbd w(step->weight);
        sum += w;
        sum2 += w * w;
      }
      const Albedo all = scatteredFlux(bsdf, wi, int(N), 1);
      const Rgbd mean = sum / double(N), variance = max(sum2 / double(N) - mean * mean, 0.0) / double(N);
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(mean[k], all.mean[k], 5 * std::sqrt(variance[k] + square(all.error[k])) + 1e-4)
            << "wi.z " << wi.z;
    }
  });
}

namespace {

/** Text of a value for a declared parameter: an end of its range, or a value in between. Empty: omits the
 * parameter. */
std::string cornerValue(const ParameterSpec& p, TestRandom& random) {
  if (p.ignored) return {};
  const auto number = [&](double low, double high) {
    const double least = std::isfinite(p.minimum) ? p.minimum : low;
    const double most = std::isfinite(p.maximum) ? p.maximum : high;
    const double u = double(random.next());
    switch (random.below(4)) {
    case 0:
      return p.minimumExcluded ? std::min(most, std::max(1e-30, least * (1 + 1e-6))) : least;
    case 1:
      return most;
    case 2: // small values are important for roughness
      return std::clamp(least + std::exp(-12 * u) * (most - least), least, most);
    default:
      return std::clamp(least + u * (most - least), least + (p.minimumExcluded ? 1e-30 : 0), most);
    }
  };
  const auto text = [](double x) {
    char buffer[40];
    std::snprintf(buffer, sizeof buffer, "%.17g", x);
    return std::string(buffer);
  };
  switch (p.type) {
  case ParameterType::BOOLEAN:
    return "\"bool " + p.name + "\" " + (random.below(2) ? "true" : "false");
  case ParameterType::REAL:
    return "\"float " + p.name + "\" " + text(number(0, 1));
  case ParameterType::INTEGER:
    return "\"integer " + p.name + "\" " + text(std::floor(std::min(number(0, 10), 20.0)));
  case ParameterType::SPECTRUM: {
    std::string v = "\"rgb " + p.name + "\" [";
    const double high = p.spectrumKind == SpectrumKind::ALBEDO ? 1 : 1e3;
    for (int i = 0; i < 3; ++i) v += text(number(0, high)) + " ";
    return v + "]";
  }
  case ParameterType::STRING:
    if (p.choices.empty()) return {};
    return "\"string " + p.name + "\" \"" + p.choices[random.below(p.choices.size())] + "\"";
  default:
    return {};
  }
}

/** Direction, often a special case: on an axis, grazing, in the plane, nearly along the normal. */
Vec3f cornerDirection(TestRandom& random) {
  const double phi = 2 * M_PI * double(random.next()), side = random.below(2) ? 1 : -1;
  const auto at = [&](double z) {
    const double r = std::sqrt(1 - z * z);
    return Vec3f(Vec3d(r * std::cos(phi), r * std::sin(phi), z * side));
  };
  switch (random.below(6)) {
  case 0:
    return {0, 0, float(side)};
  case 1:
    return random.below(2) ? Vec3f(1, 0, 0) : Vec3f(0, -1, 0);
  case 2:
    return at(std::pow(10.0, -8 * double(random.next())));
  case 3:
    return at(1 - std::pow(10.0, -8 * double(random.next())));
  default:
    return random.direction();
  }
}

float cornerNumber(TestRandom& random) {
  switch (random.below(8)) {
  case 0:
    return 0;
  case 1:
    return ONE_MINUS_EPSILON;
  case 2:
    return 0x1p-24f;
  default:
    return random.next();
  }
}

} // namespace

TEST(BsdfCorners, NothingButFiniteNumbers) {
  setThreadFloatMode(); // as all threads of a render have it
  // RECURSE_BSDF_EVALUATIONS sets the number of random evaluations; 1e7 was run under the sanitizers.
  const char* wanted = std::getenv("RECURSE_BSDF_EVALUATIONS");
  const size_t evaluations = wanted ? size_t(std::atof(wanted)) : size_t(samples(200000));
  const NamedMaterials named;
  TestRandom random(23);
  struct Use {
    const PlugIn<Material, MaterialContext>* entry;
    std::string base; ///< an example that provides required parameters
  };
  std::vector<Use> uses;
  for (const auto& entry : plugIns().materials.entries()) {
    bool needsMore = false;
    for (const ParameterSpec& p : entry.parameters) needsMore = needsMore || p.required;
    if (!needsMore) {
      uses.push_back({&entry, ""});
      continue;
    }
    for (const std::string& example : entry.examples) uses.push_back({&entry, example});
  }
  constexpr size_t EACH = 500; // number of evaluations for each choice of parameters
  for (size_t n = 0; n < evaluations && !::testing::Test::HasFailure();) {
    for (const Use& use : uses) {
      std::string parameters = use.base;
      if (use.base.empty())
        for (const ParameterSpec& p : use.entry->parameters)
          if (random.below(2)) parameters += cornerValue(p, random) + " ";
      SCOPED_TRACE(use.entry->name + " " + parameters);
      Diagnostics diagnostics;
      const auto material = plugIns().materials.make(parseParameterText(use.entry->name, parameters),
                                                     named.context(), diagnostics);
      if (!material) continue; // parameters that exclude each other give an error, not a crash
      BsdfArena arena;
      const Bsdf* bsdf = material->bsdfAt(flatPoint(), arena);
      if (!bsdf) continue;
      const auto good = [](const Rgb& c) { return isFinite(c) && c.r >= 0 && c.g >= 0 && c.b >= 0; };
      for (size_t i = 0; i < EACH; ++i, ++n) {
        const Vec3f wi = cornerDirection(random), wo = cornerDirection(random);
        const Rgb f = bsdf->value(wi, wo);
        const float pdf = bsdf->pdf(wi, wo);
        ASSERT_TRUE(good(f)) << f.r << " from " << wi.x << " " << wi.y << " " << wi.z << " to " << wo.x << " "
                             << wo.y << " " << wo.z;
        ASSERT_TRUE(std::isfinite(pdf) && pdf >= 0) << pdf << " from " << wi.x << " " << wi.y << " " << wi.z
                                                    << " to " << wo.x << " " << wo.y << " " << wo.z;
        ASSERT_TRUE(good(bsdf->albedo(wi)));
        const Vec2f u(cornerNumber(random), cornerNumber(random));
        if (!hasNonDelta(*bsdf)) continue;
        if (const auto to = bsdf->sample(wi, u, cornerNumber(random))) {
          ASSERT_NEAR(glm::length(*to), 1, 1e-4);
          const float p = bsdf->pdf(wi, *to);
          ASSERT_TRUE(std::isfinite(p) && p >= 0) << p << " at " << wi.x << " " << wi.y << " " << wi.z;
          if (p > 0) {
            ASSERT_TRUE(good(bsdf->value(wi, *to) * (std::abs(to->z) / p)))
                << p << " at " << wi.x << " " << wi.y << " " << wi.z;
          }
        }
        DeltaScatters deltas;
        bsdf->deltas(wi, deltas);
        for (const DeltaScatter& d : deltas) {
          ASSERT_TRUE(isFinite(d.wo) && good(d.weight) && std::isfinite(d.eta) && d.eta > 0);
        }
      }
    }
  }
}
