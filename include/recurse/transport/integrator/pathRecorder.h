/** @file
 * Record of camera paths: vertices, steps between them, density estimates, and each contribution with its
 * technique. Integrators fill it through PathRadiance::recorder.
 */
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "recurse/core/math/rgb.h"
#include "recurse/model/bsdf/bsdf.h"
#include "recurse/pathclasses/pathClasses.h"
#include "recurse/transport/integrator/lightPathRecorder.h"

namespace recurse {

struct Hit;

/** Technique of a contribution. */
enum class PathTechnique : uint8_t {
  UNKNOWN,      ///< the integrator does not record it
  HIT,          ///< a ray hit a light
  LIGHT_SAMPLE, ///< a shadow ray to a sampled point of a light
  CONNECTION,   ///< a connection to a vertex of a light path
  MERGE,        ///< a density estimate from photons
  FLIGHT,       ///< a ray passed a medium that emits
  PATCHES,      ///< irradiance interpolated between patches
  AMBIENT,      ///< a constant ambient term, without a path
  SPLAT         ///< a connection of a light path to the camera, which has no record
};

/** Name of a technique: "hit", "light sample". */
const char* techniqueName(PathTechnique technique);

/** Step index that represents the camera ray. */
constexpr int CAMERA_STEP = -1;

/** A point where a camera path scatters. */
struct RecordedVertex {
  int step = CAMERA_STEP;             ///< incoming step
  Vec3f position{0};                  ///< [scene units], relative to Scene::origin()
  Vec3f normal{0};                    ///< geometric, unit, towards the camera's side; zero in a medium
  uint32_t object = 0;                ///< see Scene::objectName()
  const Material* material = nullptr; ///< null in a medium
  bool inMedium = false;
  LobeSet lobes = NO_LOBE; ///< all lobes of the BSDF
  Rgb throughput{1};       ///< incoming throughput
};

/** Direction in which a path leaves a vertex. */
struct RecordedStep {
  int vertex = NOT_RECORDED;
  PathEvent event = PathEvent::D;
  LobeSet lobe = NO_LOBE;
  Vec3f direction{0};   ///< unit
  Rgb throughput{1};    ///< after the event
  float pdf = 0;        ///< density of the direction [1/sr]; 0: a delta lobe
  float pdfReverse = 0; ///< density of the reverse direction, from the light's side [1/sr]; 0: a delta lobe
};

/** A density estimate at a vertex. */
struct RecordedEstimate {
  int vertex = NOT_RECORDED;
  bool caustic = false; ///< from photons of caustics
  float radius = 0;     ///< of the kernel support [scene units]
  int photons = 0;      ///< number in the support; 0 as well where a cached irradiance is used
};

/** MIS weight of a technique that can make a recorded path. */
struct RecordedWeight {
  PathTechnique technique = PathTechnique::UNKNOWN;
  int cameraVertices = 0; ///< scattering vertices that it samples from the camera
  float weight = 0;
};

/** Origin of a contribution. */
struct RecordedSource {
  PathTechnique technique = PathTechnique::UNKNOWN;
  int vertex = NOT_RECORDED;   ///< for shadow rays, connections and merges
  int step = CAMERA_STEP;      ///< for hits: the outgoing step of the ray
  int estimate = NOT_RECORDED; ///< index of the density estimate; merges only
  /** Vertex of the light path: the other end of a connection, or the photon of a merge. Integrators that
   * merge many photons at once have none. */
  int lightVertex = NOT_RECORDED;
  /** Point of the light, of the light path, of a single merged photon, or where a ray leaves an emitting
   * medium; unit direction to it where `isInfinite`. Unused where no point is known: merges of many photons
   * at once, patches, and ambient terms. */
  Vec3f end{0};
  bool isInfinite = false;
  int panes = 0; ///< thin panes that a light sample passes straight, which are no vertices of the record
  /** MIS weight among all techniques that can make the path; 1 for merges of many photons at once. */
  float weight = 1;
  float pdf = 0; ///< density of this technique, for all light samples together [1/sr]; 0: delta, or unknown
  /** Density of a pair's second technique: a hit, or all light samples together [1/sr]; 0: it cannot make the
   * path, or is unknown. */
  float otherPdf = 0;
  /** Density at `vertex` of the direction to `end` by the BSDF or the phase function [1/sr]; 0: unknown, or a
   * hit, whose step has it. */
  float vertexPdf = 0;
  /** Density with which a light path that arrives from `end` leaves `vertex` towards the camera's side
   * [1/sr]. */
  float vertexPdfReverse = 0;
  /** For a connection: density with which the light path leaves `lightVertex` towards `vertex`, and a camera
   * path from there towards the light [1/sr]. */
  float lightVertexPdf = 0, lightVertexPdfReverse = 0;
  /** Weights of all techniques that can make the path, in PathRecorder::weights; none: unknown. */
  size_t firstWeight = 0, weightCount = 0;

