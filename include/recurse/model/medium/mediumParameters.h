/** @file
 * Parameters that all media share.
 */
#pragma once

#include <optional>

#include "recurse/model/medium/medium.h"
#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** Lescale, one number for all places. */
ParameterSpec emissionScaleParameter();
/** sigma_a and sigma_s with these defaults, scale, Le, and what scales that. */
std::vector<ParameterSpec> mediumParameters(const std::string& absorption, const std::string& scattering,
                                            const ParameterSpec& emissionScale = emissionScaleParameter());
/** Factor of emitted radiance: Lescale, and the largest where the cells of a grid have one each. */
double emissionScale(const Parameters& p);
/** The medium that they describe; `preset`, where it is declared and given, in the place of the first two.
 * Fails where the numbers do not fit single precision. */
MediumPoint readMediumPoint(const Parameters& p);
/** Measured matter by name [1/mm]; the scattering is reduced, for isotropic phase functions. */
std::vector<std::string> mediumPresetNames();
std::optional<MediumPoint> mediumPreset(const std::string& name);

} // namespace recurse
