/** @file
 * The photon mapping estimator, whose parts are in the files photonMapping*.cpp.
 */
#pragma once

#include "integrators/photonmap/photonMapping.h"
#include "integrators/photonmap/photonMappingPath.h"
#include "transport/density/irradianceCache.h"

namespace recurse {

/** See makePhotonMapping(). */
class PhotonMapping final : public PhotonMapper {
 public:
  PhotonMapping(const PhotonMappingSettings& settings, const LightSampler* learnedLights)
      : settings(settings), photons(settings), lights(learnedLights ? *learnedLights : ownLights) {}

  Passes passes(int /*samplesPerPixel*/) const override { return settings.passes; }
  uint64_t photonsEmitted(const Scene& scene) const override {
    return photons.photonCount(scene, settings.passes.schedule() != PassSchedule::ONE_MAP);
  }
  bool passHasOneTime() const override { return true; }
  void prepare(const Scene& scene, const PathClasses&) override;
  ForwardStatistics forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                            const ForwardControl& control) override;
  ForwardStatistics withPass(const Pass& other, const Scene& scene, const PathClasses& classes,
                             const ForwardControl& control, const std::function<void()>& use) override {
    return photons.with(other, scene, classes, control, lights, use);
  }
  const PhotonPass& photonPass() const override { return photons; }
  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler, PathRadiance& out) const override;
  std::vector<EstimatorDomain> domains() const override;
  bool supportsMedia(const Scene& scene) const override { return !hasMediaWithoutEnd(scene); }
  void visitPhotons(const std::function<void(const StoredPhoton&)>& visit) const override;

 private:
  /** Whether paths decide by themselves where to read the map of indirect light. */
  bool mayGoOn() const { return settings.finalGather < 0 && photons.isProgressive(); }

  // ----------------------------------------------------------------------------------------------- the path
  /** Follows a path to the end: emitted light, and at each surface what its lobes bring. */
  void trace(const Scene& scene, PathState path, Sampler& sampler, PathRadiance& out) const;
  /** Goes on by the delta lobes: every branch of a path from the camera while it is worth it, one by roulette
   * after. False where the path ends. */
  bool followDelta(const Scene& scene, PathState& path, const Hit& hit, const ScatteringPoint& scattering,
                   Sampler& sampler, PathRadiance& out) const;
  /** Light that non-delta lobes send along the path: direct, by photons, and by a ray that goes on. */
  void addNonDelta(const Scene& scene, PathState path, const Hit& hit, const ScatteringPoint& scattering,
                   Sampler& sampler, PathRadiance& out) const;
  /** The same where no photons are kept: by shadow rays, and by a ray that finds all other light. */
  void addByRays(const Scene& scene, PathState path, const Hit& hit, const ScatteringPoint& scattering,
                 Sampler& sampler, PathRadiance& out) const;
  /** Of the light that a whole path would find: what photons left to this one, at the most. What they leave
   * to rays alone counts in full, and each of fewer paths would be a firefly. */
  float partToFind(const PathState& path) const { return photons.leavesLightToRays() ? 1 : path.part; }
  /** Tells a recorder, where there is one, of the step to `next` from unit `wi`. */
  static void recordStep(const ScatteringPoint& scattering, const Vec3f& wi, const Scatter& s,
                         PathState& next, PathRadiance& out);
  /** Roulette at a non-delta surface, with the part of the light that is left to the path. */
  bool goesOn(PathState& path, Sampler& sampler) const;
  bool mayHitLight(const Scene& scene) const {
    return !settings.directLight && scene.contents().areaLights + scene.contents().environmentLights > 0;
  }

  // -------------------------------------------------------------------------------------------------- media
  /** Light that the medium on the way to `end` sends along the path, and what it takes off. False where
   * nothing is left. */
  bool passMedium(const Scene& scene, PathState& path, float end, Sampler& sampler, PathRadiance& out) const;
  /** Light that the medium scatters once more: direct by a shadow ray, other by photons along the way. */
  void addScattering(const Scene& scene, const PathState& path, uint16_t number, float end,
                     const RayTransmittance& transmittance, Sampler& sampler, PathRadiance& out) const;
  /** Light that photons in the medium bring along the path. */
  void addPhotonsAlong(const PathState& path, uint16_t number, const Medium& medium, float end,
                       const RayTransmittance& transmittance, const Rgb& throughput, CameraState camera,
                       PathRadiance& out) const;

  // ------------------------------------------------------------------------------------------------- lights
  void addEmission(const Scene& scene, const PathState& path, const Hit& hit, PathRadiance& out) const;
  void addEnvironment(const Scene& scene, const PathState& path, PathRadiance& out) const;
  /** Shadow rays. Photons may share what comes to the point through no pane. */
  void addDirectLight(const Scene& scene, const PathState& path, const LightSampleContext& context,
                      const PhotonShare& share, const Hit& hit, const ScatteringPoint& scattering,
                      Sampler& sampler, PathRadiance& out) const;
  /** Whether light that is met at once is shared with photons. */
  static bool isShared(const PathState& path) {
    return path.shared.share.merged > 0 && !path.delta && !path.panes;
  }
  void addShared(const Scene& scene, const PathState& path, uint32_t light, const LePdf& pdf,
                 const Rgb& radiance, float distance, PathRadiance& out) const;
  /** What light that is met shares with shadow rays: nothing from the camera on or after mirrors and glass.
   */
  BsdfRay directWeights(const PathState& path) const {
    return path.nonDelta == 0 || path.delta ? BsdfRay() : path.bsdfRay;
  }
  void addLight(const PathState& path, const Rgb& radiance, PathRadiance& out) const;

  // ------------------------------------------------------------------------------------------------ photons
  /** What part of the indirect light at the end of the path is read from the map. */
  void weighIndirect(const PathState& path, PhotonQuery& query) const;
  /** Adds what photons of a layer bring at a point. Returns their weights against rays that find the same
   * light. */
  GatherResult addPhotons(const Scene& scene, const PhotonLayer& layer, const IrradianceCache& cache,
                          const PhotonQuery& query, const ScatteringPoint& scattering,
                          const SurfacePoint& point, const PathState& path, const Sampler& sampler,
                          PathRadiance& out) const;
  /** Whether many rays ask for the irradiance at the record near by, and the photons' directions make no
   * difference. */
  bool hasRecord(const IrradianceCache& cache, const PhotonQuery& query, const ScatteringPoint& scattering,
                 const SurfacePoint& point, const PathState& path) const;
  /** How photons are searched at the record itself. */
  GatherSettings atRecord(const PhotonLayer& layer, const PhotonQuery& query) const;

  PhotonMappingSettings settings;
  PhotonPass photons;
  LightSampler ownLights;
  const LightSampler& lights;
  TransportCounts learned; ///< what learning lights took, until it has been told
  /** At the records of the layers, of this pass; empty where no rays go on. */
  IrradianceCache irradiances, causticIrradiances;
  Sampler recordSampler{0, 0, 0};
};

} // namespace recurse
