/** @file
 * Functions of exercise 1, the path tracer, whose bodies are gaps in pathTracer.cpp. Directions are in the
 * frame of the surface: z is the normal on the viewer's side.
 */
#pragma once

#include "frame/course.h"

namespace course::path {

/** Sampled direction. */
struct DirectionSample {
  Vec3f direction; ///< unit
  float pdf = 0;   ///< its density [1/sr]
};

/** Light at a smooth dielectric. */
struct Refraction {
  Vec3f direction;       ///< unit, behind the surface
  float reflectance = 0; ///< fraction that is reflected, of unpolarised light
};

Rgb emittedRadiance(const Rgb& lampRadiance, float cosLamp);                                   // gap 1
Rgb lambertianBsdf(const Rgb& albedo);                                                         // gap 2
DirectionSample sampleCosine(const Vec2f& u);                                                  // gap 3
Rgb scatteringWeight(const Rgb& bsdf, float cosine, float pdf);                                // gap 4
Rgb directLight(const Rgb& bsdf, const Rgb& lampRadiance, const Connection& c, float pdfArea); // gap 5
bool survivesRoulette(Rgb& throughput, float u);                                               // gap 6
Vec3f mirrored(const Vec3f& wo);                                                               // gap 7
std::optional<Refraction> refracted(const Vec3f& wo, float eta);                               // gap 8
float pdfSolidAngle(float pdfArea, float distance2, float cosLamp);                            // gap 9
float misWeight(float pdf, float otherPdf);                                                    // gap 9
float emissionWeight(bool lastWasDelta, float pdfRay, float pdfLamp);                          // gap 10

} // namespace course::path
