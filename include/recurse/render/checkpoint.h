/** @file
 * Renders saved to files, to be resumed after an interruption, or to be merged.
 */
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "recurse/model/film/film.h"
#include "recurse/pathclasses/pathClasses.h"
#include "recurse/render/render.h"

namespace recurse {

/** Value of the identity "sample distribution" for samples that are not adaptive. */
inline const std::string UNIFORM_SAMPLES = "uniform";

/** State of a render as a file contains it. */
struct Checkpoint {
  /** Samples [first, end) of each pixel with a seed; some of these may be missing in the film. */
  struct Part {
    uint64_t seed = 0;
    int64_t first = 0, end = 0;
  };

  /** Inputs of the samples, by name: renders that differ in any of them do not fit together. "samples per
   * pixel" is the number that missingSamples() expects; none or no number: not specified. */
  std::map<std::string, std::string> identity;
  std::map<std::string, std::string> metadata; ///< metadata of the picture
  float imagingRatio = 1;                      ///< factor from the film to the picture
  std::vector<PathClass> classes;              ///< the film's layers
  std::vector<Part> parts;
  RenderPosition position; ///< resume point of a single part
  Film film;
  std::optional<SampleAllocation> allocation; ///< adaptive samples of a single part

  /** Reads a checkpoint. Throws Error naming the file: not readable, not a checkpoint, of a different
   * version, damaged. Allocates the film only if the file has the size that its header states. */
  static Checkpoint read(const std::string& fileName);
};

/** Replaces the file atomically, without a copy of the film. Throws Error. */
void writeCheckpoint(const std::string& fileName, Checkpoint& checkpoint);

/** Throws Error with the differences where `other`, read from `fileName`, lacks an input of `identity` or has
 * another value of it. */
void requireSame(const std::string& fileName, const std::map<std::string, std::string>& identity,
                 const std::map<std::string, std::string>& other);

/** Adds film and parts of `other`, which was read from `fileName`; removes the allocation. Throws Error where
 * it does not fit, or where samples would be added twice. */
void merge(Checkpoint& into, const Checkpoint& other, const std::string& fileName);

/** Missing samples of the picture in words, such as "samples 8:16"; empty where all samples of each pixel are
 * there, or their number was never specified. Whether adaptive samples are complete can only be determined
 * before merging. */
std::string missingSamples(const Checkpoint& checkpoint);

} // namespace recurse
