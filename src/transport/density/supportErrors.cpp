/** @file
 * Sums over photons for eight supports at once.
 */
#include "transport/density/supportErrors.h"

#include <bit>
#include <cfloat>

namespace recurse {

SupportErrors supportErrors(const PhotonMap& photons, GatherRegion region, Kernel kernel, float error,
                            BoundaryCorrection& boundary, const RayAlternative& byRays,
                            TransportCounts& counts) {
  constexpr size_t AREAS = SupportErrors::AREAS;
  const float recordRadius = region.radius;
  alignas(32) float inverse[AREAS], norm[AREAS];
  // Each support is reduced where its surface bends away, so that the last may not be the widest.
  GatherRegion widest{.radius = 0};
  for (size_t j = 0; j < AREAS; ++j) {
    region.radius = recordRadius * ofArea(j);
    const float covered = coveredFraction(boundary, error, kernel, region, counts);
    if (region.radius >= widest.radius) widest = region;
    const float radius2 = square(region.radius);
    inverse[j] = 1 / radius2;
    norm[j] = INV_PI / (radius2 * covered);
  }
  Float8 sum(0), variance(0), noise(0), rays(0);
  GatherRegion own = region;
  own.radius = recordRadius;
  const float rarest = byRays.maxBrightness * irradianceWithin(photons, own);
  withKernel(kernel, [&](auto k) {
    photons.visitWithin(widest, [&](const PhotonBlock& block) {
      alignas(32) float d2[8];
      block.distance2.store(d2);
      for (uint32_t slots = block.mask; slots != 0; slots &= slots - 1) {
        const int lane = std::countr_zero(slots);
        const float total = channelSum(block.power(lane));
        const Float8 q = Float8(d2[lane]) * Float8::load(inverse);
        const Float8 inside = less(q, Float8(1));
        const Float8 brings = (kernelShape<decltype(k)::value>(min(q, Float8(1))) & inside) *
                              Float8::load(norm) * Float8(total);
        const Float8 difference = brings - fromNextLane(brings);
        sum += brings;
        variance += brings * brings;
        noise += difference * difference;
        const float ratio = std::abs(block.reverseRatio(lane));
        const float density = ratio * absDot(block.direction(lane), region.normal) * INV_PI;
        rays += brings * Float8(std::min(total * byRays.emitted / std::max(density, FLT_MIN), rarest));
      }
    });
  });
  SupportErrors e;
  for (size_t j = 0; j < AREAS; ++j) {
    const int lane = static_cast<int>(j);
    e.variance[j] = double(variance[lane]);
    e.rays2[j] = double(rays[lane]);
    if (j + 1 == AREAS) break;
    e.noise[j] = double(noise[lane]);
    e.bias2[j] = square(double(sum[lane]) - double(sum[lane + 1])) - e.noise[j];
  }
  e.irradiance = double(sum[int(SupportErrors::OWN)]);
  return e;
}

} // namespace recurse
