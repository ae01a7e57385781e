/** @file
 * Parameter "maxdepth", which integrators share.
 */
#pragma once

#include "recurse/model/scene/plugIns.h"

namespace recurse {

/** Bound on the scattering events of `paths`, such as "a path"; -1, the default: no limit. */
inline ParameterSpec maxDepthParameter(const std::string& paths = "a path") {
  return integerParameter("maxdepth", "-1",
                          "maximum number of scattering events of " + paths + "; -1: no limit")
      .range(-1, 1e9);
}

} // namespace recurse
