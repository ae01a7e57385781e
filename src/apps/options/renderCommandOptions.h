/** @file
 * The options of `recurse render`.
 */
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/options/developOptions.h"
#include "apps/options/renderOptions.h"
#include "apps/run/outputFiles.h"
#include "apps/view/filmViewers.h"
#include "recurse/render/featureLayers.h"

namespace recurse::apps {

/** Of `recurse render`. */
struct RenderCommandOptions {
  RenderOptions render;
  std::vector<std::string> outputs;
  DevelopOptions develop;
  std::optional<std::string> sampleRange, checkpointInterval;
  std::string paths, checkpoint, layers;
  std::vector<std::string> classes; ///< NAME=EXPRESSION
  ViewerOptions viewers;
  bool resume = false, throughSpecular = false;
  ExtraLayers extra;
  bool check = false, watch = false, sendScene = false;
  std::string frames;
  AnimationFrame* frame = nullptr; ///< of an animation
  int reduction = 1;               ///< what width and height of the picture are divided by

  void addTo(CLI::App& command);
  /** What --checkpoint and its relatives say. */
  RenderPlan plan() const;
  /** What --paths or --class ask for. */
  PathClasses pathClasses() const;
  /** The two of them, as on a command line. */
  std::string pathsText() const;
  /** Checks before the render that all that is to be written can be, each to a file of its own. */
  void checkOutputs(const std::vector<std::string>& outputs) const;
  /** Nothing that is written may take the place of a file of the scene. */
  void keepInputs(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs) const;
  /** Checks --layers before the render. `layered`: the scene's film asks for layers. */
  FeatureSettings features(const std::vector<std::string>& outputs, bool layered) const;
  /** What is left of them for a process that does not lead. */
  RenderCommandOptions withoutOutputs() const;

 private:
  std::vector<OutputFile> written(const std::vector<std::string>& outputs) const;
};

} // namespace recurse::apps
