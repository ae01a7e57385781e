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
#include <filesystem>
#include <new>
#include <regex>
#include <span>
#include <string_view>
#include <vector>

#include <unistd.h>

#include "apps/commands/commands.h"
#include "apps/help/quickStart.h"
#include "apps/load/modelScene.h"
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

/** Names of the command's long options without hyphens, or of its subcommands, each with its description. */
std::vector<Described> describedOptions(const CLI::App& command) {
  std::vector<Described> out;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) out.emplace_back(name, option->get_description());
  return out;
}
std::vector<Described> describedSubcommands(const CLI::App& command) {
  std::vector<Described> out;
  for (const CLI::App* sub : command.get_subcommands([](const CLI::App*) { return true; }))
    out.emplace_back(sub->get_name(), sub->get_description());
  return out;
}

/** True for an existing file and for a name with an extension of scene files. */
bool looksLikeScene(const std::string& word) {
  std::error_code ignored;
  return isSceneFile(word) || isModelFile(word) || std::filesystem::is_regular_file(word, ignored);
}

/** Message about arguments that the command does not accept. `words`: in the order of the command line. */
std::string unexpectedText(const CLI::App& command, const std::vector<std::string>& words) {
  const auto isOption = [](const std::string& word) { return word.size() > 1 && word[0] == '-'; };
  const std::vector<Described> subcommands = describedSubcommands(command);
  const auto word = words.empty() || isOption(words.front())
                        ? std::find_if(words.begin(), words.end(), looksLikeScene)
                        : words.begin();
  if (!subcommands.empty() && word != words.end()) {
    if (looksLikeScene(*word))
      return "'" + *word + "' is not a subcommand. To render: recurse render " + shellQuoted(*word) + " -o " +
             shellQuoted(std::filesystem::path(*word).stem().stem().string() + ".png");
    return "unknown subcommand '" + *word + "'" + suggestion(*word, subcommands);
  }
  if (const auto option = std::find_if(words.begin(), words.end(), isOption); option != words.end()) {
    const std::string name = option->substr(0, option->find('='));
    return "unknown option " + name +
           (name.starts_with("--") ? suggestion(name.substr(2), describedOptions(command), "--") : "");
  }
  std::string list;
  for (const std::string& given : words) list += (list.empty() ? "" : " ") + shellQuoted(given);
  return (words.size() == 1 ? "unexpected argument: " : "unexpected arguments: ") + list;
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

/** Throws Error for "--option=", which would take the next argument as its value. */
void requireValues(std::span<char* const> arguments) {
  for (const std::string_view argument : arguments) {
    if (argument == "--") return;
    if (argument.starts_with("--") && argument.find('=') == argument.size() - 1)
      badUsage(std::string(argument.substr(0, argument.size() - 1)) + ": the value is empty");
  }
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
    requireValues({argv, size_t(argc)});
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
    const bool isUnexpected = dynamic_cast<const CLI::ExtrasError*>(&error);
    const std::string message = isUnexpected ? unexpectedText(*at, app.remaining(true)) : plainText(error);
    return sayError(message + "\nRun '" + name + " --help' for more.", ExitStatus::BAD_USAGE);
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
