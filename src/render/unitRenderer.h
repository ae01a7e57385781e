/** @file
 * Rendering of units of work, one at a time on a thread of its own, for a process that shares a render.
 */
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <span>
#include <thread>
#include <vector>

#include "recurse/render/workQueue.h"
#include "render/sampleRenderer.h"

namespace recurse {

class UnitRenderer {
 public:
  /** Result of a unit, complete or stopped. */
  struct Done {
    int64_t id = 0;
    double seconds = 0;
    std::vector<WorkUnit> left;  ///< work that stop() prevented
    std::vector<float> pilots;   ///< pilots of RenderSettings::allocation: see pilotsOf()
    RenderStatistics statistics; ///< sums over all units up to now, without samples
  };
  /** Events since the previous call of events(). */
  struct Events {
    std::vector<Done> done;
    bool filmTaken = false;
    std::exception_ptr failure;
  };

  /** Takes the arguments of SampleRenderer; the film is its own. With an allocation, units are within the
   * stage allocated last, and begin and end at borders of passes or of the stage. */
  UnitRenderer(const Scene& scene, Integrator& integrator, const PathClasses& classes,
               const RenderSettings& settings, const std::function<void(const std::string&)>& log);
  ~UnitRenderer();
  UnitRenderer(const UnitRenderer&) = delete;
  UnitRenderer& operator=(const UnitRenderer&) = delete;

  /** Shoots the photons of the only pass in the calling thread, before any unit is added. False if it was
   * stopped. */
  bool shootOnlyPass(ForwardControl& control);
  /** Queues a unit, to be rendered after all units added before. */
  void add(int64_t id, const WorkUnit& unit);
  /** Queues an exchange of the film with `into`, after the units added before. `into` must be empty and must
   * exist until Events::filmTaken. */
  void takeFilm(Film& into);
  /** Stops the current unit, within a tile, and skips all units that are added later. */
  void stop() { stopping = true; }

  Events events();
  /** True if no unit is queued or being rendered. */
  bool idle();
  /** Empty film that fits takeFilm(). */
  Film emptyFilm() const;
  /** Progress: samples of tiles; rays; fraction of the first pass's photons that are shot, in [0, 1]. */
  double tileSamples() const { return tileSamplesDone; }
  uint64_t rays() const { return raysDone; }
  double photonProgress() const { return photonsDone; }
  /** True if photons have been shot, so that samples follow. */
  bool hasShot() const { return shotAny; }
  /** Sums over all units up to now, without samples; call when idle. */
  RenderStatistics statistics() const;
  const SampleRenderer& samples() const { return renderer; }

  /** Luminances of the unit's pilot samples, tile by tile; empty without an allocation. */
  std::vector<float> pilotsOf(const WorkUnit& unit) const;
  /** Writes the pilots of a unit to their places in `into`, a different allocation at the same stage. */
  void setPilots(const WorkUnit& unit, const std::vector<float>& pilots, SampleAllocation& into) const;

 private:
  struct Item {
    int64_t id = 0;
    WorkUnit unit;
    Film* film = nullptr; ///< film to be exchanged; null: the unit is to be rendered
  };
  void work();
  std::vector<WorkUnit> render(const WorkUnit& unit);
  /** Calls use(pilots of a pixel in the allocation `of`) for the pixels of the unit. */
  void forEachPilots(const WorkUnit& unit, SampleAllocation& of,
                     const std::function<void(std::span<float>)>& use) const;
  /** Renders a unit of a single pass. Returns the tiles that were stopped. */
  std::vector<WorkUnit> renderPass(const WorkUnit& unit);

  Film film;
  SampleRenderer renderer;
  SampleAllocation* allocation;
  ForwardControl control;
  std::atomic<bool> stopping{false}, ending{false}, shotAny{false};
  std::atomic<double> tileSamplesDone{0}, photonsDone{0};
  std::atomic<uint64_t> raysDone{0};
  std::optional<int64_t> shotPass;
  std::vector<TransportCounts> tileCounts;

  std::mutex mutex;
  std::condition_variable changed;
  std::deque<Item> items; ///< queue; the first item stays until it is done
  Events news;
  std::thread thread;
};

} // namespace recurse
