/** @file
 * The forward pass and what it finds out once for all passes: photons in two maps, where they start, how far
 * to search.
 */
#pragma once

#include <string>

#include "transport/density/gatherChoice.h"
#include "transport/density/radiusCache.h"
#include "transport/forward/photonGuidance.h"
#include "transport/weights/mergeWeights.h"

namespace recurse {

/** What a render can leave out, to measure what it earns. */
enum class Mechanism {
  NONE,
  LIGHT_LEARNING,  ///< lights and openings for shadow rays are chosen by place
  SHADOW_OPENINGS, ///< shadow rays to an environment go through openings
  GUIDE,           ///< emission of photons follows useful trial photons
  TARGETS,         ///< DXTRAN spheres
  PORTALS,         ///< photons from far away start where camera paths see out
  AIM,             ///< photons of far lamps
  SPARSE_LIGHT,    ///< light whose photons are few and strong is left to rays
  SPLITTING,       ///< strong photons are stored as several weak ones
  JUDGED_RADII,    ///< radii of least expected error instead of the distance of the k-th photon
  MERGE_WEIGHTS    ///< photons and rays that find the same paths are weighed by their densities
};

struct PhotonPassSettings {
  uint64_t photons = 0; ///< in each pass; 0: chosen
  double alpha = 0;     ///< see radiusScale
  int nearest = 0;      ///< photons of an estimate in the first pass; 0: chosen, or all within the radius
  double radius = 0;    ///< 0: found out from the photons' density
  int maxDepth = -1;
  bool directLight = false;  ///< photons bring direct light as well
  bool causticsOnly = false; ///< nothing but what comes by mirrors and glass alone
  bool guided = true;
  bool edges = true; ///< estimates know where surfaces end
  float flatness = 0.2f;
  GatherWeighting weighting;
  Mechanism without = Mechanism::NONE;
  bool beams = false; ///< light in media is kept as beams where that is possible, not as points
  Kernel kernel = Kernel::EPANECHNIKOV;
  PhotonIndexKind index = PhotonIndexKind::KDTREE;
};

/** Photons of some kind, and how they are searched. */
struct PhotonLayer {
  PhotonMap map;
  GatherChoice choice; ///< from the first pass
  RadiusCache cache;   ///< from the first pass
};

/** Photons in media: of each medium either points or beams. */
struct MediaPhotons {
  VolumePhotonMap points;
  PhotonBeamMap beams;

  size_t size() const { return points.size() + beams.size(); }
  size_t memoryBytes() const { return points.memoryBytes() + beams.memoryBytes(); }
};

/** How photons are searched at a point. */
struct PhotonQuery {
  GatherSettings settings;
  CachedRadius place;
  float cost = 0; ///< of the search, about, over that of a camera path
};

class PhotonPass {
 public:
  explicit PhotonPass(const PhotonPassSettings& settings) : settings(settings) {}

  /** Photons that a pass emits. */
  uint64_t photonCount(const Scene& scene, bool progressive) const;
  /** Shoots and builds the maps; pass 0 learns too. */
  ForwardStatistics run(const Scene& scene, const PathClasses& classes, const Pass& pass,
                        const ForwardControl& control, const LightSampler& shadowRays);

  /** Calls `use` with the maps of another pass than the first in the place of these. */
  ForwardStatistics with(const Pass& other, const Scene& scene, const PathClasses& classes,
                         const ForwardControl& control, const LightSampler& shadowRays,
                         const std::function<void()>& use);

  /** Photons that nothing but mirrors and glass lies behind, and with `directLight` those straight from
   * lights. */
  const PhotonLayer& caustics() const { return causticLayer; }
  /** All others. */
  const PhotonLayer& indirect() const { return indirectLayer; }
  /** Those in media that have scattered before, and with `directLight` all. */
  const MediaPhotons& inMedia() const { return mediaPhotons; }
  /** Fewer than one in MIN_STORED photons of the first pass, or than MIN_MAP, came down on surfaces. */
  bool hasTooFewPhotons() const { return tooFew; }
  /** Relative variance of what one camera ray from each visible place finds of caustics, the mean over all.
   */
  double causticVarianceByRays() const { return causticRays; }
  bool isProgressive() const { return progressive; }
  bool hasEdges() const { return settings.edges; }
  /** Radius of this pass over that of the first. */
  float scale() const { return radiusOverFirst; }

