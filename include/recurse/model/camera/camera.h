/** @file
 * Cameras and pixel filters, and the settings of the film directive.
 */
#pragma once

#include <optional>
#include <string>

#include "recurse/core/math/animatedTransform.h"
#include "recurse/core/math/ray.h"
#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** Sample of a camera ray. */
struct CameraSample {
  Vec2f film;       ///< from the film's upper left corner [pixels]
  Vec2f lens{0.5f}; ///< in [0, 1)²; the default is the centre
  float time = 0;   ///< Ray::time
};

/** Point on the lens, sampled for a point that the camera may see. */
struct WiSample {
  Vec2f film;      ///< image of the point [pixels]; anywhere, since it is not limited to the film
  Vec3f position;  ///< on the lens
  Vec3f direction; ///< unit, from the point to `position`
  float distance;  ///< between the two points [scene units]
  /** Importance W_e of one pixel [1/(length² sr)]: W_e times the cosine at the lens, integrated over the rays
   * of a pixel, is 1. It equals width · height · pdfPosition · pdfDirection / cosine of pdfWe(). */
  float importance;
  /** Density of `direction` [1/sr]; for a pinhole, its limit for a lens of unit area; 1 for a delta
   * direction. Only importance / pdf matters: times the flux that arrives at the point, the BSDF and the
   * cosine for `direction`, it is the contribution to the pixel. */
  float pdf;
};

/** Densities of a camera ray over the whole film, for uniform film and lens samples. They continue beyond the
 * borders of the film. */
struct WePdf {
  float position = 0;  ///< of the origin [1/length²]; 1 where isDeltaPosition()
  float direction = 0; ///< given the origin [1/sr]; 1 where isDeltaDirection(); 0: not in front of the camera
};

/** Arguments of makers of cameras besides parameters. */
struct CameraContext {
  AnimatedTransform sceneFromCamera; ///< camera space looks along +z, x right, y up, as in pbrt
  double startTime = 0, endTime = 1; ///< times of the motion at which Ray::time is 0 and 1
  int width = 0, height = 0;         ///< resolution of the whole film, before cropping
  double diagonal = 0.035;           ///< diagonal of the film, for cameras with a physical one [m]
};

/** Name and shutter, the parameters of every camera. */
std::vector<ParameterSpec> cameraParameters();

/** Camera of a scene. Immutable; any thread may call it. */
class Camera {
 public:
  /** Throws SceneError unless the shutter closes after it opens. */
  Camera(const Parameters& p, const CameraContext& c);
  virtual ~Camera() = default;
  /** Samples a ray in the space of the scene, with all members but sampleSpacing, which the renderer sets.
   * Its radiance times its weight, averaged over a pixel's samples, is the value of the pixel. Empty: the ray
   * is blocked within the lens. */
  virtual std::optional<CameraRay> sampleRay(const CameraSample& sample) const = 0;
  /** sampleRay(), but empty also where the origin or direction is NaN or too large to be traced. */
  std::optional<CameraRay> validRay(const CameraSample& sample) const {
    constexpr float LARGEST = 1e18f; // squares must be finite
    std::optional<CameraRay> ray = sampleRay(sample);
    const auto within = [](const Vec3f& v) { return glm::all(glm::lessThan(magnitude(v), Vec3f(LARGEST))); };
    if (ray && !(within(ray->origin) && within(ray->direction))) ray.reset();
    return ray;
  }
  /** Whether rays depend on CameraSample::lens. */
  virtual bool usesLens() const { return false; }
  /** Whether the camera moves. */
  virtual bool usesTime() const { return false; }

  // Importance functions, for light paths that are connected to the camera.

