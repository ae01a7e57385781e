/** @file
 * A thread that looks at the files' times and sizes, and the loop around renders.
 */
#include "apps/watch.h"

#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "apps/interrupt.h"

namespace recurse::apps {

namespace {

/** Between looks at the files: no longer than a person notices. */
constexpr std::chrono::milliseconds LOOK{200};

/** Tells when files change. */
class FileWatcher {
 public:
  /** `onChange` is called in another thread, once. */
  explicit FileWatcher(std::function<void()> onChange)
      : onChange(std::move(onChange)), thread([this] { work(); }) {}
  ~FileWatcher() {
    ends = true;
    thread.join();
  }
  FileWatcher(const FileWatcher&) = delete;
  FileWatcher& operator=(const FileWatcher&) = delete;

  /** Those that are watched already keep the state that they had. */
  void add(const std::vector<std::string>& files) {
    const std::lock_guard<std::mutex> guard(mutex);
    for (const std::string& file : files) states.try_emplace(file, stateOf(file));
  }
  bool changed() const { return hasChanged; }

 private:
  using State = std::pair<std::filesystem::file_time_type, uintmax_t>;
  /** Of a file that is missing too, as while an editor puts another one in its place. */
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
    FileWatcher watcher(requestStop);
    watcher.add(files);
    const auto loaded = [&](const std::vector<std::string>& found) {
      files = found;
      watcher.add(found);
    };
    for (const bool first : {true, false}) {
      try {
        render(first, loaded);
      } catch (const Error& error) {
        if (error.status() == ExitStatus::BAD_USAGE) throw;
        const std::string text = error.what();
        if (!graceful.flag())
          std::fputs(("recurse: " + text + (text.ends_with('\n') ? "" : "\n")).c_str(), stderr);
        break;
      }
      if (graceful.flag()) break;
    }
    if (!graceful.flag()) std::fputs("waiting for a change of the scene's files; Ctrl-C ends\n", stderr);
    while (!graceful.flag()) std::this_thread::sleep_for(LOOK);
    if (!watcher.changed()) return ExitStatus::DONE;
    withdrawStop();
  }
}

} // namespace recurse::apps
