/** @file
 * Where light from infinitely far comes in: boxes around the places from which camera paths see out of the
 * scene, such as the panes of a window, and around those where such paths cross, such as a hole in a wall.
 * Photons of that light start through these boxes rather than over the whole scene's disc, of which a window
 * is a tiny part. Any ray's density is known, so that nothing becomes biased.
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
  /** Follows camera paths until they leave the scene, by chance or towards a light in one direction; without
   * effect where there is no light from infinitely far. What stands for a path is its last vertex, and where
   * other such paths come close to its last segment. */
  void learn(const Scene& scene, uint64_t seed, TransportCounts& counts);
  /** A place where a path has left the scene, or where others that have left cross it. */
  struct Exit {
    Vec3f position;
    float weight;
    Vec3f direction; ///< (0, 0, 0) towards a light in one direction
    float along = 0; ///< from its last vertex
  };
  /** Crossings of camera paths that leave the scene, of as many as a picture of so many pixels takes a small
   * part of the time for; none where too few do. */
  static std::vector<Exit> crossings(const Scene& scene, uint64_t seed, TransportCounts& counts);
  bool active() const { return !boxes.empty(); }
  size_t size() const { return boxes.size(); }
  /** Silhouettes of the boxes over the scene's disc: about what part of such light comes in, unless boxes lie
   * behind each other. */
  float openPart() const;

  /** Gives the sample of a light infinitely far another origin, from numbers in [0, 1), and the flux that
   * goes with it. */
  void redirect(LeSample& sample, float pick, const Vec2f& u) const;
  /** Density of such origins across unit `direction`, for the ray through `point` [1/length²]. */
  float pdf(const Vec3f& point, const Vec3f& direction) const { return pdf(point, direction, nullptr); }

 private:
  /** Exits of `across`² camera paths. */
  static void findExits(const Scene& scene, const std::vector<size_t>& distant, int across, uint64_t seed,
                        std::vector<Exit>& exits, TransportCounts& counts);
  /** Of as many as it takes to tell. */
  static std::vector<Exit> exitsOf(const Scene& scene, const std::vector<size_t>& distant, int across,
                                   uint64_t seed, TransportCounts& counts);
  static void moveToCrossings(std::vector<Exit>& exits, uint64_t seed);
  /** `met`: a box that the ray is known to meet, whatever rounding says. */
  float pdf(const Vec3f& point, const Vec3f& direction, const NestedBoxes::Box* met) const;
  /** Boxes around the exits; none where those are too few. */
  void enclose(const std::vector<Exit>& exits);

  /** Eight boxes side by side. */
  struct BoxBlock {
    explicit BoxBlock(std::span<const NestedBoxes::Box> boxes);
    /** What they add to the density; `met`: the lanes of boxes that the ray is known to meet. */
    float pdf(const Vec3f& point, const Vec3f& direction, uint32_t met) const;

    std::array<Float8, 3> lower, upper, sides; ///< areas of the sides across each axis
    Float8 chances;
  };

  NestedBoxes boxes;
  std::vector<BoxBlock> blocks; ///< the same
  SceneBounds scene;
};

} // namespace recurse
