/** @file
 * Animations of rendered frames and of transient renders.
 */
#include "apps/animation/animationFiles.h"

#include <algorithm>
#include <cmath>

#include "apps/options/optionText.h"
#include "recurse/core/io/error.h"

namespace recurse::apps {

TransientFrames parseTimeOfFlight(const std::string& text) {
  constexpr int64_t MAX_FRAMES = 9999;
  const std::string option = "--time-of-flight";
  const std::vector<std::string> parts = split(text, ':');
  if (parts.size() != 3)
    badUsage(option + ": '" + text + "' is not FROM:TO:FRAMES, such as 0:10:50: lengths in scene units");
  const double from = parseReal(option, parts[0]), to = parseReal(option, parts[1]);
  constexpr double LONGEST = 1e30; // single precision holds lengths up to 3.4e38
  if (!(std::abs(from) <= LONGEST && std::abs(to) <= LONGEST))
    badUsage(option + ": '" + text + "': lengths are from -1e30 to 1e30");
  const int64_t frames = parseCount(option, parts[2], 1, MAX_FRAMES);
  if (!(from < to)) badUsage(option + ": '" + text + "': TO must be larger than FROM");
  constexpr double RESOLVED = 1e-5; // of a length; single precision resolves 1e-7
  if (!((to - from) / double(frames) > RESOLVED * std::max(std::abs(from), std::abs(to))))
    badUsage(option + ": '" + text + "': the frames are too short to be measured; give fewer frames");
  return {from, to, static_cast<size_t>(frames)};
}

double parseFrameRate(const std::string& text) {
  constexpr double LEAST = 0.01, MOST = 500;
  const double rate = parseReal("--frame-rate", text);
  if (!(rate >= LEAST && rate <= MOST))
    badUsage("--frame-rate: '" + text + "' is not from 0.01 to 500 frames per second");
  return rate;
}

void checkAnimationOutput(const std::string& fileName, const DevelopOptions& options) {
  if (options.whiteBalance == "auto")
    badUsage("--white-balance: auto would colour each frame of " + fileName +
             " in its own way; give a temperature, such as 5000");
  if (options.settings().toneMap->measuresPicture())
    badUsage("--tonemap: " + options.toneMap + " would adapt to each frame of " + fileName +
             ", which flickers; choose another, such as filmic or reinhard \"float white\" 4");
  checkAnimationWritable(fileName);
}

void AnimationFiles::add(const std::string& fileName, const Image& developed) {
  files.try_emplace(fileName, fileName, framesPerSecond).first->second.add(developed);
}

std::vector<std::string> AnimationFiles::names() const {
  std::vector<std::string> out;
  for (const auto& [name, file] : files) out.push_back(name);
  return out;
}

void AnimationFiles::write(const std::string& fileName) const { files.at(fileName).write(); }

bool isTransientAnimation(const std::string& fileName) {
  return isAnimationFormat(fileName) || lowerCase(fileName).ends_with(".png");
}

namespace {

/** Index of the red channel of each frame. */
std::vector<size_t> frameChannels(const Image& picture) {
  std::vector<size_t> first;
  for (size_t i = 0; i < picture.channels.size(); ++i)
    if (TransientFrames::isFrameName(picture.channels[i]) && picture.channels[i].ends_with(".R"))
      first.push_back(i);
  return first;
}

Image frameOf(const Image& picture, size_t firstChannel) {
  Image frame(picture.width, picture.height, {"R", "G", "B"});
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) std::copy_n(picture.at(x, y) + firstChannel, 3, frame.at(x, y));
  frame.metadata = picture.metadata;
  return frame;
}

/** Picture with each pixel as it is in its brightest frame. */
Image brightestOf(const Image& picture, const std::vector<size_t>& frames) {
  Image out(picture.width, picture.height, {"R", "G", "B"});
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      for (const size_t first : frames) {
        const float* p = picture.at(x, y) + first;
        const Rgb frame(p[0], p[1], p[2]);
        if (luminance(frame) > luminance(out.rgb(x, y))) std::copy_n(p, 3, out.at(x, y));
      }
  return out;
}

} // namespace

double writeTransientAnimation(const std::string& fileName, const Image& picture,
                               const DevelopOptions& options, double framesPerSecond) {
  const std::vector<size_t> frames = frameChannels(picture);
  if (frames.empty())
    throw Error(fileName + ": the picture has no frames, as 'recurse render --time-of-flight' makes them");
  DevelopSettings settings = options.settings();
  Image brightest = brightestOf(picture, frames);
  applyWhiteBalance(brightest, settings.whiteBalance);
  const double stops = stopsFor(settings.exposure, brightest);
  settings.exposure = {Exposure::Meter::NONE, 0, stops};
  AnimationFile animation(fileName, framesPerSecond);
  for (const size_t first : frames) {
    Developed frame = develop(frameOf(picture, first), settings);
    frame.picture.metadata["recurse:developed"] = options.text(stops);
    animation.add(frame.picture);
  }
  animation.write();
  return stops;
}

} // namespace recurse::apps
