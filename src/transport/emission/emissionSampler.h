/** @file
 * Starts of light paths: the one sampler of emission for photons, light subpaths and virtual lights.
 */
#pragma once

#include <optional>

#include "transport/emission/emissionMixture.h"
#include "transport/emission/emissiveMedia.h"
#include "transport/emission/pathEnds.h"
#include "transport/paths/recordedWalk.h"
#include "transport/paths/walker.h"

namespace recurse {

/** Start of a light path. */
struct LightStart {
  LightSubpath path;     ///< throughput: flux of the light over the density of the start [W]
  LightEnd end;          ///< `light` is null for a medium; pdfNext depends on the first vertex and is not set
  LePdf pdf;             ///< densities of the ray; 1 for a delta, as in LeSample; 0 for a medium
  float probability = 0; ///< probability with which the light was chosen; 0 if a medium emits
};

/** Samples the starts of light paths. */
class EmissionSampler {
 public:
  EmissionSampler(const Scene& scene, const PathClasses& classes, const EmissionSettings& settings,
                  TransportCounts& counts)
      : scene(scene), classes(classes), settings(settings), counts(counts), mediaPart(partOfMedia()) {}

  /** Starts a path from a light or an emissive medium; nullopt if the sample has no flux, or no path class
   * can use it. */
  std::optional<LightStart> start(float time, Sampler& sampler) const;

 private:
  bool fromLight(float time, Sampler& sampler, LightStart& start) const;
  void fromMedium(float time, Sampler& sampler, LightStart& start) const;
  float partOfMedia() const;

  const Scene& scene;
  const PathClasses& classes;
  const EmissionSettings settings;
  TransportCounts& counts;
  float mediaPart; ///< fraction of the paths that emissive media start
};

/** Samples the start of one light path by the lights' own sampling, or by a mixture; empty where nothing is
 * emitted. Emissive media start no paths here. */
inline std::optional<LightStart> startLightSubpath(const Scene& scene, const PathClasses& classes, float time,
                                                   Sampler& sampler, TransportCounts& counts,
                                                   const EmissionMixture* mixture = nullptr) {
  return EmissionSampler(scene, classes, {.mixture = mixture}, counts).start(time, sampler);
}

/** Sampler stream of light paths, distinct from the streams of pixels. */
constexpr uint64_t LIGHT_PATH_STREAM = 0x4c49474854504154ull;
/** Sampler of light path `number` in a pass. `stream`: distinct from the streams of pixels. */
inline Sampler lightPathSampler(const Pass& pass, uint64_t number, uint64_t stream = LIGHT_PATH_STREAM) {
  return Sampler(hashCombine(pass.seed, pass.index), stream + (number >> 32), static_cast<uint32_t>(number));
}

/** Follows light path `number` of a pass to its end: calls visit(path, vertex) at each vertex, before the
 * path scatters there. */
template <class Visit>
void followLightPath(const Scene& scene, const PathClasses& classes, const Pass& pass, uint64_t number,
                     int maxDepth, const EmissionMixture* mixture, TransportCounts& counts,
                     RecordedWalk& record, const Visit& visit) {
  Sampler sampler = lightPathSampler(pass, number);
  std::optional<LightStart> start = startLightSubpath(scene, classes, pass.time, sampler, counts, mixture);
  if (!start) return;
  Walker<LightState> walker(scene, classes, counts, maxDepth);
  LightSubpath& path = start->path;
  LightVertex vertex;
  record.start(path);
  while (walker.next(path, vertex, sampler, record.escape(path, scene))) {
    record.arrive(path, vertex, vertex.isConnectable());
    visit(path, vertex);
    const std::optional<Scatter> s = walker.scatter(path, vertex, sampler);
    if (!s) return;
    record.leave(vertex, *s);
  }
}

} // namespace recurse
