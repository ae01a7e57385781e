/** @file
 * Rays through the middles of pixels, and the surface points that they see: figures of direct light sample
 * light there, without any other noise.
 */
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <vector>

#include "recurse/core/sampling/sampler.h"
#include "recurse/model/bsdf/scatteringPoint.h"
#include "recurse/model/scene/scene.h"

namespace recurse {

/** Non-delta surface point seen from a pixel, directly or through mirrors and glass. */
struct ViewedPoint {
  Hit hit;
  const Bsdf* bsdf = nullptr; ///< valid within the call of visitViews()
  Vec3f wi{0};                ///< unit, back along the camera path
  Rgb weight{0};              ///< throughput from the camera
  Ray ray;                    ///< ray that hits it, from the camera or a mirror or glass
};

/** View of the middle of a pixel through the middle of the lens. */
struct PixelView {
  Rgb emission{0}; ///< light that the camera sees without non-delta scattering
  std::vector<ViewedPoint> points;
};

/** Throws Error for scenes with media, priorities of dielectrics, or no light. */
void requireVisiblePoints(const Scene& scene);

/** Ray through the middle of a pixel and of the lens, in the middle of the exposure. Empty: see
 * Camera::validRay(). */
std::optional<CameraRay> middleRay(const Scene& scene, int x, int y);

/** Calls use(pixel, ray) for the middle ray of each pixel of the crop window that has one, on all threads;
 * `pixel` counts row by row. Skips pixels once `stop` is true. */
void visitMiddleRays(const Scene& scene, const std::atomic<bool>& stop,
                     const std::function<void(size_t pixel, const CameraRay&)>& use);

/** Follows mirrors and glass by all their directions, up to MAX_DELTA_DEPTH events and down to
 * MIN_DELTA_WEIGHT. BSDFs of the view are in `arena`. */
PixelView viewAlong(const Scene& scene, const CameraRay& first, BsdfArena& arena);

/** Calls use(pixel, view) for the same pixels with the views along their middle rays. */
void visitViews(const Scene& scene, const std::atomic<bool>& stop,
                const std::function<void(size_t pixel, const PixelView&)>& use);
constexpr int MAX_DELTA_DEPTH = 16;
constexpr float MIN_DELTA_WEIGHT = 0.01f;

/** Calls use(hit) for the emitting surfaces on the ray, up to the first that scatters, whose hit is returned;
 * and use(nullptr) if it leaves the scene. */
std::optional<Hit> followRay(const Scene& scene, Ray ray, const std::function<void(const Hit*)>& use);

/** Light sample of a viewed point. */
struct ViewedLight {
  LiSample light;
  float density = 0;   ///< of the light and its sample [1/sr], or its probability
  Rgb contribution{0}; ///< unoccluded, to the pixel, times the density
};

/** Samples a light for next-event estimation. Empty: it contributes nothing. */
std::optional<ViewedLight> sampleLight(const Scene& scene, const ViewedPoint& visible,
                                       const ScatteringPoint& scattering, Sampler& sampler);

/** Whether a shadow ray from `origin`, near the point, is blocked. */
bool isBlocked(const Scene& scene, const SurfacePoint& from, const Vec3f& origin, const LiSample& light);

} // namespace recurse
