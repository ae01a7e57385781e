/** @file
 * Settings, resume point and statistics of a render.
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

/** State reported to the progress display, at most ten times a second and at the end, from one thread at a
 * time. */
struct RenderProgress {
  std::string phase;          ///< "photons", "picture"
  double fraction = 0;        ///< of the phase, in [0, 1]
  double elapsed = 0;         ///< since the start of the render [s]
  double secondsLeft = -1;    ///< negative: unknown
  double samplesPerPixel = 0; ///< mean of the film
  double raysPerSecond = 0;
  double error = -1;          ///< latest Film::relativeError(); negative: unknown
  double learningSeconds = 0; ///< RenderStatistics::learningProcessorSeconds up to now
  std::optional<GuideStatistics> guide = {};
};

/** Limit that ended a render. */
enum class StopReason { SAMPLES, TIME, ERROR, INTERRUPTED };

/** Figures of a render; a resumed render includes those from before the interruption. */
struct RenderStatistics {
  double processorSeconds = 0;         ///< processor time of all threads together [s]
  double learningProcessorSeconds = 0; ///< part of processorSeconds for learning before or between passes [s]
  double photonProcessorSeconds = 0;   ///< part of processorSeconds for photon maps without learning [s]
  double renderSeconds = 0, photonSeconds = 0, balanceSeconds = 0,
         gatherSeconds = 0; ///< elapsed time [s]; gather: all time without photons and balancing
  uint64_t photonsEmitted = 0, photonsStored = 0, photonsRefused = 0; ///< see ForwardStatistics
  size_t mapBytes = 0;                                                ///< of the largest photon map
  uint64_t splatsSaturated = 0; ///< contributions too large for the splat plane, which lost light
  TransportCounts counts;
  uint64_t samples = 0;                     ///< camera paths
  uint64_t least = 0, median = 0, most = 0; ///< camera paths of a pixel
  int passes = 0;                           ///< rounds of samples over the whole picture
  int forwardPasses = 0;                    ///< number of photon maps
  int threads = 0;
  StopReason stopReason = StopReason::SAMPLES;
  double error = -1;                    ///< Film::relativeError() at the end; negative: too few samples
  std::optional<GuideStatistics> guide; ///< of the latest pass; empty: no guide
  bool oneMap = false; ///< all samples share one forward pass, whose error is not included in `error`
  std::vector<std::string> notes, warnings; ///< automatic choices, and visible consequences, in words
};

/** Guide in words: "guide: 412 cells, 31 % of them sampled, learned from 180000 records". */
std::string guideText(const GuideStatistics& guide);

/**
 * Resume point. Rounds of samples are atomic per tile: of the round that begins with `sample`, each tile of
 * the picture has all samples or none. The film, and the allocation if any, hold all other state.
 */
struct RenderPosition {
  int64_t sample = 0; ///< every pixel, or with an allocation the average one, has all samples before it
  RenderStatistics statistics; ///< up to now, without notes and warnings
  /** Unfinished work of a render by several processes, regardless of `sample`. */
  std::optional<std::vector<WorkUnit>> left = {};
};

/** Largest distance from a pixel without a sample at the time limit to one with a sample, within a tile that
 * was begun [steps along rows and columns]. */
constexpr int FIRST_SAMPLE_REACH = 6;

/** A render between rounds, while no thread renders. */
class RenderPause {
 public:
  virtual ~RenderPause() = default;
  /** The integrator, with the photons of its latest pass. */
  virtual const Integrator& integrator() const = 0;
  /** Records the latest samples of a pixel that the latest pass serves, at most `count`, as they were
   * rendered; the film does not change. Before the first complete round of the pass it records the next
   * sample. With adaptive samples or a range of samples, the pixel's own samples may be others: then those of
   * these numbers are recorded. The pixel must be within the crop window. */
  virtual void record(int x, int y, int64_t count, PathRecorder& recorder) const = 0;
};

/** Limits, samples and callbacks of a render. */
struct RenderSettings {
  int samplesPerPixel = 16; ///< the integrator may need more; 0: until the time limit or the error target
  double timeLimit = 0;     ///< for the whole render [s]; 0: none
  /** Time after the limit, or after a first forward pass beyond it, that the first sample of each pixel may
   * take [s]. */
  double firstSampleTime = 1;
  /** Whether the time limit ends the first forward pass, which leaves a film without samples; else that pass
   * may exceed it. */
  bool limitsFirstPass = false;
  double errorTarget = 0; ///< Film::relativeError at which to stop; 0: none
  uint64_t seed = 0;
  /** Range of samples of each pixel, from `firstSample` up to `endSample` out of samplesPerPixel, for renders
   * to be merged; endSample 0: up to the last one. */
  int64_t firstSample = 0, endSample = 0;
  RenderPosition from = {}; ///< resume point of the film
  /** Adaptive samples; samplesPerPixel is then the average, and the range above must contain all samples. It
   * belongs to the film: new, or from the same resume point. Null: the same number for each pixel. */
  SampleAllocation* allocation = nullptr;
  /** Called with a film at a resume point: when `saveInterval` seconds have passed since the last call, and
   * at the end, for whatever reason the render ends. */
  std::function<void(const RenderPosition&)> save = {};
  double saveInterval = 60; ///< [s]
  /** Called while no thread writes to the film, to display intermediate pictures: first after `lookAfter`
   * seconds. Returns the seconds until the next call. */
  std::function<double()> look = {};
  double lookAfter = 0; ///< [s]
  /** Whether somebody waits for answer(); the round then ends soon. Called by any thread. */
  std::function<bool()> isAsked = {};
  /** Called while no thread renders, if isAsked(); must be set with it. */
  std::function<void(const RenderPause&)> answer = {};
};

} // namespace recurse
