/** @file
 * Reasons for black pictures: probes by a few thousand rays, for messages.
 */
#pragma once

#include <atomic>
#include <string>

#include "apps/load/loadedScene.h"
#include "recurse/model/film/film.h"
#include "recurse/pathclasses/pathClasses.h"

namespace recurse::apps {

/** Longest time for all probes [s]: in general, and after a render that its time limit has ended. */
constexpr double PROBE_SECONDS = 5, PROBE_SECONDS_OVERTIME = 0.5;

/** Reason why no light reaches the camera, and a remedy; empty if light reaches it, if the probes do not find
 * the reason, and if they take longer than a few seconds. */
std::string darknessReason(const LoadedScene& loaded);

/** Warning about a picture of these classes that is black or nearly black, or that lamps leave nearly black
 * while infinite lights do not. Empty if it is neither, if `stop` becomes true, and if the probes take longer
 * than `seconds`. */
std::string blackPictureText(const LoadedScene& loaded, const PathClasses& classes, const Film& film,
                             const std::atomic<bool>& stop, double seconds = PROBE_SECONDS);

} // namespace recurse::apps
