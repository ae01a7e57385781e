/** @file
 * Light selection for shadow rays, learned from photons that arrive straight from the lights: lights that
 * reach a region are sampled more often there.
 */
#pragma once

#include <array>
#include <span>
#include <vector>

#include "recurse/transport/integrator/integrator.h"
#include "transport/direct/portalSampler.h"
#include "transport/paths/nesting.h"

namespace recurse {

/** Context of a light choice: the shaded point, and the cells of the sampler that contain it or are near,
 * each with its weight. */
struct LightSampleContext {
  static constexpr size_t MAX_CELLS = 4;
  struct Share {
    uint32_t cell = 0;
    float weight = 1;
  };
  Vec3f position{0};
  uint32_t count = 1;
  std::array<Share, MAX_CELLS> shares{};
};

/** Chooses lights for shadow rays: by power until it has learned, then by a light tree (Conty Estevez and
 * Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting"), whose upper levels are
 * weighted by the photons that arrived in cells of space (Keller and Wald 2000, "Efficient Importance
 * Sampling Techniques for the Photon Map"). Probabilities are blended between cells. They depend only on
 * the position and the axis nearest to the normal, so that MIS weights can evaluate them:
 * doc-files/notes/light-sampler.md. */
class LightSampler {
 public:
  /** Learns portals, if `withPortals`. With more than one light, also traces photons up to their first
   * surface, and camera rays from whose first non-delta surface shadow rays find a light. Independent of the
   * seed and the number of threads. Returns the work it took. An interrupt leaves nothing learned. */
  TransportCounts learn(const Scene& scene, bool withPortals = true);

  bool active() const { return !order.empty(); }
  /** Context of a point; only while active(). `normal`: geometric, on the visible side. */
  LightSampleContext at(const Vec3f& position, const Vec3f& normal) const;
  /** Chooses a light from `lights`, the table of the learned scene, which must not be empty. u in [0,1) is
   * consumed and replaced by a new uniform number in [0,1). */
  ChosenLight choose(const LightTable& lights, const LightSampleContext& context, float& u) const {
    return active() ? chooseLearned(lights, context, u) : lights.choose(u);
  }
  float probability(const LightTable& lights, const LightSampleContext& context, uint32_t light) const {
    return active() ? probabilityLearned(context, light) : lights.probability(light);
  }
  /** Samples the chosen light towards a point, by Light::sampleLiAt() or through portals. */
  std::optional<LiSample> sampleLi(const Light& light, float time, const Vec3f& point, float pick,
                                   const Vec2f& u) const {
    if (portals.active() && light.kind() == LightKind::ENVIRONMENT)
      return portals.sampleLi(static_cast<const EnvironmentLight&>(light), point, pick, u);
    return light.sampleLiAt(time, point, pick, u);
  }
  /** Density of the directions that sampleLi() chooses for an environment light [1/sr]. */
  float pdfLi(const EnvironmentLight& light, const Vec3f& from, const Vec3f& direction) const {
    return portals.pdfLi(light, from, direction);
  }

 private:
  /** Number of signed axes; arrivals are stored by the one nearest to the normal. */
  static constexpr size_t SIDES = 6;
  /** Node of the lights [first, end) in `order`. Its left child follows it in `nodes`. The right child's
   * index is computed, since the halves differ by at most one light. */
  struct Node {
    Vec3f center{0};
    float radius2 = 0; ///< squared radius of the sphere around its emission positions
    float power = 0;
  };
  /** Node at which the tables of probabilities end. */
  struct Cluster {
    uint32_t node, first, end;
  };
  /** Node of a kd-tree over photon positions, one tree per class of normals (sideOf()). axis 3: leaf. */
  struct Cell {
    uint32_t axis = 3;
    float at = 0, band = 0; ///< split position; both children are blended within `band` of it
    uint32_t other = 0;     ///< index of the child beyond `at`; the one below is next. In a leaf: its table
  };
  /** Photon that arrived straight from a light at a surface, on the side of `normal`. */
  struct Arrival {
    Vec3f position, normal;
    uint32_t light; ///< index in `order`
  };
  /** Arrivals in one cell. */
  using Arrivals = std::span<Arrival>;
  struct Found {
    std::array<std::vector<Arrival>, SIDES> arrivals;
    TransportCounts counts;
  };
  class Descent;
  static size_t sideOf(const Vec3f& normal);

  ChosenLight chooseLearned(const LightTable& lights, const LightSampleContext& context, float& u) const;
  struct Chosen {
    uint32_t light; ///< index in `order`
    double probability;
  };
  /** Chooses a light of the cluster by power over distance², by the number `uCluster` in [0,1). Multiplies
   * `probability` by the light's conditional probability. */
  Chosen chooseBelow(const Cluster& cluster, const Vec3f& position, double uCluster, double probability,
                     float& u) const;
  float probabilityLearned(const LightSampleContext& context, uint32_t light) const;
  /** Cumulative probability, at a point, of the clusters up to and including this one. */
  double upTo(const LightSampleContext& context, size_t cluster) const {
    double sum = 0;
    for (uint32_t i = 0; i < context.count; ++i) {
      const LightSampleContext::Share& s = context.shares[i];
      sum += double(s.weight) * double(tables[s.cell * clusters.size() + cluster]);
    }
    return sum;
  }
  /** Traces a photon from a light to its first surface. */
  void shoot(const Scene& scene, uint32_t index, Found& found) const;
  /** Traces a camera ray to its first non-delta surface, and finds a light that reaches it. */
  void look(const Scene& scene, uint32_t index, Found& found) const;
  void lookForLight(const Scene& scene, const Hit& hit, const Vec3f& direction, const Nesting& nesting,
                    Sampler& sampler, Found& found) const;
  void keep(const Hit& hit, const Vec3f& direction, uint32_t light, Found& found) const;
  void buildTree(const LightTable& lights);
  void buildNode(std::span<const Bounds3f> boxes, const LightTable& lights, size_t first, size_t end,
                 int depth);
  static void buildCells(Arrivals arrivals, std::vector<Cell>& cells, std::vector<Arrivals>& leaves);
  /** Unoccluded irradiance from each cluster at the positions of the arrivals, up to a common factor. */
  std::vector<double> irradiances(const LightTable& lights, Arrivals arrivals, Sampler sampler) const;
  void buildTable(const LightTable& lights, Arrivals arrivals, Sampler sampler, float* table) const;

  PortalSampler portals;
  std::vector<uint32_t> order, rank; ///< indices of lights by position in the tree, and the inverse
  std::vector<Node> nodes;
  std::vector<Cluster> clusters;
  std::vector<uint32_t> clusterOf; ///< index of the cluster by position in the tree
  std::array<std::vector<Cell>, SIDES> cells;
  /** Cumulative probabilities of clusters, by cell; the first table is for points without photons. */
  std::vector<float> tables;
};

} // namespace recurse