  /** Densities of the emission of photons along a ray that a light emits. */
  LePdf pdfLe(uint32_t index, const Light& light, const LeRay& ray) const;
  /** A lamp far from what is seen, whose photons are aimed. */
  bool isAimed(uint32_t light) const { return aim.isAimed(light); }
  /** Whether some light starts too sparsely to be for photons. */
  bool leavesLightToRays() const { return guidance.sparsePart > 0; }
  /** Whether light straight from there to a surface is for rays alone; `pdf` as of pdfLe(). */
  bool isSparse(const Light& light, const LePdf& pdf) const {
    return light.isInfinite() && pdf.position < guidance.minStartDensity;
  }
  /** With which a photon comes from a light. */
  float probability(const Scene& scene, uint32_t light) const;
  /** The weight of a camera ray against caustic photons, where it has met an area light behind mirrors and
   * glass, or has left the scene and meets one of its environment. */
  float rayWeight(const Scene& scene, MergeRatio merge, const Hit& hit, const Vec3f& direction) const;
  float rayWeight(const Scene& scene, const MergeRatio& merge, size_t environment, const Ray& ray) const;
  /** How densely photons straight from a light arrive at a point, see arrivalDensity(): `pdf` as of pdfLe(),
   * `cosine` at the surface there, `chosen` the light's probability for shadow rays. */
  float arrivals(const Scene& scene, uint32_t light, const LePdf& pdf, float cosine, float distance,
                 float chosen) const;

  /** The only pass looks for the nearest photons, or within the radius it was given. One of many takes the
   * radius that the first pass found thereabouts, shrunk: its own photons have no say in it. */
  PhotonQuery query(const PhotonLayer& layer, const SurfacePoint& point, const Vec3f& wi,
                    LobeSet lobes) const;
  /** Weighs photons of the indirect layer against the rays that its surface sends on, by what is known of
   * both errors there; `footprint` is the width of a pixel. */
  void weighAgainstRays(PhotonQuery& query, float footprint) const;
  /** Whether to read the indirect layer takes less than to go on, for the variance that it saves. */
  bool paysInstead(const PhotonQuery& query) const {
    return !query.place.known || query.cost < indirectLayer.cache.place(query.place.index).worth.instead;
  }
  /** The search with such a radius of the first pass. */
  GatherSettings searchWithin(const PhotonLayer& layer, float firstRadius) const;

  static constexpr uint64_t MIN_STORED = 1000;
  /** Fewer photons in a map tell too little as well: an estimate by eight of them would average over a
   * hundredth of all that is lit, a stain as wide as a wall. */
  static constexpr size_t MIN_MAP = 800;

 private:
  void learnGuidance(const Scene& scene, const PathClasses& classes, uint64_t seed,
                     const ShootSettings& shoot, const ForwardControl& control,
                     ForwardStatistics& statistics);
  /** Adds what was learned, in words. */
  void noteGuidance(std::vector<std::string>& notes) const;
  /** Lights by the power that comes where photons are sent. */
  LightTable lightsByPower(const LightTable& lights) const;
  /** What light from infinitely far comes through before it reaches the scene. */
  void learnOutsideMedium(const Scene& scene, ForwardStatistics& statistics);
  /** Which media keep beams, and how many photons and beams to keep. */
  void learnMedia(const Scene& scene, const PathClasses& classes, const Pass& pass, ShootSettings shoot,
                  const ForwardControl& control, ForwardStatistics& statistics);
  void learnRadii(const Scene& scene, const PathClasses& classes, const LightSampler& shadowRays,
                  ForwardStatistics& statistics);
  /** Relative, of what one camera ray finds of caustics, the mean over visible places. */
  double causticVarianceAt(std::span<const VisiblePoint> seen) const;

  PhotonPassSettings settings;
  PhotonLayer causticLayer, indirectLayer;
  MediaPhotons mediaPhotons;
  KeptInMedia media;           ///< from the first pass
  uint16_t outside = 0;        ///< the medium around the scene
  Rgb outsideTransmittance{1}; ///< its transmittance
  EmissiveMedia emissiveMedia; ///< learned before the first pass, for all
  LightPortals portals;        ///< learned before the first pass, for all
  PhotonAim aim;               ///< learned before the first pass, for all
  LightTable lights;           ///< by what comes in
  PhotonGuidance guidance;     ///< learned before the first pass, for all
  VisibleRegion region;        ///< the same
  uint64_t emitted = 0;
  double causticRays = 0; ///< see causticVarianceByRays
  bool progressive = false, tooFew = false, causticsKnown = false;
  bool inVain = false; ///< the eye sees no surface that gathers photons, and the first pass kept none
  float radiusOverFirst = 1;
};

} // namespace recurse
