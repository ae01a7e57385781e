/** @file
 * What every rank does.
 */
#pragma once

#include <atomic>
#include <chrono>
#include <ctime>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <mpi.h>

#include "mpi/filmReduction.h"
#include "mpi/messages.h"
#include "render/unitRenderer.h"

namespace recurse::apps {

/** Between looks for messages, while films are on their way and else. */
constexpr std::chrono::microseconds BUSY_POLL{50}, IDLE_POLL{500};

/** What every rank does: renders units, gives its film away, and reports. */
class Worker {
 public:
  /** Learns what the integrator learns before the first sample. */
  Worker(const Scene& scene, Integrator& integrator, const PathClasses& classes,
         const RenderSettings& settings, const std::function<void(const std::string&)>& log, bool leads);
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /** False at the end. */
  bool obey(const Command& command);
  /** The leader's plan of adaptive samples goes to all, together. Elsewhere `plan` is of the right size. */
  void shareStage(std::vector<std::byte> plan);
  /** What there is to be said now. */
  std::vector<FullReport> reports(bool stop);
  /** Goes on with the reduction. True when it has just ended, and the leader has the sum in films(). */
  bool reduced();
  bool isReducing() const { return reduction.isActive() || filmWanted; }
  static void clear(Film& film);

  UnitRenderer renderer;
  Film outgoing;
  FilmReduction reduction;
  std::optional<Film> sum; ///< of all ranks, at the leader

 private:
  SampleAllocation* allocation;
  MPI_Comm stages; ///< for what shareStage() sends, apart from films that are on their way
  Figures figures;
  std::clock_t processorStart;
  Clock::time_point told{};
  bool stopSaid = false, filmWanted = false;
};

/** A rank that does not lead: until the end. */
void follow(Worker& worker, const std::atomic<bool>& stop);

} // namespace recurse::apps
