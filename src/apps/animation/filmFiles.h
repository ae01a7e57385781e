/** @file
 * Output files that hold many pictures: animations and transient renders.
 */
#pragma once

#include <map>
#include <string>
#include <vector>

#include "apps/options/developOptions.h"
#include "recurse/core/image/filmFile.h"
#include "recurse/pathclasses/transientFrames.h"

namespace recurse::apps {

/** Value of --time-of-flight, FROM:TO:FRAMES. Throws Error (BAD_USAGE). */
TransientFrames parseTimeOfFlight(const std::string& text);
/** Value of --frame-rate. Throws Error (BAD_USAGE). */
double parseFrameRate(const std::string& text);

/** Throws Error if a film could not be written there, or if these options would change its frames one by
 * one. */
void checkFilmOutput(const std::string& fileName, const DevelopOptions& options);

/** Films of an animation, whose frames are rendered one after another. */
class FilmFiles {
 public:
  explicit FilmFiles(double framesPerSecond) : framesPerSecond(framesPerSecond) {}
  /** Adds a developed picture to a film. */
  void add(const std::string& fileName, const Image& developed);
  std::vector<std::string> names() const;
  /** Writes a film of all its frames so far. Throws Error. */
  void write(const std::string& fileName) const;

 private:
  double framesPerSecond;
  std::map<std::string, FilmFile> films;
};

/** Whether this output of a transient render is a film, not the picture. */
bool isTransientFilm(const std::string& fileName);

/** Writes the frames of a transient picture as a film; throws Error if it has none. One exposure serves all
 * frames: that of a picture with each pixel at its brightest. Returns the exposure [stops]. */
double writeTransientFilm(const std::string& fileName, const Image& picture, const DevelopOptions& options,
                          double framesPerSecond);

} // namespace recurse::apps
