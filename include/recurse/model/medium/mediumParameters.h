/** @file
 * Parameters of all media.
 */
#pragma once

#include <optional>

#include "recurse/model/medium/medium.h"
#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** Parameter Lescale as one number for the whole medium. */
ParameterSpec emissionScaleParameter();
/** Parameters sigma_a and sigma_s with these defaults, scale, Le, and the scale of Le. */
std::vector<ParameterSpec> mediumParameters(const std::string& absorption, const std::string& scattering,
                                            const ParameterSpec& emissionScale = emissionScaleParameter());
/** Factor of emitted radiance: Lescale; the largest one where the cells of a grid have one each. */
double emissionScale(const Parameters& p);
/** Medium described by the parameters; the `preset` of a homogeneous one applies if neither sigma_a nor
 * sigma_s is given. Throws SceneError for coefficients above 1e18. */
MediumPoint readMediumPoint(const Parameters& p);
/** Measured media by name [1/mm]; the scattering coefficient is reduced, for isotropic phase functions. */
std::vector<std::string> mediumPresetNames();
std::optional<MediumPoint> mediumPreset(const std::string& name);

} // namespace recurse
