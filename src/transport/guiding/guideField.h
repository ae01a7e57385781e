/** @file
 * The guide: for each place and side of a surface a density over directions in which light arrives that no
 * other technique samples well (Jensen 1995, "Importance Driven Path Tracing using the Photon Map"; Vorba et
 * al. 2014; Müller et al. 2017). It is rebuilt from records, never updated, so that it depends on the records
 * alone.
 */
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "recurse/core/math/vector.h"
#include "recurse/model/bsdf/directionGuide.h"
#include "transport/guiding/squareTree.h"

namespace recurse {

/** One estimate of light that arrives at a vertex of a camera path. */
struct GuideRecord {
  Vec3f position{0};
  Vec3f normal{0};    ///< unit, geometric, on the side that the vertex is seen from
  Vec3f direction{0}; ///< unit, away from the vertex
  /** f L cos times the MIS weight of the ray over the density of the direction; positive. Flux of a photon,
   * in any unit: the values of photons and of camera paths are brought to a common scale in each cell. */
  float value = 0;
  float pdfBsdf = 0;       ///< of BSDF sampling for the direction [1/sr]; positive
  bool fromPhoton = false; ///< else from a camera path
};

/** Places that share a density: a cosine lobe around their mean normal, times a quadtree over the square that
 * the lobe is sampled by. */
class GuideCell final : public DirectionGuide {
 public:
  /** Off. */
  GuideCell() = default;
  GuideCell(SquareTree tree, const Frame& frame) : tree(std::move(tree)), frame(frame), on(true) {}

  /** A wrong tree then makes the weight of a path at most twice as large at each vertex. */
  static constexpr float BSDF_PROBABILITY = 0.5f;
  float bsdfProbability() const override { return BSDF_PROBABILITY; }
  bool isOn() const { return on; }
  float pdf(const Vec3f& direction) const override;
  Vec3f sample(Vec2f u, float& density) const override;

 private:
  friend class GuideField;
  SquareTree tree;
  Frame frame{Vec3f(0, 0, 1)};
  bool on = false;
};

/** The densities of all places. */
class GuideField {
 public:
  /** Learns from records. `smallest`: no cell is divided below this extent [scene units]. The same for any
   * number of threads. */
  void build(std::span<const GuideRecord> records, float smallest);

  /** The cell for a point with unit `normal` on the side that it is seen from. Null: BSDF
   * sampling. */
  const GuideCell* find(const Vec3f& position, const Vec3f& normal) const;

  size_t cellCount() const { return cells.size(); }
  /** Cells that guide. */
  size_t cellsOn() const { return on; }
  size_t nodeCount() const;

  static constexpr size_t MAX_RECORDS = 500;  ///< of a cell
  static constexpr double MIN_EFFECTIVE = 32; ///< effective records, below which a cell is off
  /** Effective records that the photons of a cell count for at most: camera paths know the BSDF, and the MIS
   * weights at both ends of a ray. */
  static constexpr double MAX_PHOTONS = 256;
  /** Effective records that the mean of all cells counts for in the gain of one. */
  static constexpr double PRIOR_COUNT = 256;
  /** A cell is off where its mixture gains less log-likelihood over BSDF sampling. */
  static constexpr double MIN_GAIN = 0.02;

 private:
  struct Node {
    int axis = -1; ///< -1: a leaf
    float split = 0;
    uint32_t next = 0; ///< first of two children; of a leaf its cell
  };
  void divide(std::span<uint32_t> order, std::span<const GuideRecord> records, uint32_t node, float smallest,
              int depth, std::vector<std::span<uint32_t>>& leaves);

  std::vector<Node>
      nodes; ///< the first are the roots, by the axis that the normal is nearest to and its sign
  std::vector<GuideCell> cells;
  size_t on = 0;
};

} // namespace recurse
