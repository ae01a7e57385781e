/** @file
 * Files with pictures of all directions, in the common layouts.
 */
#pragma once

#include "lights/maps/environmentMap.h"
#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** Names of layouts, for the "mapping" of a light. */
const std::vector<std::string>& probeLayouts();

/** Reads the picture that the parameter "filename" names; negative values become 0, with a warning. Fails
 * where the file cannot be read or a value is not finite. */
Image readLightPicture(const Parameters& p);

/**
 * Reads the picture of "filename" in the layout of "mapping", or in the layout that its shape implies, with a
 * warning that names it. Light space has +z up. In a picture that shows the front, the middle faces -x and
 * the right faces -y, as in a latitude-longitude picture.
 */
EnvironmentMap readLightProbe(const Parameters& p);

} // namespace recurse
