/** @file
 * Functions of exercise 2, the photon mapper, whose bodies are gaps in photonMapper.cpp.
 */
#pragma once

#include <functional>

#include "frame/photonTree.h"

namespace course::photon {

/** Events of a photon since its emission. */
struct PhotonHistory {
  int specular = 0; ///< number of reflections and refractions by mirrors and glass
  int diffuse = 0;  ///< number of reflections by diffuse surfaces
};

/** Maps that store a photon. */
struct Maps {
  bool global = false, caustic = false;
};

/** Radiance that photons give a surface, towards the viewer. */
using Estimate = std::function<Rgb(const Surface&)>;

Rgb photonPower(const Rgb& lampRadiance, float cosine, float pdfArea, float pdfDirection,
                int photons);                                                                 // gap 1
Maps mapsOf(Surface::Kind kind, const PhotonHistory& history);                                // gap 2
bool survivesScattering(Rgb& power, const Rgb& reflectance, float u);                         // gap 3
bool visitsFarSide(float planeDistance, float radius2);                                       // gap 4
Rgb radianceEstimate(const std::vector<NearPhoton>& photons, float radius2, const Rgb& bsdf); // gap 5
float coneKernel(float distance2, float radius2);                                             // gap 6
Rgb directLight(const Rgb& bsdf, float cosine, const Rgb& radiance, float pdf);               // gap 7
Rgb finalGather(const Scene& scene, const Surface& surface, const Estimate& estimate, Sampler& sampler,
                TransportCounts& counts); // gap 8

} // namespace course::photon
