/** @file
 * Work dealt out and films added up by MPI.
 */
#include "mpi/mpiCluster.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <ctime>
#include <optional>
#include <sstream>
#include <thread>
#include <utility>
#include <vector>

#include <mpi.h>
#include <sched.h>

#include "recurse/core/error.h"
#include "recurse/core/parallel.h"
#include "recurse/core/text.h"
#include "recurse/transport/unitRenderer.h"

namespace recurse::apps {

namespace {

using Clock = std::chrono::steady_clock;

enum Tag { COMMAND = 1, REPORT = 2 };
constexpr int LEADER = 0;
/** Seconds of a unit, where there is a choice: dealing them out costs next to nothing then, and whoever is
 * slow holds up the others for so long at most. */
constexpr double UNIT_SECONDS = 1;
/** Between looks for messages, while films are on their way and else. */
constexpr std::chrono::microseconds BUSY_POLL{50}, IDLE_POLL{500};
/** Between reports of a rank. */
constexpr double REPORT_SECONDS = 0.2;
/** Looking at the error takes no more than one part in so many of the time. */
constexpr double ERROR_PART = 20;

double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/** From the leader to a rank. */
struct Command {
  enum Kind : int64_t { UNIT, TAKE_FILM, STOP, END };
  int64_t kind = UNIT, id = 0;
  WorkUnit unit;
};

/** The numbers of RenderStatistics that add up. */
struct Figures {
  double photonSeconds = 0, balanceSeconds = 0, processorSeconds = 0, truncatedThroughput = 0;
  uint64_t photonsEmitted = 0, photonsStored = 0, photonsRefused = 0, mapBytes = 0, rays = 0, nonFinite = 0,
           gathers = 0, photonsFound = 0;
  int64_t forwardPasses = 0;

  Figures() = default;
  explicit Figures(const RenderStatistics& s)
      : photonSeconds(s.photonSeconds), balanceSeconds(s.balanceSeconds),
        processorSeconds(s.processorSeconds), truncatedThroughput(s.counts.truncatedThroughput),
        photonsEmitted(s.photonsEmitted), photonsStored(s.photonsStored), photonsRefused(s.photonsRefused),
        mapBytes(s.mapBytes), rays(s.counts.rays), nonFinite(s.counts.nonFinite), gathers(s.counts.gathers),
        photonsFound(s.counts.photonsFound), forwardPasses(s.forwardPasses) {}
  void addTo(RenderStatistics& s) const {
    s.photonSeconds += photonSeconds;
    s.balanceSeconds += balanceSeconds;
    s.processorSeconds += processorSeconds;
    s.counts.truncatedThroughput += truncatedThroughput;
    s.photonsEmitted += photonsEmitted;
    s.photonsStored += photonsStored;
    s.photonsRefused += photonsRefused;
    s.mapBytes = std::max<size_t>(s.mapBytes, mapBytes);
    s.counts.rays += rays;
    s.counts.nonFinite += nonFinite;
    s.counts.gathers += gathers;
    s.counts.photonsFound += photonsFound;
    s.forwardPasses += static_cast<int>(forwardPasses);
  }
};

/** From a rank to the leader. Units that are left, and the text of a failure, come after it. */
struct Report {
  int64_t finished = -1; ///< a unit; -1: none
  double seconds = 0;    ///< that it took
  double tileSamples = 0, photonProgress = 0;
  uint64_t rays = 0;
  int64_t stop = 0, threads = 0;
  Figures figures;
  uint64_t leftCount = 0, failureBytes = 0;
};
struct FullReport : Report {
  std::vector<WorkUnit> left;
  std::string failure;
};

template <class T> void append(std::vector<char>& bytes, const T* values, size_t count) {
  if (count == 0) return;
  const size_t at = bytes.size();
  bytes.resize(at + sizeof(T) * count);
  std::memcpy(&bytes[at], values, sizeof(T) * count);
}

// MPI passes nothing to an operation but the numbers.
constexpr size_t MAX_PARTS = 8;
std::array<Film::StatePart::Add, MAX_PARTS> adders{};
template <size_t PART> void addPart(void* from, void* into, int* count, MPI_Datatype*) {
  adders[PART](from, into, static_cast<size_t>(*count));
}
template <size_t... PARTS>
constexpr std::array<MPI_User_function*, MAX_PARTS> operationsOf(std::index_sequence<PARTS...>) {
  return {addPart<PARTS>...};
}

/** Adds up the films of all ranks at the leader, while they do other things. */
class FilmReduction {
 public:
  explicit FilmReduction(Film& shape) {
    const std::vector<Film::StatePart> parts = shape.stateParts();
    if (parts.size() > MAX_PARTS) throw Error("internal error: a film of too many parts");
    static const auto functions = operationsOf(std::make_index_sequence<MAX_PARTS>());
    for (size_t i = 0; i < parts.size(); ++i) {
      adders[i] = parts[i].add;
      MPI_Type_contiguous(static_cast<int>(parts[i].elementBytes), MPI_BYTE, &types.emplace_back());
      MPI_Type_commit(&types.back());
      MPI_Op_create(functions[i], 1, &operations.emplace_back());
    }
  }
  ~FilmReduction() {
    for (MPI_Datatype& t : types) MPI_Type_free(&t);
    for (MPI_Op& o : operations) MPI_Op_free(&o);
  }
  FilmReduction(const FilmReduction&) = delete;
  FilmReduction& operator=(const FilmReduction&) = delete;

