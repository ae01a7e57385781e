/** @file
 * Conversion of options to parameters, by the integrator's own declaration, so that a new integrator needs no
 * change here.
 */
#include "apps/options/integratorOptions.h"

#include <algorithm>

#include "apps/options/optionText.h"
#include "recurse/core/io/error.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/scene/parameters/otherNames.h"

namespace recurse::apps {

namespace {

std::string joined(const std::vector<std::string>& words, const std::string& separator = " ") {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : separator) + word;
  return out;
}

const ParameterSpec* findSpec(const std::vector<ParameterSpec>& specs, const std::string& name) {
  for (const ParameterSpec& spec : specs)
    if (spec.name == name) return &spec;
  return nullptr;
}

ParsedParameter valueOf(const ParameterSpec& spec, const std::string& option, const std::string& text) {
  ParsedParameter p;
  p.name = spec.name;
  switch (spec.type) {
  case ParameterType::INTEGER:
    p.type = "integer";
    p.numbers = {double(parseCount(option, text, -2147483648ll, 2147483647))};
    break;
  case ParameterType::REAL:
    p.type = "float";
    p.numbers = {parseReal(option, text)};
    break;
  case ParameterType::BOOLEAN:
    p.type = "bool";
    if (text != "true" && text != "false") badUsage(option + ": '" + text + "' is not true or false");
    p.booleans = {text == "true"};
    break;
  case ParameterType::STRING:
    p.type = "string";
    p.strings = {text};
    break;
  default:
    badUsage(option + ": " + spec.name + " can only be set in the scene file");
  }
  return p;
}

std::string valueText(const ParsedParameter& p) {
  std::vector<std::string> words = p.strings;
  for (double number : p.numbers) words.push_back(formatted("%.9g", number));
  for (bool b : p.booleans) words.emplace_back(b ? "true" : "false");
  return joined(words);
}

} // namespace

void IntegratorOptions::addTo(CLI::App& command) {
  command
      .add_option("--integrator", name,
                  std::string("Integrator instead of the scene's (default if the scene has none: ") +
                      DEFAULT_INTEGRATOR + ")")
      ->type_name("NAME");
  const std::vector<Value> before = std::move(values);
  values = {{"--photons", "photons", {}},         {"--gather-photons", "gatherphotons", {}},
            {"--radius", "radius", {}},           {"--maxdepth", "maxdepth", {}},
            {"--direct", "direct", {}},           {"--light-samples", "lightsamples", {}},
            {"--photon-index", "photonindex", {}}};
  for (size_t i = 0; i < before.size(); ++i) values[i].text = before[i].text;
  earlier.insert(earlier.end(), settings.begin(), settings.end());
  settings.clear();
  const std::vector<std::pair<const char*, const char*>> descriptions = {
      {"N", "Number of photons emitted in each pass; also as 1M or 1e6"},
      {"K", "Number of nearest photons of a density estimate, if the radius is not given"},
      {"R", "Radius of the density estimates [scene units] (default: chosen from the density of photons)"},
      {"N", "Maximum number of scattering events of a path; -1: no limit"},
      {"WAY", "Estimator of direct light: shadowrays, or photons as for all other light"},
      {"N", "Number of shadow rays at each diffuse surface"},
      {"INDEX", "Search structure of the photons: kdtree or flann"}};
  const auto* entry = plugIns().integrators.find(DEFAULT_INTEGRATOR);
  for (size_t i = 0; i < values.size(); ++i) {
    std::string description = descriptions[i].second;
    const ParameterSpec* spec = entry ? findSpec(entry->parameters, values[i].parameter) : nullptr;
    if (spec && !spec->defaultText.empty()) description += " (default: " + spec->defaultText + ")";
    command.add_option(values[i].option, values[i].text, description)->type_name(descriptions[i].first);
  }
  addRepeatedOption(command, "--set", settings,
                    "Any other parameter of the integrator, see 'recurse reference'; may be repeated")
      ->type_name("NAME=VALUE");
}

void IntegratorOptions::set(const std::string& option, const std::string& text) {
  for (Value& value : values)
    if (value.option == option) value.text = text;
}

