/** @file
 * Cameras and pixel filters, and the settings that film and sampler directives stand for.
 */
#pragma once

#include <optional>
#include <string>

#include "recurse/core/math/animatedTransform.h"
#include "recurse/core/math/ray.h"
#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** What a camera ray is made from. */
struct CameraSample {
  Vec2f film;       ///< in pixels from the film's upper left corner
  Vec2f lens{0.5f}; ///< in [0, 1)²; the default is the middle
  float time = 0;   ///< Ray::time
};

/** A place of the lens, sampled for a point that it may see. */
struct WiSample {
  Vec2f film;      ///< where the point is seen [pixels]; may lie outside, from where filters still reach in
  Vec3f position;  ///< on the lens
  Vec3f direction; ///< unit, from the point to `position`
  float distance;  ///< between them
  /** Importance W_e of one pixel [1/(length² sr)]: W_e times the cosine at the lens, integrated over the rays
   * of a pixel, is 1. It is width · height · pdfPosition · pdfDirection / cosine of pdfWe(). */
  float importance;
  /** Density of `direction` [1/sr]. For a camera at a point its limit for a lens of unit area: what counts is
   * importance / pdf, the factor of radiance that leaves the point in `direction` over the density by solid
   * angle, and that of flux arriving at the point times the BSDF times its cosine. */
  float pdf;
};

/** Densities of a camera ray over the whole film, for film and lens places that are uniform. */
struct WePdf {
  float position = 0;  ///< of the origin [1/length²]; 1 where isDeltaPosition()
  float direction = 0; ///< given the origin [1/sr]; 1 where isDeltaDirection(); 0: not a ray of the camera
};

struct CameraContext {
  AnimatedTransform sceneFromCamera; ///< camera space looks along +z, x right, y up, as in pbrt
  double startTime = 0, endTime = 1; ///< of the motion: what Ray::time 0 and 1 stand for
  int width = 0, height = 0;         ///< of the whole film, before cropping
  double diagonal = 0.035;           ///< of the film, for cameras with a real one [m]
};

/** The shutter's parameters, which every camera takes. */
std::vector<ParameterSpec> shutterParameters();

class Camera {
 public:
  /** Fails where the shutter does not open. */
  Camera(const Parameters& p, const CameraContext& c);
  virtual ~Camera() = default;
  /** A ray whose radiance times its weight, averaged over a pixel's samples, is the pixel's value; none where
   * the light is stopped on its way through the lens. */
  virtual std::optional<CameraRay> sampleRay(const CameraSample& sample) const = 0;
  /** The same, and none where numbers at the edge of their range leave no ray that could be traced. */
  std::optional<CameraRay> validRay(const CameraSample& sample) const {
    constexpr float LARGEST = 1e18f; // squares must be finite
    std::optional<CameraRay> ray = sampleRay(sample);
    const auto within = [](const Vec3f& v) { return glm::all(glm::lessThan(magnitude(v), Vec3f(LARGEST))); };
    if (ray && !(within(ray->origin) && within(ray->direction))) ray.reset();
    return ray;
  }
  /** Whether CameraSample::lens makes a difference. */
  virtual bool usesLens() const { return false; }
  /** Whether the camera moves. */
  virtual bool usesTime() const { return false; }

  // The importance side, for paths that start at the lights and are connected to the eye.

  /** Whether sampleWi() and pdfWe() are there. */
  virtual bool isConnectable() const { return false; }
  /** All rays of a moment start at one point, which no path can meet by chance. */
  virtual bool isDeltaPosition() const { return false; }
  /** The rays of a moment are parallel. */
  virtual bool isDeltaDirection() const { return false; }
  /** The place of the lens that `lens` in [0, 1)² stands for, as seen from a point; none where no ray of the
   * camera comes from there. Not tested for what lies between. */
  virtual std::optional<WiSample> sampleWi(const Vec3f& /*point*/, const Vec2f& /*lens*/,
                                           float /*time*/) const {
    return {};
  }
  /** The densities with which sampleRay() gives a ray, which starts at the camera. */
  virtual WePdf pdfWe(const Ray& /*ray*/) const { return {}; }

  /** Ray::time at a part of the time, in [0, 1), that the shutter is open. */
  float timeAt(float part) const {
    return std::clamp(shutterOpen + part * (shutterClose - shutterOpen), 0.0f, 1.0f);
  }
  /** How long the shutter is open; a factor of the picture, as in pbrt-v4. */
  float exposureTime() const { return exposure; }

 private:
  float shutterOpen, shutterClose; ///< as Ray::time, but that they may lie before or after the motion
  float exposure;
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
  /** The filter's value at an offset from the pixel's centre, its integral being 1: what sample() samples. */
  virtual float value(const Vec2f& offset) const = 0;
  /** Half of its width and height [pixels]; value() is zero beyond. */
  virtual Vec2f radius() const = 0;
};

/** A rectangle of pixels: x0 <= x < x1, y0 <= y < y1. */
struct PixelBounds {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  size_t area() const { return size_t(width()) * size_t(height()); }
  /** The middle of a cell, where `across` x `across` of them cover these pixels [pixels of the film]. */
  Vec2f middleOfCell(int x, int y, int across) const {
    return {float(x0) + (float(x) + 0.5f) / float(across) * float(width()),
            float(y0) + (float(y) + 0.5f) / float(across) * float(height())};
  }
};

/** The Film directive. */
struct FilmSettings {
  int width = 1280, height = 720;
  PixelBounds crop; ///< the part that is rendered
  /** All pixels: what is learned of a scene goes by these, so that a crop is a part of the same picture. */
  PixelBounds whole() const { return {0, 0, width, height}; }
  std::string fileName;
  float imagingRatio = 1;  ///< pbrt's exposuretime · iso / 100, times the camera's exposure
  double diagonal = 0.035; ///< of a real film, for cameras with a lens system [m]
  /** The largest X, Y or Z that a sample may have, times imagingRatio; brighter ones are dimmed, as in pbrt.
   */
  float maxComponent = INFINITE;
  std::optional<Mat3f> whiteBalance; ///< of Rec. 709 colours; none: as they are
  bool layered = false;              ///< features of what is seen are asked for as well
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
