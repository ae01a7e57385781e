/** @file
 * Files with pictures of all directions, in the layouts that are in use.
 */
#pragma once

#include "lights/maps/environmentMap.h"
#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** Names of layouts, for the "mapping" of a light. */
const std::vector<std::string>& probeLayouts();

/** Reads the picture that the parameter "filename" names; negative values become 0, with a warning. Fails
 * where it cannot be read or has values that are no numbers. */
Image readLightPicture(const Parameters& p);

/**
 * Reads the picture of "filename" in the layout that "mapping" names, or that its shape tells, with a warning
 * that says which. Light space has +z up; the middle of a picture that shows what is in front lies towards
 * -x, and what is to its right towards -y, as where a latitude-longitude picture has them.
 */
EnvironmentMap readLightProbe(const Parameters& p);

} // namespace recurse
