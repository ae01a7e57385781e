/** @file
 * References for `recurse converge` where none are given.
 */
#pragma once

#include <string>

#include "apps/options/renderOptions.h"
#include "recurse/report/converge/converge.h"

namespace recurse::apps {

struct ReferencePlan {
  double relMse = 1e-3; ///< target: upper end of the 95% interval of the mean's relMSE
  double seconds = 0;   ///< longest time for making them; 0: no limit
};

/**
 * Makes two independent references by the integrator `path`, or by `sppm` if the scene has light that path
 * never finds, with the options that are for all runs. They are kept in the folder as reference.exr, the mean
 * with layers a and b, and extended if they are not accurate enough yet. Throws Error (INTERRUPTED) on
 * Ctrl-C, and Error (BAD_USAGE) if the folder has references of a different scene or settings. Replaces the
 * integrator of `loaded`.
 */
References ownReferences(LoadedScene& loaded, const RenderOptions& options, const ReferencePlan& plan,
                         const std::string& sceneHash, const std::string& folder);

} // namespace recurse::apps
