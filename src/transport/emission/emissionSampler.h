/** @file
 * Starts of light paths: the one sampler of emission for photons, light subpaths and virtual lights.
 */
#pragma once

#include <optional>

#include "transport/direct/lightPortals.h"
#include "transport/emission/emissionGuide.h"
#include "transport/emission/emissiveMedia.h"
#include "transport/emission/pathEnds.h"
#include "transport/emission/photonAim.h"
#include "transport/paths/pathVertex.h"

namespace recurse {

/** What light paths start from, and what has been learned about useful starts. By default every light emits
 * by its own sampling, and lights are chosen by power. */
struct EmissionSettings {
  const LightTable* lights = nullptr;    ///< table from which lights are chosen; null: the scene's
  const EmissionGuide* guide = nullptr;  ///< density of useful starts; null: unguided
  const LightPortals* portals = nullptr; ///< openings that admit infinite lights; null: none known
  const PhotonAim* aim = nullptr;        ///< aim of lamps far from visible surfaces; null: unaimed
  const EmissiveMedia* media = nullptr;  ///< emissive media besides the lights; null: none
  uint16_t outside = 0;                  ///< index of the medium where paths of infinite lights start
  Rgb outsideTransmittance{1};           ///< transmittance from the infinite lights to those starts

  const LightTable& table(const Scene& scene) const { return lights ? *lights : scene.lights(); }
  bool isAimed(uint32_t light) const { return aim && aim->isAimed(light); }
  bool entersByPortals(const Light& light) const {
    return light.isInfinite() && portals && portals->active();
  }
  /** Densities with which a ray of the light with this index starts. The guide does not change them. */
  LePdf pdfLe(uint32_t index, const Light& light, const LeRay& ray) const;
};

/** Start of a light path. */
struct LightStart {
  LightSubpath path; ///< throughput: flux of the light over the density of the start [W]
  LightEnd end;      ///< its pdfNext is not set, because it depends on the first vertex; no light: a medium
  LePdf pdf;         ///< densities of the ray; 1 for a delta, as in LeSample
  float probability = 0; ///< of the choice of the light
};

/** Samples the starts of light paths. */
class EmissionSampler {
 public:
  EmissionSampler(const Scene& scene, const PathClasses& classes, const EmissionSettings& settings,
                  TransportCounts& counts)
      : scene(scene), classes(classes), settings(settings), counts(counts), mediaPart(partOfMedia()) {}

  /** Draws the random numbers of a start; the sample's weight is the inverse of their density. */
  EmissionGuide::TrainingSample draw(Sampler& sampler) const;
  /** Starts a path from a light or an emissive medium, by numbers of draw(). Returns false where nothing is
   * emitted. A guide divides the flux by its density, and leaves the other densities as they are. */
  bool start(const EmissionGuide::TrainingSample& sample, float time, Sampler& sampler,
             LightStart& start) const;

 private:
  bool fromLight(const EmissionGuide::Numbers& n, float time, Sampler& sampler, LightStart& start) const;
  void fromMedium(const EmissionGuide::Numbers& n, float time, LightStart& start) const;
  float partOfMedia() const;

  const Scene& scene;
  const PathClasses& classes;
  const EmissionSettings settings;
  TransportCounts& counts;
  float mediaPart; ///< fraction of the paths that emissive media start
};

/** Samples the start of one light path by the lights' own sampling, or by a guide; empty where nothing is
 * emitted. Emissive media start no paths here. */
std::optional<LightStart> startLightSubpath(const Scene& scene, const PathClasses& classes, float time,
                                            Sampler& sampler, TransportCounts& counts,
                                            const EmissionGuide* guide = nullptr);

} // namespace recurse
