/** @file
 * Those who look at a film while it is rendered: a file that is kept up to date, a page, a display server.
 * They work in threads of their own and so seldom that the render hardly notices.
 */
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "apps/options/developOptions.h"
#include "apps/view/liveServer.h"
#include "apps/view/tevClient.h"
#include "recurse/core/image/image.h"
#include "recurse/render/render.h"

namespace recurse::apps {

/** Hands pictures to a function in another thread: always the newest, one at a time. */
class PictureThread {
 public:
  using Present = std::function<void(const Image&)>;

  explicit PictureThread(Present present);
  /** Waits until the last picture was presented. */
  ~PictureThread() { end(); }
  /** The same; nothing is to be offered after it. */
  void end();

  /** Takes the place of a picture that still waits. */
  void offer(Image picture);
  /** Seconds that presenting took, the last time. */
  double cost() const;
  /** Why presenting failed for the first time, told once; later pictures are tried all the same. */
  std::string takeFailure();

 private:
  void work();

  const Present present;
  mutable std::mutex mutex;
  std::condition_variable wake;
  std::optional<Image> next;
  bool ends = false, failed = false;
  std::string failure;
  double seconds = 0;
  std::thread thread;
};

/** The options of the command line. */
struct ViewerOptions {
  std::string preview, liveAddress, displayServer;
  std::vector<std::string> liveHosts;
  std::optional<std::string> every;
  bool live = false;
  /** Of several renders one after the other, which share it; null: each render has its own. */
  std::shared_ptr<LiveServer> page;
  double patience = 2; ///< seconds that pages and display servers have for the last picture

  void addTo(CLI::App& command);
  /** Throws Error where one makes no sense or the preview cannot be written. */
  void check() const;
  /** A page where one is asked for, else null; prints its address. `stop` as FilmViewers has it. */
  std::shared_ptr<LiveServer> openPage(const std::string& title, std::function<void()> stop) const;
  bool any() const { return !preview.empty() || live || !displayServer.empty(); }
};

/** The viewers that the options ask for, from before the render to its end. */
class FilmViewers {
 public:
  /** `stop` is called when a viewer wants the render to end. Throws Error where one cannot begin. */
  FilmViewers(const ViewerOptions& options, const DevelopOptions& develop, const std::string& title,
              std::function<void()> stop);

  /** A picture of the film for those whose time it is. Returns the seconds until the next time. */
  double look(const std::function<Image()>& picture, const std::function<void(const std::string&)>& say);
  void show(const RenderProgress& progress);
  /** The last picture. The preview is left to the caller, as its other outputs are. */
  void finish(const Image& picture, const std::function<void(const std::string&)>& say);

 private:
  using Clock = std::chrono::steady_clock;
  struct Viewer {
    std::unique_ptr<PictureThread> thread;
    double interval = 1; ///< seconds
    bool isPreview = false;
    Clock::time_point due{};
    std::shared_ptr<TevClient> server{}; ///< that it sends to
  };
  std::vector<Viewer> viewers;
  std::shared_ptr<LiveServer> live;
  bool keepsPage;  ///< it outlives the render
  double patience; ///< as ViewerOptions has it
  Clock::time_point liveDue{};
};

} // namespace recurse::apps
