/** @file
 * Leader: distribution of work, sum of films, end of the render.
 */
#include "mpi/leader.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <thread>
#include <utility>

#include "recurse/core/io/error.h"
#include "recurse/render/sampleAllocation.h"
#include "render/progressEstimate.h"
#include "render/stopRule.h"

namespace recurse::apps {

namespace {

/** Duration of a unit, if it can be chosen [s]. The cost of distribution is then negligible, and a slow rank
 * delays the render by this time at most. */
constexpr double UNIT_SECONDS = 1;
/** Shortest time between estimates of the error [s]. Including the transfer of films they take at most 1 /
 * ERROR_COST_RATIO of the time; the ranks go on rendering. */
constexpr double ERROR_INTERVAL = 0.5, ERROR_COST_RATIO = 20;
/** Silence of a rank before a warning [s]; ranks report five times a second. */
constexpr double SILENCE_SECONDS = 3;

/** Rank that distributes the work. */
class Leader {
 public:
  Leader(Worker& worker, const std::vector<std::string>& names, const RenderSettings& settings, Film& film,
         Clock::time_point start, const std::atomic<bool>& stop,
         const std::function<void(const RenderProgress&)>& progress,
         const std::function<void(const std::string&)>& log)
      : worker(worker), names(names), settings(settings), film(film), stop(stop), log(log),
        ranks(names.size()), samples(worker.renderer.samples()), tiles(double(samples.tiles())),
        firstSample(settings.firstSample),
        lastSample(settings.endSample > 0 ? settings.endSample : samples.samples()),
        allocation(settings.allocation),
        queue(samples.samples(), int64_t(samples.tiles()), samples.passes(), workLeft()), start(start),
        rule(settings, film.totalSamples() > 0), errors(ERROR_INTERVAL, ERROR_COST_RATIO, elapsed()),
        saves(settings.save ? settings.saveInterval : INFINITY, elapsed()),
        looks(settings.look ? settings.lookAfter : INFINITY, elapsed()), reporter(progress),
        pictureStart(elapsed()), before(tileSamplesInFilm()) {
    if (!allocation) return;
    queue.keepPassesWhole();
    if (allocation->dealtUpTo() > 0) shareStage();
  }

  RenderStatistics lead() {
    if (settings.errorTarget > 0 && before > 0) estimateError();
    while (!isOver()) {
      bool quiet = true;
      while (auto message = receivedReport()) {
        take(message->first, message->second);
        quiet = false;
      }
      for (const FullReport& r : worker.reports(stop)) take(LEADER, r);
      if (worker.reduced()) addFilms();
      if (isSaveDue && isFilmKnown()) save();
      watch();
      tellSilence();
      beginStage();
      deal();
      reduceIfDue();
      reporter.tell([&] { return progress(); });
      if (quiet) std::this_thread::sleep_for(worker.isReducing() ? BUSY_POLL : IDLE_POLL);
    }
    sendOthers(Command::END);
    if (reason != StopReason::ERROR) estimateError(); // otherwise the known error has ended the render
    if (settings.save) save();
    reporter.finish(progress());
    return summary();
  }

 private:
  struct Rank {
    int units = 0;       ///< units that the rank has
    double unitSize = 0; ///< of the latest unit
    double speed = 0;    ///< tile samples per second; 0: unknown
    FullReport last;
    Clock::time_point heard = Clock::now();
    bool isMissed = false;
  };
  struct Dealt {
    int64_t id = 0;
    WorkUnit unit;
    int64_t reduction = 0; ///< number of the reduction with this unit
    bool finished = false;
  };

  RenderStatistics summary() const {
    RenderStatistics out = statistics();
    countSamples(film, out);
    out.error = errors.error();
    out.notes = worker.renderer.statistics().notes;
    out.guide = worker.renderer.statistics().guide;
    for (const std::string& w : worker.renderer.statistics().warnings) out.warnings.push_back(w);
    out.stopReason = reason.value_or(StopReason::SAMPLES);
    out.oneMap = samples.hasOneMap() && out.photonsEmitted > 0;
    out.gatherSeconds = std::max(0.0, out.renderSeconds - out.photonSeconds - out.balanceSeconds);
    return out;
  }

