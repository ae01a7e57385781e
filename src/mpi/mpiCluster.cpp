/** @file
 * MPI ranks: agreement at the start, exchange of texts, common render.
 */
#include "mpi/mpiCluster.h"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include <mpi.h>
#include <sched.h>

#include "mpi/leader.h"
#include "mpi/sharedPhotons.h"
#include "recurse/core/io/error.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/core/threads/watchdog.h"
#include "render/progressEstimate.h"
#include "render/stopRule.h"

namespace recurse::apps {

namespace {

/** Text of an identity: a line "name\tvalue\n" for each entry. */
std::string textOf(const std::map<std::string, std::string>& identity) {
  std::string out;
  for (const auto& [name, value] : identity) out += name + "\t" + value + "\n";
  return out;
}
std::map<std::string, std::string> identityOf(const std::string& text) {
  std::map<std::string, std::string> out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (const size_t tab = line.find('\t'); tab != std::string::npos)
      out[line.substr(0, tab)] = line.substr(tab + 1);
  return out;
}
/** First character of the text of a rank that cannot join. */
constexpr char FAILED = '!';

/** Shoots the photons of the only pass, shared by all ranks. A stop at one rank stops all: each then shoots
 * the photons alone when it needs them. */
void shootTogether(Worker& worker, const std::function<bool()>& isToEnd, Clock::time_point start,
                   const std::function<void(const RenderProgress&)>& progress) {
  std::atomic<bool> stopping{isToEnd()};
  SharedPhotons sharing(stopping);
  ForwardControl control;
  control.stop = &stopping;
  control.sharing = &sharing;
  ProgressReporter reporter(progress);
  control.progress = [&](double fraction) {
    reporter.tell([&] { return photonProgress(fraction, secondsSince(start)); });
  };
  const Watchdog watchdog([&] {
    if (isToEnd()) stopping = true;
  });
  worker.renderer.shootOnlyPass(control);
}

} // namespace

MpiCluster::MpiCluster(int& argc, char**& argv) {
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  MPI_Comm onHost;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &onHost);
  int neighbours = 1;
  MPI_Comm_size(onHost, &neighbours);
  MPI_Comm_free(&onHost);
  // mpirun binds each rank to one core by default.
  if (std::getenv("OMPI_COMM_WORLD_LOCAL_SIZE")) {
    cpu_set_t all;
    CPU_ZERO(&all);
    for (int i = 0; i < CPU_SETSIZE; ++i) CPU_SET(i, &all);
    sched_setaffinity(0, sizeof all, &all);
    ownThreads = std::max(1, availableCores() / neighbours);
  }
}

MpiCluster::~MpiCluster() { MPI_Finalize(); }

void MpiCluster::abort(int status) {
  MPI_Abort(MPI_COMM_WORLD, status);
  std::abort();
}

std::vector<std::string> MpiCluster::gather(const std::string& text) const {
  const int length = static_cast<int>(text.size());
  std::vector<int> lengths(static_cast<size_t>(size)), places(lengths.size());
  MPI_Gather(&length, 1, MPI_INT, lengths.data(), 1, MPI_INT, LEADER, MPI_COMM_WORLD);
  int all = 0;
  for (size_t i = 0; i < lengths.size(); ++i) {
    places[i] = all;
    all += lengths[i];
  }
  std::string joined(static_cast<size_t>(all), '\0');
  MPI_Gatherv(text.data(), length, MPI_CHAR, joined.data(), lengths.data(), places.data(), MPI_CHAR, LEADER,
              MPI_COMM_WORLD);
  std::vector<std::string> out;
  for (size_t i = 0; rank == LEADER && i < lengths.size(); ++i)
    out.push_back(joined.substr(size_t(places[i]), size_t(lengths[i])));
  return out;
}

std::string MpiCluster::tellAll(std::string text) const {
  auto length = static_cast<int>(text.size());
  MPI_Bcast(&length, 1, MPI_INT, LEADER, MPI_COMM_WORLD);
  text.resize(static_cast<size_t>(length));
  MPI_Bcast(text.data(), length, MPI_CHAR, LEADER, MPI_COMM_WORLD);
  return text;
}

void MpiCluster::requireAgreement(const std::string& text) {
  char host[MPI_MAX_PROCESSOR_NAME] = {};
  int length = 0;
  MPI_Get_processor_name(host, &length);
  const std::vector<std::string> hosts = gather(host), texts = gather(text);
  std::string refusal;
  if (rank == LEADER) {
    const auto own = identityOf(texts[0]);
    for (size_t r = 0; r < texts.size(); ++r) {
      names.push_back("rank " + std::to_string(r) + " on " + hosts[r]);
      if (texts[r].starts_with(FAILED)) {
        refusal += (refusal.empty() ? "" : "\n") + names[r] + ": " + texts[r].substr(1);
        continue;
      }
      if (texts[0].starts_with(FAILED)) continue;
      auto other = identityOf(texts[r]);
      for (const auto& [name, value] : own)
        if (other[name] != value)
          refusal += (refusal.empty() ? "" : "\n") + names[r] + ": " + name + ": " +
                     (other[name].empty() ? "not said" : other[name]) + ", " + value + " at " + names[0];
    }
    if (texts[0].starts_with(FAILED)) refusal = names[0] + " could not start";
  }
  refusal = tellAll(refusal);
  hasJoined = true;
  if (!refusal.empty()) throw Error(refusal);
}

void MpiCluster::join(const std::map<std::string, std::string>& identity) {
  requireAgreement(textOf(identity));
  inRender = true;
  onJoined();
}

void MpiCluster::fail(const std::string& why) {
  try {
    requireAgreement(FAILED + why);
  } catch (const Error&) { // reported already by the rank that failed
  }
}

RenderStatistics MpiCluster::render(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                                    const RenderSettings& settings, Film& film, const std::atomic<bool>& stop,
                                    const std::function<void(const RenderProgress&)>& progress,
                                    const std::function<void(const std::string&)>& log) {
  // The leader's own worker needs an allocation apart from the one that is saved.
  RenderSettings workerSettings = settings;
  std::optional<SampleAllocation> workerAllocation;
  if (leads() && settings.allocation)
    workerSettings.allocation = &workerAllocation.emplace(*settings.allocation);
  const Clock::time_point start = startOf(settings);
  // Shared photons require the same learning at all ranks. Where one rank does not finish learning in time,
  // no photons are shot either.
  const StopRule rule(settings, false);
  const auto isToEnd = [&] { return stop || rule.isTimeUp(secondsSince(start)); };
  const auto logHere = leads() ? log : std::function<void(const std::string&)>();
  Worker worker = interruptibly(
      isToEnd, [&] { return Worker(scene, integrator, classes, workerSettings, logHere, leads()); });
  RenderStatistics statistics;
  if (size > 1 && worker.renderer.samples().hasOneMap())
    shootTogether(worker, isToEnd, start, leads() ? progress : nullptr);
  if (leads()) {
    // The film needs the splats of the ranks' films.
    if (worker.sum->splats()) film.enableSplats(worker.sum->splats()->unit());
    if (settings.allocation)
      settings.allocation->setMapPerSample(worker.renderer.samples().hasMapPerSample());
    statistics = lead(worker, names, settings, film, start, stop, progress, log);
    warnOfDarkFrames(film, classes, statistics, log);
  } else {
    follow(worker, stop);
  }
  inRender = false;
  return statistics;
}

} // namespace recurse::apps
