/** @file
 * The picture that is there before an integrator has learned or shot anything.
 */
#pragma once

#include <atomic>
#include <functional>
#include <optional>

#include "apps/load/loadedScene.h"
#include "recurse/render/render.h"

namespace recurse::apps {

/** Path tracing with lights chosen by power, of at most `maxDepth` scattering events; -1: any number. */
std::unique_ptr<Integrator> pathTracerThatLearnsNothing(int maxDepth);

/** A film with one sample of each pixel, and how it came about. */
struct FirstPicture {
  Film film;
  RenderStatistics statistics;
};

/**
 * The classes of paths of a first picture: `classes`, without the paths that the integrator leaves out. None
 * for an integrator of direct light only, which begins with its samples, and where nothing is left.
 */
std::optional<PathClasses> firstPictureClasses(const Integrator& integrator, const PathClasses& classes);

/**
 * One sample of each pixel by path tracing with lights chosen by power, which learns nothing. Ends early
 * when `stop` becomes true, and with `timeLimit` [s; 0: none] as RenderSettings has it.
 */
FirstPicture renderFirstPicture(const LoadedScene& loaded, const PathClasses& classes, uint64_t seed,
                                double timeLimit, const std::atomic<bool>& stop,
                                const std::function<void(const RenderProgress&)>& progress);

} // namespace recurse::apps
