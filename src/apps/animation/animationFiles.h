/** @file
 * Output files that hold many pictures: animations and transient renders.
 */
#pragma once

#include <map>
#include <string>
#include <vector>

#include "apps/options/developOptions.h"
#include "recurse/core/image/animationFile.h"
#include "recurse/pathclasses/transientFrames.h"

namespace recurse::apps {

/** Value of --time-of-flight, FROM:TO:FRAMES. Throws Error (BAD_USAGE). */
TransientFrames parseTimeOfFlight(const std::string& text);
/** Value of --frame-rate. Throws Error (BAD_USAGE). */
double parseFrameRate(const std::string& text);

/** Throws Error if an animation could not be written there, or if these options would change its frames one
 * by one. */
void checkAnimationOutput(const std::string& fileName, const DevelopOptions& options);

/** Animations in several files, whose frames are rendered one after another. */
class AnimationFiles {
 public:
  explicit AnimationFiles(double framesPerSecond) : framesPerSecond(framesPerSecond) {}
  /** Adds a developed picture to an animation. */
  void add(const std::string& fileName, const Image& developed);
  std::vector<std::string> names() const;
  /** Writes an animation of all its frames so far. Throws Error. */
  void write(const std::string& fileName) const;

 private:
  double framesPerSecond;
  std::map<std::string, AnimationFile> files;
};

/** Whether this output of a transient render is an animation, not the picture. */
bool isTransientAnimation(const std::string& fileName);

/** Writes the frames of a transient picture as an animation; throws Error if it has none. One exposure serves
 * all frames: that of a picture with each pixel at its brightest. Returns the exposure [stops]. */
double writeTransientAnimation(const std::string& fileName, const Image& picture,
                               const DevelopOptions& options, double framesPerSecond);

} // namespace recurse::apps
