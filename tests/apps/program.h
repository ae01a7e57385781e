/** @file
 * Runs the program as a user would, in a separate folder.
 */
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <unistd.h>

namespace programTesting {

struct Outcome {
  int status = -1; ///< 128 + signal if it was killed
  std::string out, err;
  double seconds = 0;
};

inline std::string contents(const std::string& name) {
  std::ifstream in(name, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/** Runs the program in `folder` as a separate process; `meanwhile` is called with its process id. */
Outcome runIn(const std::string& folder, const std::vector<std::string>& arguments,
              const std::function<void(pid_t)>& meanwhile = {});

/** Fixture with a folder, and a small scene in it: a lit floor under a square lamp. */
class Program : public testing::Test {
 protected:
  void SetUp() override {
    folder = (std::filesystem::temp_directory_path() / ("recurse-program-test-" + std::to_string(::getpid())))
                 .string();
    std::filesystem::create_directories(folder);
    write("scene.pbrt", scene());
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  static std::string scene(const std::string& header = {}, const std::string& inWorld = {}) {
    return "LookAt 0 1 3  0 0.5 0  0 1 0\n"
           "Camera \"perspective\" \"float fov\" 50\n"
           "Film \"rgb\" \"integer xresolution\" 24 \"integer yresolution\" 16 \"string filename\" "
           "\"film.exr\"\n"
           "Sampler \"sobol\" \"integer pixelsamples\" 2\n" +
           header +
           "WorldBegin\n"
           "AttributeBegin\n"
           "AreaLightSource \"diffuse\" \"rgb L\" [ 4 4 4 ]\n"
           "Shape \"trianglemesh\" \"integer indices\" [ 0 1 2 0 2 3 ]\n"
           "  \"point3 P\" [ -0.5 2 -0.5  0.5 2 -0.5  0.5 2 0.5  -0.5 2 0.5 ]\n"
           "AttributeEnd\n"
           "Material \"diffuse\" \"rgb reflectance\" [ 0.5 0.5 0.5 ]\n"
           "Shape \"trianglemesh\" \"integer indices\" [ 0 1 2 0 2 3 ]\n"
           "  \"point3 P\" [ -2 0 -2  -2 0 2  2 0 2  2 0 -2 ]\n" +
           inWorld;
  }

  /** Scene with shapes that take ten minutes to build. */
  static std::string slowScene() {
    std::string shapes;
    for (int i = 0; i < 1000; ++i)
      shapes += "Shape \"loopsubdiv\" \"integer levels\" 9 \"point3 P\" [ 0 0 0  1 0 0  0 1 0  0 0 1 ] "
                "\"integer indices\" [ 0 1 2  0 2 3 ]\n";
    return scene({}, shapes);
  }

  Outcome run(const std::vector<std::string>& arguments,
              const std::function<void(pid_t)>& meanwhile = {}) const {
    return runIn(folder, arguments, meanwhile);
  }
  /** Runs the program with a limit: it is killed a minute after `meanwhile`. */
  Outcome runAMinute(const std::vector<std::string>& arguments,
                     const std::function<void(pid_t)>& meanwhile = {}) const {
    std::jthread watch;
    return run(arguments, [&](pid_t child) {
      if (meanwhile) meanwhile(child);
      watch = std::jthread([child](const std::stop_token& ended) {
        std::mutex own;
        std::unique_lock lock(own);
        std::condition_variable_any sleep;
        sleep.wait_for(lock, ended, std::chrono::minutes(1), [] { return false; });
        if (!ended.stop_requested()) ::kill(child, SIGKILL);
      });
    });
  }
  std::string file(const std::string& name) const { return folder + "/" + name; }
  void write(const std::string& name, const std::string& text) const { std::ofstream(file(name)) << text; }
  bool exists(const std::string& name) const { return std::filesystem::exists(file(name)); }
  /** Number of remaining temporary files, whose names begin with a dot. */
  size_t leftBehind() const {
    size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      count += entry.path().filename().string().starts_with(".");
    return count;
  }
  static bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  }

  /** Waits until the condition holds; false if it does not within a minute. */
  static bool comesTo(const std::function<bool()>& isSo) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (!isSo()) {
      if (std::chrono::steady_clock::now() > end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return true;
  }
  bool appears(const std::string& name) const {
    return comesTo([&] { return exists(name); });
  }
  /** Waits until a render with `--progress json` has a sample of every pixel. */
  bool isUnderWay() const {
    return comesTo([&] {
      std::ifstream lines(file(".stderr"));
      for (std::string line; std::getline(lines, line);) {
        const size_t at = line.find(SAMPLES);
        if (at != std::string::npos && std::atof(line.c_str() + at + SAMPLES.size()) >= 1) return true;
      }
      return false;
    });
  }
  /** Function that waits for isUnderWay() and sends the signal; SIGKILL after a minute without a sample. */
  std::function<void(pid_t)> onceUnderWay(int signal) const {
    return [this, signal](pid_t child) { ::kill(child, isUnderWay() ? signal : SIGKILL); };
  }

  std::string folder;

 private:
  inline static const std::string SAMPLES = "\"samples_per_pixel\":";
};

inline void sleepSeconds(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

} // namespace programTesting
