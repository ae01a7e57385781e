/** @file
 * Comparison of a command's files with each other.
 */
#include "apps/run/outputFiles.h"

#include "apps/options/optionText.h"
#include "recurse/core/io/files.h"

namespace recurse::apps {

void requireDistinctFiles(const std::vector<OutputFile>& outputs, const std::vector<InputFile>& inputs) {
  for (size_t i = 0; i < outputs.size(); ++i) {
    const OutputFile& output = outputs[i];
    if (output.name.empty()) continue;
    for (size_t j = 0; j < i; ++j) {
      if (outputs[j].name.empty() || !isSameFile(output.name, outputs[j].name)) continue;
      if (output.option == outputs[j].option && output.name == outputs[j].name)
        badUsage(output.option + ": " + output.name + " is given twice; each output needs a file of its own");
      badUsage(output.option + " " + output.name + " and " + outputs[j].option + " " + outputs[j].name +
               " are the same file; each output needs a file of its own");
    }
    for (const InputFile& input : inputs)
      if (!input.name.empty() && isSameFile(output.name, input.name))
        badUsage(output.option + ": " + output.name + " is " + input.what + " and cannot be overwritten" +
                 (input.name == output.name ? "" : ": it is the same file as " + input.name));
  }
}

void requireOutsideOf(const std::string& folder, const std::vector<OutputFile>& outputs,
                      const std::vector<InputFile>& inputs) {
  const auto require = [&](const std::string& what, const std::string& name) {
    if (!name.empty() && isInside(name, folder))
      badUsage(what + " " + name + " is in the folder " + folder + ", whose files are overwritten");
  };
  for (const OutputFile& output : outputs) require(output.option, output.name);
  for (const InputFile& input : inputs) require(input.what, input.name);
}

std::vector<OutputFile> outputFiles(const std::string& option, const std::vector<std::string>& names) {
  std::vector<OutputFile> out;
  for (const std::string& name : names) out.push_back({option, name});
  return out;
}

std::vector<InputFile> inputFiles(const std::string& what, const std::vector<std::string>& names) {
  std::vector<InputFile> out;
  for (const std::string& name : names) out.push_back({what, name});
  return out;
}

} // namespace recurse::apps
