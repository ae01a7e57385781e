/** @file
 * Animations: pictures in sequence, as an animated PNG or, by the program ffmpeg, as MP4.
 */
#pragma once

#include <string>
#include <vector>

#include "recurse/core/image/image.h"

namespace recurse {

/** True for the formats that only animations have: .apng .mp4. */
bool isAnimationFormat(const std::string& fileName);

/** Throws Error when an animation could not be written there: an extension other than .png .apng .mp4, no
 * ffmpeg in the PATH for .mp4 (both BAD_USAGE), or as checkFileWritable(). Called before a long render. */
void checkAnimationWritable(const std::string& fileName);

/** Animation in memory, one PNG for each frame, until write(). */
class AnimationFile {
 public:
  /** `framesPerSecond`: see animatedPng(). */
  AnimationFile(std::string fileName, double framesPerSecond)
      : fileName(std::move(fileName)), framesPerSecond(framesPerSecond) {}

  /** Adds a picture of R, G and B, encoded for the display, in [0, 1]. Throws Error if its size differs from
   * the first one's. */
  void add(const Image& encoded);
  /** Writes the animation: MP4 for .mp4, else animated PNG. It appears under its name only when it is
   * complete. Throws Error without frames, and where ffmpeg fails. */
  void write() const;

 private:
  std::string fileName;
  double framesPerSecond;
  int width = 0, height = 0;
  std::vector<std::vector<unsigned char>> frames; ///< PNG files
};

/** Animated PNG (PNG specification, third edition, section 11.3.6) of PNG files with equal headers, which is
 * repeated without end. Rates that are not whole are rounded to 1/100; from 0.01 to 655 they fit the format.
 * Throws Error without frames, and for unequal headers. */
std::vector<unsigned char> animatedPng(const std::vector<std::vector<unsigned char>>& frames,
                                       double framesPerSecond);

} // namespace recurse
