/** @file
 * Options that replace the scene file's Integrator directive or its parameters.
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

/** Default integrator, if neither the scene nor the command line names one. */
constexpr const char* DEFAULT_INTEGRATOR = "auto";

class IntegratorOptions {
 public:
  /** Declares the options. Values set before are kept unless they are given again. */
  void addTo(CLI::App& command);
  /** Sets an option as on the command line; call after addTo(). */
  void set(const std::string& option, const std::string& text);
  void setIntegrator(const std::string& integrator) { name = integrator; }

  /** The file's directive, changed by the options. Throws Error (BAD_USAGE) for an unknown integrator and for
   * options that it does not take. */
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
  /** Replaces a parameter by the text of an option, checked by the integrator's declaration. */
  void replace(ParsedDirective& directive, const std::vector<ParameterSpec>& specs, const std::string& option,
               const std::string& parameter, const std::string& text) const;

  std::string name;
  std::vector<Value> values;
  std::vector<std::string> earlier, settings; ///< arguments of --set: NAME=VALUE
};

/** Makes the integrator. Null after an error, which goes to `diagnostics`. */
std::unique_ptr<Integrator> makeIntegrator(const ParsedDirective& directive, bool lenient,
                                           Diagnostics& diagnostics);

/** Parameters of an integrator with their values, as `name value`, a line each. */
std::vector<std::string> settingsOf(const ParsedDirective& directive);
/** Integrator for a message: `path: maxdepth 7, others default`, with the parameters that are given. */
std::string integratorText(const ParsedDirective& directive);

} // namespace recurse::apps
