/** @file
 * `recurse classes`: explanation of path expressions.
 */
#include <optional>

#include "apps/commands/commands.h"
#include "apps/options/optionText.h"
#include "recurse/pathclasses/classesReport.h"

namespace recurse::apps {

namespace {

struct ClassesOptions {
  std::vector<std::string> expressions;
  std::optional<std::string> events, examples;
};

/** Parses NAME=EXPRESSION, or an expression that is its own name. */
PathClass classOf(const std::string& text) {
  const size_t equals = text.find('=');
  if (equals == std::string::npos) return {text, text};
  if (equals == 0 || equals + 1 == text.size())
    throw Error("'" + text + "' is not NAME=EXPRESSION", ExitStatus::BAD_USAGE);
  return {text.substr(0, equals), text.substr(equals + 1)};
}

ExitStatus reportClasses(const ClassesOptions& o) {
  const auto events = static_cast<size_t>(o.events ? parseCount("--events", *o.events, 0, 12) : 4);
  const auto examples = static_cast<size_t>(o.examples ? parseCount("--examples", *o.examples, 1, 1000) : 4);
  std::vector<PathClass> classes;
  for (const std::string& text : o.expressions) classes.push_back(classOf(text));
  if (classes.empty())
    print(namedClassesText());
  else
    print(analyseClasses(classes, events, examples).text());
  return ExitStatus::DONE;
}

} // namespace

void addClassesCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<ClassesOptions>();
  CLI::App* command = app.add_subcommand("classes", "Explain classes of light paths, and compare them");
  command
      ->add_option("expressions", options->expressions,
                   "Path expressions, or NAME=EXPRESSION; none: list the classes that have names")
      ->type_name("EXPR...");
  command
      ->add_option("--events", options->events,
                   "Maximum length of example paths, in scattering events (default: 4)")
      ->type_name("N");
  command->add_option("--examples", options->examples, "Number of examples for each length (default: 4)")
      ->type_name("N");
  command->footer(
      "A path is a word: L the light source, D a diffuse or glossy event, S a mirror or smooth refraction,\n"
      "V an event in a medium, E the camera (eye). Expressions are regular expressions over these letters,\n"
      "with the class names, '.', '[..]', '|', '*', '+', '?', '{2,3}', '!', '&' and '-'. A name after a\n"
      "letter restricts it to lights or surfaces of that name in the scene: L'lamp'SD'floor'E.\n\n"
      "Examples:\n"
      "  recurse classes\n"
      "  recurse classes 'LS+DE'\n"
      "  recurse classes direct caustic 'rest=all - direct - caustic'");
  command->callback([options, &chosen] { chosen = [options] { return reportClasses(*options); }; });
}

} // namespace recurse::apps
