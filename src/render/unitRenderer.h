/** @file
 * Renders units of work one after the other on a thread of its own, for a process that shares a render.
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
  /** A unit that was worked on. */
  struct Done {
    int64_t id = 0;
    double seconds = 0;
    std::vector<WorkUnit> left;  ///< what stop() kept from being done
    std::vector<float> pilots;   ///< of RenderSettings::allocation: see pilotsOf()
    RenderStatistics statistics; ///< of all units so far, without samples
  };
  /** What happened since the last time. */
  struct Events {
    std::vector<Done> done;
    bool filmTaken = false;
    std::exception_ptr failure;
  };

  /** As SampleRenderer; the film is its own. With an allocation units lie within the stage that it has dealt
   * out, and begin and end as passes or the stage do. */
  UnitRenderer(const Scene& scene, Integrator& integrator, const PathClasses& classes,
               const RenderSettings& settings, const std::function<void(const std::string&)>& log);
  ~UnitRenderer();
  UnitRenderer(const UnitRenderer&) = delete;
  UnitRenderer& operator=(const UnitRenderer&) = delete;

  /** Shoots the photons of the only pass, before anything is added, on the thread that calls. False where it
   * was stopped. */
  bool shootOnlyPass(ForwardControl& control);
  /** To be rendered after all that was added before. */
  void add(int64_t id, const WorkUnit& unit);
  /** After the units that were added before: exchanges the film with this one, which must be empty, and stay
   * until Events::filmTaken. */
  void takeFilm(Film& into);
  /** Ends what it is at, within a tile; what is added from now on is not done. */
  void stop() { stopping = true; }

  Events events();
  /** Nothing waits, nothing is under way. */
  bool idle();
  /** A film that fits takeFilm(). */
  Film emptyFilm() const;
  /** Samples of a tile and rays so far, and how far the photons of the first pass are, in [0, 1]. */
  double tileSamples() const { return tileSamplesDone; }
  uint64_t rays() const { return raysDone; }
  double photonProgress() const { return photonsDone; }
  /** Whether the first pass has been shot, so that samples follow. */
  bool hasShot() const { return shotAny; }
  /** Of all units so far, without samples; call when idle. */
  RenderStatistics statistics() const;
  const SampleRenderer& samples() const { return renderer; }

  /** Luminances of the pilot samples of a unit, one tile after the other, where there is an allocation. */
  std::vector<float> pilotsOf(const WorkUnit& unit) const;
  /** Puts them in their places in another allocation of the same stage. */
  void setPilots(const WorkUnit& unit, const std::vector<float>& pilots, SampleAllocation& into) const;

 private:
  struct Item {
    int64_t id = 0;
    WorkUnit unit;
    Film* film = nullptr; ///< to be exchanged; else the unit is to be rendered
  };
  void work();
  std::vector<WorkUnit> render(const WorkUnit& unit);
  /** Calls use(pilots of a pixel in the allocation `of`) for the pixels of the unit. */
  void forEachPilots(const WorkUnit& unit, SampleAllocation& of,
                     const std::function<void(std::span<float>)>& use) const;
  /** Tiles of the unit whose samples of a pass were not done. */
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
  std::deque<Item> items; ///< the first one stays until it is done
  Events news;
  std::thread thread;
};

} // namespace recurse