  /** Whether sampleWi() and pdfWe() are implemented. */
  virtual bool isConnectable() const { return false; }
  /** True where all rays of one time start at one point, which no path can hit. */
  virtual bool isDeltaPosition() const { return false; }
  /** True where all rays of one time are parallel. */
  virtual bool isDeltaDirection() const { return false; }
  /** Samples the lens by `lens` in [0, 1)² as seen from a point; empty where the point is behind the lens.
   * Neither visibility nor the borders of the film are tested. */
  virtual std::optional<WiSample> sampleWi(const Vec3f& /*point*/, const Vec2f& /*lens*/,
                                           float /*time*/) const {
    return {};
  }
  /** Densities in sampleRay() of one of its rays. */
  virtual WePdf pdfWe(const Ray& /*ray*/) const { return {}; }

  /** Ray::time at a fraction, in [0, 1), of the exposure, clamped to [0, 1]. */
  float timeAt(float exposureFraction) const {
    return std::clamp(shutterOpen + exposureFraction * (shutterClose - shutterOpen), 0.0f, 1.0f);
  }
  /** Duration of the exposure [time of TransformTimes]; scales the image, as in pbrt-v4. */
  float exposureTime() const { return exposure; }

 private:
  float shutterOpen, shutterClose; ///< [Ray::time]; may lie outside of [0, 1], before or after the motion
  float exposure;
};

/** Pixel filter. It is sampled, so that every sample belongs to one pixel. */
class Filter {
 public:
  virtual ~Filter() = default;
  struct Sample {
    Vec2f offset; ///< from the centre of the pixel [pixels]
    float weight; ///< value() / density, mean 1; always 1 for filters without negative lobes
  };
  /** Samples an offset with a density in proportion to the magnitude of value(), by u in [0, 1)². */
  virtual Sample sample(const Vec2f& u) const = 0;
  /** Filter value at an offset from the pixel's centre, with integral 1; it may be negative. */
  virtual float value(const Vec2f& offset) const = 0;
  /** Half of the width and height of the support [pixels]; value() is zero beyond. */
  virtual Vec2f radius() const = 0;
};

/** A rectangle of pixels: x0 <= x < x1, y0 <= y < y1. */
struct PixelBounds {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  size_t area() const { return size_t(width()) * size_t(height()); }
  /** Centre of cell (x, y) where `across` x `across` cells cover these pixels [pixels of the film]. */
  Vec2f middleOfCell(int x, int y, int across) const {
    return {float(x0) + (float(x) + 0.5f) / float(across) * float(width()),
            float(y0) + (float(y) + 0.5f) / float(across) * float(height())};
  }
};

/** Settings of the Film directive. */
struct FilmSettings {
  int width = 1280, height = 720;
  PixelBounds crop = whole(); ///< pixels that are rendered
  /** All pixels: learning uses these, so that a crop is a part of the same image. */
  PixelBounds whole() const { return {0, 0, width, height}; }
  std::string fileName;    ///< file of the picture; the command line may replace it
  float imagingRatio = 1;  ///< pbrt's exposuretime · iso / 100; in a scene, times Camera::exposureTime()
  double diagonal = 0.035; ///< of a physical film, for cameras with a lens system [m]
  /** Limit of X, Y and Z of a camera path, each times imagingRatio, before white balance; brighter ones are
   * scaled down to it, as in pbrt. Splats of light paths are not limited. */
  float maxComponent = INFINITE;
  std::optional<Mat3f> whiteBalance; ///< of Rec. 709 colours; none: no white balance
  bool layered = false;              ///< true: feature layers are requested as well
};

/** Pixels of a film within a crop window given by fractions of width and height; bounds are rounded up, as in
 * pbrt. */
inline PixelBounds cropOf(const FilmSettings& film, double x0, double x1, double y0, double y1) {
  const auto pixel = [](double part, int size) { return static_cast<int>(std::ceil(part * size)); };
  return {pixel(x0, film.width), pixel(y0, film.height), pixel(x1, film.width), pixel(y1, film.height)};
}

/** Context of plug-ins that need parameters only. */
struct NoContext {};

} // namespace recurse
