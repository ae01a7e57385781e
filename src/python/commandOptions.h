/** @file
 * Options of commands, parsed as on the command line.
 */
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "apps/options/optionText.h"

namespace recurse::python {

/** Options set by the words of a command line. Throws like the command itself. */
template <class Options> Options commandOptions(const std::vector<std::string>& words) {
  Options out;
  CLI::App command;
  out.addTo(command);
  try {
    command.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::ParseError& error) {
    apps::badUsage(error.what());
  }
  return out;
}

} // namespace recurse::python
