/** @file
 * Viewers of a film during its render: a file that is kept up to date, a page, a display server. They work in
 * threads of their own, and seldom enough not to slow down the render.
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

/** Thread that hands pictures to a function: always the newest, one at a time. */
class PictureThread {
 public:
  using Present = std::function<void(const Image&)>;

  explicit PictureThread(Present present);
  /** Waits until the last picture has been presented. */
  ~PictureThread() { end(); }
  /** Waits until the last picture has been presented. No picture may be offered after it. */
  void end();

  /** Queues a picture, which replaces one that still waits. */
  void offer(Image picture);
  /** Duration of the latest presentation [s]. */
  double cost() const;
  /** Reason of the first failure, returned once; later pictures are tried nevertheless. */
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

/** Command-line options of the viewers. */
struct ViewerOptions {
  std::string preview, liveAddress, displayServer;
  std::vector<std::string> liveHosts;
  std::optional<std::string> every;
  bool live = false;
  /** Page shared by renders in sequence; null: each render has its own. */
  std::shared_ptr<LiveServer> page;
  double patience = 2; ///< seconds that pages and display servers have for the last picture

  void addTo(CLI::App& command);
  /** Throws Error if an option makes no sense, or if the preview cannot be written. */
  void check() const;
  /** Opens a page if one is requested, and prints its address; else null. `stop`: see FilmViewers. */
  std::shared_ptr<LiveServer> openPage(const std::string& title, std::function<void()> stop) const;
  bool any() const { return !preview.empty() || live || !displayServer.empty(); }
};

/** Viewers that the options request, from before the render to its end. */
class FilmViewers {
 public:
  /** `stop` is called when a viewer wants the render to end. Throws Error if a viewer cannot begin. */
  FilmViewers(const ViewerOptions& options, const DevelopOptions& develop, const std::string& title,
              std::function<void()> stop);
  ~FilmViewers();
  FilmViewers(const FilmViewers&) = delete;
  FilmViewers& operator=(const FilmViewers&) = delete;

  /** Shows a picture of the film to all viewers that are due. Returns the time until the next is due [s]. */
  double look(const std::function<Image()>& picture, const std::function<void(const std::string&)>& say);
  void show(const RenderProgress& progress);
  /** Lets a page ask for the paths of pixels as long as the viewers exist. Without a page nobody asks. */
  void answerPixels(std::shared_ptr<PixelQueries> queries);
  /** Shows the last picture. The caller writes the preview, like its other outputs. */
  void finish(const Image& picture, const std::function<void(const std::string&)>& say);

 private:
  using Clock = std::chrono::steady_clock;
  struct Viewer {
    std::unique_ptr<PictureThread> thread;
    double interval = 1; ///< seconds
    bool isPreview = false;
    Clock::time_point due{};
    std::shared_ptr<TevClient> server{}; ///< display server; null: a preview
  };
  std::vector<Viewer> viewers;
  std::shared_ptr<LiveServer> live;
  bool keepsPage;  ///< the page outlives the render
  double patience; ///< see ViewerOptions
  Clock::time_point liveDue{};
};

} // namespace recurse::apps
