/** @file
 * Renders kept in files: to go on with after an interruption, and to be added up.
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

/** What identity says of samples that are not adaptive. */
inline const std::string ALL_ALIKE = "to all pixels alike";

struct Checkpoint {
  /** Samples [first, end) of each pixel with a seed; some of them may be missing from the film. */
  struct Part {
    uint64_t seed = 0;
    int64_t first = 0, end = 0;
  };

  /** What the samples depend on, by name: renders that differ in any of it do not fit together. */
  std::map<std::string, std::string> identity;
  std::map<std::string, std::string> metadata; ///< of the picture
  float imagingRatio = 1;                      ///< of the picture to the film
  std::vector<PathClass> classes;              ///< the film's layers
  std::vector<Part> parts;
  RenderPosition position; ///< of a single part
  Film film;
  std::optional<SampleAllocation> allocation; ///< of a single part

  /** A film too large for the file (see the error) is not allocated. Throws Error that names the file: not
   * readable, not a checkpoint, of another version, damaged. */
  static Checkpoint read(const std::string& fileName);
};

/** Replaces the file in one step; without a copy of the film. Throws Error. */
void writeCheckpoint(const std::string& fileName, Checkpoint& checkpoint);

/** Throws Error with what differs, where `other` is not a render of the same picture. */
void requireSame(const std::string& fileName, const std::map<std::string, std::string>& identity,
                 const std::map<std::string, std::string>& other);

/** Adds `other`, which was read from `fileName`. Throws Error where it does not fit, or has samples that are
 * there already. */
void merge(Checkpoint& into, const Checkpoint& other, const std::string& fileName);

/** What the picture lacks, in words, such as "samples 8:16"; empty where all samples of each pixel are there,
 * or nobody has said how many there are to be. Only before merging it is known whether adaptive samples are
 * complete. */
std::string missingSamples(const Checkpoint& checkpoint);

} // namespace recurse
