/** @file
 * Photons times BSDF times kernel, eight at a time where the BSDF is one constant.
 */
#include "recurse/transport/gather.h"

#include <cstring>

namespace recurse {

namespace {

/** Sums of photon power, one for each light-side state, as long as there is only one state at a time. */
class Estimate {
 public:
  Estimate(const ScatteringPoint& scattering, const SurfacePoint& point, const Vec3f& eye,
           const PathClasses& classes)
      : scattering(scattering), eye(eye), states(classes.lightStateCount()),
        lambertian((scattering.lobes() & LAMBERTIAN) && !(scattering.lobes() & TRANSMISSION)),
        shadingSide(glm::dot(scattering.normal(), eye) < 0 ? -scattering.normal() : scattering.normal()),
        bent(point.shadingNormal != point.geometricNormal) {
    for (size_t i = 0; i < states; ++i) sums[i] = BLACK;
  }

  /** Adds the found photons of a block, with kernel shape values in `shape`. */
  void add(const PhotonBlock& block, Float8 shape) {
    Float8 weight = block.found(shape);
    if (lambertian) {
      if (bent) { // light that arrives from behind the shading normal would leak
        const Vec3f8 d = unpackOctahedron(block.payload->direction);
        weight = weight & less(Float8(0), d.x * Float8(shadingSide.x) + d.y * Float8(shadingSide.y) +
                                              d.z * Float8(shadingSide.z));
      }
      if (states == 1 || uniform(block)) {
        Rgb& sum8 = sums[block.pathStates[0]];
        sum8 += Rgb(sum(block.red() * weight), sum(block.green() * weight), sum(block.blue() * weight));
        return;
      }
    }
    alignas(32) float w[8];
    weight.store(w);
    for (uint32_t rest = block.mask; rest != 0; rest &= rest - 1) {
      const int lane = std::countr_zero(rest);
      Rgb power = block.power(lane) * w[lane];
      if (!lambertian) power *= scattering.value(eye, block.direction(lane));
      sums[block.pathStates[lane]] += power;
    }
  }

  void addTo(PathRadiance& out, EyeState eyeState, const Rgb& scale) {
    // A Lambertian BSDF is the same for all photons: one evaluation straight out of the surface.
    const Rgb factor = lambertian ? scale * scattering.value(eye, shadingSide) : scale;
    for (size_t i = 0; i < states; ++i)
      if (!isBlack(sums[i])) out.add(LightState(static_cast<uint8_t>(i)), eyeState, sums[i] * factor);
  }

 private:
  static bool uniform(const PhotonBlock& block) {
    uint64_t eight;
    std::memcpy(&eight, block.pathStates, sizeof eight);
    return eight == (eight & 0xff) * 0x0101010101010101ull;
  }

  const ScatteringPoint& scattering;
  Vec3f eye;
  size_t states;
  bool lambertian;
  Vec3f shadingSide;
  bool bent;
  std::array<Rgb, 256> sums;
};

} // namespace

GatherResult gather(const PhotonMap& map, const GatherSettings& settings, const ScatteringPoint& scattering,
                    const SurfacePoint& point, const Vec3f& eye, float footprint, const Rgb& throughput,
                    EyeState eyeState, PathRadiance& out) {
  ++out.counts.gathers;
  GatherResult result;
  if (map.empty()) return result;
  GatherRegion region;
  region.center = point.position;
  region.normal = glm::dot(point.geometricNormal, eye) < 0 ? -point.geometricNormal : point.geometricNormal;
  region.radius = settings.radius;
  region.flatness = settings.flatness;
  region.bothSides = (scattering.lobes() & TRANSMISSION) != 0;

  Estimate estimate(scattering, point, eye, out.pathClasses());
  float radius2 = square(std::max(region.radius, footprint));
  const auto addBlock = [&](const PhotonBlock& block) {
    const Float8 q = min(block.distance2 / Float8(radius2), Float8(1));
    result.found += std::popcount(block.mask);
    withKernel(settings.kernel, [&](auto kernel) { estimate.add(block, kernelShape<kernel.value>(q)); });
  };

  thread_local PhotonScratch scratch;
  bool byNearest = false;
  if (settings.nearest > 0) {
    const NearestPhotons nearest = map.nearest(region, settings.nearest, scratch);
    if (nearest.count == settings.nearest && nearest.radius2 > square(footprint)) {
      // The disc ends at the k-th photon, which therefore does not count itself: E[(k - 1)/disc] is the
      // density.
      byNearest = true;
      radius2 = nearest.radius2;
      map.visitNearest(scratch, [&](PhotonBlock block) {
        block.mask &= bits(less(block.distance2, Float8(radius2)));
        if (block.mask != 0) addBlock(block);
      });
    } else if (nearest.count == settings.nearest) {
      radius2 = square(footprint);
    }
  }
  if (!byNearest) {
    region.radius = std::sqrt(radius2);
    map.visitWithin(region, addBlock);
  }
  out.counts.photonsFound += static_cast<uint64_t>(result.found);
  result.radius = std::sqrt(radius2);
  if (result.found > 0) estimate.addTo(out, eyeState, throughput * (INV_PI / radius2));
  return result;
}

} // namespace recurse
