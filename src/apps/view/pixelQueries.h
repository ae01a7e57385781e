/** @file
 * Questions about single pixels of a running render: the paths that the integrator sampled for them, and path
 * tracing at clicked points.
 */
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "recurse/report/inspect/inspect.h"

namespace recurse::apps {

/** Question about a pixel, and whether it has been answered. */
struct PixelQuestion {
  int x = 0, y = 0;    ///< from the upper left corner of the crop window
  uint64_t number = 0; ///< counted from 1; 0: none
  bool isAnswered = false;
};

/**
 * Passes questions from the thread of a page to the render, which answers between its rounds. All functions
 * are for the page's thread, except where noted.
 */
class PixelQueries {
 public:
  /** `classes`: of the render; `maxDepth`: of the paths, as in the parameter "maxdepth". */
  PixelQueries(std::shared_ptr<const Scene> scene, PathClasses classes, std::string title, std::string label,
               int maxDepth, uint64_t seed);

  /** Replaces the question. Throws Error (BAD_USAGE) for a pixel outside of the crop window. */
  void ask(int x, int y);
  PixelQuestion question() const;
  /** Page of the latest answer, see inspectPage(), with a picture of the crop window; empty: there is no
   * answer yet. Throws Error with the reason if answering failed. */
  std::string page(const Image& picture);
  /** Irradiance by path tracing at a surface point, as JSON; takes about a second at most, with fewer paths
   * then. Throws Error with the reason where there is none. */
  std::string reference(const Vec3f& position, const Vec3f& normal);

  /** Ends reference(), now and from now on. For any thread. */
  void stop() { stopped = true; }

  /** Whether a question waits, and may be answered: answers take at most 1/50 of the render's time. For any
   * thread. */
  bool isAsked() const { return waits && Clock::now() >= due.load(); }
  /** Answers the question; the reason of a failure is then the answer. For the render's thread. */
  void answer(const RenderPause& pause);

 private:
  using Clock = std::chrono::steady_clock;

  /** Content of the page about a pixel, but for the picture; also its photons' light as an expression. */
  std::shared_ptr<Inspection> inspectionOf(const PixelQuestion& now, const RenderPause& pause,
                                           std::string& expression) const;
  void prepareReferences(const std::string& expression);

  const std::shared_ptr<const Scene> owner; ///< the page may outlive the render
  const Scene& scene;
  const PathClasses classes;
  const std::string title, label;
  const int maxDepth;
  const uint64_t seed;
  std::atomic<bool> waits{false}, stopped{false};
  std::atomic<Clock::time_point> due{Clock::time_point::min()}; ///< of the next answer
  mutable std::mutex mutex;                                     ///< guards the members below
  PixelQuestion asked;
  std::shared_ptr<Inspection> answered; ///< null: none
  std::string failure;                  ///< why there is no answer; empty: it did not fail
  std::string photonPaths;              ///< light of the answer's photons as an expression; empty: none
  // References, in the page's thread only:
  std::string referencePaths;
  std::unique_ptr<PathClasses> referenceClasses;
  std::unique_ptr<Integrator> path;
};

} // namespace recurse::apps
