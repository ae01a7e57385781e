/** @file
 * The options that stand in the place of the scene file's Integrator directive or of its parameters.
 */
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "recurse/scene/directives/sceneDescription.h"
#include "recurse/scene/parameters/parsedDirective.h"
#include "recurse/transport/integrator/integrator.h"

namespace recurse::apps {

/** The integrator where neither the scene nor the command line names one. */
constexpr const char* DEFAULT_INTEGRATOR = "auto";

class IntegratorOptions {
 public:
  /** What was given before counts on where it is not given again. */
  void addTo(CLI::App& command);
  /** As if the option stood on the command line; call after addTo(). */
  void set(const std::string& option, const std::string& text);
  void setIntegrator(const std::string& integrator) { name = integrator; }

  /** The file's directive with what the options say. Throws Error (BAD_USAGE) for an unknown integrator and
   * for options that it does not take. */
  ParsedDirective directive(const ParsedDirective& fromFile) const;
  /** The options as they were given, for the picture's metadata. */
  std::string text() const;
  bool named() const { return !name.empty(); }
  const std::string& integratorName() const { return name; }

 private:
  struct Value {
    const char* option;
    const char* parameter;
    std::optional<std::string> text; ///< empty: not given
  };
  /** What every value of the command line is, by the integrator's own declaration. */
  void replace(ParsedDirective& directive, const std::vector<ParameterSpec>& specs, const std::string& option,
               const std::string& parameter, const std::string& text) const;

  std::string name;
  std::vector<Value> values;
  std::vector<std::string> earlier, settings; ///< of --set: NAME=VALUE
};

/** Makes it; what is wrong goes to `diagnostics`, and the result is null then. */
std::unique_ptr<Integrator> makeIntegrator(const ParsedDirective& directive, bool lenient,
                                           Diagnostics& diagnostics);

/** The parameters of an integrator with the values that they have, `name value`, a line each. */
std::vector<std::string> settingsOf(const ParsedDirective& directive);

} // namespace recurse::apps
