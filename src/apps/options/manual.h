/** @file
 * The command line as other programs read it: pages for man, completions for shells.
 */
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace recurse::apps {

/** A page for man(1), of the program or of one subcommand. */
std::string manualPage(const CLI::App& app, const std::string& version);
/** Shell code that completes subcommands, options and their fixed values: "bash", "zsh" or "fish". */
std::string completion(const CLI::App& app, const std::string& shell);

} // namespace recurse::apps
