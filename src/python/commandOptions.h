/** @file
 * Options of commands as the command line takes them.
 */
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "apps/options/optionText.h"

namespace recurse::python {

/** The options that words of a command line set. Throws as the command does. */
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
