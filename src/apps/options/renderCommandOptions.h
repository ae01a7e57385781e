/** @file
 * The options of `recurse render`.
 */
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/animation/animationFiles.h"
#include "apps/options/developOptions.h"
#include "apps/options/renderOptions.h"
#include "apps/run/outputFiles.h"
#include "apps/view/filmViewers.h"
#include "recurse/render/featureLayers.h"

namespace recurse::apps {

/** Options of `recurse render` as given. */
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
  std::string frames, timeOfFlight;
  std::string frameRate = "24";
  AnimationFrame* frame = nullptr;      ///< current frame of an animation
  AnimationFiles* animations = nullptr; ///< written after the last frame
  int reduction = 1;                    ///< divisor of the picture's width and height

  void addTo(CLI::App& command);
  /** Plan of the render, with --checkpoint and its related options. */
  RenderPlan plan() const;
  /** Path classes of --paths or --class. Throws Error where they do not compile in any scene. */
  std::vector<PathClass> pathClasses() const;
  /** The same, compiled for a scene and its integrator, and the frames of --time-of-flight. */
  PathClasses pathClasses(const LoadedScene& loaded) const;
  /** Text of --paths, --class and --time-of-flight, as on a command line. */
  std::string pathsText() const;
  /** Throws Error if the integrator of the scene does not render what the options ask for. */
  void checkIntegrator(const LoadedScene& loaded) const;
  /** Whether an output holds many pictures. */
  bool isAnimation(const std::string& output) const;
  /** Checks before the render that all outputs can be written, each to a file of its own. */
  void checkOutputs(const std::vector<std::string>& outputs) const;
  /** Throws Error (BAD_USAGE) if an output would replace a file of the scene. */
  void keepInputs(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs) const;
  /** Checks --layers before the render. `layered`: the scene's film asks for layers. */
  FeatureSettings features(const std::vector<std::string>& outputs, bool layered) const;
  /** Options for a process that does not lead, which writes no files. */
  RenderCommandOptions withoutOutputs() const;

 private:
  std::vector<OutputFile> written(const std::vector<std::string>& outputs) const;
};

} // namespace recurse::apps
