/** @file
 * Photon mapping estimator, and the parameters of its plug-ins.
 */
#pragma once

#include <utility>

#include "integrators/photonmap/photonMappingPath.h"
#include "integrators/photonmap/photonPass.h"
#include "recurse/scene/parameters/parameters.h"
#include "transport/density/irradianceCache.h"
#include "transport/learning/lightLearning.h"

namespace recurse {

struct PhotonMappingSettings : PhotonPassSettings {
  Passes passes = Passes::perSample();
  int lightSamples = 1;
  bool shareIrradiance = true; ///< the rays of final gathers read irradiance cached at records
  int finalGather =
      -1; ///< rays from a path's first non-delta surface; 0: none; -1: one, where it is more efficient
  float weightLimit = 0.001f;
};

/** Whether the medium around the scene is emissive and unbounded, so that no photons can start in it;
 * integrators with photon maps do not support such scenes. */
bool hasMediaWithoutEnd(const Scene& scene);
/** Whether no medium emits or scatters light. Camera paths find other light of media by photons, which carry
 * more than caustics. */
bool mediaOnlyAbsorb(const Scene& scene);

/** Estimates at a non-delta vertex, against which the rays that leave it are weighted. */
struct VertexEstimates {
  bool byRays = false;           ///< no photons are stored there
  LightSampleContext context;    ///< context that the shadow rays are sampled with
  PhotonShare direct;            ///< share of photons in the light that shadow rays sample
  float directWeight = 0;        ///< PathState::remainingWeight without the weight of `direct`
  float causticMergeDensity = 0; ///< merge density of caustic photons, see MergeRatio
  bool weighsIndirect = false;   ///< see GatherSettings::weighedAgainstRays
  GatherResult indirect;         ///< weights of the photons of indirect light
};

/** Photon mapping: emitted light, plus the photon maps' estimate at non-delta surfaces, plus mirror and
 * refracted light, recursively. With `causticsOnly` rays find all indirect light but caustics. */
class PhotonMapping final : public Integrator {
 public:
  /** `learnedLights`: has learned the scene; null: prepare() learns a light sampler. */
  explicit PhotonMapping(const PhotonMappingSettings& settings, const LightSampler* learnedLights = nullptr)
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
  TransportCounts prepare(const Scene& scene, const PathClasses&) override {
    if (&lights != &ownLights || settings.directLight || settings.without == Mechanism::LIGHT_LEARNING)
      return {};
    return learnLights(scene, ownLights, settings.without != Mechanism::SHADOW_OPENINGS);
  }
  const LightSampler& lightSampler() const { return lights; }
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
  ForwardStatistics forward(const Scene& scene, const PathClasses& classes, const Pass& pass,
                            const ForwardControl& control) override;
  void backward(const Scene& scene, const CameraRay& ray, Sampler& sampler, PathRadiance& out) const override;
  std::vector<EstimatorDomain> domains() const override;
  void visitPhotons(const std::function<void(const StoredPhoton&)>& visit) const override;
  std::string photonPaths() const override {
    return settings.causticsOnly ? "LS+DE" : settings.directLight ? "all" : "all - LDE";
  }
  void visitPhotonBoxes(int levels, const std::function<void(const PhotonBox&)>& visit) const override;

 private:
  /** Whether each path chooses where to read the map of indirect light. */
  bool mayGoOn() const { return settings.finalGather < 0 && photons.isProgressive(); }

  /** Adds the estimators in media to domains(). */
  void addMedia(std::vector<EstimatorDomain>& all) const;

  // ----------------------------------------------------------------------------------------------- the path
  /** Follows a path to its end: adds emitted light, and at each surface the light of its lobes. */
  void trace(const Scene& scene, PathState path, Sampler& sampler, PathRadiance& out) const;
  /** Continues by the delta lobes: before the first non-delta vertex by all, if each is above the weight
   * limit; otherwise by one, chosen at random, with Russian roulette. Returns false if the path ends. */
  bool followDelta(const Scene& scene, const CameraWalker& walker, PathState& path,
                   const CameraVertex& vertex, Sampler& sampler, PathRadiance& out) const;
  /** Adds light that non-delta lobes scatter along the path: direct light, photons where they are stored, and
   * rays that go on. */
  void addNonDelta(const Scene& scene, const CameraWalker& walker, PathState path, const CameraVertex& vertex,
                   Sampler& sampler, PathRadiance& out) const;
  /** Adds the estimates by both photon maps at a vertex. Sets their weights in `at`. */
  void addFromMaps(const Scene& scene, const PathState& path, const CameraVertex& vertex,
                   const Sampler& sampler, VertexEstimates& at, PathRadiance& out) const;
  /** Continues by a non-delta lobe, for the light that the estimates at the vertex leave to rays. */
  void followNonDelta(const Scene& scene, const CameraWalker& walker, const PathState& path,
                      const CameraVertex& vertex, const VertexEstimates& at, Sampler sampler,
                      PathRadiance& out) const;
  /** Records the step from a vertex to `next`, if there is a recorder. */
  static void recordStep(const CameraVertex& vertex, const Scatter& s, PathState& next, PathRadiance& out);
  bool mayHitLight(const Scene& scene) const {
    return !settings.directLight && scene.contents().areaLights + scene.contents().environmentLights > 0;
  }

  // -------------------------------------------------------------------------------------------------- media
  /** Adds light of the medium `number` up to the distance `end` [scene units]; attenuates the path. */
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
  /** Adds the emission of a surface, or of the environment lights if `hit` is null. */
  void addEmission(const Scene& scene, const PathState& path, const Hit* hit, PathRadiance& out) const;
  /** Adds shadow rays. Light that arrives through no pane may be shared with photons. */
  void addDirectLight(const Scene& scene, const PathState& path, const LightSampleContext& context,
                      const PhotonShare& share, const CameraVertex& vertex, Sampler& sampler,
                      PathRadiance& out) const;
  /** Whether directly hit light is shared with photons. */
  static bool isShared(const PathState& path) {
    return path.weights.shared.share.merged > 0 && !path.delta && !path.panes;
  }
  /** Adds light that a path has found, shared with photons. */
  void addShared(const Scene& scene, const PathState& path, const LightHit& found, PathRadiance& out) const;
  /** MIS weights of hit light against shadow rays: none from the camera or through mirrors and glass, where
   * no shadow rays find it. */
  BsdfRay directWeights(const PathState& path) const {
    return path.nonDelta == 0 || path.delta ? BsdfRay() : path.weights.bsdfRay;
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

  /** Irradiance at the records of the layers in this pass; empty unless final gathers share it. */
  IrradianceCache irradiances, causticIrradiances;
  Sampler recordSampler{0, 0, 0};

  PhotonMappingSettings settings;
  PhotonPass photons;
  LightSampler ownLights;
  const LightSampler& lights;
};

/** Settings with `causticsOnly`, and without settings that this excludes. */
PhotonMappingSettings onlyCaustics(PhotonMappingSettings settings);

/** Parameters of photonmap that other plug-ins share. */
std::vector<ParameterSpec> photonMappingParameters();
PhotonMappingSettings photonMappingSettings(const Parameters& parameters);

} // namespace recurse
