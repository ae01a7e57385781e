/** @file
 * `recurse reference`: every directive, plug-in and parameter, from the registries themselves.
 */
#include <algorithm>

#include "apps/commands/commands.h"
#include "apps/options/optionText.h"
#include "apps/options/suggestions.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/scene/directives/directiveInfo.h"
#include "recurse/scene/directives/reference.h"
#include "recurse/transport/integrator/integrator.h"

namespace recurse::apps {

namespace {

struct ReferenceOptions {
  std::vector<std::string> names;
  bool markdown = false;
};

/** Calls visit(registry) for every registry, in the order of the page. */
template <class Visitor> void forEachRegistry(const Visitor& visit) {
  const PlugIns& all = plugIns();
  visit(all.films);
  visit(all.cameras);
  visit(all.filters);
  visit(all.samplers);
  visit(all.integrators);
  visit(all.accelerators);
  visit(all.shapes);
  visit(all.imports);
  visit(all.materials);
  visit(all.textures);
  visit(all.lights);
  visit(all.areaLights);
  visit(all.media);
  visit(all.phaseFunctions);
  visit(all.toneMaps);
}

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

/** Everything, or what bears one of the names: of a directive, a kind of plug-in or a plug-in. */
std::string plainPage(const std::vector<std::string>& names) {
  const auto wanted = [&names](const std::string& name) {
    return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
  };
  std::string out;
  for (const DirectiveInfo& d : directiveInfos())
    if (wanted(d.name)) out += padded(d.name + " " + d.arguments, 50) + " " + d.summary + "\n";
  if (!out.empty()) out += "\n";
  std::vector<Described> known;
  for (const DirectiveInfo& d : directiveInfos()) known.emplace_back(d.name, d.summary);
  forEachRegistry([&](const auto& registry) {
    known.emplace_back(registry.kind(), "");
    for (const auto& plugIn : registry.entries()) {
      known.emplace_back(plugIn.name, plugIn.summary);
      if (wanted(plugIn.name) || wanted(registry.kind())) out += plainPlugIn(registry.kind(), plugIn);
    }
  });
  for (const std::string& name : names)
    if (std::none_of(known.begin(), known.end(), [&](const Described& one) { return one.first == name; }))
      badUsage("no directive or plug-in '" + name + "'" + suggestion(name, known));
  return out;
}

} // namespace

void addReferenceCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<ReferenceOptions>();
  CLI::App* command = app.add_subcommand(
      "reference", "Print every directive, plug-in and parameter of scene files, and tone operators");
  CLI::Option* names =
      command->add_option("names", options->names, "Only these directives or plug-ins (default: all)")
          ->type_name("NAME...");
  command->add_flag("--markdown", options->markdown, "The whole page as Markdown")->excludes(names);
  command->footer("Examples:\n"
                  "  recurse reference\n"
                  "  recurse reference photonmap dielectric\n"
                  "  recurse reference LightSource\n"
                  "  recurse reference --markdown > reference.md");
  command->callback([options, &chosen] {
    chosen = [options] {
      print(options->markdown ? markdownPage() : plainPage(options->names));
      return ExitStatus::DONE;
    };
  });
}

} // namespace recurse::apps