  /** `sum`: at the leader, where it is to go; null elsewhere. Both stay until it has ended. */
  void start(Film& own, Film* sum) {
    const std::vector<Film::StatePart> from = own.stateParts();
    const std::vector<Film::StatePart> into = sum ? sum->stateParts() : from;
    requests.clear();
    bytesSent = 0;
    for (size_t i = 0; i < from.size(); ++i) {
      bytesSent += from[i].bytes.size();
      // Counts are of 31 bits.
      const size_t count = from[i].bytes.size() / from[i].elementBytes;
      for (size_t at = 0; at < count; at += CHUNK)
        MPI_Ireduce(from[i].bytes.data() + at * from[i].elementBytes,
                    sum ? into[i].bytes.data() + at * into[i].elementBytes : nullptr,
                    static_cast<int>(std::min(CHUNK, count - at)), types[i], operations[i], LEADER,
                    MPI_COMM_WORLD, &requests.emplace_back());
    }
    active = true;
  }
  bool isActive() const { return active; }
  /** True when it has just ended. */
  bool ended() {
    if (!active) return false;
    int done = 0;
    MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE);
    if (done) active = false;
    return done != 0;
  }
  size_t bytes() const { return bytesSent; }

 private:
  /** So that what has come is added while the rest is on its way. */
  static constexpr size_t CHUNK = 1 << 18;
  std::vector<MPI_Datatype> types;
  std::vector<MPI_Op> operations;
  std::vector<MPI_Request> requests;
  size_t bytesSent = 0;
  bool active = false;
};

/** What every rank does: renders units, gives its film away, and reports. */
class Worker {
 public:
  Worker(const Scene& scene, Integrator& integrator, const PathClasses& classes,
         const RenderSettings& settings, const std::function<void(const std::string&)>& log, bool leads)
      : renderer(scene, integrator, classes, settings, log), outgoing(renderer.emptyFilm()),
        reduction(outgoing), processorStart(std::clock()) {
    if (leads) sum.emplace(renderer.emptyFilm());
  }

