/** @file
 * Kinds of `recurse figure`.
 */
#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "apps/options/renderOptions.h"
#include "recurse/report/figures/figureDrawing.h"
#include "recurse/report/figures/figures.h"

namespace recurse::apps {

/** Options of the command as they were given. */
struct FigureOptions {
  RenderOptions render;
  std::string kind, output;
  std::optional<std::string> edges, maps, offsets, stages;
  std::vector<std::string> pixels;

  /** Options that only some kinds have: their names, and whether they are given. */
  std::vector<std::pair<std::string, bool>> own() const {
    return {{"--edges", edges.has_value()},
            {"--maps", maps.has_value()},
            {"--offsets", offsets.has_value()},
            {"--stages", stages.has_value()},
            {"--pixel", !pixels.empty()}};
  }
};

/** Inputs of a figure. */
struct FigureRun {
  const FigureOptions& options;
  const LoadedScene& loaded;
  RenderSettings settings;
  std::string scene; ///< file name without its folder
  const std::atomic<bool>& stop;

  /** Line below the title. */
  std::string subtitle(int64_t samples) const {
    return scene + ", " + std::to_string(samples) + " samples per pixel";
  }
  std::string subtitle() const { return subtitle(settings.samplesPerPixel); }
  /** Makes an integrator, with those parameters of the scene and of the options that it takes. Throws Error
   * if it cannot render the scene. */
  std::unique_ptr<Integrator> integrator(const std::string& type) const { return made(directive(type)); }
  /** Makes an integrator from its directive. Throws Error if it cannot render the scene. */
  std::unique_ptr<Integrator> made(const ParsedDirective& directive) const;
  /** Directive of an integrator, with those parameters of the scene and of the options that it takes. */
  ParsedDirective directive(const std::string& type) const;
  /** Throws Error where the memory is too small for a figure with this number of panels on a sheet of `cells`
   * places, with `layers` layers of a film. */
  void requireMemoryFor(int panels, int cells, int layers = 1) const;
};

/** Kind of figure. */
struct FigureKind {
  /** Integrators of a kind. */
  enum class Method {
    ANY, ///< the scene's or the one of --integrator
    OWN, ///< certain integrators, with the parameters of the options
    NONE ///< none, and no parameters
  };
  const char* name;
  const char* description; ///< for --help
  Method method;
  std::vector<std::string> options; ///< out of FigureOptions::own()
  /** Throws Error (BAD_USAGE) for wrong values of its options, before the scene is loaded; null: no check. */
  void (*check)(const FigureOptions&);
  FigureDrawing (*draw)(const FigureRun&);
};

const std::vector<FigureKind>& figureKinds();

/** Kind by its name, which must exist. */
const FigureKind& figureKind(const std::string& name);

} // namespace recurse::apps
