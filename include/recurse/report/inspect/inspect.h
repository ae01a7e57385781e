/** @file
 * Page that shows how light travels in a scene: the scene in 3D, the recorded paths of some pixels, and the
 * photons of a map.
 */
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recurse/core/image/image.h"
#include "recurse/render/recordPixels.h"
#include "recurse/report/inspect/formFactors.h"

namespace recurse {

/** Irradiance at the surface point in the middle of a pixel, from path tracing. */
struct ReferencePoint {
  int x = 0, y = 0;        ///< pixel
  Vec3f position{0};       ///< [scene units], relative to Scene::origin()
  Vec3f normal{0};         ///< geometric, unit, towards the camera
  uint32_t object = 0;     ///< see Scene::objectName()
  Rgb irradiance{0};       ///< [W/m²]
  float standardError = 0; ///< of the irradiance's luminance [W/m²]; infinite for one sample
  int64_t samples = 0;
};

/** Path classes with which pixels and light paths are recorded: those of the page, then one for each lamp and
 * one for each depth, from which the page takes the lamp of a path and the depth of a photon. */
struct InspectClasses {
  PathClasses classes;
  size_t shown = 0;               ///< number of classes of the page
  std::vector<std::string> lamps; ///< names of lamps; one alone has no class; empty: not known
  size_t depths = 0;              ///< the last is for all greater depths; 0: not known
};

/** Classes with as many lamps and depths as one automaton and a film of `pixels` pixels allow. Throws Error
 * like PathClasses. */
InspectClasses inspectClasses(const std::vector<PathClass>& shown, const Scene& scene,
                              const Integrator* integrator, size_t pixels);

/** Content of the page. */
struct Inspection {
  std::string title, label;          ///< scene, and settings of the render
  Image picture;                     ///< R, G, B of the crop window
  std::vector<RecordedPixel> pixels; ///< recorded with the classes of the page
  std::vector<std::string> notes;    ///< see recordNotes()
  std::vector<StoredPhoton> photons; ///< empty: the integrator has no photon map
  size_t photonsInMap = 0;           ///< number in the map, before thinning
  std::string photonName;            ///< see Integrator::photonName()
  size_t shownPhotons = 0;           ///< maximum number to show
  std::vector<PhotonBox> boxes;      ///< of the photon map's tree
  LightPathRecorder lightPaths{0};
  std::vector<ReferencePoint> references;
  std::vector<RadiosityPatch> patches; ///< empty: the integrator divides no surfaces
  std::vector<FormFactors> factors;    ///< parallel to `patches`
  uint32_t factorRays = 0;             ///< rays for each patch; 0: no form factors, see formFactorRays()
  std::vector<SurfaceKind> kinds; ///< parallel to `photons`, see surfaceKindsOf(); empty: all are the same
  size_t shownClasses = 0;        ///< see InspectClasses::shown; 0: all
  std::vector<std::string> lamps; ///< see InspectClasses
  size_t depths = 0;              ///< see InspectClasses
  bool isLive = false;            ///< the program serves the page, and answers referenceAt() for any point
};

/** Levels of Integrator::visitPhotonBoxes(): the last has up to 4096 boxes, enough for a clear picture. */
constexpr int BOX_LEVELS = 13;

/** Sentences about the light that the records of an integrator's paths lack, or suppose. */
std::vector<std::string> recordNotes(const Integrator& integrator);

/** At most `most` photons, evenly thinned from the map; their power is scaled to include the omitted ones.
 * Sets `inMap` to the number of photons in the map. */
std::vector<StoredPhoton> photonsOf(const Integrator& integrator, size_t most, size_t& inMap);

/** Kinds of the surfaces on which photons are; empty where the classes do not distinguish surfaces. */
std::vector<SurfaceKind> surfaceKindsOf(const Scene& scene, const PathClasses& classes,
                                        const std::vector<StoredPhoton>& photons);

/** Expression of the paths of `photonPaths` (see Integrator) in the classes of the photons: the first `shown`
 * classes, 0: all. The classes of a photon are those of its path continued by DE. Empty without photons, and
 * if a photon is in no class. `kinds`: see surfaceKindsOf(). */
std::string photonExpression(const PathClasses& classes, const std::vector<StoredPhoton>& photons,
                             const std::string& photonPaths, const std::vector<SurfaceKind>& kinds = {},
                             size_t shown = 0);

/**
 * Estimates the irradiance E = π L / ρ at Lambertian surfaces of albedo ρ from the radiance L of `samples`
 * camera rays through the middle of each pixel. `integrator`: prepared, and after its forward pass.
 * `classes`: one class, of the paths from the light to the camera that count. Pixels are left out whose first
 * surface is not Lambertian, has other lobes, a bump or normal map, or a black channel. The list is
 * empty for scenes with motion, media or thin panes, where photons carry other light than these paths.
 */
std::vector<ReferencePoint> referencePoints(const Scene& scene, const Integrator& integrator,
                                            const PathClasses& classes, std::span<const RecordedPixel> pixels,
                                            int64_t samples, uint64_t seed, const std::atomic<bool>& stop);

/** Does the same for any surface point, on the side of its unit normal, by rays against the normal. The
 * nearest surface along the normal is taken, up to 2 % of the scene's radius away: positions on a simplified
 * mesh are off it. Backs count as four times as far. Empty where no surface is near or it is not Lambertian,
 * or the light is not comparable. */
std::optional<ReferencePoint> referenceAt(const Scene& scene, const Integrator& integrator,
                                          const PathClasses& classes, const Vec3f& position,
                                          const Vec3f& normal, int64_t samples, uint64_t seed,
                                          const std::atomic<bool>& stop);

/** Reference point as the JSON of the page. */
std::string referenceText(const Scene& scene, const ReferencePoint& reference);

/** Self-contained page; a live one asks the program for references at clicked points. */
std::string inspectPage(const Scene& scene, const PathClasses& classes, const Inspection& inspection);

} // namespace recurse
