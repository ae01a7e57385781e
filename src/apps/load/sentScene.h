/** @file
 * A scene that the leading process reads and sends to the others, which need no shared folder then.
 */
#pragma once

#include <string>

#include "apps/load/loadedScene.h"
#include "apps/run/cluster.h"

namespace recurse::apps {

/** At the leading process. Throws Error for a scene that is made of more than the files it names. */
void sendScene(const Cluster& cluster, const LoadedScene& loaded);
/** At the leading process, where there is none to send: the others give up too. */
void sendNoScene(const Cluster& cluster);

/** At the others: its files in a temporary folder, for as long as this lives. */
class ReceivedScene {
 public:
  /** Waits for sendScene(). Throws Error where the leading process has none, or the files cannot be written.
   */
  explicit ReceivedScene(const Cluster& cluster);
  ~ReceivedScene();
  ReceivedScene(const ReceivedScene&) = delete;
  ReceivedScene& operator=(const ReceivedScene&) = delete;
  const std::string& fileName() const { return scene; }

 private:
  std::string folder, scene;
};

} // namespace recurse::apps