  std::vector<WorkUnit> workLeft() const {
    if (settings.from.left) return *settings.from.left;
    const int64_t next = std::max(firstSample, settings.from.sample);
    const auto due = [&](size_t pixel) {
      return allocation && next > 0 ? allocation->due(pixel, next) : uint64_t(next - firstSample);
    };
    for (size_t i = 0; i < film.bounds().area(); ++i)
      if (film.samples(i) != due(i))
        throw Error("--resume: this checkpoint is of one process that was interrupted in its first pass over "
                    "the picture; continue it with one process");
    return {WorkUnit{next, allocation ? allocation->dealtUpTo() : lastSample, 0, int64_t(samples.tiles())}};
  }
  double elapsed() const { return secondsSince(start); }
  void send(int rank, const Command& c) {
    if (rank == LEADER)
      worker.obey(c);
    else
      sendCommand(rank, c);
  }
  void sendOthers(Command::Kind kind) {
    for (int r = 0; r < int(ranks.size()); ++r)
      if (r != LEADER) send(r, {kind, 0, {}});
  }
  void sendAll(Command::Kind kind) {
    sendOthers(kind);
    send(LEADER, {kind, 0, {}});
  }
  void shareStage() {
    sendOthers(Command::STAGE);
    worker.shareStage(allocation->plan());
  }

