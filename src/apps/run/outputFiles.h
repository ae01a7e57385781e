/** @file
 * Outputs of a command, which must neither replace each other nor its inputs.
 */
#pragma once

#include <string>
#include <vector>

namespace recurse::apps {

/** File that a command writes, with the option that names it, such as "-o". */
struct OutputFile {
  std::string option, name;
};

/** File that a command reads, with its description, such as "the reference". */
struct InputFile {
  std::string what, name;
};

/** Throws Error (BAD_USAGE) if two outputs, or an output and an input, are the same file, in any spelling or
 * through links. Empty names are ignored. */
void requireDistinctFiles(const std::vector<OutputFile>& outputs, const std::vector<InputFile>& inputs);

/** Throws Error (BAD_USAGE) if an output or an input is in `folder`, in which the command writes many
 * files. */
void requireOutsideOf(const std::string& folder, const std::vector<OutputFile>& outputs,
                      const std::vector<InputFile>& inputs);

/** Lists the files of one option. */
std::vector<OutputFile> outputFiles(const std::string& option, const std::vector<std::string>& names);
std::vector<InputFile> inputFiles(const std::string& what, const std::vector<std::string>& names);

} // namespace recurse::apps
