/** @file
 * First picture of a render, before the integrator has learned or shot anything.
 */
#pragma once

#include <atomic>
#include <functional>
#include <optional>

#include "apps/load/loadedScene.h"
#include "recurse/render/render.h"

namespace recurse::apps {

/** Limit of scattering events by an integrator's parameter "maxdepth"; -1: none. */
int maxDepthOf(const ParsedDirective& integrator);

/** Path tracer with lights selected by power, with at most `maxDepth` scattering events; -1: any number. */
std::unique_ptr<Integrator> pathTracerThatLearnsNothing(int maxDepth);

/** Film with one sample of each pixel, and the statistics of its render. */
struct FirstPicture {
  Film film;
  RenderStatistics statistics;
};

/**
 * Path classes of a first picture: `classes`, without the paths that the integrator leaves out. None for an
 * integrator of direct light only, which begins with its samples, and if a class would be empty.
 */
std::optional<PathClasses> firstPictureClasses(const LoadedScene& loaded, const PathClasses& classes);

/**
 * Renders one sample of each pixel by path tracing with lights selected by power, which learns nothing. Ends
 * early when `stop` becomes true, and at `timeLimit` [s; 0: none], see RenderSettings.
 */
FirstPicture renderFirstPicture(const LoadedScene& loaded, const PathClasses& classes, uint64_t seed,
                                double timeLimit, const std::atomic<bool>& stop,
                                const std::function<void(const RenderProgress&)>& progress);

} // namespace recurse::apps
