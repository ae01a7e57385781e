/** @file
 * Density estimation: photons times BSDF times kernel, eight at once for a Lambertian BSDF.
 */
#include "transport/density/gather.h"

#include <bit>
#include <cfloat>
#include <vector>

namespace recurse {

namespace {

Float8 dot(const Vec3f8& a, const Vec3f8& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Float8 dot(const Vec3f8& a, const Vec3f& b) { return dot(a, Vec3f8{Float8(b.x), Float8(b.y), Float8(b.z)}); }

/** Cosines of photon directions to both normals of a point (Veach 1997, section 5.3): photon flux has the
 * cosine to its own surface, the reflection equation the cosine to the shading normal. Directions undergo the
 * rotation that takes the normal of the photon's surface to the geometric normal of the point. */
class PhotonCosines {
 public:
  /** Unit normals of the point, on the side of the viewer. */
  PhotonCosines(const Vec3f& geometric, const Vec3f& shading) : geometric(geometric), shading(shading) {}

  struct Pair {
    Float8 geometric, shading;
    /** Ratio of the cosines; 0 for light parallel to the surface, whose direction packing has changed. */
    Float8 quotient() const {
      return select(less(Float8(0), abs(geometric)), shading / geometric, Float8(0));
    }
  };
  Pair of(const PhotonBlock& block) const {
    const Vec3f8 direction = block.directions();
    Vec3f8 normal = unpackDirections(block.normals);
    const Float8 side = copysign(Float8(1), dot(normal, geometric)); // photons may be from the far side
    normal = {normal.x * side, normal.y * side, normal.z * side};
    const Float8 cosine = dot(direction, normal);
    const Float8 along = (cosine + dot(direction, geometric)) / (Float8(1) + dot(normal, geometric));
    const Float8 both(glm::dot(geometric, shading));
    return {cosine, dot(direction, shading) - along * (dot(normal, shading) + both) + cosine * (both + both)};
  }

 private:
  Vec3f geometric, shading;
};

/** Photon of a support, before its BSDF is evaluated. */
struct Candidate {
  Rgb power{0}; ///< times the kernel's weight
  PackedDirection direction;
  float reverseRatio = 0;
  uint8_t pathState = 0;
};

/** Sums of photon power, one for each state of the light path. */
class Estimate {
 public:
  Estimate(const ScatteringPoint& scattering, const SurfacePoint& point, const Vec3f& eye,
           const GatherSettings& settings, const GatherResult& weights, const PathClasses& classes,
           CameraState cameraState, std::vector<Candidate>& candidates)
      : candidates(candidates), scattering(scattering), eye(eye), weighting(settings.weighting),
        cameraState(cameraState), states(classes.lightStateCount()), weighed(settings.weighedAgainstRays),
        mergeDensity(weights.mergeDensity), unknownWeight(weights.unknownWeight),
        lambertian((scattering.lobes() & LAMBERTIAN) && !(scattering.lobes() & TRANSMISSION)),
        shadingSide(glm::dot(scattering.normal(), eye) < 0 ? -scattering.normal() : scattering.normal()),
        bent(point.shadingNormal != point.geometricNormal), cosines(point.normalTowards(eye), shadingSide) {
    if (lambertian && states <= MAX_LISTED) {
      for (size_t i = 0; i < states; ++i)
        if (classes.join(LightState(static_cast<uint8_t>(i)), cameraState) != 0) {
          lanes[listed] = {Float8(0), Float8(0), Float8(0)};
          list[listed++] = static_cast<uint8_t>(i);
        }
    } else {
      for (size_t i = 0; i < states; ++i) sums[i] = BLACK;
    }
    candidates.clear();
  }

  bool isLambertian() const { return lambertian; }
  /** Fast path for the most common case: a Lambertian BSDF without distinction of path classes. */
  bool oneSum() const { return lambertian && states == 1 && listed == 1; }
  void set(const Vec3f8& power) { lanes[0] = power; }
  auto arrives() const {
    return [this](Float8 weight, const PhotonBlock& block) { return counted(weight, block); };
  }

  /** Adds the photons found in a block, with kernel shape values in `shape`. */
  void add(const PhotonBlock& block, Float8 shape) {
    const Float8 weight = weightOf(block, shape);
    if (lambertian && states <= MAX_LISTED) {
      const Vec3f8 power = {block.red() * weight, block.green() * weight, block.blue() * weight};
      // Loops over all states for each block: cheaper than a branch that depends on the photons.
      const Uint32x8 pathStates = Uint32x8::fromBytes(block.pathStates);
      for (size_t i = 0; i < listed; ++i) {
        const Float8 same = equal(pathStates, Uint32x8(list[i]));
        addLanes(i, {power.x & same, power.y & same, power.z & same});
      }
      return;
    }
    forEachPhoton(block, weight, [&](int lane, const Rgb& power) {
      if (lambertian)
        sums[block.pathStates[lane]] += power;
      else
        candidates.push_back({power, PackedDirection{block.payload->direction[lane]},
                              block.reverseRatio(lane), block.pathStates[lane]});
    });
  }
  /** Adds the photons that add() has kept because the BSDF depends on their directions: all of them without
   * `sampler`, else at most about MOST, by systematic sampling in proportion to power. Returns the number of
   * BSDFs evaluated. */
  size_t addKept(const Sampler* sampler) {
    // More evaluations would not reduce the variance of the photons, which is larger.
    constexpr size_t MOST = 16;
    constexpr uint32_t FORK = 0x4342; // distinct from other forks of the caller's sampler
    const auto evaluate = [&](const Candidate& c, float scale) {
      sums[c.pathState] += c.power * (scale * value(unpackDirection(c.direction), c.reverseRatio));
    };
    if (!sampler || candidates.size() <= MOST) {
      for (const Candidate& c : candidates) evaluate(c, 1);
      return candidates.size();
    }
    double total = 0;
    for (const Candidate& c : candidates) total += double(maxComponent(c.power));
    const double step = total / double(MOST);
    double end = 0, next = double(sampler->fork(FORK).next1D()) * step;
    for (const Candidate& c : candidates) {
      const auto power = double(maxComponent(c.power));
      end += power;
      int times = 0;
      for (; next < end; next += step) ++times;
      if (times > 0) evaluate(c, static_cast<float>(times * step / power));
    }
    return MOST;
  }

  /** Adds the photons found in a block to `out`, each by the length of its path; see add() and addTo().
   * `optical`: of the camera path on arrival. */
  void addByLength(const PhotonMap& map, const SurfacePoint& point, const OpticalPath& optical,
                   const PhotonBlock& block, Float8 shape, const Rgb& scale, PathRadiance& out) const {
    const Rgb factor = factorOf(scale);
    forEachPhoton(block, weightOf(block, shape), [&](int lane, Rgb power) {
      const size_t slot = block.first + static_cast<size_t>(lane);
      const Vec3f light = block.direction(lane);
      if (!lambertian) power *= value(light, block.reverseRatio(lane));
      const float arrival = lengthNear(point.position, map.position(slot), light, map.length(slot),
                                       leaving(optical, scattering, eye, light).index);
      if (!isBlack(power))
        out.add(LightState(block.pathStates[lane]), cameraState, power * factor, optical.length + arrival);
    });
  }

  void addTo(PathRadiance& out, const Rgb& scale) {
    const Rgb factor = factorOf(scale);
    const auto addState = [&](size_t state, const Rgb& power) {
      if (!isBlack(power)) out.add(LightState(static_cast<uint8_t>(state)), cameraState, power * factor);
    };
    if (lambertian && states <= MAX_LISTED) {
      for (size_t i = 0; i < listed; ++i)
        addState(list[i], Rgb(sum(lanes[i].x), sum(lanes[i].y), sum(lanes[i].z)));
    } else {
      for (size_t i = 0; i < states; ++i) addState(i, sums[i]);
    }
  }

 private:
  /** Maximum number of states that are summed in lanes; beyond, photons are added one by one. */
  static constexpr size_t MAX_LISTED = 12;

  /** A Lambertian BSDF is constant. Its value for light from the viewer avoids leaks at either normal. */
  Rgb factorOf(const Rgb& scale) const { return lambertian ? scale * scattering.value(eye, eye) : scale; }

  /** Weights of the photons found in a block, without those of value(). */
  Float8 weightOf(const PhotonBlock& block, Float8 shape) const {
    const Float8 weight = block.found(shape);
    if (lambertian) return counted(weight, block);
    return bent ? weight * abs(cosines.of(block).quotient()) : weight;
  }

  /** Calls visit(lane, power) for the photons found in a block, with their weighted power. */
  template <class Visit>
  void forEachPhoton(const PhotonBlock& block, Float8 weight, const Visit& visit) const {
    alignas(32) float w[8];
    weight.store(w);
    for (uint32_t slots = block.mask; slots != 0; slots &= slots - 1) {
      const int lane = std::countr_zero(slots);
      visit(lane, block.power(lane) * w[lane]);
    }
  }

  /** BSDF times the photon's weight against rays and MIS weight. */
  Rgb value(const Vec3f& light, float reverseRatio) const {
    const Rgb f = scattering.value(eye, light);
    if (isBlack(f) || !(weighed || weighting.ever())) return f;
    const float pdf = scattering.pdfNonDelta(eye, light);
    return f * (weighting.gathered(pdf) *
                (weighed ? photonWeight(reverseRatio, mergeDensity, pdf, unknownWeight) : 1));
  }

  /** Weights of photons at a Lambertian surface; 0 from behind the shading normal. */
  Float8 counted(Float8 weight, const PhotonBlock& block) const {
    if (!bent && !weighed) return weight;
    if (!bent && !block.reverseRatios) return weight * Float8(unknownWeight);
    Float8 cosine;
    if (bent) {
      const PhotonCosines::Pair pair = cosines.of(block);
      cosine = max(pair.shading, Float8(0));
      weight = weight * max(pair.quotient(), Float8(0));
      if (!weighed) return weight;
      if (!block.reverseRatios) return weight * Float8(unknownWeight);
    } else {
      cosine = max(dot(block.directions(), shadingSide), Float8(0));
    }
    const Float8 ratio = Float8::load(block.reverseRatios);
    const Float8 share =
        Float8(mergeDensity) / max(Float8(mergeDensity) + ratio * cosine * Float8(INV_PI), Float8(FLT_MIN));
    return weight * select(less(Float8(0), ratio), share, Float8(unknownWeight));
  }

  void addLanes(size_t i, const Vec3f8& power) {
    Vec3f8& total = lanes[i];
    total.x += power.x;
    total.y += power.y;
    total.z += power.z;
  }

  std::vector<Candidate>& candidates;
  const ScatteringPoint& scattering;
  Vec3f eye;
  GatherWeighting weighting;
  CameraState cameraState;
  size_t states;
  bool weighed;
  float mergeDensity, unknownWeight;
  bool lambertian;
  Vec3f shadingSide;
  bool bent; ///< the shading normal differs from the geometric normal
  PhotonCosines cosines;
  std::array<Rgb, 256> sums;
  size_t listed = 0; ///< number of states that complete a path of some class
  std::array<uint8_t, MAX_LISTED> list;
  std::array<Vec3f8, MAX_LISTED> lanes; ///< sums of the listed states, in eight lanes
};

/** Share of the expected irradiance from which on estimates are always made. */
constexpr float FAINT = 0.1f;

/** Kernel support: the region of the photons and the area to divide by. */
struct Support {
  GatherRegion region;
  float radius2 = 0;
  bool empty = false;     ///< no photons, or not estimated; the surface fraction is unknown
  float scale = 1;        ///< 1 / probability of the estimate
  float fraction = 1;     ///< fraction of the kernel's weight that is on the surface
  bool byNearest = false; ///< photons are in the scratch memory
};

/** Finds the support around `region`, of at least `least`. `error`: bound of the centre's error. */
Support findKernelSupport(const PhotonMap& map, const GatherSettings& settings, const GatherRegion& region,
                          float error, float least, BoundaryCorrection* boundary, PhotonScratch& scratch,
                          TransportCounts& counts) {
  Support support{region};
  const auto search = [&] {
    support.region.radius = settings.radius;
    support.byNearest = false;
    support.radius2 = square(support.region.radius);
    if (settings.nearest > 0) {
      const NearestPhotons nearest = map.nearest(support.region, settings.nearest, scratch);
      // Photons that all coincide with the centre define no density.
      if (nearest.count == settings.nearest && (nearest.radius2 > 0 || least > 0)) {
        support.radius2 = nearest.radius2;
        support.byNearest = true;
      }
    }
    if (support.radius2 < square(least)) {
      support.radius2 = square(least);
      support.byNearest = false;
    }
    support.region.radius = std::sqrt(support.radius2);
  };
  const float flat = boundary ? boundary->flat() : 0;
  support.region.flatness =
      flat > 0 ? flatnessOfFlat(*boundary, settings.flatness, error, std::min(settings.radius, flat))
               : settings.flatness;
  search();
  if (flat > 0 && support.region.radius > flat) { // flatness is unknown at this distance
    support.region.flatness = settings.flatness;
    search();
  }
  if (!boundary) return support;
  // The weight of rays depends on the support even if it contains no photons.
  if (!settings.leavesLightToRays && !support.byNearest && support.region.radius > flat) {
    // Probe rays take longer than the search, and are left out at random where few photons were found. The
    // variance that this adds is at most FAINT times the square of the expected irradiance, unless the
    // support is reduced: a small one may be much brighter, and has at most 1 / FAINT times its brightness.
    const float found = irradianceWithin(map, support.region);
    const float probability =
        found > 0 ? std::max(FAINT, found / std::max(FAINT * settings.expected, FLT_MIN)) : 0;
    if (probability < 1) {
      support.empty = boundary->sampler.next1D() >= probability;
      if (support.empty) return support;
      support.scale = 1 / probability;
    }
  }
  const auto fit = [&] {
    const uint64_t before = counts.rays;
    const float radius = support.region.radius;
    support.fraction = coveredFraction(*boundary, error, settings.kernel, support.region, counts);
    counts.boundaryRays += counts.rays - before;
    if (support.region.radius == radius) return;
    support.radius2 = square(support.region.radius);
    support.byNearest = false;
  };
  const float flatness = support.region.flatness;
  fit();
  // Searches again for the nearest photons inside of the clipped region.
  if (support.byNearest && (support.region.clipCount > 0 || support.region.flatness < flatness)) {
    search();
    fit();
  }
  return support;
}

/** Sum of power times kernel shape over the photons of a support, without BSDF. */
struct PowerSum {
  Vec3f8 power{0, 0, 0};
  int found = 0;
};

/** `arrives(weight, block)`: weight in the lanes whose light counts, else 0. A support of the k nearest
 * photons ends at the k-th, which does not count itself: E[(k - 1)/area] is the density. */
template <class Arrives>
PowerSum sumPower(const PhotonMap& map, const Support& support, Kernel kernel, const PhotonScratch& scratch,
                  const Arrives& arrives) {
  return withKernel(kernel, [&](auto k) {
    const Float8 limit(support.radius2), inverse(1 / support.radius2);
    const auto add = [=](PowerSum& s, const PhotonBlock& block) {
      const uint32_t mask = block.mask & bits(less(block.distance2, limit));
      const Float8 shape = kernelShape<decltype(k)::value>(min(block.distance2 * inverse, Float8(1)));
      const Float8 weight = arrives(shape & Float8::lanes(mask), block);
      s.power.x += block.red() * weight;
      s.power.y += block.green() * weight;
      s.power.z += block.blue() * weight;
      s.found += std::popcount(mask);
    };
    return support.byNearest ? map.accumulateNearest(scratch, PowerSum(), add)
                             : map.accumulateWithin(support.region, PowerSum(), add);
  });
}

} // namespace

GatherResult gather(const PhotonMap& map, const GatherSettings& settings, const ScatteringPoint& scattering,
                    const SurfacePoint& point, const Vec3f& eye, float footprint, const Rgb& throughput,
                    CameraState cameraState, PathRadiance& out, BoundaryCorrection* boundary,
                    const Sampler* sampler, const OpticalPath& optical) {
  ++out.counts.gathers;
  GatherResult result;
  result.unknownWeight = settings.unknownWeight;
  result.mergeDensity =
      mergeDensityWithin(settings.mergeDensity, square(std::max(settings.radius, footprint / 2)));
  if (map.empty()) return result;
  const GatherRegion region{.center = point.position,
                            .normal = point.normalTowards(eye),
                            .bothSides = (scattering.lobes() & TRANSMISSION) != 0,
                            .time = point.time};
  thread_local PhotonScratch scratch;
  // Detail below a pixel is only noise: the support is at least as wide as the pixel.
  const Support support = findKernelSupport(map, settings, region, glm::length(point.error), footprint / 2,
                                            boundary, scratch, out.counts);
  if (settings.leavesLightToRays)
    result.mergeDensity = mergeDensityWithin(settings.mergeDensity, support.radius2);
  result.unknownWeight = settings.unknownWeightWithin(support.radius2);
  result.radius = support.region.radius;
  if (support.empty) return result;
  thread_local std::vector<Candidate> candidates;
  Estimate estimate(scattering, point, eye, settings, result, out.pathClasses(), cameraState, candidates);
  const Rgb scale = throughput * support.scale *
                    ((settings.weighedAgainstRays ? 1 : result.unknownWeight) * INV_PI /
                     (support.radius2 * support.fraction));
  if (estimate.oneSum() && !map.hasLengths()) {
    const PowerSum sum = sumPower(map, support, settings.kernel, scratch, estimate.arrives());
    result.found = sum.found;
    estimate.set(sum.power);
  } else {
    withKernel(settings.kernel, [&](auto kernel) {
      const auto addBlock = [&](PhotonBlock block) {
        block.mask &= bits(less(block.distance2, Float8(support.radius2)));
        if (block.mask == 0) return;
        result.found += std::popcount(block.mask);
        const Float8 q = min(block.distance2 / Float8(support.radius2), Float8(1));
        const Float8 shape = kernelShape<decltype(kernel)::value>(q);
        if (map.hasLengths())
          estimate.addByLength(map, point, optical, block, shape, scale, out);
        else
          estimate.add(block, shape);
      };
      if (support.byNearest)
        map.visitNearest(scratch, addBlock);
      else
        map.visitWithin(support.region, addBlock);
    });
  }
  out.counts.photonsFound += static_cast<uint64_t>(result.found);
  const bool allScattered = map.hasLengths() && !estimate.isLambertian();
  out.counts.photonsScattered += allScattered ? size_t(result.found) : estimate.addKept(sampler);
  if (result.found > 0 && !map.hasLengths()) estimate.addTo(out, scale);
  return result;
}

Rgb irradiance(const PhotonMap& map, const GatherSettings& settings, const GatherRegion& region, float error,
               BoundaryCorrection* boundary, TransportCounts& counts) {
  ++counts.gathers;
  if (map.empty()) return BLACK;
  thread_local PhotonScratch scratch;
  const Support support = findKernelSupport(map, settings, region, error, 0, boundary, scratch, counts);
  if (support.empty) return BLACK;
  const float mergeDensity = mergeDensityWithin(settings.mergeDensity, square(settings.radius));
  const PowerSum s =
      sumPower(map, support, settings.kernel, scratch, [&](Float8 weight, const PhotonBlock& block) {
        if (!settings.weighedAgainstRays || !block.reverseRatios) return weight;
        alignas(32) float shares[8];
        for (int lane = 0; lane < 8; ++lane)
          shares[lane] =
              photonWeight(block.reverseRatios[lane], mergeDensity,
                           absDot(block.direction(lane), region.normal) * INV_PI, settings.unknownWeight);
        return weight * Float8::load(shares);
      });
  counts.photonsFound += static_cast<uint64_t>(s.found);
  return Rgb(sum(s.power.x), sum(s.power.y), sum(s.power.z)) *
         (support.scale * INV_PI / (support.radius2 * support.fraction));
}

} // namespace recurse
