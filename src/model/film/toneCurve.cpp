/** @file
 * Statistics and blur for tone operators.
 */
#include "recurse/model/film/toneCurve.h"

#include <cmath>

#include "recurse/core/threads/parallel.h"

namespace recurse {

std::vector<float> luminances(const Image& picture) {
  const size_t stride = picture.channels.size();
  std::vector<float> out(size_t(picture.width) * size_t(picture.height));
  for (size_t i = 0; i < out.size(); ++i) {
    const float* p = &picture.pixels[i * stride];
    out[i] = luminance(Rgb(p[0], p[1], p[2]));
  }
  return out;
}

float luminanceQuantile(const Image& picture, double q) {
  std::vector<float> all = luminances(picture);
  if (all.empty()) return 0;
  const auto at = all.begin() + std::ptrdiff_t(q * double(all.size() - 1));
  std::nth_element(all.begin(), at, all.end());
  return *at;
}

namespace {

/** Right half of a Gaussian, centre included, not normalised; it ends at 3.5 standard deviations. */
std::vector<float> halfKernel(float sigma) {
  std::vector<float> half(size_t(std::ceil(3.5f * sigma)) + 1);
  for (size_t i = 0; i < half.size(); ++i) half[i] = std::exp(-0.5f * float(i * i) / (sigma * sigma));
  return half;
}

/** Blurs rows and transposes, so that two calls blur both axes. */
std::vector<float> blurredTransposed(const std::vector<float>& field, int width, int height,
                                     const std::vector<float>& half) {
  std::vector<float> out(field.size());
  const int reach = int(half.size()) - 1;
  parallelFor(size_t(height), [&](size_t y) {
    const float* row = &field[y * size_t(width)];
    for (int x = 0; x < width; ++x) {
      float sum = 0, weight = 0;
      for (int i = std::max(0, x - reach); i <= std::min(width - 1, x + reach); ++i) {
        const float w = half[size_t(std::abs(i - x))];
        sum += w * row[i];
        weight += w;
      }
      out[size_t(x) * size_t(height) + y] = sum / weight;
    }
  });
  return out;
}

std::vector<float> blurredDirectly(const std::vector<float>& field, int width, int height, float sigma) {
  const std::vector<float> half = halfKernel(sigma);
  return blurredTransposed(blurredTransposed(field, width, height, half), height, width, half);
}

/** Means of blocks of `factor` × `factor` pixels. */
std::vector<float> reduced(const std::vector<float>& field, int width, int height, int factor) {
  const int w = (width + factor - 1) / factor, h = (height + factor - 1) / factor;
  std::vector<float> out(size_t(w) * size_t(h));
  parallelFor(size_t(h), [&](size_t block) {
    const int y0 = int(block) * factor, y1 = std::min(height, y0 + factor);
    for (int x = 0; x < w; ++x) {
      const int x0 = x * factor, x1 = std::min(width, x0 + factor);
      float sum = 0;
      for (int y = y0; y < y1; ++y)
        for (int i = x0; i < x1; ++i) sum += field[size_t(y) * size_t(width) + size_t(i)];
      out[block * size_t(w) + size_t(x)] = sum / float((x1 - x0) * (y1 - y0));
    }
  });
  return out;
}

/** Bilinear interpolation between the centres of blocks. */
std::vector<float> enlarged(const std::vector<float>& blocks, int width, int height, int factor) {
  const int w = (width + factor - 1) / factor, h = (height + factor - 1) / factor;
  std::vector<float> out(size_t(width) * size_t(height));
  parallelFor(size_t(height), [&](size_t y) {
    const float v = std::clamp((float(y) + 0.5f) / float(factor) - 0.5f, 0.0f, float(h - 1));
    const int y0 = int(v), y1 = std::min(y0 + 1, h - 1);
    for (int x = 0; x < width; ++x) {
      const float u = std::clamp((float(x) + 0.5f) / float(factor) - 0.5f, 0.0f, float(w - 1));
      const int x0 = int(u), x1 = std::min(x0 + 1, w - 1);
      const auto at = [&](int i, int j) { return blocks[size_t(j) * size_t(w) + size_t(i)]; };
      const float upper = at(x0, y0) + (at(x1, y0) - at(x0, y0)) * (u - float(x0));
      const float lower = at(x0, y1) + (at(x1, y1) - at(x0, y1)) * (u - float(x0));
      out[y * size_t(width) + size_t(x)] = upper + (lower - upper) * (v - float(y0));
    }
  });
  return out;
}

} // namespace

std::vector<float> gaussianBlur(const std::vector<float>& field, int width, int height, float sigma) {
  if (!(sigma > 0)) return field;
  // A wide blur works on a reduced picture, in which sigma is at least 8 pixels.
  const int factor = int(sigma / 8);
  if (factor < 2) return blurredDirectly(field, width, height, sigma);
  const int w = (width + factor - 1) / factor, h = (height + factor - 1) / factor;
  // Blocks and interpolation add variances of 1/12 and 1/6 [blocks squared].
  const float rest = std::sqrt(square(sigma / float(factor)) - 0.25f);
  return enlarged(blurredDirectly(reduced(field, width, height, factor), w, h, rest), width, height, factor);
}

} // namespace recurse
