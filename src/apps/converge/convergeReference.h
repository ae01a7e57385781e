/** @file
 * References for `recurse converge` where none are given.
 */
#pragma once

#include <string>

#include "apps/options/renderOptions.h"
#include "recurse/report/converge/converge.h"

namespace recurse::apps {

struct ReferencePlan {
  double relMse = 1e-3; ///< to stop at: upper end of the interval of 95% of their mean's
  double seconds = 0;   ///< longest time for making them; 0: no limit
};

/**
 * Two independent references by the integrator `path`, or by `sppm` where the scene has light that path never
 * finds, with the options that are for all runs. They are kept
 * in the folder as reference.exr, the mean with layers a and b, and gone on with where they are not good
 * enough yet. Throws Error (INTERRUPTED) when Ctrl-C ends it, and Error (BAD_USAGE) where the folder has
 * references of something else. The scene's integrator is another one afterwards.
 */
References ownReferences(LoadedScene& loaded, const RenderOptions& options, const ReferencePlan& plan,
                         const std::string& sceneHash, const std::string& folder);

} // namespace recurse::apps
