/** @file
 * Worker of a rank, the leader included.
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

/** Time between polls for messages: during a reduction, and at all other times. */
constexpr std::chrono::microseconds BUSY_POLL{50}, IDLE_POLL{500};

/** Worker of every rank: renders units, gives its film to the reduction, and reports. */
class Worker {
 public:
  /** Prepares the integrator, including everything it learns before the first sample. */
  Worker(const Scene& scene, Integrator& integrator, const PathClasses& classes,
         const RenderSettings& settings, const std::function<void(const std::string&)>& log, bool leads);
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /** Executes a command. False at the end. */
  bool obey(const Command& command);
  /** Broadcasts the leader's plan of adaptive samples to all ranks. Elsewhere `plan` has only its size. */
  void shareStage(std::vector<std::byte> plan);
  /** Reports that are due now. */
  std::vector<FullReport> reports(bool stop);
  /** Advances the reduction. True when it has just ended; the leader then has the sum of films in `sum`. */
  bool reduced();
  bool isReducing() const { return reduction.isActive(); }
  static void clear(Film& film);

  UnitRenderer renderer;
  Film outgoing;
  FilmReduction reduction;
  std::optional<Film> sum; ///< sum of the films of all ranks, at the leader

 private:
  void takeFilm();

  SampleAllocation* allocation;
  MPI_Comm stages; ///< communicator of shareStage(), apart from reductions of films
  Figures figures;
  std::clock_t processorStart;
  Clock::time_point told{};
  bool stopSaid = false;
};

/** Runs a rank that does not lead, until the end. */
void follow(Worker& worker, const std::atomic<bool>& stop);

} // namespace recurse::apps
