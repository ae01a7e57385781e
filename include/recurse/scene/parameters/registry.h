/** @file
 * Registries: plug-ins of one kind by name, with their declarations.
 */
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "recurse/scene/parameters/parameters.h"

namespace recurse {

/** Description of a plug-in, for the reference page and for tests. */
struct PlugInInfo {
  std::string name;
  std::string summary; ///< one sentence
  std::vector<ParameterSpec> parameters;
  /** Parameters of typical uses in scene-file syntax; tests over the registry make one plug-in from each. */
  std::vector<std::string> examples;
};

/** Plug-in of interface I, made from parameters and a `Context` that is specific to the interface. */
template <class I, class Context> struct PlugIn : PlugInInfo {
  /** Maker. Throws SceneError, by Parameters::fail(), for values that cannot be used. */
  std::function<std::unique_ptr<I>(const Parameters&, const Context&)> make;
};

/** Plug-ins of interface I, in the order of their registration. */
template <class I, class Context> class Registry {
 public:
  using Entry = PlugIn<I, Context>;

  /** `kind` is the name of the directive, for messages: "Shape". */
  explicit Registry(std::string kind) : kindName(std::move(kind)) {}

  void add(Entry entry) { list.push_back(std::move(entry)); }
  /** Adds common parameters to every plug-in that is registered already, except those named in `except`.
   * `finish` reads these parameters after the construction of a plug-in. */
  void addToAll(const std::vector<ParameterSpec>& parameters,
                const std::function<void(I&, const Parameters&, const Context&)>& finish,
                const std::vector<std::string>& except = {}) {
    for (Entry& e : list) {
      if (std::find(except.begin(), except.end(), e.name) != except.end()) continue;
      e.parameters.insert(e.parameters.end(), parameters.begin(), parameters.end());
      e.make = [make = std::move(e.make), finish](const Parameters& p, const Context& c) {
        std::unique_ptr<I> made = make(p, c);
        if (made) finish(*made, p, c);
        return made;
      };
    }
  }
  const std::string& kind() const { return kindName; }
  const std::vector<Entry>& entries() const { return list; }
  std::vector<std::string> names() const {
    std::vector<std::string> out;
    for (const Entry& e : list) out.push_back(e.name);
    return out;
  }
  /** Plug-in of a name; null: there is none. */
  const Entry* find(const std::string& name) const {
    for (const Entry& e : list)
      if (e.name == name) return &e;
    return nullptr;
  }

  /**
   * Checks the parameters and makes the plug-in. Returns null for an unknown name, wrong parameters or a
   * SceneError of the maker, which the diagnostics describe after its warnings. Passes other exceptions of
   * the maker on. `lenient`: unknown parameters are warnings.
   */
  std::unique_ptr<I> make(const ParsedDirective& directive, const Context& context, Diagnostics& diagnostics,
                          bool lenient = false) const;

 private:
  std::string kindName;
  std::vector<Entry> list;
};

/** Message for a plug-in name that is not in `names`, with the nearest ones. */
std::string unknownPlugInText(const std::string& kind, const std::string& name,
                              const std::vector<std::string>& names);
/** Reports a plug-in name that is not in `names`, with the nearest ones. */
void reportUnknownPlugIn(const std::string& kind, const ParsedDirective& directive,
                         const std::vector<std::string>& names, Diagnostics& diagnostics);

template <class I, class Context>
std::unique_ptr<I> Registry<I, Context>::make(const ParsedDirective& directive, const Context& context,
                                              Diagnostics& diagnostics, bool lenient) const {
  const Entry* entry = find(directive.type);
  if (!entry) {
    reportUnknownPlugIn(kindName, directive, names(), diagnostics);
    return nullptr;
  }
  Diagnostics own;
  const Parameters parameters = bindParameters(directive, entry->parameters, own, lenient);
  for (const Diagnostic& d : own.all())
    d.severity == Severity::ERROR ? diagnostics.error(d.location, d.message, d.accepted)
                                  : diagnostics.warning(d.location, d.message, d.accepted);
  if (own.hasErrors()) return nullptr;
  const auto reportWarnings = [&] {
    for (const Diagnostic& d : parameters.warnings().all())
      diagnostics.warning(d.location, d.message, d.accepted);
  };
  try {
    std::unique_ptr<I> made = entry->make(parameters, context);
    reportWarnings();
    return made;
  } catch (const SceneError& e) {
    reportWarnings();
    for (const Diagnostic& d : e.diagnostics()) diagnostics.error(d.location, d.message, d.accepted);
    if (e.diagnostics().empty()) diagnostics.error(directive.location, e.what());
  }
  return nullptr;
}

} // namespace recurse
