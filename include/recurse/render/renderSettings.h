/** @file
 * What a render is asked to do, where it stands, and what it has done.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "recurse/model/film/film.h"
#include "recurse/render/sampleAllocation.h"
#include "recurse/render/workQueue.h"
#include "recurse/transport/integrator/integrator.h"

namespace recurse {

/** Told to the progress display about ten times a second, from one thread at a time. */
struct RenderProgress {
  std::string phase;       ///< "photons", "picture"
  double fraction = 0;     ///< of the phase, in [0, 1]
  double elapsed = 0;      ///< seconds since the start of the render
  double secondsLeft = -1; ///< negative: not known yet
  double samplesPerPixel = 0;
  double raysPerSecond = 0;
  double error = -1; ///< Film::relativeError when it was last looked at; negative: not known yet
};

enum class StopReason { SAMPLES, TIME, ERROR, INTERRUPTED };

struct RenderStatistics {
  double processorSeconds = 0;         ///< of all threads together
  double learningProcessorSeconds = 0; ///< of them before the first photon map or sample, and for all of them
  double photonProcessorSeconds = 0;   ///< of them for photon maps; what is left is that of camera paths
  double renderSeconds = 0, photonSeconds = 0, balanceSeconds = 0,
         gatherSeconds = 0; ///< gather: the backward part
  uint64_t photonsEmitted = 0, photonsStored = 0, photonsRefused = 0;
  size_t mapBytes = 0;
  uint64_t splatsSaturated = 0; ///< that were too large to be added up, and lost light by it
  TransportCounts counts;
  uint64_t samples = 0;                     ///< camera paths
  uint64_t least = 0, median = 0, most = 0; ///< camera paths of a pixel
  int passes = 0;                           ///< rounds of samples over the whole picture
  int forwardPasses = 0;                    ///< photon maps shot
  int threads = 0;
  StopReason stopReason = StopReason::SAMPLES;
  double error = -1;   ///< Film::relativeError at the end; negative: too few samples to tell
  bool oneMap = false; ///< all samples share one forward pass, whose error is not in `error`
  std::vector<std::string> notes, warnings;
};

/**
 * Where a render stands. The film, and the allocation where there is one, have the rest: of the round of
 * samples that begins with `sample` each tile of the picture has either everything or nothing.
 */
struct RenderPosition {
  int64_t sample = 0; ///< every pixel, or with an allocation the average one, has the samples up to this one
  RenderStatistics statistics; ///< so far, without notes and warnings
  /** Of a render by several processes: what they have not done, whatever `sample` says. */
  std::optional<std::vector<WorkUnit>> left = {};
};

/** From a pixel that has no sample when the time is up to one that has [steps along rows and columns], at
 * most where its tile was begun. */
constexpr int FIRST_SAMPLE_REACH = 6;

struct RenderSettings {
  int samplesPerPixel = 16;   ///< 0: until the time limit or the error target
  double timeLimit = 0;       ///< seconds for the whole render; 0: none
  double firstSampleTime = 1; ///< how many seconds more the first sample of each pixel may take
  /** The time limit ends the first forward pass, and leaves a film without samples; else that pass ends late.
   */
  bool limitsFirstPass = false;
  double errorTarget = 0; ///< Film::relativeError at which to stop; 0: none
  uint64_t seed = 0;
  /** A part of the samples of each pixel, those from `firstSample` up to `endSample` of samplesPerPixel, for
   * renders that are to be added up; 0: up to the last one. */
  int64_t firstSample = 0, endSample = 0;
  RenderPosition from = {}; ///< where the film comes from that the render begins with
  /** Deals the samples out; samplesPerPixel is the average then, and all samples are rendered. Goes with the
   * film: new, or the one of the moment that the render goes on from. Null: each pixel gets as many. */
  SampleAllocation* allocation = nullptr;
  /** Called with a film that a render can go on from: when `saveInterval` seconds have passed since the last
   * time, and at the end, whatever the reason for it. */
  std::function<void(const RenderPosition&)> save = {};
  double saveInterval = 60;
  /** Called while no thread writes to the film, for those who want to see it grow: first after `lookAfter`
   * seconds. Returns the seconds until the next time. */
  std::function<double()> look = {};
  double lookAfter = 0;
};

} // namespace recurse
