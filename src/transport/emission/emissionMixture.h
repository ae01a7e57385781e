/** @file
 * Density of emission: for each light a mixture of its own sampling and of sampling through boxes around
 * vertices and exits of camera paths, with probabilities learned from trial photons (multiple importance
 * sampling of one sample, Veach 1997, section 9.2.4; a population Monte Carlo update, Cappé et al. 2008).
 */
#pragma once

#include <span>
#include <vector>

#include "transport/emission/emissionBoxes.h"

namespace recurse {

class EmissiveMedia;

/**
 * A finite light samples a point on itself, and then a direction by its own sampling or in the cone around a
 * box. An infinite light samples a direction, and then an origin on the whole disc of the scene or on the
 * silhouette of a box. The density of any ray is known, so that estimates remain unbiased.
 */
class EmissionMixture {
 public:
  /** Squared contributions of trial photons, by light and component of the mixture. */
  class Moments {
   public:
    explicit Moments(const EmissionMixture& mixture);
    /** Adds a trial photon with the squared value of its estimate. */
    void add(uint32_t light, const LeRay& ray, double squared);
    void add(const Moments& o);

   private:
    friend EmissionMixture;
    const EmissionMixture& mixture;
    std::vector<double> sums; ///< by group; in a group: own sampling, then the lanes of the boxes
  };

  /** Lights emit by their own sampling, and are chosen by power. */
  EmissionMixture() = default;
  /** Finds boxes by camera paths. Their probabilities are not learned yet. */
  EmissionMixture(const Scene& scene, uint64_t seed, TransportCounts& counts);

  bool active() const { return !groups.empty(); }
  /** The lights of the scene with learned probabilities; requires active(). */
  const LightTable& lights() const { return table; }
  /** Replaces the direction of a finite light's sample or the origin of an infinite light's, and updates the
   * members that depend on it. The flux is black where the light does not emit in that direction. `pick` and
   * `u` are in [0, 1) and independent of the sample. */
  void redirect(uint32_t light, LeSample& sample, float pick, const Vec2f& u) const;
  /** Densities of a ray of redirect(). */
  LePdf pdfLe(uint32_t light, const LeRay& ray) const;
  /** Adapts all probabilities to trial photons of this mixture. The variance of photons is least where the
   * moments of all components are equal; each step multiplies a probability by the root of its moment. */
  void adapt(const Moments& moments);
  /** Fraction of the light paths that start through boxes. */
  double boxPart() const;
  /** Whether rays from most vertices of camera paths rarely hit a finite light, because it is far away. False
   * for infinite lights, and unless active(). */
  bool isFar(uint32_t light) const;

 private:
  /** Lights that share the probabilities of boxes: one light, or several neighbours in the table if there are
   * many. Finite lights have no boxes around exits. */
  struct Group {
    size_t firstBlock = 0;
    float probability = 0, powerShare = 0;
    /** Before anything is learned: half by power, half uniform, as a lamp indoors may matter more than the
     * sun. */
    float firstProbability = 0;
    float lightSamplingProbability = 1; ///< probability of the lights' own sampling
    std::vector<float> chances;         ///< probabilities of the boxes, by lane from firstBlock
    std::vector<Float8> lanes;          ///< `chances` in blocks
    std::vector<float> firstGuess;      ///< the same before anything is learned
  };
  /** Median of a value of the centres of boxes around camera vertices, by probability. */
  template <class Value> float medianOf(const Value& value) const;
  void gather(const Scene& scene);
  void buildTable();
  const Group& groupOf(uint32_t light) const { return groups[groupOfLight[light]]; }
  size_t components() const { return 1 + 8 * boxes.blocks.size(); }
  /** Density of the direction, or of the origin of an infinite light. `lightDensity`: density by the light's
   * own sampling. `hitLane`: lane of a box that the ray hits even if rounding denies it, counted from the
   * first block; negative: none. */
  float density(uint32_t light, const LeRay& ray, float lightDensity, int hitLane) const;

  SceneBounds bounds;
  EmissionBoxes boxes;
  std::vector<Group> groups;
  std::vector<uint32_t> groupOfLight;
  std::vector<double> powerShares; ///< probabilities of the lights by power
  LightTable table;
};

/** Settings of the starts of light paths. By default every light emits by its own sampling, and lights are
 * chosen by power. */
struct EmissionSettings {
  const EmissionMixture* mixture = nullptr; ///< learned emission; null: none
  const EmissiveMedia* media = nullptr;     ///< emissive media besides the lights; null: none
  uint16_t outside = 0;                     ///< index of the medium where paths of infinite lights start
  Rgb outsideTransmittance{1};              ///< transmittance from the infinite lights to those starts

  bool isMixed() const { return mixture && mixture->active(); }
  const LightTable& table(const Scene& scene) const { return isMixed() ? mixture->lights() : scene.lights(); }
  /** Densities with which a ray of the light with this index starts. */
  LePdf pdfLe(uint32_t index, const Light& light, const LeRay& ray) const {
    return isMixed() ? mixture->pdfLe(index, ray) : light.pdfLe(ray);
  }
};

} // namespace recurse
