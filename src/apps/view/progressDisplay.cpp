/** @file
 * Progress on a terminal, as plain lines, and as JSON.
 */
#include "apps/view/progressDisplay.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <nlohmann/json.hpp>
#include <sys/ioctl.h>
#include <unistd.h>

#include "apps/options/optionText.h"
#include "apps/run/console.h"
#include "recurse/core/io/terminalText.h"

namespace recurse::apps {

namespace {

/** Plain lines: step of the fraction; shortest and longest interval between lines [s]. */
constexpr double PLAIN_STEP = 0.1, PLAIN_SHORTEST = 2, PLAIN_LONGEST = 30;

bool isTerminal() {
  const char* term = std::getenv("TERM");
  return ::isatty(STDERR_FILENO) != 0 && term && std::strcmp(term, "dumb") != 0;
}

size_t terminalWidth() {
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

std::string figures(const RenderProgress& p) {
  std::string out;
  if (p.samplesPerPixel > 0) out += formatted("  %.4g spp", p.samplesPerPixel);
  if (p.raysPerSecond > 0) out += "  " + formatted("%.3g", p.raysPerSecond / 1e6) + " Mrays/s";
  if (p.error >= 0) out += "  error " + formatted("%.3g", p.error);
  out += "  " + durationText(p.elapsed);
  if (p.secondsLeft >= 0) out += ", " + durationText(p.secondsLeft) + " left";
  return out;
}

std::string percent(double fraction) { return formatted("%3.0f%%", 100 * fraction); }

} // namespace

ProgressMode progressModeOf(const std::string& name) {
  if (name == "plain") return ProgressMode::PLAIN;
  if (name == "json") return ProgressMode::JSON;
  if (name == "off") return ProgressMode::OFF;
  return isTerminal() ? ProgressMode::TERMINAL : ProgressMode::PLAIN;
}

void ProgressDisplay::clear() {
  if (!shown) return;
  std::fputs("\r\033[K", stderr);
  shown = false;
}

void ProgressDisplay::finish() {
  const std::lock_guard guard(mutex);
  clear();
}

void ProgressDisplay::message(const std::string& text) {
  const std::lock_guard guard(mutex);
  clear();
  say(text + "\n");
}

void ProgressDisplay::update(const RenderProgress& p) {
  if (mode == ProgressMode::OFF) return;
  const std::lock_guard guard(mutex);
  if (mode == ProgressMode::TERMINAL) {
    const std::string after = " " + percent(p.fraction) + figures(p);
    const size_t width = terminalWidth(), used = p.phase.size() + after.size() + 4;
    std::string line = terminalText(p.phase);
    if (used + 10 <= width) {
      const size_t bar = std::min<size_t>(30, width - used),
                   full = size_t(std::lround(double(bar) * p.fraction));
      line += " [" + std::string(full, '#') + std::string(bar - full, '.') + "]";
    }
    line += after;
    // A line longer than the terminal would wrap, and could not be rewritten.
    std::fputs(("\r\033[K" + line.substr(0, width - 1)).c_str(), stderr);
    std::fflush(stderr);
    shown = true;
    return;
  }
  const auto now = std::chrono::steady_clock::now();
  if (mode == ProgressMode::JSON) {
    nlohmann::ordered_json json = {{"phase", p.phase},
                                   {"fraction", p.fraction},
                                   {"elapsed", p.elapsed},
                                   {"seconds_left", nullptr},
                                   {"samples_per_pixel", p.samplesPerPixel},
                                   {"rays_per_second", p.raysPerSecond}};
    if (p.error >= 0) json["relative_error"] = p.error;
    if (p.secondsLeft >= 0) json["seconds_left"] = p.secondsLeft;
    say(json.dump() + "\n");
    return;
  }
  if (lastPhase != p.phase) {
    lastPhase = p.phase;
    lastFraction = 0;
    last = now;
  }
  const double since = std::chrono::duration<double>(now - last).count();
  const bool step = p.fraction - lastFraction >= PLAIN_STEP && since >= PLAIN_SHORTEST;
  if (!step && since < PLAIN_LONGEST) return;
  last = now;
  lastFraction = p.fraction;
  say(p.phase + " " + percent(p.fraction) + figures(p) + "\n");
}

} // namespace recurse::apps
