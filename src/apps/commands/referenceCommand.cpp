/** @file
 * `recurse reference`: every directive, plug-in and parameter, from the registries themselves.
 */
#include <algorithm>

#include "apps/commands/commands.h"
#include "apps/help/referenceSearch.h"
#include "apps/help/registries.h"
#include "apps/options/optionText.h"
#include "apps/options/suggestions.h"
#include "recurse/core/io/text.h"
#include "recurse/scene/directives/directiveInfo.h"
#include "recurse/scene/directives/reference.h"

namespace recurse::apps {

namespace {

struct ReferenceOptions {
  std::vector<std::string> names;
  bool markdown = false;
};

std::string markdownPage() {
  std::string out =
      "# Scene files: directives, plug-ins and parameters\n\n"
      "Made by `recurse reference --markdown` from the program's own tables. Tone operators, at the end,\n"
      "are for the option `--tonemap`.\n\n";
  out += directiveReference();
  forEachRegistry([&out](const auto& registry) { out += "\n" + registryReference(registry); });
  return out;
}

std::string padded(const std::string& text, size_t width) {
  return text.size() < width ? text + std::string(width - text.size(), ' ') : text;
}

std::string plainPlugIn(const std::string& kind, const PlugInInfo& plugIn) {
  std::string out = kind + " \"" + plugIn.name + "\"\n  " + plugIn.summary + "\n";
  size_t width = 0;
  for (const ParameterSpec& spec : plugIn.parameters) width = std::max(width, declarationText(spec).size());
  for (const ParameterSpec& spec : plugIn.parameters) {
    out += "  " + padded(declarationText(spec), width + 2) + spec.description;
    std::string more;
    const auto add = [&more](const std::string& text) { more += (more.empty() ? "" : "; ") + text; };
    if (spec.ignored) add("no effect");
    if (const std::string range = rangeText(spec); !range.empty()) add(range);
    if (!spec.defaultText.empty()) add("default " + spec.defaultText);
    if (spec.required) add("required");
    if (!more.empty()) out += " (" + more + ")";
    out += "\n";
  }
  return out + "\n";
}

/** Names of directives, kinds of plug-ins and plug-ins, each with its summary. */
std::vector<Described> knownNames() {
  std::vector<Described> known;
  for (const DirectiveInfo& d : directiveInfos()) known.emplace_back(d.name, d.summary);
  forEachRegistry([&](const auto& registry) {
    known.emplace_back(registry.kind(), "");
    for (const auto& plugIn : registry.entries()) known.emplace_back(plugIn.name, plugIn.summary);
  });
  return known;
}

/** The directives, kinds of plug-ins and plug-ins for which wanted(name) holds. */
template <class Wanted> std::string plainPage(const Wanted& wanted) {
  std::string out;
  for (const DirectiveInfo& d : directiveInfos())
    if (wanted(d.name)) out += padded(d.name + " " + d.arguments, 50) + " " + d.summary + "\n";
  if (!out.empty()) out += "\n";
  forEachRegistry([&](const auto& registry) {
    for (const auto& plugIn : registry.entries())
      if (wanted(plugIn.name) || wanted(registry.kind())) out += plainPlugIn(registry.kind(), plugIn);
  });
  return out;
}

/** Directives and plug-ins with one of the names in full, then search results for the words that are no
 * names. */
std::string answers(const std::vector<std::string>& words) {
  const std::vector<Described> known = knownNames();
  std::vector<std::string> names;
  std::string found;
  for (const std::string& word : words) {
    const std::string lower = lowerCase(word);
    if (std::any_of(known.begin(), known.end(),
                    [&](const Described& one) { return lowerCase(one.first) == lower; })) {
      names.push_back(lower);
      continue;
    }
    const std::string matches = searchReference(word);
    if (matches.empty())
      badUsage("no directive, plug-in or text of the reference contains '" + word + "'" +
               suggestion(word, known));
    found += (found.empty() ? "" : "\n") + matches;
  }
  const auto isNamed = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), lowerCase(name)) != names.end();
  };
  return plainPage(isNamed) + found;
}

} // namespace

void addReferenceCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<ReferenceOptions>();
  CLI::App* command = app.add_subcommand(
      "reference", "Print the directives, plug-ins and parameters of scene files, and tone operators");
  CLI::Option* names =
      command
          ->add_option("names", options->names,
                       "Names of directives or plug-ins, or a word to search for in all texts (default: all)")
          ->type_name("NAME...");
  command->add_flag("--markdown", options->markdown, "Print the whole reference as Markdown")
      ->excludes(names);
  command->footer(
      "Examples:\n"
      "  recurse reference\n"
      "  recurse reference photonmap dielectric     two plug-ins with all parameters\n"
      "  recurse reference LightSource              all lights\n"
      "  recurse reference fog                      plug-ins for a word, and all texts that contain it\n"
      "  recurse reference --markdown > reference.md");
  command->callback([options, &chosen] {
    chosen = [options] {
      print(options->markdown        ? markdownPage()
            : options->names.empty() ? plainPage([](const std::string&) { return true; })
                                     : answers(options->names));
      return ExitStatus::DONE;
    };
  });
}

} // namespace recurse::apps
