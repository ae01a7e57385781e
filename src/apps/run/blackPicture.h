/** @file
 * Why a picture is black: probes by a few thousand rays, for messages.
 */
#pragma once

#include <string>

#include "apps/load/loadedScene.h"
#include "recurse/model/film/film.h"
#include "recurse/pathclasses/pathClasses.h"

namespace recurse::apps {

/** True where no pixel has light, or fewer than one in a thousand. */
bool isNearlyBlack(const Film& film);

/** What keeps light from the camera, and what to do about it; empty where light reaches it, or where the
 * probes do not show what is in the way. */
std::string darknessReason(const LoadedScene& loaded);

/** What a warning about a black or nearly black picture of these classes says. */
std::string blackPictureText(const LoadedScene& loaded, const PathClasses& classes, const Film& film);

} // namespace recurse::apps
