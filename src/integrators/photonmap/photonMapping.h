/** @file
 * Estimators with photon maps, for the plug-ins that offer them under their names.
 */
#pragma once

#include <utility>

#include "integrators/photonmap/photonPass.h"
#include "recurse/scene/parameters/parameters.h"
#include "transport/learning/lightLearning.h"

namespace recurse {

struct PhotonMappingSettings : PhotonPassSettings {
  Passes passes = Passes::perSample();
  int lightSamples = 1;
  bool shareIrradiance = true; ///< the rays of final gathers read irradiance cached at records
  int finalGather =
      -1; ///< rays from a path's first non-delta surface; 0: none; -1: one, where it is more efficient
  float weightLimit = 0.01f;
};

/** Whether the medium around the scene is emissive and unbounded, so that no photons can start in it;
 * integrators with photon maps do not support such scenes. */
bool hasMediaWithoutEnd(const Scene& scene);
/** Whether no medium emits or scatters light. Camera paths find other light of media by photons, which carry
 * more than caustics. */
bool mediaOnlyAbsorb(const Scene& scene);

/** Integrator with photon maps, which also gives access to its photons, to judge their benefit. */
class PhotonMapper : public Integrator {
 public:
  /** `learnedLights`: has learned the scene; null: prepare() learns a light sampler. */
  PhotonMapper(const PhotonMappingSettings& settings, const LightSampler* learnedLights)
      : settings(settings), photons(settings), lights(learnedLights ? *learnedLights : ownLights) {}

  Passes passes(int /*samplesPerPixel*/) const override { return settings.passes; }
  uint64_t photonsEmitted(const Scene& scene) const override {
    return photons.photonCount(scene, settings.passes.schedule() != PassSchedule::ONE_MAP);
  }
  bool passHasOneTime() const override { return true; }
  bool supportsMedia(const Scene& scene) const override {
    return settings.causticsOnly ? mediaOnlyAbsorb(scene) : !hasMediaWithoutEnd(scene);
  }
  bool supportsTransient(const Scene& scene) const override { return !scene.hasEmissiveMedia(); }
  void prepare(const Scene& scene, const PathClasses&) override {
    learned = {};
    if (&lights == &ownLights && !settings.directLight && settings.without != Mechanism::LIGHT_LEARNING)
      learned = learnLights(scene, ownLights, settings.without != Mechanism::SHADOW_OPENINGS);
  }
  ForwardStatistics forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                            const ForwardControl& control) override {
    ForwardStatistics statistics = photons.run(scene, classes, pass, control, lights);
    statistics.counts.add(std::exchange(learned, {}));
    return statistics;
  }
  /** Photons of the latest forward(). */
  const PhotonPass& photonPass() const { return photons; }
  /** Calls `use` with the photons of `other`, a pass after the first, and then restores the photons. */
  ForwardStatistics withPass(const Pass& other, const Scene& scene, const PathClasses& classes,
                             const ForwardControl& control, const std::function<void()>& use) {
    return photons.with(other, scene, classes, control, lights, use);
  }
  /** Calls `use` while camera paths read the photons of caustics only, as with `causticsOnly`. */
  template <class Use> void readingCausticsOnly(const Use& use) {
    const bool before = std::exchange(settings.causticsOnly, true);
    use();
    settings.causticsOnly = before;
  }

 protected:
  PhotonMappingSettings settings;
  PhotonPass photons;
  LightSampler ownLights;
  const LightSampler& lights;
  TransportCounts learned; ///< counts of light learning, until forward() returns them
};

/** Photon mapping: emitted light, plus the photon maps' estimate at non-delta surfaces, plus mirror and
 * refracted light, recursively. With `causticsOnly` rays find all indirect light but caustics. `lights` has
 * learned the scene and must outlive the integrator; null: the integrator learns its own light sampler. */
std::unique_ptr<PhotonMapper> makePhotonMapping(const PhotonMappingSettings& settings,
                                                const LightSampler* lights = nullptr);
/** Settings with `causticsOnly`, and without settings that this excludes. */
PhotonMappingSettings onlyCaustics(PhotonMappingSettings settings);

/** Parameters of photonmap that other plug-ins share. */
std::vector<ParameterSpec> photonMappingParameters();
PhotonMappingSettings photonMappingSettings(const Parameters& parameters);

} // namespace recurse
