/** @file
 * Dealing out, adding up, and when to end.
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

/** Seconds of a unit, where there is a choice: dealing them out costs next to nothing then, and whoever is
 * slow holds up the others for so long at most. */
constexpr double UNIT_SECONDS = 1;
/** Shortest time between estimates of the error [s]. They take one part in ERROR_COST_RATIO of the time, with
 * the films' way to the leader, while the ranks go on. */
constexpr double ERROR_INTERVAL = 0.5, ERROR_COST_RATIO = 20;
/** Seconds without a word from a rank, which reports five times a second. */
constexpr double SILENCE_SECONDS = 3;

/** The rank that deals out. */
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
    if (reason != StopReason::ERROR) estimateError(); // else it is the one that was reached
    if (settings.save) save();
    reporter.finish(progress());
    return summary();
  }

 private:
  struct Rank {
    int units = 0;       ///< that it has
    double unitSize = 0; ///< of the last one
    double speed = 0;    ///< samples of a tile in a second; 0: not known yet
    FullReport last;
    Clock::time_point heard = Clock::now();
    bool isMissed = false;
  };
  struct Dealt {
    int64_t id = 0;
    WorkUnit unit;
    int64_t reduction = 0; ///< that it will be in
    bool finished = false;
  };

  RenderStatistics summary() const {
    RenderStatistics out = statistics();
    countSamples(film, out);
    out.error = errors.error();
    out.notes = worker.renderer.statistics().notes;
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
        throw Error("--resume: one process was interrupted while it had not gone once over the picture; one "
                    "has to go on with it");
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

  /** Whether photons are shot here, or another rank has samples. */
  bool hasBegunPicture() const {
    return worker.renderer.hasShot() ||
           std::any_of(ranks.begin(), ranks.end(), [](const Rank& r) { return r.last.tileSamples > 0; });
  }
  bool isStopped() const { return stop || stoppedElsewhere; }
  /** Ends the render early where that is due. */
  void watch() {
    if (reason) return;
    if (!isPicture && hasBegunPicture()) {
      isPicture = true;
      pictureStart = elapsed();
      rule.beginFirstSample(pictureStart);
    }
    const bool hasFirstSample = everyPixelHasASample();
    if (hasFirstSample) rule.completeFirstSample();
    // Of a picture that has begun there is to be something to be written.
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
            ", which does not answer: is its process stopped, or its machine out of reach?");
    }
  }
  void end(StopReason why) {
    reason = why;
    if (unitsOut() > 0) sendAll(Command::STOP);
  }

  bool isWorkLeft() const { return !queue.empty() || (allocation && allocation->dealtUpTo() < lastSample); }
  /** A stage of adaptive samples follows from all samples of those before. */
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
    // What is left takes too long for the time.
    if (!queue.empty() && unitsOut() == 0) reason = StopReason::TIME;
  }
  /** False where it has enough to do, or there is nothing that it would finish in time. */
  bool dealTo(int r) {
    const int workers = int(ranks.size());
    Rank& rank = ranks[size_t(r)];
    // A second one is on its way while the first is worked on, but not where they run out.
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
      one.photonSeconds /= double(ranks.size()); // they work at the same time
      one.balanceSeconds /= double(ranks.size());
      Figures(one).addTo(out);
      out.threads += static_cast<int>(r.last.threads);
    }
    out.passes = static_cast<int>(double(film.totalSamples()) / double(film.bounds().area()));
    out.renderSeconds = elapsed();
    return out;
  }

  /** All units have been reported that are in the film. */
  bool isFilmKnown() const {
    return std::none_of(dealt.begin(), dealt.end(),
                        [&](const Dealt& d) { return !d.finished && d.reduction <= reductionsDone; });
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
    return pictureProgress(s, settings);
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
  std::vector<Dealt> dealt; ///< not finished, or not in the film yet
  int64_t lastId = 0, reductionsBegun = 0, reductionsDone = 0;
  bool anythingNew = false;      ///< in the films of the ranks
  bool stoppedElsewhere = false; ///< somebody wants another rank to end
  bool isPicture = false;        ///< its first sample has begun
  bool isSaveDue = false;
  std::optional<StopReason> reason; ///< to end early: no more work is dealt out
  const Clock::time_point start;    ///< with the time before an interruption
  StopRule rule;
  ErrorWatch errors;
  Recurrence saves, looks;
  ProgressReporter reporter;
  double pictureStart; ///< seconds since `start`
  Clock::time_point reductionStart{};
  double reductionSeconds = 0; ///< of the latest one
  double before;               ///< tile samples that the film began with
};

} // namespace

RenderStatistics lead(Worker& worker, const std::vector<std::string>& names, const RenderSettings& settings,
                      Film& film, Clock::time_point start, const std::atomic<bool>& stop,
                      const std::function<void(const RenderProgress&)>& progress,
                      const std::function<void(const std::string&)>& log) {
  return Leader(worker, names, settings, film, start, stop, progress, log).lead();
}

} // namespace recurse::apps
