/** @file
 * A cluster of MPI ranks.
 */
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/run/cluster.h"

namespace recurse::apps {

/**
 * Rank 0 leads. It deals out units of work to ranks that are free, itself included; each adds what it renders
 * to a film of its own. Every now and then, and at the end, the films are added up by a reduction that goes
 * on while the ranks render. Film sums are the same in any order, and so is the picture.
 */
class MpiCluster final : public Cluster {
 public:
  /** Initializes MPI. */
  MpiCluster(int& argc, char**& argv);
  /** Finalizes it. */
  ~MpiCluster() override;
  MpiCluster(const MpiCluster&) = delete;
  MpiCluster& operator=(const MpiCluster&) = delete;

  bool leads() const override { return rank == 0; }
  int threads() const override { return ownThreads; }
  /** join() or fail() was called. */
  bool joined() const { return hasJoined; }
  /** All have joined, and are in a render: none may leave without the others. */
  bool isRendering() const { return inRender; }
  /** Called once all have joined. */
  std::function<void()> onJoined = [] {};
  std::string tellAll(std::string text) const override;
  void join(const std::map<std::string, std::string>& identity) override;
  /** In the place of join(), by a process that cannot. */
  void fail(const std::string& why);
  /** Ends all of them at once. */
  [[noreturn]] void abort(int status);
  RenderStatistics render(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                          const RenderSettings& settings, Film& film, const std::atomic<bool>& stop,
                          const std::function<void(const RenderProgress&)>& progress,
                          const std::function<void(const std::string&)>& log) override;

 private:
  /** What each rank says, at rank 0. */
  std::vector<std::string> gather(const std::string& text) const;
  /** Throws in all ranks where a rank has another identity than the leader, or has failed. */
  void requireAgreement(const std::string& text);

  int rank = 0, size = 1, ownThreads = 0;
  bool hasJoined = false, inRender = false;
  std::vector<std::string> names; ///< of the ranks, at rank 0: "rank 3 on host"
};

} // namespace recurse::apps
