/** @file
 * Convolution with the glare by cosine transforms (FFTW), which imply that the picture continues mirrored
 * beyond its borders.
 */
#include "report/develop/bloom.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fftw3.h>

namespace recurse {

namespace {

struct FreeFftw {
  void operator()(double* memory) const { fftw_free(memory); }
};
using Field = std::unique_ptr<double, FreeFftw>;

Field makeField(size_t count) { return Field(fftw_alloc_real(count)); }

/** A cosine transform of both axes, in place. */
void transform(double* field, int width, int height, fftw_r2r_kind kind) {
  fftw_plan plan = fftw_plan_r2r_2d(height, width, field, field, kind, kind, FFTW_ESTIMATE);
  fftw_execute(plan);
  fftw_destroy_plan(plan);
}

/** Mean of the glare over a pixel at (x, y) pixels from the light. Near the light the glare varies within
 * a pixel, so that it is subsampled. */
double glareOfPixel(int x, int y, double degreesPerPixel) {
  const int parts = x + y == 0 ? 128 : std::max(x, y) < 8 ? 16 : 1;
  double sum = 0;
  for (int j = 0; j < parts; ++j)
    for (int i = 0; i < parts; ++i)
      sum += glareAt(degreesPerPixel * std::hypot(x + (i + 0.5) / parts - 0.5, y + (j + 0.5) / parts - 0.5));
  return sum / (parts * parts);
}

/** Glare of a picture's pixels on each other. */
struct Glare {
  Field transfer; ///< factor of each frequency of the picture; (width + 1) × (height + 1), 1 for the mean
  double ownPart = 1; ///< fraction of a pixel's light that stays in the pixel
};

Glare glareOf(int width, int height, double degreesPerPixel) {
  const size_t w = size_t(width) + 1, h = size_t(height) + 1;
  Glare out{makeField(w * h)};
  const Field& kernel = out.transfer;
  for (size_t y = 0; y < h; ++y)
    for (size_t x = 0; x < w; ++x) kernel.get()[y * w + x] = glareOfPixel(int(x), int(y), degreesPerPixel);
  const double own = kernel.get()[0];
  transform(kernel.get(), int(w), int(h), FFTW_REDFT00);
  const double sum = kernel.get()[0];
  for (size_t i = 0; i < w * h; ++i) kernel.get()[i] /= sum;
  out.ownPart = own / sum;
  return out;
}

} // namespace

double glareAt(double degrees) {
  const double t = degrees + 0.02;
  return 0.384 * 2.61e6 * std::exp(-degrees * degrees / (0.02 * 0.02)) + 0.478 * 20.91 / (t * t * t) +
         0.138 * 72.37 / (t * t);
}

double applyBloom(Image& picture, double amount, double degrees) {
  if (!(amount > 0)) return 1;
  const int width = picture.width, height = picture.height;
  const size_t stride = picture.channels.size(), count = size_t(width) * size_t(height);
  const Glare glare = glareOf(width, height, degrees / width);
  const Field light = makeField(count);
  const double scale = 1 / (4.0 * width * height); // normalises the two transforms
  for (size_t channel = 0; channel < 3; ++channel) {
    for (size_t i = 0; i < count; ++i) light.get()[i] = double(picture.pixels[i * stride + channel]);
    transform(light.get(), width, height, FFTW_REDFT10);
    for (size_t i = 0; i < count; ++i) {
      const size_t frequency = i / size_t(width) * (size_t(width) + 1) + i % size_t(width);
      light.get()[i] *= scale * (1 - amount + amount * glare.transfer.get()[frequency]);
    }
    transform(light.get(), width, height, FFTW_REDFT01);
    for (size_t i = 0; i < count; ++i) // negative values are rounding
      picture.pixels[i * stride + channel] = static_cast<float>(std::max(light.get()[i], 0.0));
  }
  return 1 - amount + amount * glare.ownPart;
}

} // namespace recurse
