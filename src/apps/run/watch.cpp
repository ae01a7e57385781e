/** @file
 * Thread that polls the files' times and sizes, and the loop around renders.
 */
#include "apps/run/watch.h"

#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "apps/run/console.h"
#include "apps/run/interrupt.h"

namespace recurse::apps {

namespace {

/** Interval between polls of the files, too short to be noticed. */
constexpr std::chrono::milliseconds LOOK{200};

/** Watches files for changes, in a thread. */
class FileWatcher {
 public:
  /** `onChange` is called at most once, in the watching thread. */
  explicit FileWatcher(std::function<void()> onChange)
      : onChange(std::move(onChange)), thread([this] { work(); }) {}
  ~FileWatcher() {
    ends = true;
    thread.join();
  }
  FileWatcher(const FileWatcher&) = delete;
  FileWatcher& operator=(const FileWatcher&) = delete;

  /** Adds files. The ones that are watched already keep their recorded state. */
  void add(const std::vector<std::string>& files) {
    const std::lock_guard<std::mutex> guard(mutex);
    for (const std::string& file : files) states.try_emplace(file, stateOf(file));
  }
  bool changed() const { return hasChanged; }

 private:
  using State = std::pair<std::filesystem::file_time_type, uintmax_t>;
  /** State of a file, even if it is missing, as while an editor replaces it. */
  static State stateOf(const std::string& file) {
    std::error_code ignored;
    const auto time = std::filesystem::last_write_time(file, ignored);
    return {time, std::filesystem::file_size(file, ignored)};
  }
  bool differs() {
    const std::lock_guard<std::mutex> guard(mutex);
    for (const auto& [file, state] : states)
      if (stateOf(file) != state && std::filesystem::exists(file)) return true;
    return false;
  }
  void work() {
    while (!ends && !hasChanged) {
      if (differs()) {
        std::this_thread::sleep_for(LOOK); // writers may need a moment
        hasChanged = true;
        onChange();
      }
      std::this_thread::sleep_for(LOOK);
    }
  }

  const std::function<void()> onChange;
  std::mutex mutex;
  std::map<std::string, State> states;
  std::atomic<bool> ends{false}, hasChanged{false};
  std::thread thread;
};

} // namespace

ExitStatus watchScene(
    const std::string& scene,
    const std::function<void(bool, const std::function<void(const std::vector<std::string>&)>&)>& render) {
  const GracefulStop graceful;
  std::vector<std::string> files = {scene};
  for (;;) {
    std::optional<FileWatcher> watcher(std::in_place, requestStop);
    watcher->add(files);
    bool isFirstLoad = true;
    const auto loaded = [&](const std::vector<std::string>& found) {
      if (std::exchange(isFirstLoad, false)) files.clear();
      files.insert(files.end(), found.begin(), found.end());
      watcher->add(found);
    };
    for (const bool first : {true, false}) {
      try {
        render(first, loaded);
      } catch (const Error& error) {
        if (error.status() == ExitStatus::BAD_USAGE) throw;
        const std::string text = error.what();
        if (!graceful.flag()) say("recurse: " + text + (text.ends_with('\n') ? "" : "\n"));
        break;
      }
      if (graceful.flag() || watcher->changed()) break;
    }
    if (!graceful.flag()) say("waiting for changes of the scene's files; press Ctrl-C to quit\n");
    while (!graceful.flag() && !watcher->changed()) std::this_thread::sleep_for(LOOK);
    const bool changed = watcher->changed();
    watcher.reset(); // it requests no stop from here on
    if (!changed) return ExitStatus::DONE;
    withdrawStop();
  }
}

} // namespace recurse::apps
