/** @file
 * Options that may be repeated.
 */
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace recurse::apps {

/** Adds an option that takes one value each time it is given; `values` receives all of them, in order. What
 * follows a value belongs to the command. */
inline CLI::Option* addRepeatedOption(CLI::App& command, const std::string& name,
                                      std::vector<std::string>& values, const std::string& description) {
  return command.add_option(name, values, description)->expected(1)->allow_extra_args(false)->take_all();
}

} // namespace recurse::apps
