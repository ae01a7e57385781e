/** @file
 * Forward pass: shoots photons into two maps. Emission and radii are learned in the first pass.
 */
#pragma once

#include <string>

#include "transport/density/gatherChoice.h"
#include "transport/density/radiusCache.h"
#include "transport/direct/directLight.h"
#include "transport/forward/photonGuidance.h"
#include "transport/weights/mergeWeights.h"

namespace recurse {

/** Mechanisms that a render can omit, to measure their effect. */
enum class Mechanism {
  NONE,
  LIGHT_LEARNING,  ///< lights and openings for shadow rays are sampled by position
  SHADOW_OPENINGS, ///< shadow rays to an environment go through openings
  SPLITTING,       ///< strong photons are stored as several weak ones
  JUDGED_RADII,    ///< radii of least expected error instead of the distance of the k-th photon
  MERGE_WEIGHTS    ///< photons and rays that find the same paths are weighted by their densities
};

struct PhotonPassSettings {
  uint64_t photons = 0; ///< photons emitted in each pass; 0: default number
  double alpha = 0;     ///< see radiusScale()
  int nearest = 0;      ///< photons of an estimate in the first pass; 0: default, or all within the radius
  double radius = 0;    ///< search radius [scene units]; 0: from the photon density
  int maxDepth = -1;
  bool directLight = false;  ///< photons carry direct light as well
  bool causticsOnly = false; ///< photons carry caustics only: delta events between light and surface
  bool guided = true;
  bool edges = true; ///< estimates are corrected where surfaces end
  float flatness = 0.2f;
  GatherWeighting weighting;
  Mechanism without = Mechanism::NONE;
  bool beams = false; ///< media store beams instead of points where possible
  Kernel kernel = Kernel::EPANECHNIKOV;
  PhotonIndexKind index = PhotonIndexKind::KDTREE;
};

/** Photons of one kind, with the settings and radii of their search. */
struct PhotonLayer {
  PhotonMap map;
  GatherChoice choice; ///< from the first pass
  RadiusCache cache;   ///< from the first pass
};

/** Photons in media: each medium has either points or beams. */
struct MediaPhotons {
  VolumePhotonMap points;
  PhotonBeamMap beams;

  size_t size() const { return points.size() + beams.size(); }
  size_t memoryBytes() const { return points.memoryBytes() + beams.memoryBytes(); }
};

/** Parameters of a photon search at a point. */
struct PhotonQuery {
  GatherSettings settings;
  CachedRadius cached;
  /** Irradiance by the layer and direct light at a record near by, sum of channels [W/m²]. */
  float expected = 0;
};

class PhotonPass {
 public:
  explicit PhotonPass(const PhotonPassSettings& settings) : settings(settings) {}

  /** Number of photons that a pass emits. */
  uint64_t photonCount(const Scene& scene, bool progressive) const;
  /** Shoots the photons and builds the maps; pass 0 also learns. */
  ForwardStatistics run(const Scene& scene, const PathClasses& classes, const Pass& pass,
                        const ForwardControl& control, const LightSampler& shadowRays);

  /** Calls `use` with the maps of `other`, a pass after the first, and then restores the maps. */
  ForwardStatistics with(const Pass& other, const Scene& scene, const PathClasses& classes,
                         const ForwardControl& control, const LightSampler& shadowRays,
                         const std::function<void()>& use);

  /** Photons that came through mirrors and glass only; with `directLight` also photons straight from the
   * lights. */
  const PhotonLayer& caustics() const { return causticLayer; }
  /** All other photons on surfaces. */
  const PhotonLayer& indirect() const { return indirectLayer; }
  /** Photons in media that have scattered at least once, and all from emissive media; with `directLight` all
   * photons in media. */
  const MediaPhotons& inMedia() const { return mediaPhotons; }
  /** Whether surfaces store fewer than MIN_MAP photons, or than one in MIN_STORED, in the first pass. */
  bool hasTooFewPhotons() const { return tooFew; }
  /** Relative variance of the caustics that one camera ray finds from a visible point; mean over all visible
   * points. */
  double causticVarianceByRays() const { return causticRays; }
  bool isProgressive() const { return progressive; }
  /** Search radius of this pass relative to the first pass. */
  float scale() const { return radiusOverFirst; }