  /** Why the path between the light and the camera's side is not recorded, in words; null for a whole path.
   */
  const char* omission() const;
};

/** Radiance that a path adds to a sample. */
struct RecordedContribution {
  RecordedSource source;
  LayerMask classes = 0; ///< classes of the path
  Rgb radiance{0};       ///< including MIS weight and throughput
};

/** Camera path with all its branches. The indices are its first entries in the record; its entries end where
 * the entries of the next sample begin. */
struct RecordedSample {
  uint32_t index = 0;            ///< index among the pixel's samples
  Vec2f film{0};                 ///< point of the film [pixels]
  Vec3f origin{0}, direction{0}; ///< of the camera ray; zero where there is none
  float filterWeight = 1;        ///< see Filter::Sample
  float rayWeight = 1;           ///< weight of the camera ray; 0 where there is none
  /** Radiance added to the film: the sum of the contributions times `rayWeight`, unless the film clamps it or
   * changes its white. */
  Rgb total{0};
  size_t firstVertex = 0, firstStep = 0, firstEstimate = 0, firstContribution = 0, firstLightVertex = 0;
};

/** Record of some samples. Used by one thread. */
class PathRecorder {
 public:
  /** Starts the record of a sample. */
  void beginSample(RecordedSample sample);
  /** Ends the record of the sample. */
  void endSample(const Rgb& total) { recordedSamples.back().total = total; }

  /** Adds a vertex and returns its index; light samples and merges that follow belong to it. */
  int addVertex(const RecordedVertex& vertex);
  /** Adds a vertex on a surface, hit by a ray of unit `direction`; returns its index. */
  int addVertex(int step, const Hit& hit, const Vec3f& direction, LobeSet lobes, const Rgb& throughput);
  /** Adds a step and returns its index. */
  int addStep(const RecordedStep& step);
  /** Starts a density estimate at a vertex; contributions that follow belong to it. */
  void beginEstimate(int vertex, bool caustic);
  /** Ends the density estimate. */
  void endEstimate(float radius, int photons);
  /** Adds a contribution from `source`. */
  void add(LayerMask classes, const Rgb& radiance) {
    recordedContributions.push_back({source, classes, radiance});
  }

  RecordedSource source; ///< of the contributions that follow
  /** Vertices of the light paths that the samples were joined with. */
  std::vector<RecordedLightVertex> lightVertices;
  std::vector<RecordedWeight>
      weights; ///< technique weights of all contributions, see RecordedSource::firstWeight

  const std::vector<RecordedSample>& samples() const { return recordedSamples; }
  const std::vector<RecordedVertex>& vertices() const { return recordedVertices; }
  const std::vector<RecordedStep>& steps() const { return recordedSteps; }
  const std::vector<RecordedEstimate>& estimates() const { return recordedEstimates; }
  const std::vector<RecordedContribution>& contributions() const { return recordedContributions; }
  /** Index one past the last contribution of a sample. */
  size_t endContribution(size_t sample) const {
    return sample + 1 < recordedSamples.size() ? recordedSamples[sample + 1].firstContribution
                                               : recordedContributions.size();
  }

  /** Events up to and including a step, last event first, as in path expressions: "DS" where the camera sees
   * a diffuse surface in a mirror. */
  std::string letters(int step) const;

 private:
  std::vector<RecordedSample> recordedSamples;
  std::vector<RecordedVertex> recordedVertices;
  std::vector<RecordedStep> recordedSteps;
  std::vector<RecordedEstimate> recordedEstimates;
  std::vector<RecordedContribution> recordedContributions;
};

} // namespace recurse
