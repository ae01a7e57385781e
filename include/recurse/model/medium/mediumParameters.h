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
/** Medium described by the parameters, with the emission sigma_a · Le · emissionScale(). The `preset` of a
 * homogeneous medium, with millimetres as the scene unit, applies if neither sigma_a nor sigma_s is given.
 * Throws SceneError for coefficients or an emission above 1e18. */
MediumPoint readMediumPoint(const Parameters& p);
/** Names of measured media. */
std::vector<std::string> mediumPresetNames();
/** Measured medium [1/mm], without emission; scattering is reduced, for isotropic phase functions. Empty:
 * unknown name. */
std::optional<MediumPoint> mediumPreset(const std::string& name);

} // namespace recurse
