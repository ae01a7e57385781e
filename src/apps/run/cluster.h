/** @file
 * Cluster of processes that render one picture together.
 */
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <string>

#include "recurse/render/render.h"

namespace recurse::apps {

class Cluster {
 public:
  virtual ~Cluster() = default;
  /** True in one process of the cluster, which gets the picture, writes it, and prints messages. */
  virtual bool leads() const = 0;
  /** Number of threads for this process by default; 0: one for each core. */
  virtual int threads() const = 0;
  /** Broadcasts the leading process's text, at most 1 GB, to all processes. Called by all. */
  virtual std::string tellAll(std::string text) const = 0;
  /** Called by all: compares what samples depend on. Throws Error that names who differs or has failed. */
  virtual void join(const std::map<std::string, std::string>& identity) = 0;
  /** Renders like recurse::render(), called by all processes with the same scene and settings. Only the film
   * of the leading process is filled, and only its callbacks are called. */
  virtual RenderStatistics render(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                                  const RenderSettings& settings, Film& film, const std::atomic<bool>& stop,
                                  const std::function<void(const RenderProgress&)>& progress,
                                  const std::function<void(const std::string&)>& log) = 0;
};

/** Cluster of this process; null if it renders alone. */
Cluster* cluster();
void setCluster(Cluster* cluster);

} // namespace recurse::apps
