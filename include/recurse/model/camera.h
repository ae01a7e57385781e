/** @file
 * Cameras and pixel filters, and the settings that film and sampler directives stand for.
 */
#pragma once

#include <string>

#include "recurse/core/ray.h"
#include "recurse/scene/parameters.h"

namespace recurse {

class Camera {
 public:
  virtual ~Camera() = default;
  /** The ray through a place of the film, in pixels from its upper left corner. */
  virtual EyeRay ray(const Vec2f& film) const = 0;
};

struct CameraContext {
  Mat4d sceneFromCamera{1};  ///< camera space looks along +z, x right, y up, as in pbrt
  int width = 0, height = 0; ///< of the whole film, before cropping
};

/** A filter sampled in proportion to its magnitude, so that every sample belongs to one pixel. */
class Filter {
 public:
  virtual ~Filter() = default;
  struct Sample {
    Vec2f offset; ///< from the pixel's centre, in pixels
    float weight; ///< value / density over its mean: 1 for filters without negative lobes
  };
  virtual Sample sample(const Vec2f& u) const = 0;
};

/** A rectangle of pixels: x0 <= x < x1, y0 <= y < y1. */
struct PixelBounds {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  size_t area() const { return size_t(width()) * size_t(height()); }
};

/** The Film directive. */
struct FilmSettings {
  int width = 1280, height = 720;
  PixelBounds crop; ///< the part that is rendered
  std::string fileName;
  float imagingRatio = 1; ///< pbrt's exposuretime · iso / 100
};

/** The pixels of a film whose centres' cells lie in a window given as parts of the whole, as pbrt rounds
 * them. */
inline PixelBounds cropOf(const FilmSettings& film, double x0, double x1, double y0, double y1) {
  const auto pixel = [](double part, int size) { return static_cast<int>(std::ceil(part * size)); };
  return {pixel(x0, film.width), pixel(y0, film.height), pixel(x1, film.width), pixel(y1, film.height)};
}

/** The Sampler directive: Recurse draws with its own sampler whatever the name, and takes the numbers. */
struct SamplerSettings {
  int pixelSamples = 16;
  uint64_t seed = 0;
};

struct NoContext {};

} // namespace recurse