  void take(int from, const FullReport& r) {
    Rank& rank = ranks[size_t(from)];
    if (!r.failure.empty()) throw Error(names[size_t(from)] + ": " + r.failure);
    if (r.stop) stoppedElsewhere = true;
    rank.heard = Clock::now();
    if (std::exchange(rank.isMissed, false) && log) log("warning: " + names[size_t(from)] + " answers again");
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
    if (allocation) worker.renderer.setPilots(d->unit, r.pilots, *allocation);
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

  /** True if photons have been shot here, or any rank has samples. */
  bool hasBegunPicture() const {
    return worker.renderer.hasShot() ||
           std::any_of(ranks.begin(), ranks.end(), [](const Rank& r) { return r.last.tileSamples > 0; });
  }
  bool isStopped() const { return stop || stoppedElsewhere; }
  /** Ends the render early if a limit is reached. */
  void watch() {
    if (reason) return;
    if (!isPicture && hasBegunPicture()) {
      isPicture = true;
      pictureStart = elapsed();
      rule.beginFirstSample(pictureStart);
    }
    const bool hasFirstSample = everyPixelHasASample();
    if (hasFirstSample) rule.completeFirstSample();
    // A picture that has begun gets at least one tile, so that there is output.
    const bool waitsForTile = isPicture && !hasFirstSample && worker.renderer.tileSamples() == 0;
    if (isStopped() || (rule.isTimeUp(elapsed() + reductionSeconds) && !waitsForTile) ||
        (rule.isErrorReached(errors.error()) && (isWorkLeft() || unitsOut() > 0)))
      end(rule.reason(isStopped(), errors.error(), false));
  }
  void tellSilence() {
    for (size_t r = 0; r < ranks.size(); ++r) {
      if (r == LEADER || ranks[r].isMissed || secondsSince(ranks[r].heard) < SILENCE_SECONDS) continue;
      ranks[r].isMissed = true;
      if (log)
        log("warning: waiting for " + names[r] +
            ", which does not answer: check that its process runs and its machine is reachable");
    }
  }
  void end(StopReason why) {
    reason = why;
    if (unitsOut() > 0) sendAll(Command::STOP);
  }

  bool isWorkLeft() const { return !queue.empty() || (allocation && allocation->dealtUpTo() < lastSample); }
  /** Begins the next stage of adaptive samples after all samples of the stages before. */
  void beginStage() {
    if (reason || !allocation || !queue.empty() || unitsOut() > 0 || !isWorkLeft()) return;
    const int64_t first = allocation->dealtUpTo();
    allocation->begin(first, std::min(SampleAllocation::stageEnd(first), lastSample), settings.seed);
    queue.giveBack({first, allocation->dealtUpTo(), 0, int64_t(samples.tiles())});
    shareStage();
  }

  void deal() {
    if (reason) return;
    for (bool any = true; any && !queue.empty();) {
      any = false;
      for (int r = 0; r < int(ranks.size()) && !queue.empty(); ++r) any = dealTo(r) || any;
    }
    // No remaining unit fits into the time limit.
    if (!queue.empty() && unitsOut() == 0) reason = StopReason::TIME;
  }
  /** False if the rank has enough units, or no unit can be finished in time. */
  bool dealTo(int r) {
    const int workers = int(ranks.size());
    Rank& rank = ranks[size_t(r)];
    // A second unit is sent while the first is rendered, unless few units are left.
    const bool plenty = queue.size() > 4 * double(workers) * rank.unitSize && rank.speed > 0;
    if (rank.units >= (plenty ? 2 : 1)) return false;
    double wanted =
        rank.speed > 0 ? UNIT_SECONDS * rank.speed : std::min(tiles, queue.size()) / (8 * workers);
    if (rank.speed > 0 && queue.nextSample() > firstSample) {
      const double seconds = rule.timeLeft(elapsed()) - reductionSeconds;
      const double fits = seconds * rank.speed - rank.units * rank.unitSize;
      if (queue.smallest(workers) > fits) return false;
      wanted = std::min(wanted, fits);
    }
    const std::optional<WorkUnit> unit = queue.take(wanted, workers);
    if (!unit) return false;
    rank.unitSize = unit->size();
    ++rank.units;
    dealt.push_back({++lastId, *unit, reductionsBegun + 1, false});
    send(r, {Command::UNIT, lastId, *unit});
    return true;
  }

  bool isReducing() const { return reductionsDone < reductionsBegun; }
  void reduceIfDue() {
    if (isReducing()) return;
    const bool over = unitsOut() == 0 && (!isWorkLeft() || reason);
    const double now = elapsed();
    const bool due =
        !reason && (saves.isDue(now) || looks.isDue(now) || (settings.errorTarget > 0 && errors.isDue(now)));
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
    reductionSeconds = std::min(secondsSince(reductionStart), UNIT_SECONDS);
    std::erase_if(dealt, [&](const Dealt& d) { return d.finished && d.reduction <= reductionsDone; });
    if (reason) return;
    if (settings.errorTarget > 0) estimateError();
    isSaveDue = saves.isDue(elapsed());
    if (looks.isDue(elapsed())) {
      const double interval = settings.look();
      looks.restart(elapsed(), interval);
    }
  }
  bool isOver() const {
    return unitsOut() == 0 && !isReducing() && !anythingNew && (!isWorkLeft() || reason);
  }

  double tileSamplesInFilm() const {
    return double(film.totalSamples()) / double(film.bounds().area()) * tiles;
  }
  void estimateError() {
    const double begin = elapsed(), error = film.relativeError();
    errors.add(error, tileSamplesInFilm(), begin - reductionSeconds, elapsed());
  }

  RenderStatistics statistics() const {
    RenderStatistics out = settings.from.statistics;
    for (const Rank& r : ranks) {
      RenderStatistics one;
      r.last.figures.addTo(one);
      one.photonSeconds /= double(ranks.size()); // ranks work at the same time
      one.balanceSeconds /= double(ranks.size());
      Figures(one).addTo(out);
      out.threads += static_cast<int>(r.last.threads);
    }
    out.passes = static_cast<int>(double(film.totalSamples()) / double(film.bounds().area()));
    out.renderSeconds = elapsed();
    return out;
  }

  /** Whether a checkpoint can be saved: every unit in the film has been reported, and every unit that is not
   * is of the current stage, whose plan the checkpoint has. */
  bool isFilmKnown() const {
    const int64_t stageBegin = allocation ? allocation->dealtFrom() : 0;
    return std::none_of(dealt.begin(), dealt.end(), [&](const Dealt& d) {
      return d.reduction <= reductionsDone ? !d.finished : d.unit.firstSample < stageBegin;
    });
  }
  void save() {
    std::vector<WorkUnit> left = queue.left();
    for (const Dealt& d : dealt)
      if (d.reduction > reductionsDone) left.push_back(d.unit);
    RenderPosition position{allocation ? allocation->dealtUpTo() : samples.samples(), statistics(), {}};
    for (const WorkUnit& unit : left) position.sample = std::min(position.sample, unit.firstSample);
    position.statistics.notes.clear();
    position.statistics.warnings.clear();
    position.left = std::move(left);
    settings.save(position);
    saves.restart(elapsed());
    isSaveDue = false;
  }

  RenderProgress progress() const {
    PictureState s;
    s.elapsed = elapsed();
    s.working = s.elapsed - pictureStart;
    s.samplesDone = worker.renderer.tileSamples();
    s.rays = double(worker.renderer.rays());
    for (size_t r = 1; r < ranks.size(); ++r) {
      s.samplesDone += ranks[r].last.tileSamples;
      s.rays += double(ranks[r].last.rays);
    }
    if (s.samplesDone == 0)
      return photonProgress(worker.renderer.photonProgress(), s.elapsed, errors.error());
    s.samplesBefore = before;
    if (settings.samplesPerPixel > 0) s.samplesLeft = tileSamplesLeft();
    s.samplesPerPixel = (before + s.samplesDone) / tiles;
    s.error = errors.error();
    s.errorSamples = errors.samples();
    return withLearning(pictureProgress(s, settings), statistics());
  }
  double tileSamplesLeft() const {
    double left = queue.size();
    for (const Dealt& d : dealt)
      if (!d.finished) left += d.unit.size();
    if (allocation) left += double(lastSample - allocation->dealtUpTo()) * tiles;
    return left;
  }

  Worker& worker;
  const std::vector<std::string>& names;
  const RenderSettings& settings;
  Film& film;
  const std::atomic<bool>& stop;
  const std::function<void(const std::string&)>& log;
  std::vector<Rank> ranks;
  const SampleRenderer& samples;
  double tiles;
  int64_t firstSample, lastSample;
  SampleAllocation* allocation;
  WorkQueue queue;
  std::vector<Dealt> dealt; ///< units not finished, or not in the film yet
  int64_t lastId = 0, reductionsBegun = 0, reductionsDone = 0;
  bool anythingNew = false;      ///< in the ranks' films since the latest reduction
  bool stoppedElsewhere = false; ///< a rank apart from the leader was asked to end the render
  bool isPicture = false;        ///< the first sample has begun
  bool isSaveDue = false;
  std::optional<StopReason> reason; ///< why the render ends early: no more work is distributed
  const Clock::time_point start;    ///< earlier by the time before an interruption
  StopRule rule;
  ErrorWatch errors;
  Recurrence saves, looks;
  ProgressReporter reporter;
  double pictureStart; ///< seconds since `start`
  Clock::time_point reductionStart{};
  double reductionSeconds = 0; ///< duration of the latest reduction
  double before;               ///< tile samples in the film at the start
};

} // namespace

RenderStatistics lead(Worker& worker, const std::vector<std::string>& names, const RenderSettings& settings,
                      Film& film, Clock::time_point start, const std::atomic<bool>& stop,
                      const std::function<void(const RenderProgress&)>& progress,
                      const std::function<void(const std::string&)>& log) {
  return Leader(worker, names, settings, film, start, stop, progress, log).lead();
}

} // namespace recurse::apps
