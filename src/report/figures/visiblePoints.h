/** @file
 * Surface points that the middles of pixels see: figures of direct light sample light there, without any
 * other noise.
 */
#pragma once

#include <functional>
#include <vector>

#include "recurse/model/scene/scene.h"

namespace recurse {

/** Non-delta surface point seen from a pixel, directly or through mirrors and glass. */
struct ViewedPoint {
  Hit hit;
  const Bsdf* bsdf = nullptr; ///< in the arena of viewOfPixel()
  Vec3f wi{0};                ///< unit, back along the camera path
  Rgb weight{0};              ///< throughput from the camera
};

/** View of the middle of a pixel through the middle of the lens. */
struct PixelView {
  Rgb emission{0}; ///< light that the camera sees without non-delta scattering
  std::vector<ViewedPoint> points;
};

/**
 * Follows mirrors and glass by all their directions, up to MAX_DELTA_DEPTH events and down to
 * MIN_DELTA_WEIGHT. Media and priorities of dielectrics are ignored: see requireVisiblePoints().
 */
PixelView viewOfPixel(const Scene& scene, int x, int y, BsdfArena& arena);
constexpr int MAX_DELTA_DEPTH = 16;
constexpr float MIN_DELTA_WEIGHT = 0.01f;

/** Throws Error for scenes that viewOfPixel() does not follow. */
void requireVisiblePoints(const Scene& scene);

/** Calls use(pixel, view) for all pixels of the crop window, on all threads; `pixel` counts row by row. Skips
 * pixels once `stop` is true. */
void visitViews(const Scene& scene, const std::atomic<bool>& stop,
                const std::function<void(size_t pixel, const PixelView&)>& use);

/** Calls use(hit) for the emitting surfaces on the ray, up to the first that scatters, whose hit is returned;
 * and use(nullptr) if it leaves the scene. */
std::optional<Hit> followRay(const Scene& scene, Ray ray, const std::function<void(const Hit*)>& use);

/** Ray from a surface point to a light sample, or to infinity. Not occluded: the light is visible. */
Ray rayToLight(const SurfacePoint& from, const Vec3f& origin, const LiSample& light);

} // namespace recurse
