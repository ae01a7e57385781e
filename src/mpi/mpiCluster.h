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
 * Rank 0 leads. It distributes units of work to idle ranks, itself included; each rank adds its samples to a
 * film of its own. From time to time, and at the end, a reduction in the background sums the films. Sums are
 * the same in any order, and so is the picture.
 */
class MpiCluster final : public Cluster {
 public:
  /** Initializes MPI. */
  MpiCluster(int& argc, char**& argv);
  /** Finalizes MPI. */
  ~MpiCluster() override;
  MpiCluster(const MpiCluster&) = delete;
  MpiCluster& operator=(const MpiCluster&) = delete;

  bool leads() const override { return rank == 0; }
  int threads() const override { return ownThreads; }
  /** True after join() or fail(). */
  bool joined() const { return hasJoined; }
  /** True in a render of all ranks: then no rank may leave alone. */
  bool isRendering() const { return inRender; }
  /** Called once all ranks have joined. */
  std::function<void()> onJoined = [] {};
  std::string tellAll(std::string text) const override;
  void join(const std::map<std::string, std::string>& identity) override;
  /** Replaces join() in a process that cannot join. */
  void fail(const std::string& why);
  /** Ends all ranks at once. */
  [[noreturn]] void abort(int status);
  RenderStatistics render(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                          const RenderSettings& settings, Film& film, const std::atomic<bool>& stop,
                          const std::function<void(const RenderProgress&)>& progress,
                          const std::function<void(const std::string&)>& log) override;

 private:
  /** Texts of all ranks, at rank 0. */
  std::vector<std::string> gather(const std::string& text) const;
  /** Throws in all ranks if the identity of a rank differs from the leader's, or if a rank has failed. */
  void requireAgreement(const std::string& text);

  int rank = 0, size = 1, ownThreads = 0;
  bool hasJoined = false, inRender = false;
  std::vector<std::string> names; ///< names of the ranks, at rank 0: "rank 3 on host"
};

} // namespace recurse::apps
