/** @file
 * Why a picture is black: probes by a few thousand rays, for messages.
 */
#pragma once

#include <atomic>
#include <string>

#include "apps/load/loadedScene.h"
#include "recurse/model/film/film.h"
#include "recurse/pathclasses/pathClasses.h"

namespace recurse::apps {

/** Longest time for all probes [s], and after a render that its time limit ended. */
constexpr double PROBE_SECONDS = 5, PROBE_SECONDS_OVERTIME = 0.5;

/** What keeps light from the camera, and what to do about it; empty where light reaches it, where the probes
 * do not show what is in the way, and where they take longer than a few seconds. */
std::string darknessReason(const LoadedScene& loaded);

/** The warning about a picture of these classes that is black or nearly black, or that lamps leave nearly
 * black while other lights do not. Empty where it is neither, and where `stop` becomes true or the probes
 * take longer. */
std::string blackPictureText(const LoadedScene& loaded, const PathClasses& classes, const Film& film,
                             const std::atomic<bool>& stop, double seconds = PROBE_SECONDS);

} // namespace recurse::apps
