/** @file
 * The program `recurse`: dispatch to the subcommand, and conversion of every error to a message and an exit
 * status.
 */
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <regex>
#include <vector>

#include <unistd.h>

#include "apps/commands/commands.h"
#include "apps/help/quickStart.h"
#include "apps/options/manual.h"
#include "apps/options/optionText.h"
#include "apps/options/suggestions.h"
#include "apps/program.h"
#include "apps/run/interrupt.h"
#include "apps/run/renderOutput.h"
#include "recurse/core/io/atomicFile.h"

namespace recurse::apps {

namespace {

ExitStatus sayError(const std::string& message, ExitStatus status) {
  say("recurse: " + message + (message.ends_with('\n') ? "" : "\n"));
  return status;
}

ExitStatus sayScene(const SceneError& error) {
  say(error.what());
  const auto isError = [](const Diagnostic& d) { return d.severity == Severity::ERROR; };
  const auto count = std::count_if(error.diagnostics().begin(), error.diagnostics().end(), isError);
  if (count > 0) say("refused: " + std::to_string(count) + (count == 1 ? " error\n" : " errors\n"));
  return error.status();
}

/** Handler of std::terminate, for example of an exception in a destructor. */
[[noreturn]] void lastWords() {
  removeTemporaryFiles();
  say("recurse: internal error; the program ends here\n");
  ::_exit(static_cast<int>(ExitStatus::FAILED));
}

/** Wraps lines at 100 columns; descriptions of options continue in their column. */
std::string wrapped(const std::string& help) {
  constexpr size_t WIDTH = 100, INDENT = 30; // INDENT: column of descriptions in CLI11
  std::string out;
  size_t begin = 0;
  while (begin < help.size()) {
    const size_t end = std::min(help.find('\n', begin), help.size());
    std::string line = help.substr(begin, end - begin);
    begin = end + 1;
    while (line.size() > WIDTH) {
      const size_t blank = line.rfind(' ', WIDTH);
      if (blank == std::string::npos || blank <= INDENT) break;
      out += line.substr(0, blank) + "\n";
      line = std::string(INDENT, ' ') + line.substr(blank + 1);
    }
    out += line + "\n";
  }
  return out;
}

/** Suggestion for the first word that the command does not know: an option, or before any subcommand the name
 * of one. */
std::string nearestTo(const CLI::App& command, const std::vector<std::string>& words) {
  const auto isIn = [](const std::vector<Described>& list, const std::string& word) {
    return std::any_of(list.begin(), list.end(), [&](const Described& one) { return one.first == word; });
  };
  std::vector<Described> options, commands;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames())
      options.emplace_back(name, option->get_description());
  for (const CLI::App* sub : command.get_subcommands([](const CLI::App*) { return true; }))
    commands.emplace_back(sub->get_name(), sub->get_description());
  for (const std::string& given : words) {
    const std::string word = given.substr(0, given.find('='));
    if (!word.starts_with("--")) {
      if (!commands.empty()) return suggestion(word, commands);
      continue;
    }
    const std::string name = word.substr(2);
    if (isIn(options, name)) continue;
    return suggestion(name, options, "--");
  }
  return {};
}

/** The message of CLI11, in plain words where an option is repeated that may be given once. */
std::string plainText(const CLI::ParseError& error) {
  static const std::regex REPEATED("(--?[^:]+): At Most 1 required but received (\\d+)");
  const std::string text = error.what();
  std::smatch found;
  if (!std::regex_match(text, found, REPEATED)) return text;
  return found[1].str() + ": given " + (found[2] == "2" ? "twice" : found[2].str() + " times") +
         "; accepted: once";
}

ExitStatus run(int argc, char** argv) {
  CLI::App app("Recurse: photon mapping and path tracing of scene files in the pbrt-v4 format.", "recurse");
  app.set_version_flag("--version", std::string("Recurse ") + VERSION);
  app.require_subcommand(0, 1);
  app.footer("Examples:\n"
             "  recurse render scene.pbrt -o picture.exr -o picture.png\n"
             "  recurse compare picture.exr reference.exr\n"
             "  recurse render --help\n\n"
             "Exit status: 0 done, 1 failed, 2 wrong usage, 3 wrong scene, 130 interrupted.");
  Command chosen;
  addRenderCommand(app, chosen);
  addSplitCommand(app, chosen);
  addMergeCommand(app, chosen);
  addDevelopCommand(app, chosen);
  addStillsCommand(app, chosen);
  addCompareCommand(app, chosen);
  addConvergeCommand(app, chosen);
  addMethodsCommand(app, chosen);
  addInspectCommand(app, chosen);
  addFigureCommand(app, chosen);
  addInfoCommand(app, chosen);
  addClassesCommand(app, chosen);
  addExplainCommand(app, chosen);
  addConvertCommand(app, chosen);
  addReferenceCommand(app, chosen);
  if (argc <= 1) {
    print(quickStart());
    return ExitStatus::DONE;
  }
  std::string manual, shell;
  app.add_option("--manual", manual, "Print a manual page: 'recurse', or the name of a subcommand")
      ->type_name("COMMAND");
  app.add_option("--completion", shell, "Print shell completions for bash, zsh or fish")->type_name("SHELL");
  try {
    app.parse(argc, argv);
    if (!manual.empty()) {
      const auto named = app.get_subcommands([&](const CLI::App* sub) { return sub->get_name() == manual; });
      if (named.empty() && manual != app.get_name())
        badUsage("--manual: there is no subcommand '" + manual + "'");
      print(manualPage(named.empty() ? app : *named.front(), VERSION));
    }
    if (!shell.empty()) print(completion(app, shell));
    if (!manual.empty() || !shell.empty()) return ExitStatus::DONE;
    if (!chosen) throw CLI::RequiredError("A subcommand");
  } catch (const CLI::CallForHelp&) {
    print(wrapped(app.help()));
    return ExitStatus::DONE;
  } catch (const CLI::CallForVersion& version) {
    print(std::string(version.what()) + "\n");
    return ExitStatus::DONE;
  } catch (const CLI::ParseError& error) {
    const CLI::App* at = &app;
    while (!at->get_subcommands().empty()) at = at->get_subcommands().front();
    const std::string name = at == &app ? "recurse" : "recurse " + at->get_name();
    const std::string near = nearestTo(*at, std::vector<std::string>(argv + 1, argv + argc));
    return sayError(plainText(error) + near + "\nRun '" + name + " --help' for more.", ExitStatus::BAD_USAGE);
  }
  return chosen();
}

ExitStatus runCaught(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const SceneError& error) {
    return sayScene(error);
  } catch (const Error& error) {
    return sayError(error.what(), error.status());
  } catch (const std::bad_alloc&) {
    return sayError("out of memory: the scene, the picture or the number of photons is too large",
                    ExitStatus::FAILED);
  } catch (const std::exception& error) {
    return sayError(std::string("internal error: ") + error.what(), ExitStatus::FAILED);
  } catch (...) {
    return sayError("internal error", ExitStatus::FAILED);
  }
}

} // namespace

int program(int argc, char** argv) {
  std::set_terminate(lastWords);
  installInterruptHandlers();
  return static_cast<int>(runCaught(argc, argv));
}

} // namespace recurse::apps
