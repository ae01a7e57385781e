/** @file
 * Transfer of a scene from the leading process to all processes, without a shared folder.
 */
#pragma once

#include <string>

#include "apps/load/loadedScene.h"
#include "apps/run/cluster.h"

namespace recurse::apps {

/** Sends the files of the scene, in the leading process. Throws Error if a file cannot be read. */
void sendScene(const Cluster& cluster, const LoadedScene& loaded);
/** Makes each ReceivedScene fail, if the leading process has no scene to send. */
void sendNoScene(const Cluster& cluster);

/** Received scene, in all but the leading process. A temporary folder has its files until destruction. */
class ReceivedScene {
 public:
  /** Waits for sendScene(). Throws Error if the leading process has no scene, or if the files cannot be
   * written. */
  explicit ReceivedScene(const Cluster& cluster);
  ~ReceivedScene();
  ReceivedScene(const ReceivedScene&) = delete;
  ReceivedScene& operator=(const ReceivedScene&) = delete;
  const std::string& fileName() const { return scene; }

 private:
  std::string folder, scene;
};

} // namespace recurse::apps
