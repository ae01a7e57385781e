/** @file
 * Photons as records of the guide (Jensen 1995, "Importance Driven Path Tracing using the Photon Map"; Vorba
 * et al. 2014, "On-line Learning of Parametric Mixture Models for Light Transport Simulation").
 */
#pragma once

#include "recurse/transport/integrator/integrator.h"
#include "transport/forward/shootSettings.h"
#include "transport/guiding/guideField.h"

namespace recurse {

/**
 * Records of the photons of `pass` that rays of camera paths find better than shadow rays: all indirect
 * light, and caustics where a ray can hit their light. The flux that arrives in a cell
 * from a bin of directions is the integral of L cos over both, so that fluxes are the masses of a density
 * proportional to L cos. `shoot` says how many photons start, and where.
 */
std::vector<GuideRecord> photonRecords(const Scene& scene, const Pass& pass, const ShootSettings& shoot,
                                       const ForwardControl& control, TransportCounts& counts);

} // namespace recurse
