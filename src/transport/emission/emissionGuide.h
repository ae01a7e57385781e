/** @file
 * Importance sampling of photon emission. The density of the random numbers of a photon's start is learned
 * from trial photons that hit visible surfaces. Division by the density keeps the estimate unbiased.
 */
#pragma once

#include <array>
#include <span>
#include <unordered_map>
#include <vector>

#include "recurse/core/math/vector.h"

namespace recurse {

/** Region where the camera reads the photon map, as hashed cells of a few sizes. */
class VisibleRegion {
 public:
  /** Adds at least all points within `size` > 0 [scene units] of the position. */
  void add(const Vec3f& position, float size);
  bool contains(const Vec3f& position) const { return importance(position) > 0; }
  /** Visible-point density on surfaces [1/area]; 0 outside of the region. */
  float importance(const Vec3f& position) const { return surfaces.importance(position); }
  /** Adds a point in a medium with a weight. Its density is per area perpendicular to the camera rays. */
  void addInMedium(const Vec3f& position, float size, float weight);
  float importanceInMedium(const Vec3f& position) const { return media.importance(position); }
  bool empty() const { return surfaces.empty() && media.empty(); }

 private:
  class Cells {
   public:
    void add(const Vec3f& position, float size, float weight);
    float importance(const Vec3f& position) const;
    bool empty() const { return weights.empty(); }

   private:
    static uint64_t key(int level, const Vec3f& position);
    std::unordered_map<uint64_t, float> weights;
    std::vector<int> levels; ///< cells of side 2^level
  };
  Cells surfaces, media;
};

/**
 * Density over the unit cube of the random numbers of a photon's start. It is constant in the leaves of a
 * tree, which splits where trial photons are unevenly distributed. A photon of density q carries 1/q of its
 * flux without the guide.
 */
class EmissionGuide {
 public:
  /** Dimensions: the light (1), the part of the light (1), the position (2), the direction (2). */
  static constexpr size_t DIMENSIONS = 6;
  using Numbers = std::array<float, DIMENSIONS>;
  struct TrainingSample {
    Numbers numbers;
    float weight; ///< squared contribution, divided by the density of the sample
  };

  /** Guide with the uniform density 1. */
  EmissionGuide() = default;
  /**
   * Learns the density from the photons with a contribution among `trials`. The density of least variance is
   * proportional to √p, where p is the mean squared contribution. A tenth of it remains uniform, because
   * photons may contribute where no trial did. `lights` lights share the first dimension.
   */
  EmissionGuide(std::span<const TrainingSample> useful, double trials, size_t lights = 1);

  /** Expected variance without the guide over the variance with it; 1 without a guide. */
  double gain() const { return expectedGain; }
  bool active() const { return leaves.size() > 1; }
  /** Transforms uniform numbers to the learned density, and returns that density. `choice` is an additional
   * number in [0, 1). */
  float warp(Numbers& numbers, float choice) const;

 private:
  static constexpr double UNIFORM_PART = 0.1;
  struct Node { ///< numbers[dimension] < at: the next node, else `other`; dimension is -1 in leaves
    int dimension;
    float at;
    uint32_t other; ///< in leaves: index of the leaf
  };
  struct Leaf {
    Numbers low, high;
    double density; ///< density with the uniform part
    double chance;  ///< cumulative probability in the guided part: this leaf and all before it
  };
  void split(std::span<TrainingSample> useful, const Numbers& low, const Numbers& high, double trials,
             int depth);

  std::vector<Node> nodes;
  std::vector<Leaf> leaves;
  size_t lights = 1;
  double expectedGain = 1;
};

} // namespace recurse
