/** @file
 * Record of camera paths.
 */
#include "recurse/transport/integrator/pathRecorder.h"

#include "recurse/model/scene/scene.h"

namespace recurse {

const char* techniqueName(PathTechnique technique) {
  switch (technique) {
  case PathTechnique::HIT:
    return "hit";
  case PathTechnique::LIGHT_SAMPLE:
    return "light sample";
  case PathTechnique::CONNECTION:
    return "connection";
  case PathTechnique::MERGE:
    return "merge";
  case PathTechnique::FLIGHT:
    return "emission along a ray";
  case PathTechnique::PATCHES:
    return "patches";
  case PathTechnique::AMBIENT:
    return "ambient term";
  case PathTechnique::SPLAT:
    return "connection to the camera";
  case PathTechnique::UNKNOWN:
    break;
  }
  return "unknown";
}

const char* RecordedSource::omission() const {
  switch (technique) {
  case PathTechnique::HIT:
  case PathTechnique::LIGHT_SAMPLE:
  case PathTechnique::CONNECTION:
  case PathTechnique::FLIGHT:
    return nullptr;
  case PathTechnique::MERGE:
    return lightVertex == NOT_RECORDED ? "photons are stored without the paths that they came by" : nullptr;
  case PathTechnique::PATCHES:
    return "patches store irradiance without the paths of its light";
  case PathTechnique::AMBIENT:
    return "a constant radiance replaces the light of these paths";
  case PathTechnique::SPLAT:
  case PathTechnique::UNKNOWN:
    break;
  }
  return "the integrator does not record these paths";
}

void PathRecorder::beginSample(RecordedSample sample) {
  sample.firstVertex = recordedVertices.size();
  sample.firstStep = recordedSteps.size();
  sample.firstEstimate = recordedEstimates.size();
  sample.firstContribution = recordedContributions.size();
  sample.firstLightVertex = lightVertices.size();
  recordedSamples.push_back(sample);
  source = {};
}

int PathRecorder::addVertex(const RecordedVertex& vertex) {
  recordedVertices.push_back(vertex);
  return source.vertex = static_cast<int>(recordedVertices.size()) - 1;
}

int PathRecorder::addVertex(int step, const Hit& hit, const Vec3f& direction, LobeSet lobes,
                            const Rgb& throughput) {
  return addVertex({.step = step,
                    .position = hit.point.position,
                    .normal = hit.point.normalTowards(-direction),
                    .object = hit.object,
                    .material = hit.material,
                    .lobes = lobes,
                    .throughput = throughput});
}

int PathRecorder::addStep(const RecordedStep& step) {
  recordedSteps.push_back(step);
  return static_cast<int>(recordedSteps.size()) - 1;
}

void PathRecorder::beginEstimate(int vertex, bool caustic) {
  recordedEstimates.push_back({.vertex = vertex, .caustic = caustic});
  source = {.technique = PathTechnique::MERGE,
            .vertex = vertex,
            .estimate = static_cast<int>(recordedEstimates.size()) - 1};
}

void PathRecorder::endEstimate(float radius, int photons) {
  recordedEstimates.back().radius = radius;
  recordedEstimates.back().photons = photons;
  const int vertex = source.vertex;
  source = {.vertex = vertex};
}

std::string PathRecorder::letters(int step) const {
  std::string out;
  while (step != CAMERA_STEP) {
    const RecordedStep& s = recordedSteps[size_t(step)];
    out += "SDV"[static_cast<size_t>(s.event)];
    step = recordedVertices[size_t(s.vertex)].step;
  }
  return out;
}

} // namespace recurse
