/** @file
 * Openings through which infinite lights enter a scene: boxes around vertices where camera paths leave the
 * scene, such as the panes of a window, and around crossings of such paths, such as a hole in a wall. Photons
 * of infinite lights start through these boxes rather than on the disc of the whole scene, of which a window
 * is a tiny part. The density of each ray is known, so that the estimate remains unbiased.
 */
#pragma once

#include <array>
#include <span>
#include <vector>

#include "recurse/core/math/float8.h"
#include "recurse/transport/integrator/integrator.h"
#include "transport/direct/nestedBoxes.h"

namespace recurse {

class LightPortals {
 public:
  /** Follows camera paths until they leave the scene, by scattering or towards a distant light, and encloses
   * their last vertices and the crossings of their last segments in boxes. Without infinite lights there are
   * no boxes. */
  void learn(const Scene& scene, uint64_t seed, TransportCounts& counts);
  /** Vertex where a camera path has left the scene, or the crossing of its last segment with such paths. */
  struct Exit {
    Vec3f position;
    float weight;
    Vec3f direction; ///< unit; (0, 0, 0) towards a distant light
    float along = 0; ///< distance from the last vertex [scene units]
  };
  /** Crossings of camera paths that leave the scene; their last vertices if too few cross; empty if too few
   * paths leave. The number of paths follows the pixels of the film, so that the time remains small. */
  static std::vector<Exit> crossings(const Scene& scene, uint64_t seed, TransportCounts& counts);
  bool active() const { return !boxes.empty(); }
  size_t size() const { return boxes.size(); }
  /** Area of the boxes' silhouettes relative to the scene's disc: estimated fraction of infinite lights that
   * enters, too large if boxes are behind each other. */
  float openPart() const;

  /** Replaces the origin and flux of an infinite light's sample, by numbers `pick` and `u` in
   * [0, 1). */
  void redirect(LeSample& sample, float pick, const Vec2f& u) const;
  /** Density of redirect()'s origins across unit `direction`, for the ray through `point` [1/area]. */
  float pdf(const Vec3f& point, const Vec3f& direction) const { return pdf(point, direction, nullptr); }

 private:
  /** Exits of `across`² camera paths. */
  static void findExits(const Scene& scene, const std::vector<size_t>& distant, int across, uint64_t seed,
                        std::vector<Exit>& exits, TransportCounts& counts);
  /** Exits of as many rounds of camera paths as needed to find openings. */
  static std::vector<Exit> exitsOf(const Scene& scene, const std::vector<size_t>& distant, int across,
                                   uint64_t seed, TransportCounts& counts);
  static void moveToCrossings(std::vector<Exit>& exits, uint64_t seed);
  /** Density of origins [1/area]; `met`: a box that the ray hits even if rounding denies it, or null. */
  float pdf(const Vec3f& point, const Vec3f& direction, const NestedBoxes::Box* met) const;
  /** Encloses the exits in boxes; no boxes if there are too few exits. */
  void enclose(const std::vector<Exit>& exits);

  /** Eight boxes, one in each SIMD lane. */
  struct BoxBlock {
    explicit BoxBlock(std::span<const NestedBoxes::Box> boxes);
    /** Density of the eight boxes [1/area]; `met`: mask of the lanes whose boxes the ray is known to hit. */
    float pdf(const Vec3f& point, const Vec3f& direction, uint32_t met) const;

    std::array<Float8, 3> lower, upper, sides; ///< areas of the sides across each axis
    Float8 chances;
  };

  NestedBoxes boxes;
  std::vector<BoxBlock> blocks; ///< `boxes` in groups of eight
  SceneBounds scene;
};

} // namespace recurse
