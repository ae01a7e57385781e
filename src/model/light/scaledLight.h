/** @file
 * Lights with a factor on their emission, as LightScale sets it.
 */
#pragma once

#include <memory>

#include "recurse/model/light/light.h"

namespace recurse {

/** The light with its emission multiplied; densities do not change. An environment light remains one. */
std::unique_ptr<Light> scaledLight(std::unique_ptr<Light> light, const Rgb& scale);
std::unique_ptr<AreaLight> scaledAreaLight(std::unique_ptr<AreaLight> light, const Rgb& scale);

} // namespace recurse
