/** @file
 * Shares by the inverse of the expected squared error.
 */
#include "recurse/transport/gatherShare.h"

#include <cfloat>

#include "recurse/core/parallel.h"

namespace recurse {

namespace {

constexpr int PATHS = 4; ///< from each record
constexpr int NEIGHBOURS =
    64; ///< records that are judged together: a few paths alone do not show rare bright light
/** Squared relative error of a covered fraction that eight rays have found, which no pass makes smaller:
 * weighed as the variance of one of so many passes. */
constexpr double UNSURE_FRACTION = 0.01 * 32;
/** Relative variance in the first pass of what is seen as a stain after some fifty: five per cent. */
constexpr double VISIBLE_STAIN = 0.1;

struct Paths {
  double sum = 0, squares = 0;
};

} // namespace

void GatherShare::learn(const RadiusCache& cache, const SampleIrradiance& sample, TransportCounts& counts) {
  constexpr size_t AT_ONCE = 64;
  const size_t parts = (cache.size() + AT_ONCE - 1) / AT_ONCE;
  const auto forAll = [&](const auto& f) {
    parallelFor(parts, [&](size_t part) {
      for (size_t i = part * AT_ONCE; i < std::min(cache.size(), (part + 1) * AT_ONCE); ++i) f(part, i);
    });
  };
  std::vector<Paths> paths(cache.size());
  std::vector<TransportCounts> partCounts(parts);
  forAll([&](size_t part, size_t i) {
    if (cache.place(i).footprint == 0) return; // not seen, and read for other places only
    for (uint32_t n = 0; n < PATHS; ++n) {
      constexpr uint64_t STREAM = 0x5348415245ull; // not to be confused with samples of pixels and photons
      Sampler sampler(i, STREAM, n);
      const auto y = double(sample(cache.place(i), sampler, partCounts[part]));
      paths[i].sum += y / PATHS;
      paths[i].squares += y * y / PATHS;
    }
  });
  for (const TransportCounts& c : partCounts) counts.add(c);
  shares.assign(cache.size(), 1);
  forAll([&](size_t, size_t i) {
    const RadiusCache::Place& place = cache.place(i);
    thread_local PhotonScratch scratch;
    Paths all;
    double footprint = 0;
    int count = 0;
    cache.visitNeighbours(i, NEIGHBOURS, scratch, [&](size_t n) {
      if (cache.place(n).footprint == 0) return;
      all.sum += paths[n].sum;
      all.squares += paths[n].squares;
      footprint += double(cache.place(n).footprint);
      ++count;
    });
    if (count == 0) return;
    all.sum /= count;
    all.squares /= count;
    footprint /= count;
    const double ofPath = std::max(0.0, all.squares - square(all.sum));
    // All pixels of a kernel's support err alike, and err less than so many paths together would: as a stain,
    // if it is strong enough to be seen.
    const double pixels = std::max(1.0, M_PI * square(double(place.radius) / footprint));
    const double relative = double(place.variance) / std::max(square(all.sum), double(FLT_MIN));
    const double stain = 1 + (std::sqrt(pixels) - 1) * std::min(1.0, relative / VISIBLE_STAIN);
    double ofMap = stain * double(place.variance) + double(place.bias2);
    if (place.radius > place.around.flat) ofMap += UNSURE_FRACTION * square(all.sum);
    if (!(ofPath + ofMap > 0)) return;
    const double share = std::isfinite(ofMap) ? ofPath / (ofPath + ofMap) : 0;
    constexpr double NONE = 0.35, ALL = 0.65; // beyond, the second estimate costs more than it brings
    shares[i] = static_cast<float>(std::clamp((share - NONE) / (ALL - NONE), 0.0, 1.0));
  });
}

} // namespace recurse
