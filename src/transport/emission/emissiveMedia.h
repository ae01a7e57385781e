/** @file
 * Emissive media, and sampling of positions in them where photons start.
 */
#pragma once

#include <vector>

#include "recurse/transport/integrator/integrator.h"
#include "transport/paths/nesting.h"

namespace recurse {

/** Medium around the scene: the most frequent one in front of boundaries that axis-parallel rays into the
 * scene's bounding cube hit first. Without any, it is the camera's medium if the rays hit no boundary behind
 * opaque surfaces either, else a vacuum. */
uint16_t mediumOutside(const Scene& scene, TransportCounts& counts);

/** Emissive media of a scene. Positions are sampled by cells, in proportion to their probed emission. A
 * fraction is sampled uniformly, so that the density is positive where the probes missed emission. */
class EmissiveMedia {
 public:
  /** Probes the media as they are at `time`; `outside`: the medium around the scene. False if the probes of
   * an emissive medium find no emission. */
  bool learn(const Scene& scene, uint16_t outside, uint64_t seed, float time, TransportCounts& counts);
  bool empty() const { return sources.empty(); }
  /** Estimated power of all emissive media in their strongest channel [W]. */
  double power() const { return sources.empty() ? 0 : sources.back().powers; }

  /** Sampled position in an emissive medium. */
  struct Sample {
    Vec3f position{0};
    Nesting nesting; ///< nesting of a walk that starts there
    Rgb power{0};    ///< emission into all directions, divided by the density of the position [W]
    uint16_t medium = 0;
  };
  /** Samples a position by `choice` and `uPosition` in [0, 1); requires !empty(). The power is black where
   * the position has no emission. */
  Sample sample(const Scene& scene, float time, float choice, const Vec3f& uPosition,
                TransportCounts& counts) const;

 private:
  static constexpr int CELLS = 32; ///< cells along an axis
  static constexpr float EVEN_PART = 0.1f;

  struct Source {
    uint16_t medium = 0;
    Bounds3f whole;                 ///< bounds of the medium
    Bounds3f probed;                ///< bounds of the cells
    std::vector<double> cumulative; ///< cumulative probabilities of the cells
    double powers = 0;              ///< power of this source and those before it [W]
  };

  /** Power emitted by a unit of the medium's volume; black if the position is not in this medium. */
  Rgb emissionAt(const Scene& scene, uint16_t medium, const Vec3f& position, float time, Nesting& nesting,
                 TransportCounts& counts) const;
  /** Mean of emissionAt() in each cell of a box, in the strongest channel. */
  std::vector<double> probe(const Scene& scene, uint16_t medium, const Bounds3f& box, uint64_t seed,
                            float time, TransportCounts& counts) const;

  /** Shrinks `source.probed` to the emissive cells in a few rounds, and returns probe() of that box. */
  std::vector<double> probeCloser(const Scene& scene, Source& source, uint64_t seed, float time,
                                  TransportCounts& counts) const;

  uint16_t outside = 0;
  std::vector<Source> sources;
};

} // namespace recurse