void IntegratorOptions::replace(ParsedDirective& directive, const std::vector<ParameterSpec>& specs,
                                const std::string& option, const std::string& parameter,
                                const std::string& text) const {
  const ParameterSpec* spec = findSpec(specs, parameter);
  if (!spec || spec->ignored) {
    std::vector<std::string> taken;
    for (const ParameterSpec& s : specs)
      if (!s.ignored) taken.push_back(s.name);
    badUsage(option + ": the integrator '" + directive.type + "' has no parameter '" + parameter +
             "'; it takes: " + (taken.empty() ? "none" : joined(taken)));
  }
  ParsedDirective alone = directive;
  alone.parameters = {valueOf(*spec, option, text)};
  Diagnostics diagnostics;
  bindParameters(alone, {*spec}, diagnostics, false);
  for (const Diagnostic& d : diagnostics.all())
    badUsage(option + ": " + d.message + (d.accepted.empty() ? "" : "; accepted: " + d.accepted));
  std::erase_if(directive.parameters, [&](const ParsedParameter& p) { return p.name == parameter; });
  directive.parameters.push_back(alone.parameters.front());
}

ParsedDirective IntegratorOptions::directive(const ParsedDirective& fromFile) const {
  const auto& registry = plugIns().integrators;
  ParsedDirective out = fromFile;
  if (named() || !fromFile.given()) out.type = named() ? name : DEFAULT_INTEGRATOR;
  const auto* entry = registry.find(out.type);
  if (!entry) {
    // An unknown name in the file is reported with its location when the integrator is made.
    if (!named()) return out;
    const std::vector<std::string> nearest = likelyNames("Integrator", name, registry.names());
    badUsage("--integrator: there is no integrator '" + name + "'" +
             (nearest.empty() ? "" : "; did you mean " + joined(nearest, " or ") + "?") +
             "; there are: " + joined(registry.names()));
  }
  if (named() && name != fromFile.type) {
    out.location = {}; // the file does not name it
    // A radius in the file suits the file's method; a different integrator finds its own.
    std::erase_if(out.parameters, [&](const ParsedParameter& p) {
      return p.name == "radius" || !findSpec(entry->parameters, p.name);
    });
  }
  for (const Value& value : values)
    if (value.text) replace(out, entry->parameters, value.option, value.parameter, *value.text);
  // --photons is a number per pass: it sets "passes" to 0, unless "passes" is given.
  const auto names = [&](const char* parameter) {
    return std::any_of(out.parameters.begin(), out.parameters.end(),
                       [&](const ParsedParameter& p) { return p.name == parameter; });
  };
  const auto photons = std::find_if(values.begin(), values.end(), [](const Value& value) {
    return value.parameter == std::string("photons");
  });
  if (photons != values.end() && photons->text && findSpec(entry->parameters, "passes") && !names("passes"))
    replace(out, entry->parameters, photons->option, "passes", "0");
  std::vector<std::string> all = earlier;
  all.insert(all.end(), settings.begin(), settings.end());
  for (const std::string& setting : all) {
    const size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0) badUsage("--set: '" + setting + "' is not NAME=VALUE");
    replace(out, entry->parameters, "--set", setting.substr(0, equals), setting.substr(equals + 1));
  }
  return out;
}

std::string IntegratorOptions::text() const {
  std::string out;
  for (const Value& value : values)
    if (value.text) out += std::string(" ") + value.option + " " + shellQuoted(*value.text);
  for (const std::vector<std::string>& list : {earlier, settings})
    for (const std::string& setting : list) out += " --set " + shellQuoted(setting);
  return out;
}

std::unique_ptr<Integrator> makeIntegrator(const ParsedDirective& directive, bool lenient,
                                           Diagnostics& diagnostics) {
  return plugIns().integrators.make(directive, NoContext{}, diagnostics, lenient);
}

std::vector<std::string> settingsOf(const ParsedDirective& directive) {
  std::vector<std::string> out;
  const auto* entry = plugIns().integrators.find(directive.type);
  if (!entry) return out;
  for (const ParameterSpec& spec : entry->parameters) {
    if (spec.ignored) continue;
    std::string text = spec.defaultText.empty() ? "chosen automatically" : spec.defaultText;
    for (const ParsedParameter& p : directive.parameters)
      if (p.name == spec.name) {
        text = valueText(p);
        break;
      }
    out.push_back(spec.name + " " + text);
  }
  return out;
}

std::string integratorText(const ParsedDirective& directive) {
  const auto* entry = plugIns().integrators.find(directive.type);
  if (!entry || entry->parameters.empty()) return directive.type;
  std::string given;
  for (const ParameterSpec& spec : entry->parameters)
    for (const ParsedParameter& p : directive.parameters)
      if (!spec.ignored && p.name == spec.name) given += spec.name + " " + valueText(p) + ", ";
  return directive.type + ": " + (given.empty() ? "default parameters" : given + "others default");
}

} // namespace recurse::apps
