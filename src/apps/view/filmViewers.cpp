/** @file
 * Threads that show pictures of a render, and the times at which they get one.
 */
#include "apps/view/filmViewers.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "apps/options/optionText.h"
#include "apps/view/tevClient.h"
#include "recurse/core/io/error.h"

namespace recurse::apps {

PictureThread::PictureThread(Present present) : present(std::move(present)), thread([this] { work(); }) {}

void PictureThread::end() {
  if (!thread.joinable()) return;
  {
    const std::lock_guard<std::mutex> guard(mutex);
    ends = true;
  }
  wake.notify_one();
  thread.join();
}

void PictureThread::offer(Image picture) {
  {
    const std::lock_guard<std::mutex> guard(mutex);
    next = std::move(picture);
  }
  wake.notify_one();
}

double PictureThread::cost() const {
  const std::lock_guard<std::mutex> guard(mutex);
  return seconds;
}

std::string PictureThread::takeFailure() {
  const std::lock_guard<std::mutex> guard(mutex);
  return std::exchange(failure, {});
}

void PictureThread::work() {
  std::unique_lock<std::mutex> lock(mutex);
  for (;;) {
    wake.wait(lock, [this] { return next || ends; });
    if (!next) return;
    const Image picture = std::move(*next);
    next.reset();
    lock.unlock();
    const auto start = std::chrono::steady_clock::now();
    std::string reason;
    try {
      present(picture);
    } catch (const std::exception& error) {
      reason = error.what();
    }
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    lock.lock();
    seconds = took.count();
    if (!reason.empty() && !std::exchange(failed, true)) failure = reason;
  }
}

void ViewerOptions::addTo(CLI::App& command) {
  const std::string group = "To watch the render";
  command.add_option("--preview", preview, "File to which the picture so far is written at intervals")
      ->type_name("FILE")
      ->group(group);
  command.add_option("--every", every, "Minimum interval between writes of --preview (default: 5s)")
      ->type_name("TIME")
      ->group(group);
  command
      .add_flag(
          "--live", live,
          "Serve a web page with the picture so far, exposure, tone operator, pixel values, the paths of a "
          "clicked pixel, remaining time, and a button to stop and keep the picture. Anyone who has the "
          "printed address can watch and stop")
      ->group(group);
  command
      .add_option("--live-address", liveAddress,
                  "For --live: address of the page (default: 127.0.0.1, reachable from this machine only, at "
                  "any free port); IPv6 as [::1]:8080")
      ->type_name("HOST:PORT")
      ->group(group);
  addRepeatedOption(command, "--live-host", liveHosts,
                    "For --live: host name by which browsers may reach the page, may be repeated, besides "
                    "localhost and this machine's addresses")
      ->type_name("NAME")
      ->group(group);
  command
      .add_option("--display-server", displayServer,
                  "Send the picture so far to the viewer tev, such as localhost:14158")
      ->type_name("HOST:PORT")
      ->group(group);
}

void ViewerOptions::check() const {
  if (!preview.empty()) checkImageWritable(preview);
  if (every && preview.empty()) badUsage("--every: needs --preview FILE");
  if (every) parseDuration("--every", *every);
  if (!liveAddress.empty() && !live) badUsage("--live-address: needs --live");
  if (!liveHosts.empty() && !live) badUsage("--live-host: needs --live");
  if (!displayServer.empty()) TevClient(displayServer, "");
}

std::shared_ptr<LiveServer> ViewerOptions::openPage(const std::string& title,
                                                    std::function<void()> stop) const {
  if (!live) return nullptr;
  auto opened = std::make_shared<LiveServer>(liveAddress.empty() ? LOOPBACK : liveAddress, liveHosts, title,
                                             std::move(stop));
  std::fputs(("the picture so far: " + opened->url() + "\n").c_str(), stderr);
  return opened;
}

FilmViewers::FilmViewers(const ViewerOptions& options, const DevelopOptions& develop,
                         const std::string& title, std::function<void()> stop)
    : keepsPage(options.page != nullptr), patience(options.patience) {
  const auto begin = Clock::now();
  if (!options.preview.empty()) {
    constexpr double PREVIEW_SECONDS = 5;
    const double interval = options.every ? parseDuration("--every", *options.every) : PREVIEW_SECONDS;
    auto write = [file = options.preview, develop](const Image& p) { PictureWriter(develop).write(file, p); };
    viewers.push_back({std::make_unique<PictureThread>(std::move(write)), interval, true, begin});
  }
  if (!options.displayServer.empty()) {
    auto client = std::make_shared<TevClient>(options.displayServer, title);
    auto send = [client](const Image& p) { client->send(p); };
    viewers.push_back({std::make_unique<PictureThread>(std::move(send)), 1, false, begin, client});
  }
  live = options.page ? options.page : options.openPage(title, std::move(stop));
  if (live) live->begin();
}

double FilmViewers::look(const std::function<Image()>& picture,
                         const std::function<void(const std::string&)>& say) {
  // Viewers take at most 1 / LEAST_PART of the time.
  constexpr double LEAST_PART = 50;
  const auto start = Clock::now();
  const auto after = [&](double seconds) {
    return start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  };
  std::optional<Image> newest;
  const auto made = [&] {
    if (!newest) newest = picture();
    return *newest;
  };
  Clock::time_point next = after(3600);
  for (Viewer& viewer : viewers) {
    if (const std::string failure = viewer.thread->takeFailure(); !failure.empty())
      say("warning: " + failure);
    if (viewer.due <= start) {
      viewer.thread->offer(made());
      viewer.due = after(std::max(viewer.interval, LEAST_PART * viewer.thread->cost()));
    }
    next = std::min(next, viewer.due);
  }
  if (live) {
    if (liveDue <= start) {
      live->show(made());
      liveDue = after(std::max(1.0, LEAST_PART * live->cost()));
    }
    next = std::min(next, liveDue);
  }
  const std::chrono::duration<double> cost = Clock::now() - start, wait = next - start;
  return std::max(wait.count(), LEAST_PART * cost.count());
}

void FilmViewers::show(const RenderProgress& progress) {
  if (live) live->show(progress);
}

void FilmViewers::answerPixels(std::shared_ptr<PixelQueries> queries) {
  if (live) live->setQueries(std::move(queries));
}

FilmViewers::~FilmViewers() {
  if (live) live->setQueries(nullptr);
}

void FilmViewers::finish(const Image& picture, const std::function<void(const std::string&)>& say) {
  const auto end =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(patience));
  for (Viewer& viewer : viewers) {
    if (viewer.server) viewer.server->endBy(end);
    if (!viewer.isPreview) viewer.thread->offer(picture);
  }
  for (Viewer& viewer : viewers) {
    viewer.thread->end();
    if (const std::string failure = viewer.thread->takeFailure(); !failure.empty() && !viewer.isPreview)
      say("warning: " + failure);
  }
  viewers.clear();
  if (!live) return;
  live->show(picture);
  if (!keepsPage) live->finish(patience);
}

} // namespace recurse::apps
