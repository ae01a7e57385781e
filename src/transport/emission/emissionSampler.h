/** @file
 * Starts of light paths: the one sampler of emission for photons, light subpaths and virtual lights.
 */
#pragma once

#include <optional>

#include "transport/emission/emissionMixture.h"
#include "transport/emission/emissiveMedia.h"
#include "transport/emission/pathEnds.h"
#include "transport/paths/pathVertex.h"

namespace recurse {

/** Settings of the starts of light paths. By default every light emits by its own sampling, and lights are
 * chosen by power. */
struct EmissionSettings {
  const EmissionMixture* mixture = nullptr; ///< learned emission; null: none
  const EmissiveMedia* media = nullptr;     ///< emissive media besides the lights; null: none
  uint16_t outside = 0;                     ///< index of the medium where paths of infinite lights start
  Rgb outsideTransmittance{1};              ///< transmittance from the infinite lights to those starts

  bool isMixed() const { return mixture && mixture->active(); }
  const LightTable& table(const Scene& scene) const { return isMixed() ? mixture->lights() : scene.lights(); }
  /** Densities with which a ray of the light with this index starts. */
  LePdf pdfLe(uint32_t index, const Light& light, const LeRay& ray) const {
    return isMixed() ? mixture->pdfLe(index, ray) : light.pdfLe(ray);
  }
};

/** Start of a light path. */
struct LightStart {
  LightSubpath path;     ///< throughput: flux of the light over the density of the start [W]
  LightEnd end;          ///< `light` is null for a medium; pdfNext depends on the first vertex and is not set
  LePdf pdf;             ///< densities of the ray; 1 for a delta, as in LeSample; 0 for a medium
  float probability = 0; ///< of the choice among the lights; 0 for a medium
};

/** Samples the starts of light paths. */
class EmissionSampler {
 public:
  EmissionSampler(const Scene& scene, const PathClasses& classes, const EmissionSettings& settings,
                  TransportCounts& counts)
      : scene(scene), classes(classes), settings(settings), counts(counts), mediaPart(partOfMedia()) {}

  /** Starts a path from a light or an emissive medium. Returns false if the sample has no flux, or no path
   * class can use it; `start` is then invalid. */
  bool start(float time, Sampler& sampler, LightStart& start) const;

 private:
  bool fromLight(float time, Sampler& sampler, LightStart& start) const;
  void fromMedium(float time, Sampler& sampler, LightStart& start) const;
  float partOfMedia() const;

  const Scene& scene;
  const PathClasses& classes;
  const EmissionSettings settings;
  TransportCounts& counts;
  float mediaPart; ///< fraction of the paths that emissive media start
};

/** Samples the start of one light path by the lights' own sampling, or by a mixture; empty where nothing is
 * emitted. Emissive media start no paths here. */
std::optional<LightStart> startLightSubpath(const Scene& scene, const PathClasses& classes, float time,
                                            Sampler& sampler, TransportCounts& counts,
                                            const EmissionMixture* mixture = nullptr);

} // namespace recurse
