/** @file
 * Subcommands of the program. Each function adds a command to the command line, whose parsing sets `chosen`.
 */
#pragma once

#include <functional>
#include <string>

#include <CLI/CLI.hpp>

#include "apps/run/console.h"
#include "recurse/core/io/error.h"

namespace recurse::apps {

using Command = std::function<ExitStatus()>;

void addRenderCommand(CLI::App& app, Command& chosen);
void addSplitCommand(CLI::App& app, Command& chosen);
void addMergeCommand(CLI::App& app, Command& chosen);
void addDevelopCommand(CLI::App& app, Command& chosen);
void addStillsCommand(CLI::App& app, Command& chosen);
void addCompareCommand(CLI::App& app, Command& chosen);
void addConvergeCommand(CLI::App& app, Command& chosen);
void addMethodsCommand(CLI::App& app, Command& chosen);
void addInspectCommand(CLI::App& app, Command& chosen);
void addFigureCommand(CLI::App& app, Command& chosen);
void addInfoCommand(CLI::App& app, Command& chosen);
void addClassesCommand(CLI::App& app, Command& chosen);
void addExplainCommand(CLI::App& app, Command& chosen);
void addConvertCommand(CLI::App& app, Command& chosen);
void addReferenceCommand(CLI::App& app, Command& chosen);

} // namespace recurse::apps
