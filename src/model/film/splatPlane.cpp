/** @file
 * Fixed-point sums of splats, and their moments.
 */
#include "recurse/model/film/splatPlane.h"

#include <atomic>
#include <bit>
#include <cmath>

#include "recurse/core/sampling/sampler.h"

namespace recurse {

namespace {

/** Largest absolute value of one contribution [units]. */
constexpr double LARGEST = 0x1p88;
/** Unit of sums of squares [units squared]. */
constexpr double SQUARE_SCALE = 0x1p57;
/** Largest square [SQUARE_SCALE]. The sum of 256 such squares is the first to overflow. */
constexpr double LARGEST_SQUARE = LARGEST * (LARGEST / SQUARE_SCALE);

/** Random key for the rounding of a contribution. */
uint64_t keyOf(uint64_t place, uint64_t index, double value) {
  return hashCombine(hashCombine(place, index), std::bit_cast<uint64_t>(value));
}

} // namespace

void SplatPlane::add(const Vec2f& film, const Filter& filter, uint64_t layerSet, const Rgb& value,
                     size_t extraLayer) {
  const Vec2f radius = filter.radius();
  // Pixels whose centres are no farther away than the filter's radius.
  const auto first = [](float place, float r, int from) {
    return std::max(static_cast<int>(std::ceil(place - r - 0.5f)), from);
  };
  const auto last = [](float place, float r, int end) {
    return std::min(static_cast<int>(std::floor(place + r - 0.5f)), end - 1);
  };
  // Positions far outside of the film would overflow an integer.
  if (!(film.x + radius.x >= float(bounds.x0) && film.x - radius.x <= float(bounds.x1) &&
        film.y + radius.y >= float(bounds.y0) && film.y - radius.y <= float(bounds.y1)))
    return;
  const uint64_t place = hashCombine(std::bit_cast<uint32_t>(film.x), std::bit_cast<uint32_t>(film.y));
  for (int y = first(film.y, radius.y, bounds.y0); y <= last(film.y, radius.y, bounds.y1); ++y)
    for (int x = first(film.x, radius.x, bounds.x0); x <= last(film.x, radius.x, bounds.x1); ++x) {
      const float weight = filter.value(film - Vec2f(x, y) - 0.5f);
      if (weight == 0) continue;
      const size_t pixel = size_t(y - bounds.y0) * size_t(bounds.width()) + size_t(x - bounds.x0);
      // Crops round as the whole picture does.
      const uint64_t here =
          hashCombine(place, hashCombine(static_cast<uint32_t>(x), static_cast<uint32_t>(y)));
      const auto addToLayer = [&](size_t layer) {
        const size_t index = (pixel * layers + layer) * 3;
        for (int c = 0; c < 3; ++c)
          if (value[c] != 0) {
            const double contribution = double(value[c]) * double(weight);
            addTo(sums[index + size_t(c)], contribution / unitOfSums, LARGEST,
                  keyOf(here, layer * 3 + size_t(c), contribution));
          }
      };
      for (uint64_t rest = layerSet; rest != 0; rest &= rest - 1)
        addToLayer(static_cast<size_t>(std::countr_zero(rest)));
      if (extraLayer != NO_LAYER) addToLayer(extraLayer);
      // Saturation is counted at the colours already, so that luminance is only clamped.
      const double units =
          std::clamp(double(recurse::luminance(value)) * double(weight) / unitOfSums, -LARGEST, LARGEST);
      addTo(moments[pixel].luminance, units, LARGEST, keyOf(here, ~uint64_t(0), units));
      addTo(moments[pixel].square, units * (units / SQUARE_SCALE), LARGEST_SQUARE,
            keyOf(here, ~uint64_t(1), units));
    }
}

void SplatPlane::addTo(WideSum& sum, double units, double largest, uint64_t key) {
  if (!(std::abs(units) <= largest)) {
    units = std::copysign(largest, units);
    std::atomic_ref(figures.saturated).fetch_add(1, std::memory_order_relaxed);
  }
  // A double of at least 2^52 has no fraction.
  if (std::abs(units) < 0x1p52)
    units = std::floor(units + double(unitFloat(static_cast<uint32_t>(key >> 32))));
  addAll(sum, WideSum(static_cast<Int128>(units)));
}

void SplatPlane::addAll(WideSum& sum, const WideSum& other) {
  if (!sum.addAtomically(other)) std::atomic_ref(figures.saturated).fetch_add(1, std::memory_order_relaxed);
}

void SplatPlane::addPaths(uint64_t count) {
  std::atomic_ref(figures.paths).fetch_add(count, std::memory_order_relaxed);
}

void SplatPlane::add(const SplatPlane& other) {
  for (size_t i = 0; i < sums.size(); ++i) addAll(sums[i], other.sums[i]);
  for (size_t i = 0; i < moments.size(); ++i) {
    addAll(moments[i].luminance, other.moments[i].luminance);
    addAll(moments[i].square, other.moments[i].square);
  }
  figures.add(other.figures);
}

void SplatPlane::addSums(const void* from, void* into, size_t count) {
  // Contributions are at most LARGEST: where a sum wraps around, the picture is useless in any case.
  for (size_t i = 0; i < count; ++i)
    static_cast<WideSum*>(into)[i].addAtomically(static_cast<const WideSum*>(from)[i]);
}

void SplatPlane::addFigures(const void* from, void* into, size_t count) {
  for (size_t i = 0; i < count; ++i) static_cast<Figures*>(into)[i].add(static_cast<const Figures*>(from)[i]);
}

void SplatPlane::clear() {
  std::fill(sums.begin(), sums.end(), WideSum());
  std::fill(moments.begin(), moments.end(), Moments());
  figures = {};
}

Rgb SplatPlane::value(size_t pixel, size_t layer) const {
  if (figures.paths == 0) return BLACK;
  const WideSum* sum = &sums[(pixel * layers + layer) * 3];
  return Rgb(Rgbd(double(sum[0]), double(sum[1]), double(sum[2])) * (unitOfSums / double(figures.paths)));
}

double SplatPlane::luminance(size_t pixel) const {
  return figures.paths == 0 ? 0 : double(moments[pixel].luminance) * (unitOfSums / double(figures.paths));
}

double SplatPlane::variance(size_t pixel) const {
  if (figures.paths < 2) return 0;
  const auto n = double(figures.paths), sum = double(moments[pixel].luminance);
  const double squares = double(moments[pixel].square) * SQUARE_SCALE;
  return std::max(0.0, squares - sum * sum / n) / (n * (n - 1)) * square(unitOfSums);
}

} // namespace recurse
