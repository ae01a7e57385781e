/** @file
 * Thread that renders units of work.
 */
#include "render/unitRenderer.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "recurse/core/threads/parallel.h"
#include "recurse/core/threads/processorTime.h"

namespace recurse {

UnitRenderer::UnitRenderer(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                           const RenderSettings& settings, const std::function<void(const std::string&)>& log)
    : film(scene.film().crop, classes.layerCount()),
      renderer(scene, integrator, classes, settings, film, log), allocation(settings.allocation),
      tileCounts(renderer.tiles()) {
  control.stop = &stopping;
  control.progress = [this](double fraction) { photonsDone = fraction; };
  thread = std::thread([this] { work(); });
}

UnitRenderer::~UnitRenderer() {
  stopping = true;
  {
    const std::lock_guard lock(mutex);
    ending = true;
  }
  changed.notify_all();
  thread.join();
}

bool UnitRenderer::shootOnlyPass(ForwardControl& control) {
  setThreadFloatMode();
  const bool isComplete = renderer.shootPass(0, false, control);
  if (isComplete) {
    shotPass = 0;
    shotAny = true;
  }
  return isComplete;
}

void UnitRenderer::add(int64_t id, const WorkUnit& unit) {
  const std::lock_guard lock(mutex);
  items.push_back({id, unit, nullptr});
  changed.notify_all();
}

void UnitRenderer::takeFilm(Film& into) {
  const std::lock_guard lock(mutex);
  items.push_back({0, {}, &into});
  changed.notify_all();
}

UnitRenderer::Events UnitRenderer::events() {
  const std::lock_guard lock(mutex);
  return std::exchange(news, {});
}

bool UnitRenderer::idle() {
  const std::lock_guard lock(mutex);
  return items.empty();
}

Film UnitRenderer::emptyFilm() const {
  Film out(film.bounds(), film.layerCount());
  if (film.splats()) out.enableSplats(film.splats()->unit());
  return out;
}

RenderStatistics UnitRenderer::statistics() const {
  RenderStatistics out = renderer.statistics;
  for (const TransportCounts& c : tileCounts) out.counts.add(c);
  return out;
}

void UnitRenderer::work() {
  setThreadFloatMode();
  std::unique_lock lock(mutex);
  for (;;) {
    changed.wait(lock, [&] { return ending || !items.empty(); });
    if (ending) return;
    const Item item = items.front();
    lock.unlock();
    Done done;
    done.id = item.id;
    std::exception_ptr failure;
    const auto start = std::chrono::steady_clock::now();
    try {
      if (item.film)
        std::swap(film, *item.film);
      else
        done.left = render(item.unit), done.pilots = pilotsOf(item.unit);
      done.statistics = statistics();
    } catch (...) {
      failure = std::current_exception();
    }
    done.seconds = secondsSince(start);
    lock.lock();
    items.pop_front();
    if (item.film)
      news.filmTaken = true;
    else
      news.done.push_back(std::move(done));
    if (failure && !news.failure) news.failure = failure;
  }
}

std::vector<WorkUnit> UnitRenderer::render(const WorkUnit& unit) {
  std::vector<WorkUnit> left;
  WorkUnit rest = unit;
  while (rest.firstSample < rest.endSample && !stopping) {
    const int64_t pass = renderer.passOf(rest.firstSample);
    const bool splats = rest.includesSplats && film.splats() && rest.firstSample == renderer.passBegin(pass);
    if (shotPass != pass || splats) {
      // Pass 0 has to be shot before any later one.
      if (!shotPass && pass > 0 && !renderer.shootPass(0, false, control)) break;
      shotPass.reset();
      if (!renderer.shootPass(pass, splats, control)) break;
      shotPass = pass;
      shotAny = true;
    }
    WorkUnit now = rest;
    now.endSample = std::min(rest.endSample, renderer.passEnd(pass));
    now.includesSplats = false;
    for (const WorkUnit& tiles : renderPass(now)) left.push_back(tiles);
    rest.firstSample = now.endSample;
  }
  if (rest.firstSample < rest.endSample) left.push_back(rest);
  return left;
}

void UnitRenderer::forEachPilots(const WorkUnit& unit, SampleAllocation& of,
                                 const std::function<void(std::span<float>)>& use) const {
  const size_t first = of.pilotsDue(unit.firstSample), end = of.pilotsDue(unit.endSample);
  for (int64_t tile = unit.firstTile; tile < unit.endTile; ++tile)
    renderer.forEachPixel(size_t(tile), [&](size_t pixel, int, int) { use(of.pilotsOf(pixel, first, end)); });
}

std::vector<float> UnitRenderer::pilotsOf(const WorkUnit& unit) const {
  std::vector<float> out;
  if (allocation)
    forEachPilots(unit, *allocation,
                  [&](std::span<float> pilots) { out.insert(out.end(), pilots.begin(), pilots.end()); });
  return out;
}

void UnitRenderer::setPilots(const WorkUnit& unit, const std::vector<float>& pilots,
                             SampleAllocation& into) const {
  auto from = pilots.begin();
  forEachPilots(unit, into, [&](std::span<float> of) {
    std::copy_n(from, of.size(), of.begin());
    from += std::ptrdiff_t(of.size());
  });
}

std::vector<WorkUnit> UnitRenderer::renderPass(const WorkUnit& unit) {
  std::vector<char> isDone(size_t(unit.endTile - unit.firstTile), 0);
  parallelFor(isDone.size(), [&](size_t i) {
    if (stopping) return;
    const size_t tile = size_t(unit.firstTile) + i;
    TransportCounts counts;
    renderer.renderTile(
        tile,
        [&](size_t pixel) {
          if (allocation)
            return SampleRenderer::PixelSamples{
                allocation->due(pixel, unit.firstSample), allocation->due(pixel, unit.endSample),
                allocation->pilotsDue(unit.firstSample), allocation->pilotsDue(unit.endSample)};
          return SampleRenderer::PixelSamples{uint64_t(unit.firstSample), uint64_t(unit.endSample)};
        },
        counts, nullptr);
    isDone[i] = 1;
    tileCounts[tile].add(counts);
    raysDone += counts.rays;
    tileSamplesDone.fetch_add(double(unit.endSample - unit.firstSample));
  });
  std::vector<WorkUnit> left;
  for (size_t i = 0; i < isDone.size(); ++i) {
    if (isDone[i]) continue;
    const int64_t tile = unit.firstTile + int64_t(i);
    if (!left.empty() && left.back().endTile == tile) {
      ++left.back().endTile;
      continue;
    }
    left.push_back(unit);
    left.back().firstTile = tile;
    left.back().endTile = tile + 1;
  }
  return left;
}

} // namespace recurse
