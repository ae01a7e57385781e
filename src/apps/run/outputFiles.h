/** @file
 * Outputs of a command that must not take the place of each other or of what it reads.
 */
#pragma once

#include <string>
#include <vector>

namespace recurse::apps {

/** A file that a command writes, by the option that names it, such as "-o". */
struct OutputFile {
  std::string option, name;
};

/** A file that a command reads, and what it is, such as "the reference". */
struct InputFile {
  std::string what, name;
};

/** Throws Error (BAD_USAGE) where an output is the same file as another output or an input, whatever the
 * spelling, and through links. Empty names are none. */
void requireDistinctFiles(const std::vector<OutputFile>& outputs, const std::vector<InputFile>& inputs);

/** The same for an output folder in which a command writes many files: none of its other files may be there.
 */
void requireOutsideOf(const std::string& folder, const std::vector<OutputFile>& outputs,
                      const std::vector<InputFile>& inputs);

/** A list of one option's files. */
std::vector<OutputFile> outputFiles(const std::string& option, const std::vector<std::string>& names);
std::vector<InputFile> inputFiles(const std::string& what, const std::vector<std::string>& names);

} // namespace recurse::apps
