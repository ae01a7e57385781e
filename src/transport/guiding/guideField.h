/** @file
 * Guiding field: for each position and surface side, a density over directions of incident light that no
 * other technique samples well (Jensen 1995, "Importance Driven Path Tracing using the Photon Map"; Vorba et
 * al. 2014; Müller et al. 2017). Always rebuilt from records, never updated, so that it depends on the
 * current records alone.
 */
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "recurse/core/math/vector.h"
#include "recurse/model/bsdf/directionGuide.h"
#include "transport/guiding/squareTree.h"

namespace recurse {

/** Sample of the light that arrives at a vertex of a camera path, or at the surface of a photon. */
struct GuideRecord {
  Vec3f position{0};
  Vec3f normal{0};    ///< unit, geometric, on the side that the vertex is seen from; 0 in a medium
  Vec3f direction{0}; ///< unit, away from the vertex
  /** f L cos θ (in a medium: phase function · L) times the MIS weight of the ray, over the pdf of the
   * direction; of a photon its flux, in any unit, since each cell scales both kinds of records. Positive. */
  float value = 0;
  bool fromPhoton = false; ///< a photon, not a camera path, made the record
};

/** Directional density shared by neighbouring positions: cosine lobe around the mean normal of the records,
 * in a medium the whole sphere, times a quadtree density over the unit square that these are sampled from. */
class GuideCell final : public DirectionGuide {
 public:
  /** A cell without a density: too few records. */
  GuideCell() = default;
  /** `frame`: of the cosine lobe; empty: the whole sphere. */
  GuideCell(SquareTree tree, const std::optional<Frame>& frame)
      : tree(std::move(tree)), frame(frame), hasDensity(true) {}

  /** Probability of BSDF sampling: with it a wrong tree at most doubles a path's weight at each vertex. */
  static constexpr float BSDF_PROBABILITY = 0.5f;
  float bsdfProbability() const override { return BSDF_PROBABILITY; }
  float pdf(const Vec3f& direction) const override;
  Vec3f sample(Vec2f u, float& density) const override;

 private:
  friend class GuideField;
  SquareTree tree;
  std::optional<Frame> frame;
  uint64_t records = 0;
  bool hasDensity = false; ///< false: BSDF sampling alone
};

/** Directional densities of all cells, found by position and normal. */
class GuideField {
 public:
  /** Learns the cells from records. No cell smaller than `smallest` [scene units] is divided. The result does
   * not depend on the number of threads. */
  void build(std::span<const GuideRecord> records, float smallest);

  /** Cell for a point with unit `normal` on the side that it is seen from, or in a medium with normal 0. Null
   * where only BSDF sampling, or the phase function, is used. */
  const GuideCell* find(const Vec3f& position, const Vec3f& normal) const {
    const GuideCell* cell = cellAt(position, normal);
    return cell && cell->hasDensity ? cell : nullptr;
  }
  /** The density that find() returns for such a point, and the number of its records. */
  LearnedDirections learnedAt(const Vec3f& position, const Vec3f& normal) const;

  size_t cellCount() const { return cells.size(); }
  /** All but the gain. */
  GuideStatistics statistics() const;

  static constexpr size_t MAX_RECORDS = 500; ///< records in a cell before it is divided
  /** Effective records (Kish 1965) below which a cell has no density. */
  static constexpr double MIN_EFFECTIVE = 32;
  /** Upper bound of the weight of a cell's photons [effective records]. Camera paths outweigh them in the
   * end: their records include the BSDF and the MIS weight of the whole ray. */
  static constexpr double MAX_PHOTONS = 256;

 private:
  struct Node {
    int axis = -1; ///< -1: a leaf
    float split = 0;
    uint32_t next = 0; ///< index of the first of two children; in a leaf, index of its cell
  };
  /** Null before the first build(). */
  const GuideCell* cellAt(const Vec3f& position, const Vec3f& normal) const;
  void divide(std::span<uint32_t> order, std::span<const GuideRecord> records, uint32_t node, float smallest,
              int depth, std::vector<std::span<uint32_t>>& leaves);

  std::vector<Node> nodes; ///< the first are the roots: one for each signed axis that a normal can be nearest
                           ///< to, and one for media
  std::vector<GuideCell> cells;
};

} // namespace recurse
