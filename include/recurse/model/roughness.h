/** @file
 * The roughness parameters that several materials share.
 */
#pragma once

#include <vector>

#include "recurse/scene/parameters.h"

namespace recurse {

inline void addRoughnessParameters(std::vector<ParameterSpec>& parameters) {
  for (const char* name : {"roughness", "uroughness", "vroughness"})
    parameters.push_back(
        realParameter(name, "0", "microfacet roughness; only 0, a smooth surface, is rendered today")
            .range(0, 1));
  parameters.push_back(
      ignoredParameter(ParameterType::BOOLEAN, "remaproughness", "a roughness of 0 stays 0"));
}

/** Says so when a rough surface is asked for. */
inline void refuseRoughness(const Parameters& p) {
  for (const char* name : {"roughness", "uroughness", "vroughness"})
    if (p.real(name) != 0) p.fail(name, "rough surfaces are not rendered yet", "0");
}

} // namespace recurse
