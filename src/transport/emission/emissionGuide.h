/** @file
 * Photons sent where the picture needs them: the density of the numbers that photons start by, learned from
 * trial photons that came down where the eye looks. Weights keep the result unbiased.
 */
#pragma once

#include <array>
#include <span>
#include <unordered_map>
#include <vector>

#include "recurse/core/math/vector.h"

namespace recurse {

/** The places that the eye reads the photon map at, as cells of a few sizes. */
class VisibleRegion {
 public:
  /** Everything within `size` > 0 of the position [scene units] belongs to it, and some more. */
  void add(const Vec3f& position, float size);
  bool contains(const Vec3f& position) const { return importance(position) > 0; }
  /** How many of the added places lie there in so much of a surface; 0 outside. */
  float importance(const Vec3f& position) const { return surfaces.importance(position); }
  /** The same of places in media, in so much of what lies across the rays. */
  void addInMedium(const Vec3f& position, float size, float weight);
  float importanceInMedium(const Vec3f& position) const { return media.importance(position); }
  bool empty() const { return surfaces.empty() && media.empty(); }
  /** What was added on surfaces. */
  const std::vector<Vec3f>& all() const { return places; }

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
  std::vector<Vec3f> places;
};

/**
 * A density over the unit cube of a photon's first numbers, constant in the leaves of a tree that splits
 * where trial photons are spread unevenly. A photon of density q carries 1/q of the flux it would carry
 * without.
 */
class EmissionGuide {
 public:
  /** The light; the part of the light; the place (2); the direction (2). */
  static constexpr size_t DIMENSIONS = 6;
  using Numbers = std::array<float, DIMENSIONS>;
  struct TrainingSample {
    Numbers numbers;
    float weight; ///< what it brings, squared, over the density that it was drawn with
  };

  /** No guide: density 1. */
  EmissionGuide() = default;
  /**
   * From the useful ones of `trials` photons. Where the mean of what is brought, squared, is p, the density
   * of least variance is in proportion to √p; a tenth is left to the rest of the cube, of which too little is
   * known to leave it out. `lights` share the first dimension.
   */
  EmissionGuide(std::span<const TrainingSample> useful, double trials, size_t lights = 1);

  /** How many times less variance a photon brings than without; 1 without a guide. */
  double gain() const { return expectedGain; }
  bool active() const { return leaves.size() > 1; }
  /** Replaces uniform numbers by ones of the density, and returns that density. `choice` is one number more.
   */
  float warp(Numbers& numbers, float choice) const;

 private:
  static constexpr double UNIFORM_PART = 0.1;
  struct Node { ///< numbers[dimension] < at: the next node, else `other`; of leaves dimension is -1
    int dimension;
    float at;
    uint32_t other; ///< of leaves the leaf
  };
  struct Leaf {
    Numbers low, high;
    double density; ///< uniform part included
    double chance;  ///< of the guided part: this leaf and all before it
  };
  void split(std::span<TrainingSample> useful, const Numbers& low, const Numbers& high, double trials,
             int depth);

  std::vector<Node> nodes;
  std::vector<Leaf> leaves;
  size_t lights = 1;
  double expectedGain = 1;
};

} // namespace recurse
