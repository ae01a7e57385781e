/** @file
 * Worker of a rank: renders units, gives films to the reduction, reports.
 */
#include "mpi/worker.h"

#include <algorithm>
#include <exception>
#include <new>
#include <thread>
#include <utility>

#include "recurse/core/threads/parallel.h"

namespace recurse::apps {

namespace {

/** Time between reports of a rank [s]. */
constexpr double REPORT_SECONDS = 0.2;

} // namespace

Worker::Worker(const Scene& scene, Integrator& integrator, const PathClasses& classes,
               const RenderSettings& settings, const std::function<void(const std::string&)>& log, bool leads)
    : renderer(scene, integrator, classes, settings, log), outgoing(renderer.emptyFilm()),
      reduction(outgoing), allocation(settings.allocation), processorStart(std::clock()) {
  MPI_Comm_dup(MPI_COMM_WORLD, &stages);
  if (leads) sum.emplace(renderer.emptyFilm());
}

Worker::~Worker() { MPI_Comm_free(&stages); }

bool Worker::obey(const Command& c) {
  if (c.kind == Command::UNIT) renderer.add(c.id, c.unit);
  if (c.kind == Command::TAKE_FILM) takeFilm();
  if (c.kind == Command::STAGE) shareStage(allocation->plan());
  if (c.kind == Command::STOP) renderer.stop();
  return c.kind != Command::END;
}

void Worker::shareStage(std::vector<std::byte> plan) {
  constexpr size_t PIECE = size_t(1) << 30; // MPI counts have 31 bits
  for (size_t at = 0; at < plan.size(); at += PIECE)
    MPI_Bcast(plan.data() + at, static_cast<int>(std::min(PIECE, plan.size() - at)), MPI_BYTE, LEADER,
              stages);
  allocation->setPlan(plan);
}

std::vector<FullReport> Worker::reports(bool stop) {
  std::vector<FullReport> out;
  UnitRenderer::Events events = renderer.events();
  if (events.filmTaken) reduction.start(outgoing, sum ? &*sum : nullptr);
  for (UnitRenderer::Done& d : events.done) {
    FullReport& r = out.emplace_back();
    r.finished = d.id;
    r.seconds = d.seconds;
    r.left = std::move(d.left);
    r.pilots = std::move(d.pilots);
    figures = Figures(d.statistics);
  }
  if (out.empty() && (events.failure || (stop && !stopSaid) || secondsSince(told) > REPORT_SECONDS))
    out.emplace_back();
  for (FullReport& r : out) {
    figures.processorSeconds = double(std::clock() - processorStart) / CLOCKS_PER_SEC;
    r.figures = figures;
    r.tileSamples = renderer.tileSamples();
    r.photonProgress = renderer.photonProgress();
    r.rays = renderer.rays();
    r.threads = threadCount();
    r.stop = stop;
    stopSaid = stop;
    told = Clock::now();
  }
  if (events.failure) {
    try {
      std::rethrow_exception(events.failure);
    } catch (const std::bad_alloc&) {
      out.back().failure = "out of memory";
    } catch (const std::exception& error) {
      out.back().failure = error.what();
    }
  }
  return out;
}

/** Takes the film after the units that were added before, and before any later one: the leader counts units
 * by this order. The latest reduction has ended at the leader, so that its end is near here too. */
void Worker::takeFilm() {
  while (reduction.isActive())
    if (!reduced()) std::this_thread::sleep_for(BUSY_POLL);
  renderer.takeFilm(outgoing);
}

bool Worker::reduced() {
  const bool ended = reduction.ended();
  if (ended) clear(outgoing);
  return ended;
}

void Worker::clear(Film& film) {
  for (const std::span<std::byte> part : film.state()) std::fill(part.begin(), part.end(), std::byte(0));
}

void follow(Worker& worker, const std::atomic<bool>& stop) {
  for (;;) {
    if (const std::optional<Command> command = receivedCommand()) {
      if (!worker.obey(*command)) return;
      continue;
    }
    for (const FullReport& r : worker.reports(stop)) sendReport(r);
    worker.reduced();
    std::this_thread::sleep_for(worker.isReducing() ? BUSY_POLL : IDLE_POLL);
  }
}

} // namespace recurse::apps
