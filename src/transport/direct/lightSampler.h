/** @file
 * Light selection for shadow rays, learned from photons that arrive straight from the lights: lights that
 * reach a region are sampled more often there.
 */
#pragma once

#include <array>
#include <span>
#include <vector>

#include "recurse/transport/integrator/integrator.h"
#include "transport/direct/lightTree.h"
#include "transport/direct/portalSampler.h"

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

/** Surface points that light reaches straight from known lights. */
struct LightArrivals {
  struct Arrival {
    Vec3f position, normal; ///< normal: on the lit side
    uint32_t leaf;          ///< leaf of the light in LightTree
  };
  void add(const Vec3f& position, const Vec3f& normal, uint32_t leaf) {
    bySide[signedAxis(normal)].push_back({position, normal, leaf});
  }
  std::array<std::vector<Arrival>, SIGNED_AXES> bySide; ///< arrivals by the signed axis nearest to the normal
};

/** Irradiance by a light sample, in its strongest channel; 0 behind the surface or if not finite. */
double irradianceBy(const LiSample& light, const Vec3f& normal, bool bothSides);

/** Chooses lights for shadow rays: by power until it has learned, then by a light tree whose clusters are
 * weighted by the photons that arrived in cells of space (Keller and Wald 2000, "Efficient Importance
 * Sampling Techniques for the Photon Map"). Probabilities are blended between cells. They depend only on
 * the position and the axis nearest to the normal, so that MIS weights can evaluate them:
 * doc-files/notes/light-sampler.md. */
class LightSampler {
 public:
  /** Forgets all, learns portals if `withPortals`, and builds the tree of the lights. Returns the work it
   * took. */
  TransportCounts prepare(const Scene& scene, bool withPortals);
  /** Tree of the lights; empty where there is nothing to choose. */
  const LightTree& lightTree() const { return tree; }
  /** Learns the probabilities of lights from arrivals, whose order changes. */
  void learn(const LightTable& lights, LightArrivals& arrivals);

  bool active() const { return !tables.empty(); }
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
  /** Node of a kd-tree over photon positions, one tree for each side of LightArrivals. axis 3: leaf. */
  struct Cell {
    uint32_t axis = 3;
    float at = 0, band = 0; ///< split position; both children are blended within `band` of it
    uint32_t other = 0;     ///< index of the child beyond `at`; the one below is next. In a leaf: its table
  };
  /** Arrivals in one cell. */
  using Arrivals = std::span<LightArrivals::Arrival>;

  ChosenLight chooseLearned(const LightTable& lights, const LightSampleContext& context, float& u) const;
  float probabilityLearned(const LightSampleContext& context, uint32_t light) const;
  /** Cumulative probability, at a point, of the clusters up to and including this one. */
  double upTo(const LightSampleContext& context, size_t cluster) const {
    double sum = 0;
    for (uint32_t i = 0; i < context.count; ++i) {
      const LightSampleContext::Share& s = context.shares[i];
      sum += double(s.weight) * double(tables[s.cell * tree.clusters.size() + cluster]);
    }
    return sum;
  }
  static void buildCells(Arrivals arrivals, std::vector<Cell>& cells, std::vector<Arrivals>& leaves);
  /** Unoccluded irradiance from each cluster at the positions of the arrivals, up to a common factor. */
  std::vector<double> irradiances(const LightTable& lights, Arrivals arrivals, Sampler sampler) const;
  void buildTable(const LightTable& lights, Arrivals arrivals, Sampler sampler, float* table) const;

  PortalSampler portals;
  LightTree tree;
  std::array<std::vector<Cell>, SIGNED_AXES> cells;
  /** Cumulative probabilities of clusters, by cell; the first table is for points without photons. */
  std::vector<float> tables;
};

} // namespace recurse
