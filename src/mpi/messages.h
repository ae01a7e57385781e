/** @file
 * Messages between the leader and the ranks.
 */
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "recurse/core/threads/processorTime.h"
#include "recurse/render/renderSettings.h"
#include "recurse/render/workQueue.h"

namespace recurse::apps {

constexpr int LEADER = 0;

using Clock = std::chrono::steady_clock;

/** Message from the leader to a rank. */
struct Command {
  enum Kind : int64_t { UNIT, TAKE_FILM, STAGE, STOP, END };
  int64_t kind = UNIT, id = 0;
  WorkUnit unit;
};

/** Additive numbers of RenderStatistics. */
struct Figures {
  double photonSeconds = 0, balanceSeconds = 0, processorSeconds = 0, learningProcessorSeconds = 0,
         photonProcessorSeconds = 0, truncatedThroughput = 0;
  uint64_t photonsEmitted = 0, photonsStored = 0, photonsRefused = 0, mapBytes = 0, rays = 0, nonFinite = 0,
           gathers = 0, photonsFound = 0;
  int64_t forwardPasses = 0;
  KernelRadii causticRadii, otherRadii;
  LengthRange lengths;

  Figures() = default;
  explicit Figures(const RenderStatistics& s)
      : photonSeconds(s.photonSeconds), balanceSeconds(s.balanceSeconds),
        processorSeconds(s.processorSeconds), learningProcessorSeconds(s.learningProcessorSeconds),
        photonProcessorSeconds(s.photonProcessorSeconds), truncatedThroughput(s.counts.truncatedThroughput),
        photonsEmitted(s.photonsEmitted), photonsStored(s.photonsStored), photonsRefused(s.photonsRefused),
        mapBytes(s.mapBytes), rays(s.counts.rays), nonFinite(s.counts.nonFinite), gathers(s.counts.gathers),
        photonsFound(s.counts.photonsFound), forwardPasses(s.forwardPasses),
        causticRadii(s.counts.causticRadii), otherRadii(s.counts.otherRadii), lengths(s.counts.lengths) {}
  void addTo(RenderStatistics& s) const {
    s.photonSeconds += photonSeconds;
    s.balanceSeconds += balanceSeconds;
    s.processorSeconds += processorSeconds;
    s.learningProcessorSeconds += learningProcessorSeconds;
    s.photonProcessorSeconds += photonProcessorSeconds;
    s.counts.truncatedThroughput += truncatedThroughput;
    s.photonsEmitted += photonsEmitted;
    s.photonsStored += photonsStored;
    s.photonsRefused += photonsRefused;
    s.mapBytes = std::max<size_t>(s.mapBytes, mapBytes);
    s.counts.rays += rays;
    s.counts.nonFinite += nonFinite;
    s.counts.gathers += gathers;
    s.counts.photonsFound += photonsFound;
    s.counts.causticRadii.add(causticRadii);
    s.counts.otherRadii.add(otherRadii);
    s.counts.lengths.add(lengths);
    s.forwardPasses += static_cast<int>(forwardPasses);
  }
};

/** Message from a rank to the leader, followed by unfinished units, pilot samples and a failure's text. */
struct Report {
  int64_t finished = -1; ///< id of a unit; -1: none
  double seconds = 0;    ///< time of the unit
  double tileSamples = 0, photonProgress = 0;
  uint64_t rays = 0;
  int64_t stop = 0, threads = 0;
  Figures figures;
  uint64_t leftCount = 0, pilotCount = 0, failureBytes = 0;
};
struct FullReport : Report {
  std::vector<WorkUnit> left;
  std::vector<float> pilots; ///< UnitRenderer::Done
  std::string failure;
};

void sendCommand(int rank, const Command& command);
/** Next command of the leader, if one has arrived. */
std::optional<Command> receivedCommand();

void sendReport(const FullReport& report);
/** Next report and the rank that sent it, if one has arrived. */
std::optional<std::pair<int, FullReport>> receivedReport();

} // namespace recurse::apps
