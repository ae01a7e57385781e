/** @file
 * Media that glow: places that photons start from.
 */
#pragma once

#include <vector>

#include "recurse/transport/integrator/integrator.h"
#include "transport/paths/nesting.h"

namespace recurse {

/** What is around a ray's origin, by the next boundary of a medium on its way; `outside` where there is
 * none. */
uint16_t mediumAround(const Scene& scene, Ray ray, uint16_t outside, TransportCounts& counts);

/** The medium around the scene: the one before most boundaries that are seen from far away, or the camera's
 * where none is. */
uint16_t mediumOutside(const Scene& scene, TransportCounts& counts);

/** The media of a scene that emit. Places are chosen by cells, in proportion to what probes have found there;
 * a part is spread evenly, so that what they have missed is found too. */
class EmissiveMedia {
 public:
  /** Probes them as they are at `time`; `outside`: the medium around the scene. False where one that is in
   * use glows nowhere. */
  bool learn(const Scene& scene, uint16_t outside, uint64_t seed, float time, TransportCounts& counts);
  bool empty() const { return sources.empty(); }
  /** What they emit, about, in the strongest channel [W]. */
  double power() const { return sources.empty() ? 0 : sources.back().powers; }

  /** A place that glows. */
  struct Sample {
    Vec3f position{0};
    Nesting nesting; ///< of a walk that starts there
    Rgb power{0};    ///< emitted there into all directions, over the density of the place [W]
  };
  /** `choice` and `place` in [0, 1). The power is black where nothing glows. */
  Sample sample(const Scene& scene, float time, float choice, const Vec3f& place,
                TransportCounts& counts) const;

 private:
  static constexpr int CELLS = 32; ///< along an axis
  static constexpr size_t CELL_COUNT = size_t(CELLS) * CELLS * CELLS;
  static constexpr float EVEN_PART = 0.1f;

  struct Source {
    uint16_t medium = 0;
    Bounds3f whole;                 ///< outside of it the medium is not
    Bounds3f probed;                ///< the box of the cells
    std::vector<double> cumulative; ///< probabilities of the cells
    double powers = 0;              ///< of this and the sources before it
  };

  /** What a unit of volume emits in the medium, if that is what lies there. */
  Rgb emissionAt(const Scene& scene, uint16_t medium, const Vec3f& position, float time, Nesting& nesting,
                 TransportCounts& counts) const;
  /** The mean of it in each cell of a box, in the strongest channel. */
  std::vector<double> probe(const Scene& scene, uint16_t medium, const Bounds3f& box, uint64_t seed,
                            float time, TransportCounts& counts) const;

  /** The same in the smallest box that some rounds of probes find around what glows: `source.probed`. */
  std::vector<double> probeCloser(const Scene& scene, Source& source, uint64_t seed, float time,
                                  TransportCounts& counts) const;

  uint16_t outside = 0;
  std::vector<Source> sources;
};

} // namespace recurse
