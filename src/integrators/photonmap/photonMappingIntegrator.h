/** @file
 * Photon mapping estimator, implemented in the files photonMapping*.cpp.
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
  bool supportsTransient(const Scene& scene) const override { return !scene.hasEmissiveMedia(); }
  void visitPhotons(const std::function<void(const StoredPhoton&)>& visit) const override;
  std::string photonPaths() const override { return settings.directLight ? "all" : "all - LDE"; }
  void visitPhotonBoxes(int levels, const std::function<void(const PhotonBox&)>& visit) const override;

 private:
  /** Whether each path chooses where to read the map of indirect light. */
  bool mayGoOn() const { return settings.finalGather < 0 && photons.isProgressive(); }

  // ----------------------------------------------------------------------------------------------- the path
  /** Follows a path to its end: adds emitted light, and at each surface the light of its lobes. */
  void trace(const Scene& scene, PathState path, Sampler& sampler, PathRadiance& out) const;
  /** Continues by the delta lobes: all branches of a path from the camera above the weight limit, otherwise
   * one by russian roulette. False if the path ends. */
  bool followDelta(const Scene& scene, const CameraWalker& walker, PathState& path,
                   const CameraVertex& vertex, Sampler& sampler, PathRadiance& out) const;
  /** Adds light that non-delta lobes scatter along the path: direct light, photons, and rays that go on. */
  void addNonDelta(const Scene& scene, const CameraWalker& walker, PathState path, const CameraVertex& vertex,
                   Sampler& sampler, PathRadiance& out) const;
  /** Adds light of non-delta lobes where no photons are stored: shadow rays, and a ray for other light. */
  void addByRays(const Scene& scene, const CameraWalker& walker, PathState path, const CameraVertex& vertex,
                 Sampler& sampler, PathRadiance& out) const;
  /** Records the step from a vertex to `next`, if there is a recorder. */
  static void recordStep(const CameraVertex& vertex, const Scatter& s, PathState& next, PathRadiance& out);
  /** Russian roulette at a non-delta surface, by the weight of the light that is left to the path. */
  bool goesOn(PathState& path, Sampler& sampler) const;
  bool mayHitLight(const Scene& scene) const {
    return !settings.directLight && scene.contents().areaLights + scene.contents().environmentLights > 0;
  }

  // -------------------------------------------------------------------------------------------------- media
  /** Adds the light of the medium `number` up to the distance `end` [scene units], and attenuates the path.
   */
  void passMedium(const Scene& scene, PathState& path, uint16_t number, float end, Sampler& sampler,
                  PathRadiance& out) const;
  /** Adds light that the medium scatters once more: direct light by shadow rays, other light by photons. */
  void addScattering(const Scene& scene, const PathState& path, uint16_t number, float end,
                     const RayTransmittance& transmittance, Sampler& sampler, PathRadiance& out) const;
  /** Adds the light of photons in the medium along the ray. */
  void addPhotonsAlong(const PathState& path, uint16_t number, const Medium& medium, float end,
                       const RayTransmittance& transmittance, const Rgb& throughput, CameraState camera,
                       PathRadiance& out) const;

  // ------------------------------------------------------------------------------------------------- lights
  void addEmission(const Scene& scene, const PathState& path, const Hit& hit, PathRadiance& out) const;
  void addEnvironment(const Scene& scene, const PathState& path, PathRadiance& out) const;
  /** Adds shadow rays. Light that arrives through no pane may be shared with photons. */
  void addDirectLight(const Scene& scene, const PathState& path, const LightSampleContext& context,
                      const PhotonShare& share, const CameraVertex& vertex, Sampler& sampler,
                      PathRadiance& out) const;
  /** Whether directly hit light is shared with photons. */
  static bool isShared(const PathState& path) {
    return path.shared.share.merged > 0 && !path.delta && !path.panes;
  }
  /** Adds light at the end of a path of optical `length`, shared with photons. */
  void addShared(const Scene& scene, const PathState& path, uint32_t light, const LePdf& pdf,
                 const Rgb& radiance, float distance, float length, PathRadiance& out) const;
  /** MIS weights of hit light against shadow rays: none from the camera or through mirrors and glass, where
   * no shadow rays find it. */
  BsdfRay directWeights(const PathState& path) const {
    return path.nonDelta == 0 || path.delta ? BsdfRay() : path.bsdfRay;
  }
  /** Adds light at the end of a path of optical `length` [scene units]. */
  void addLight(const PathState& path, LightState light, const Rgb& radiance, float length,
                PathRadiance& out) const;

  // ------------------------------------------------------------------------------------------------ photons
  /** Sets the fraction of the indirect light at the end of the path that is read from the map. */
  void weighIndirect(const PathState& path, PhotonQuery& query) const;
  /** Adds the estimate by the photons of a layer at a vertex. Returns their weights against rays that find
   * the same light. */
  GatherResult addPhotons(const Scene& scene, const PhotonLayer& layer, const IrradianceCache& cache,
                          const PhotonQuery& query, const CameraVertex& vertex, const PathState& path,
                          const Sampler& sampler, PathRadiance& out) const;
  /** Whether the cached irradiance of a record near by replaces a photon search: many rays use it, and the
   * photons' directions do not matter. */
  bool hasRecord(const IrradianceCache& cache, const PhotonQuery& query, const ScatteringPoint& scattering,
                 const SurfacePoint& point, const PathState& path) const;
  /** Settings of the photon search at the record itself. */
  GatherSettings atRecord(const PhotonLayer& layer, const PhotonQuery& query) const;

  PhotonMappingSettings settings;
  PhotonPass photons;
  LightSampler ownLights;
  const LightSampler& lights;
  TransportCounts learned; ///< counts of light learning, until forward() returns them
  /** Irradiance at the records of the layers in this pass; empty unless final gathers share it. */
  IrradianceCache irradiances, causticIrradiances;
  Sampler recordSampler{0, 0, 0};
};

} // namespace recurse
