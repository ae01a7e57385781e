/** @file
 * Which lights reach which places: photons that come straight from the lights tell, and shadow rays go there
 * more often.
 */
#pragma once

#include <array>
#include <span>
#include <vector>

#include "recurse/transport/integrator/integrator.h"
#include "transport/direct/portalSampler.h"
#include "transport/paths/nesting.h"

namespace recurse {

/** A place that a light is chosen for: where it is, and which of the guide's cells it lies in or near, each
 * with its share. */
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

/** Chooses lights for shadow rays: by power, until it has learned. A light tree (Conty Estevez and Kulla
 * 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting"), whose upper levels are weighted
 * by the photons that arrived in cells of space (Keller and Wald 2000, "Efficient Importance Sampling
 * Techniques for the Photon Map"); between cells the probabilities are blended. They are functions of the
 * place, so that weights can ask for them: doc-files/notes/light-sampler.md. */
class LightSampler {
 public:
  /** Finds portals, unless there are to be none; shoots photons as far as the first surface, where there is
   * more than one light. The same for any seed and any number of threads. Returns what that took. */
  TransportCounts learn(const Scene& scene, bool withPortals = true);

  bool active() const { return !order.empty(); }
  /** `normal`: geometric, on the side that is looked at. Only for an active guide. */
  LightSampleContext at(const Vec3f& position, const Vec3f& normal) const;
  /** `lights` are those of the scene that it has learned. u in [0,1) is used up and replaced by a fresh
   * number in [0,1). Not to be called on an empty table. */
  ChosenLight choose(const LightTable& lights, const LightSampleContext& place, float& u) const {
    return active() ? chooseLearned(lights, place, u) : lights.choose(u);
  }
  float probability(const LightTable& lights, const LightSampleContext& place, uint32_t light) const {
    return active() ? probabilityLearned(place, light) : lights.probability(light);
  }
  /** Light of a chosen one towards a point, as Light::sampleLiAt() or through portals. */
  std::optional<LiSample> sampleLi(const Light& light, float time, const Vec3f& point, float pick,
                                   const Vec2f& u) const {
    if (portals.active() && light.kind() == LightKind::ENVIRONMENT)
      return portals.sampleLi(static_cast<const EnvironmentLight&>(light), point, pick, u);
    return light.sampleLiAt(time, point, pick, u);
  }
  /** Density of such directions [1/sr]. */
  float pdfLi(const EnvironmentLight& light, const Vec3f& from, const Vec3f& direction) const {
    return portals.pdfLi(light, from, direction);
  }

 private:
  /** Arrivals are kept by the signed axis that is nearest to the normal. */
  static constexpr size_t SIDES = 6;
  /** Lights [first, end) in `order`. Its left child is the next in `nodes`, and since both halves differ by
   * one light at the most, the right one is found by counting. */
  struct Node {
    Vec3f center{0};
    float radius2 = 0; ///< of the sphere around where its photons start
    float power = 0;
  };
  /** A node that tables end at. */
  struct Cluster {
    uint32_t node, first, end;
  };
  /** Splits space for the photons of one side. Leaves have axis 3. */
  struct Cell {
    uint32_t axis = 3;
    float at = 0, band = 0; ///< so near to `at` both sides count
    uint32_t other = 0;     ///< the cell beyond `at`; the next one is below. Of leaves the table
  };
  /** Light that came straight from a light to a surface, on the side of `normal`. */
  struct Arrival {
    Vec3f position, normal;
    uint32_t light; ///< its place in `order`
  };
  /** Those of one cell. */
  using Arrivals = std::span<Arrival>;
  struct Found {
    std::array<std::vector<Arrival>, SIDES> arrivals;
    TransportCounts counts;
  };
  class Descent;
  static size_t sideOf(const Vec3f& normal);

  ChosenLight chooseLearned(const LightTable& lights, const LightSampleContext& place, float& u) const;
  struct Chosen {
    uint32_t light; ///< its place in `order`
    double probability;
  };
  /** A light of the cluster by power over distance², from `rest` in [0,1); its probability is a part of the
   * one given. */
  Chosen chooseBelow(const Cluster& cluster, const Vec3f& position, double rest, double probability,
                     float& u) const;
  float probabilityLearned(const LightSampleContext& place, uint32_t light) const;
  /** The probability at a place of all clusters as far as this one. */
  double upTo(const LightSampleContext& place, size_t cluster) const {
    double sum = 0;
    for (uint32_t i = 0; i < place.count; ++i) {
      const LightSampleContext::Share& s = place.shares[i];
      sum += double(s.weight) * double(tables[s.cell * clusters.size() + cluster]);
    }
    return sum;
  }
  /** A photon, as far as the first surface. */
  void shoot(const Scene& scene, uint32_t index, Found& found) const;
  /** What the eye sees, and a light that reaches it. */
  void look(const Scene& scene, uint32_t index, Found& found) const;
  void lookForLight(const Scene& scene, const Hit& hit, const Vec3f& direction, const Nesting& nesting,
                    Sampler& sampler, Found& found) const;
  void keep(const Hit& hit, const Vec3f& direction, uint32_t light, Found& found) const;
  void buildTree(const LightTable& lights);
  void buildNode(std::span<const Bounds3f> boxes, const LightTable& lights, size_t first, size_t end,
                 int depth);
  static void buildCells(Arrivals arrivals, std::vector<Cell>& cells, std::vector<Arrivals>& leaves);
  /** What the clusters would bring to the place of the arrivals if nothing was in the way, to a factor. */
  std::vector<double> irradiances(const LightTable& lights, Arrivals arrivals, Sampler sampler) const;
  void buildTable(const LightTable& lights, Arrivals arrivals, Sampler sampler, float* table) const;

  PortalSampler portals;
  std::vector<uint32_t> order, rank; ///< lights by place in the tree, and the other way round
  std::vector<Node> nodes;
  std::vector<Cluster> clusters;
  std::vector<uint32_t> clusterOf; ///< by place in the tree
  std::array<std::vector<Cell>, SIDES> cells;
  /** Probabilities of clusters, summed up; the first is for places without photons. */
  std::vector<float> tables;
};

} // namespace recurse