  /** False at the end. */
  bool obey(const Command& c) {
    if (c.kind == Command::UNIT) renderer.add(c.id, c.unit);
    if (c.kind == Command::TAKE_FILM) filmWanted = true;
    if (c.kind == Command::STOP) renderer.stop();
    return c.kind != Command::END;
  }
  /** What there is to be said now. */
  std::vector<FullReport> reports(bool stop) {
    std::vector<FullReport> out;
    UnitRenderer::Events events = renderer.events();
    if (events.filmTaken) reduction.start(outgoing, sum ? &*sum : nullptr);
    for (UnitRenderer::Done& d : events.done) {
      FullReport& r = out.emplace_back();
      r.finished = d.id;
      r.seconds = d.seconds;
      r.left = std::move(d.left);
      figures = Figures(d.statistics);
    }
    if (out.empty() && (events.failure || (stop && !stopSaid) || since(told) > REPORT_SECONDS))
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
  /** Goes on with the reduction. True when it has just ended, and the leader has the sum in films(). */
  bool reduced() {
    const bool ended = reduction.ended();
    if (ended) clear(outgoing);
    if (filmWanted && !reduction.isActive()) {
      filmWanted = false;
      renderer.takeFilm(outgoing);
    }
    return ended;
  }
  bool isReducing() const { return reduction.isActive() || filmWanted; }
  static void clear(Film& film) {
    for (const std::span<std::byte> part : film.state()) std::fill(part.begin(), part.end(), std::byte(0));
  }

  UnitRenderer renderer;
  Film outgoing;
  FilmReduction reduction;
  std::optional<Film> sum; ///< of all ranks, at the leader

 private:
  Figures figures;
  std::clock_t processorStart;
  Clock::time_point told{};
  bool stopSaid = false, filmWanted = false;
};

void send(const FullReport& report) {
  Report head = report;
  head.leftCount = report.left.size();
  head.failureBytes = report.failure.size();
  std::vector<char> bytes;
  append(bytes, &head, 1);
  append(bytes, report.left.data(), report.left.size());
  append(bytes, report.failure.data(), report.failure.size());
  MPI_Send(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, LEADER, REPORT, MPI_COMM_WORLD);
}

/** The next report that has arrived, and who it is from. */
std::optional<std::pair<int, FullReport>> receivedReport() {
  int there = 0;
  MPI_Status status;
  MPI_Iprobe(MPI_ANY_SOURCE, REPORT, MPI_COMM_WORLD, &there, &status);
  if (!there) return {};
  int count = 0;
  MPI_Get_count(&status, MPI_BYTE, &count);
  std::vector<char> bytes(static_cast<size_t>(count));
  MPI_Recv(bytes.data(), count, MPI_BYTE, status.MPI_SOURCE, REPORT, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  FullReport out;
  Report& head = out;
  std::memcpy(static_cast<void*>(&head), bytes.data(), sizeof(Report));
  out.left.resize(head.leftCount);
  const char* rest = bytes.data() + sizeof(Report);
  if (head.leftCount > 0) std::memcpy(out.left.data(), rest, head.leftCount * sizeof(WorkUnit));
  out.failure.assign(rest + head.leftCount * sizeof(WorkUnit), head.failureBytes);
  return std::pair(status.MPI_SOURCE, std::move(out));
}

/** A rank that does not lead: until the end. */
void follow(Worker& worker, const std::atomic<bool>& stop) {
  for (;;) {
    int there = 0;
    MPI_Iprobe(LEADER, COMMAND, MPI_COMM_WORLD, &there, MPI_STATUS_IGNORE);
    if (there) {
      Command command;
      MPI_Recv(&command, sizeof command, MPI_BYTE, LEADER, COMMAND, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
      if (!worker.obey(command)) return;
      continue;
    }
    for (const FullReport& r : worker.reports(stop)) send(r);
    worker.reduced();
    std::this_thread::sleep_for(worker.isReducing() ? BUSY_POLL : IDLE_POLL);
  }
}

/** The rank that deals out. */
class Leader {
 public:
  Leader(Worker& worker, int size, const std::vector<std::string>& names, const RenderSettings& settings,
         Film& film, const std::atomic<bool>& stop,
         const std::function<void(const RenderProgress&)>& progress)
      : worker(worker), names(names), settings(settings), film(film), stop(stop), progress(progress),
        ranks(static_cast<size_t>(size)), samples(worker.renderer.samples()), tiles(double(samples.tiles())),
        firstSample(settings.firstSample),
        queue(samples.samples(), int64_t(samples.tiles()), samples.passes(), workLeft()),
        start(Clock::now() - std::chrono::duration_cast<Clock::duration>(
                                 std::chrono::duration<double>(settings.from.statistics.renderSeconds))),
        here(Clock::now()), saved(here), looked(here), errorLooked(here), lookAfter(settings.lookAfter),
        before(double(film.totalSamples()) / double(film.bounds().area()) * tiles) {}

  RenderStatistics lead() {
    if (settings.errorTarget > 0 && before > 0) lookAtError();
    if (settings.timeLimit > 0 && before > 0 && elapsed() > settings.timeLimit) end(StopReason::TIME);
    while (!isOver()) {
      bool quiet = true;
      while (auto message = receivedReport()) {
        take(message->first, message->second);
        quiet = false;
      }
      for (const FullReport& r : worker.reports(stop)) take(LEADER, r);
      if (worker.reduced()) addFilms();
      watch();
      deal();
      reduceIfDue();
      tellProgress();
      if (quiet) std::this_thread::sleep_for(worker.isReducing() ? BUSY_POLL : IDLE_POLL);
    }
    for (int r = 0; r < int(ranks.size()); ++r)
      if (r != LEADER) send(r, {Command::END, 0, {}});
    if (!reason) lookAtError();
    if (settings.save) save();
    RenderStatistics out = statistics();
    countSamples(film, out);
    out.error = error;
    out.notes = worker.renderer.statistics().notes;
    for (const std::string& w : worker.renderer.statistics().warnings) out.warnings.push_back(w);
    out.stopReason = reason.value_or(StopReason::SAMPLES);
    out.oneMap = samples.passes() == 1 && out.photonsEmitted > 0;
    out.gatherSeconds = std::max(0.0, out.renderSeconds - out.photonSeconds - out.balanceSeconds);
    return out;
  }

 private:
  struct Rank {
    int units = 0;       ///< that it has
    double unitSize = 0; ///< of the last one
    double speed = 0;    ///< samples of a tile in a second; 0: not known yet
    FullReport last;
  };
  struct Dealt {
    int64_t id = 0;
    WorkUnit unit;
    int64_t reduction = 0; ///< that it will be in
    bool finished = false;
  };

  std::vector<WorkUnit> workLeft() const {
    if (settings.from.left) return *settings.from.left;
    const int64_t next = std::max(firstSample, settings.from.sample);
    for (size_t i = 0; i < film.bounds().area(); ++i)
      if (film.samples(i) != uint64_t(next - firstSample))
        throw Error(
            "--resume: one process was interrupted while some pixels had more samples than others; one "
            "has to go on with it");
    const int64_t last = settings.endSample > 0 ? settings.endSample : samples.samples();
    return {WorkUnit{next, last, 0, int64_t(samples.tiles())}};
  }
  double elapsed() const { return since(start); }
  static void sendTo(int rank, const Command& c) {
    MPI_Send(&c, sizeof c, MPI_BYTE, rank, COMMAND, MPI_COMM_WORLD);
  }
  void send(int rank, const Command& c) {
    if (rank == LEADER)
      worker.obey(c);
    else
      sendTo(rank, c);
  }
  void sendAll(Command::Kind kind) {
    for (int r = 0; r < int(ranks.size()); ++r) send(r, {kind, 0, {}});
  }

  void take(int from, const FullReport& r) {
    Rank& rank = ranks[size_t(from)];
    if (!r.failure.empty()) throw Error(names[size_t(from)] + ": " + r.failure);
    if (r.stop) stopped = true;
    rank.last = r;
    if (r.finished < 0) return;
    --rank.units;
    const auto d =
        std::find_if(dealt.begin(), dealt.end(), [&](const Dealt& u) { return u.id == r.finished; });
    double done = d->unit.size();
    for (const WorkUnit& left : r.left) {
      queue.giveBack(left);
      done -= left.size();
    }
    if (done > 0 && r.seconds > 0) rank.speed = done / r.seconds;
    anythingNew = anythingNew || done > 0;
    d->finished = true;
    if (d->reduction <= reductionsDone) dealt.erase(d);
  }

  int unitsOut() const {
    int out = 0;
    for (const Rank& r : ranks) out += r.units;
    return out;
  }
  bool everyPixelHasASample() const {
    if (before >= tiles) return true;
    if (!queue.empty() && queue.nextSample() <= firstSample) return false;
    return std::none_of(dealt.begin(), dealt.end(),
                        [&](const Dealt& d) { return !d.finished && d.unit.firstSample <= firstSample; });
  }

  /** Whether it is to end early. */
  void watch() {
    if (reason) return;
    if (stop || stopped) return end(StopReason::INTERRUPTED);
    if (settings.timeLimit <= 0) return;
    if (everyPixelHasASample()) {
      if (firstSampleEnd == 0) firstSampleEnd = elapsed();
      if (elapsed() + reductionSeconds > std::max(settings.timeLimit, firstSampleEnd)) end(StopReason::TIME);
    } else if (unitsOut() > 0 && worker.renderer.tileSamples() > 0 &&
               elapsed() > settings.timeLimit + settings.firstSampleTime) {
      end(StopReason::TIME);
    }
  }
  void end(StopReason why) {
    reason = why;
    if (unitsOut() > 0) sendAll(Command::STOP);
  }

  void deal() {
    if (reason) return;
    const int workers = int(ranks.size());
    for (bool any = true; any && !queue.empty();) {
      any = false;
      for (int r = 0; r < workers && !queue.empty(); ++r) {
        Rank& rank = ranks[size_t(r)];
        // A second one is on its way while the first is worked on, but not where they run out.
        const bool plenty = queue.size() > 4 * double(workers) * rank.unitSize && rank.speed > 0;
        if (rank.units >= (plenty ? 2 : 1)) continue;
        double wanted =
            rank.speed > 0 ? UNIT_SECONDS * rank.speed : std::min(tiles, queue.size()) / (8 * workers);
        if (settings.timeLimit > 0 && rank.speed > 0 && queue.nextSample() > firstSample) {
          const double fits =
              (settings.timeLimit - elapsed() - reductionSeconds) * rank.speed - rank.units * rank.unitSize;
          if (queue.smallest(workers) > fits) continue;
          wanted = std::min(wanted, fits);
        }
        const std::optional<WorkUnit> unit = queue.take(wanted, workers);
        if (!unit) continue;
        rank.unitSize = unit->size();
        ++rank.units;
        dealt.push_back({++lastId, *unit, reductionsBegun + 1, false});
        send(r, {Command::UNIT, lastId, *unit});
        any = true;
      }
    }
    // What is left takes too long for the time.
    if (!queue.empty() && unitsOut() == 0) reason = StopReason::TIME;
  }

  bool isReducing() const { return reductionsDone < reductionsBegun; }
  void reduceIfDue() {
    if (isReducing()) return;
    const bool over = unitsOut() == 0 && (queue.empty() || reason);
    const bool due = !reason && ((settings.save && since(saved) > settings.saveInterval) ||
                                 (settings.look && since(looked) > lookAfter) ||
                                 (settings.errorTarget > 0 && since(errorLooked) > errorInterval));
    if (!anythingNew || !(over || due)) return;
    anythingNew = false;
    ++reductionsBegun;
    reductionStart = Clock::now();
    sendAll(Command::TAKE_FILM);
  }
  void addFilms() {
    film.add(*worker.sum);
    Worker::clear(*worker.sum);
    ++reductionsDone;
    reductionSeconds = std::min(since(reductionStart), UNIT_SECONDS);
    std::erase_if(dealt, [&](const Dealt& d) { return d.finished && d.reduction <= reductionsDone; });
    if (reason) return;
    if (settings.errorTarget > 0) lookAtError();
    if (settings.save && since(saved) > settings.saveInterval) save();
    if (settings.look && since(looked) > lookAfter) {
      lookAfter = settings.look();
      looked = Clock::now();
    }
  }
  bool isOver() const {
    return unitsOut() == 0 && !isReducing() && !anythingNew && (queue.empty() || reason);
  }

  void lookAtError() {
    const Clock::time_point now = Clock::now();
    const double is = film.relativeError();
    errorLooked = Clock::now();
    errorInterval = std::max(0.5, ERROR_PART * (reductionSeconds + since(now)));
    if (!std::isfinite(is)) return;
    error = is;
    if (settings.errorTarget > 0 && error <= settings.errorTarget && !reason &&
        (!queue.empty() || unitsOut() > 0))
      end(StopReason::ERROR);
  }

  RenderStatistics statistics() const {
    RenderStatistics out = settings.from.statistics;
    for (const Rank& r : ranks) {
      RenderStatistics one;
      r.last.figures.addTo(one);
      one.photonSeconds /= double(ranks.size()); // they work at the same time
      one.balanceSeconds /= double(ranks.size());
      Figures(one).addTo(out);
      out.threads += static_cast<int>(r.last.threads);
    }
    out.passes = static_cast<int>(double(film.totalSamples()) / double(film.bounds().area()));
    out.renderSeconds = elapsed();
    return out;
  }

  void save() {
    std::vector<WorkUnit> left = queue.left();
    for (const Dealt& d : dealt)
      if (d.reduction > reductionsDone) left.push_back(d.unit);
    RenderPosition position{samples.samples(), statistics(), {}};
    for (const WorkUnit& unit : left) position.sample = std::min(position.sample, unit.firstSample);
    position.statistics.notes.clear();
    position.statistics.warnings.clear();
    position.left = std::move(left);
    settings.save(position);
    saved = Clock::now();
  }

  void tellProgress() {
    if (!progress || since(told) < 0.1) return;
    told = Clock::now();
    RenderProgress p;
    p.elapsed = elapsed();
    double done = worker.renderer.tileSamples(), rays = double(worker.renderer.rays());
    for (size_t r = 1; r < ranks.size(); ++r) {
      done += ranks[r].last.tileSamples;
      rays += double(ranks[r].last.rays);
    }
    p.error = error;
    if (done == 0) {
      p.phase = "photons";
      p.fraction = worker.renderer.photonProgress();
      return progress(p);
    }
    p.phase = "picture";
    p.samplesPerPixel = (before + done) / tiles;
    const double working = since(here);
    p.raysPerSecond = rays / working;
    double left = INFINITY;
    if (settings.samplesPerPixel > 0) {
      double size = queue.size();
      for (const Dealt& d : dealt)
        if (!d.finished) size += d.unit.size();
      left = size / (done / working);
    }
    if (settings.errorTarget > 0 && error > 0)
      left = std::min(left, working * ((error / settings.errorTarget) * (error / settings.errorTarget) - 1));
    if (settings.timeLimit > 0) left = std::min(left, settings.timeLimit - p.elapsed);
    left = std::max(left, 0.0);
    p.secondsLeft = left;
    p.fraction = working / (working + left);
    progress(p);
  }

  Worker& worker;
  const std::vector<std::string>& names;
  const RenderSettings& settings;
  Film& film;
  const std::atomic<bool>& stop;
  const std::function<void(const RenderProgress&)>& progress;
  std::vector<Rank> ranks;
  const SampleRenderer& samples;
  double tiles;
  int64_t firstSample;
  WorkQueue queue;
  std::vector<Dealt> dealt; ///< not finished, or not in the film yet
  int64_t lastId = 0, reductionsBegun = 0, reductionsDone = 0;
  bool anythingNew = false; ///< in the films of the ranks
  bool stopped = false;
  std::optional<StopReason> reason;
  Clock::time_point start, here, saved, looked, errorLooked, reductionStart{}, told{};
  double lookAfter, errorInterval = 0.5, reductionSeconds = 0, firstSampleEnd = 0;
  double before; ///< tile samples that the film began with
  double error = -1;
};

/** "name\tvalue\n" for each. */
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
/** What a rank sends that cannot join. */
constexpr char FAILED = '!';

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
  // mpirun ties a rank to one core unless it is told not to.
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

void MpiCluster::meet(const std::string& text) {
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
    if (texts[0].starts_with(FAILED)) refusal = names[0] + " could not begin";
  }
  refusal = tellAll(refusal);
  hasJoined = true;
  if (!refusal.empty()) throw Error(refusal);
}

void MpiCluster::join(const std::map<std::string, std::string>& identity) {
  meet(textOf(identity));
  inRender = true;
  onJoined();
}

void MpiCluster::fail(const std::string& why) {
  try {
    meet(FAILED + why);
  } catch (const Error&) { // has been said where it happened
  }
}

RenderStatistics MpiCluster::render(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                                    const RenderSettings& settings, Film& film, const std::atomic<bool>& stop,
                                    const std::function<void(const RenderProgress&)>& progress,
                                    const std::function<void(const std::string&)>& log) {
  Worker worker(scene, integrator, classes, settings,
                leads() ? log : std::function<void(const std::string&)>(), leads());
  RenderStatistics statistics;
  if (leads()) {
    // It has to have room for what the ranks' films have.
    if (worker.sum->splats()) film.enableSplats(worker.sum->splats()->unit());
    statistics = Leader(worker, size, names, settings, film, stop, progress).lead();
  } else {
    follow(worker, stop);
  }
  inRender = false;
  return statistics;
}

} // namespace recurse::apps
