/** @file
 * Several processes that make one picture together.
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
  /** One of them gets the picture, writes it, and talks to the person. */
  virtual bool leads() const = 0;
  /** Threads for this process where nobody says. */
  virtual int threads() const = 0;
  /** Called by all: what the leading one gives, no longer than 1 GB. */
  virtual std::string tellAll(std::string text) const = 0;
  /** Called by all with what the samples depend on. Throws Error, in the leading one with who differs. */
  virtual void join(const std::map<std::string, std::string>& identity) = 0;
  /** As recurse::render(), called by all with the same scene and settings. Only the film of the leading one
   * is filled, and only there the callbacks are called. */
  virtual RenderStatistics render(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                                  const RenderSettings& settings, Film& film, const std::atomic<bool>& stop,
                                  const std::function<void(const RenderProgress&)>& progress,
                                  const std::function<void(const std::string&)>& log) = 0;
};

/** Null where this process renders alone. */
Cluster* cluster();
void setCluster(Cluster* cluster);

} // namespace recurse::apps