  /** Densities of the emission of photons along a ray that a light emits. */
  LePdf pdfLe(uint32_t index, const Light& light, const LeRay& ray) const;
  /** Whether a finite light is so far from what camera paths meet that rays rarely hit it. */
  bool isFar(uint32_t light) const { return guidance.emission.isFar(light); }
  /** Probability that a photon starts at a light. */
  float probability(const Scene& scene, uint32_t light) const;
  /** MIS weight of a camera ray against caustic photons, where it has hit an area light through mirrors and
   * glass, or has left the scene towards an environment light. */
  float rayWeight(const Scene& scene, MergeRatio merge, const LightHit& found) const;
  /** Density of the photons that arrive at a point straight from a light, see arrivalDensity(). `pdf`: result
   * of pdfLe(); `cosine`: at the surface there; `chosen`: the light's probability for shadow rays. */
  float arrivals(const Scene& scene, uint32_t light, const LePdf& pdf, float cosine, float distance,
                 float chosen) const;

  /** Parameters of the search at a point. A single pass searches the nearest photons, or within a given
   * radius. One of many passes shrinks the radius that the first pass has learned there. */
  PhotonQuery query(const PhotonLayer& layer, const SurfacePoint& point, const Vec3f& wi) const;
  /** Weights photons of the indirect layer against the rays that the surface scatters, by the estimated
   * errors of both; `footprint`: width of a pixel [scene units]. */
  void weighAgainstRays(PhotonQuery& query, float footprint) const;
  /** Settings of a search whose radius in the first pass was `firstRadius` [scene units]. */
  GatherSettings searchWithin(const PhotonLayer& layer, float firstRadius) const;

  static constexpr uint64_t MIN_STORED = 1000;
  /** Minimum number of photons in a map. With fewer, an estimate by eight photons averages over a hundredth
   * of the lit area, a stain as wide as a wall. */
  static constexpr size_t MIN_MAP = 800;

 private:
  /** Whether photons are stored in media, and start in emissive media. */
  bool usesMedia(const Scene& scene) const { return scene.hasMedia() && !settings.causticsOnly; }
  /** Settings of a pass, by what is learned. */
  ShootSettings shootSettings(const Scene& scene, const LightSampler& shadowRays) const;
  void buildMaps(const Scene& scene, const Pass& pass, ShotPhotons shot, ForwardStatistics& statistics);
  /** Learns from trial photons, once for all passes, where photons start and which are stored. */
  void learnStarts(const Scene& scene, const PathClasses& classes, const Pass& pass,
                   const ForwardControl& control, const LightSampler& shadowRays,
                   ForwardStatistics& statistics);
  void learnGuidance(const Scene& scene, const PathClasses& classes, uint64_t seed,
                     const ShootSettings& shoot, const ForwardControl& control,
                     ForwardStatistics& statistics);
  /** Learned starts of photons at the lights. */
  EmissionSettings emission() const;
  /** Learns the medium around the scene, and its transmittance for infinite lights. */
  void learnOutsideMedium(const Scene& scene, ForwardStatistics& statistics);
  /** Selects the media that store beams, and the fractions of photons and beams to store. */
  void learnMedia(const Scene& scene, const PathClasses& classes, const Pass& pass, ShootSettings shoot,
                  const ForwardControl& control, ForwardStatistics& statistics);
  void learnRadii(const Scene& scene, const PathClasses& classes, const LightSampler& shadowRays, float time,
                  ForwardStatistics& statistics);
  /** Mean relative variance of the caustics that one camera ray finds, over visible points. */
  double causticVarianceAt(std::span<const VisiblePoint> seen) const;

  PhotonPassSettings settings;
  PhotonLayer causticLayer, indirectLayer;
  MediaPhotons mediaPhotons;
  KeptInMedia media;           ///< from the first pass
  uint16_t outside = 0;        ///< medium around the scene
  Rgb outsideTransmittance{1}; ///< transmittance of that medium for infinite lights
  EmissiveMedia emissiveMedia; ///< learned before the first pass, used in all
  PhotonGuidance guidance;     ///< learned before the first pass, used in all
  VisibleRegion region;        ///< learned before the first pass, used in all
  uint64_t emitted = 0;
  double causticRays = 0; ///< see causticVarianceByRays()
  bool progressive = false, tooFew = false;
  bool skipsEmission = false; ///< no photon can contribute: no visible surface gathers, none is stored
  float radiusOverFirst = 1;
};

} // namespace recurse
