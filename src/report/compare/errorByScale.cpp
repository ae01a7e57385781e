/** @file
 * Error of a picture averaged over blocks, as seen from further away.
 */
#include <algorithm>
#include <cmath>
#include <limits>

#include "recurse/report/compare/compare.h"

namespace recurse {

namespace {

/** Sums over the pixels of a block. */
struct BlockSum {
  Rgbd toA{0}, toB{0}; ///< x − a, x − b
  Rgbd smooth{0};      ///< smoothed reference
  int pixels = 0;

  void add(const BlockSum& other) {
    toA += other.toA;
    toB += other.toB;
    smooth += other.smooth;
    pixels += other.pixels;
  }
};

/** Mean over the pixels of each 7x7 neighbourhood that are inside and finite. */
std::vector<Rgbd> smoothed(const Image& r) {
  constexpr int REACH = 3;
  std::vector<Rgbd> out(size_t(r.width) * size_t(r.height));
  for (int y = 0; y < r.height; ++y)
    for (int x = 0; x < r.width; ++x) {
      Rgbd sum{0};
      int count = 0;
      for (int j = std::max(0, y - REACH); j <= std::min(r.height - 1, y + REACH); ++j)
        for (int i = std::max(0, x - REACH); i <= std::min(r.width - 1, x + REACH); ++i) {
          const Rgb c = r.rgb(i, j);
          if (!isFinite(c)) continue;
          sum += Rgbd(c);
          ++count;
        }
      out[size_t(y) * size_t(r.width) + size_t(x)] = sum / double(std::max(count, 1));
    }
  return out;
}

double meanError(const std::vector<BlockSum>& blocks) {
  double sum = 0;
  size_t counted = 0;
  for (const BlockSum& block : blocks) {
    if (block.pixels == 0) continue;
    const double n = block.pixels;
    for (int c = 0; c < 3; ++c) {
      const double r = block.smooth[c] / n;
      sum += block.toA[c] * block.toB[c] / (n * n) / (r * r + REL_MSE_EPSILON) / 3;
    }
    ++counted;
  }
  return counted > 0 ? sum / double(counted) : std::numeric_limits<double>::quiet_NaN();
}

} // namespace

ByScale errorByScale(const Image& x, const Image& a, const Image& b, const Image& r) {
  int width = r.width, height = r.height;
  std::vector<BlockSum> blocks(size_t(width) * size_t(height));
  const std::vector<Rgbd> smooth = smoothed(r);
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i) {
      const Rgb vx = x.rgb(i, j), va = a.rgb(i, j), vb = b.rgb(i, j);
      if (!isFinite(vx) || !isFinite(va) || !isFinite(vb) || !isFinite(r.rgb(i, j))) continue;
      const size_t at = size_t(j) * size_t(width) + size_t(i);
      blocks[at] = {Rgbd(vx) - Rgbd(va), Rgbd(vx) - Rgbd(vb), smooth[at], 1};
    }
  ByScale out;
  for (size_t scale = 0; scale < out.size(); ++scale) {
    out[scale] = meanError(blocks);
    // Four blocks become one.
    const int w = width / 2, h = height / 2;
    std::vector<BlockSum> larger(size_t(w) * size_t(h));
    for (int j = 0; j < 2 * h; ++j)
      for (int i = 0; i < 2 * w; ++i)
        larger[size_t(j / 2) * size_t(w) + size_t(i / 2)].add(blocks[size_t(j) * size_t(width) + size_t(i)]);
    blocks = std::move(larger);
    width = w;
    height = h;
  }
  return out;
}

} // namespace recurse
