/** @file
 * `recurse explain`: which estimator of an integrator takes which light paths into account.
 */
#include "apps/commands/commands.h"
#include "apps/load/loadedScene.h"
#include "apps/options/integratorOptions.h"
#include "recurse/render/render.h"
#include "recurse/scene/directives/loader.h"
#include "recurse/transport/integrator/estimatorDomains.h"

namespace recurse::apps {

namespace {

struct ExplainOptions {
  std::string scene;
  IntegratorOptions integrator;
};

/** Shoots the first pass, in which the integrator of the scene chooses, and returns its notes. */
std::string chosenFor(const LoadedScene& loaded) {
  RenderSettings settings;
  settings.samplesPerPixel = loaded.scene->sampler().pixelSamples;
  settings.seed = loaded.scene->sampler().seed;
  std::string text;
  for (const std::string& note :
       shootFirstPass(*loaded.scene, *loaded.integrator, PathClasses(), settings).notes)
    text += note + "\n";
  return text;
}

ExitStatus explain(const ExplainOptions& o) {
  Diagnostics diagnostics;
  ParsedDirective fromFile;
  if (!o.scene.empty()) fromFile = loadScene(o.scene, diagnostics).integrator;
  const ParsedDirective directive = o.integrator.directive(fromFile);
  LoadedScene loaded; // outlives its integrator
  std::unique_ptr<Integrator> integrator = makeIntegrator(directive, false, diagnostics);
  diagnostics.throwIfErrors();
  std::string text = directive.type;
  for (const std::string& setting : settingsOf(directive)) text += "\n  " + setting;
  text += "\n\n";
  if (const std::string choices = integrator->choices(); !choices.empty()) {
    text += "By the scene it chooses " + choices + ".\n";
    if (o.scene.empty()) {
      text += "Without a scene this is what it begins with:\n\n";
    } else {
      loaded = loadAndBuild(o.scene, {}, o.integrator);
      text += chosenFor(loaded) + "\n";
      integrator = std::move(loaded.integrator);
    }
  }
  const std::vector<EstimatorDomain> domains = integrator->domains();
  text += formatDomains(domains);
  const std::string claims = integrator->claims();
  const DomainReport atSurfaces = checkDomains(domains, claims.empty() ? "surface" : claims),
                     everywhere = checkDomains(domains);
  text += "\n";
  if (everywhere.sound())
    text += "Every path is estimated once.\n";
  else if (atSurfaces.sound() && !claims.empty())
    text += "The paths " + claims + " are estimated once; the method leaves out all others.\n";
  else if (atSurfaces.sound() && everywhere.overlaps.empty())
    text += "Every path is estimated once, except those that a medium scatters: they are not estimated.\n";
  else
    text += atSurfaces.text();
  if (!text.ends_with('\n')) text += "\n";
  if (const std::string supposed = integrator->suppositions(); !supposed.empty())
    text += "It supposes " + supposed + ".\n";
  if (const std::string missed = missedOfDeltaLights(domains); !missed.empty())
    text += "Of point, spot and distant lights no estimator finds " + missed +
            ", but for what goes straight through thin panes.\n";
  print(text);
  return atSurfaces.sound() ? ExitStatus::DONE : ExitStatus::FAILED;
}

} // namespace

void addExplainCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<ExplainOptions>();
  CLI::App* command =
      app.add_subcommand("explain", "Tell which estimator takes which light paths into account");
  command
      ->add_option("scene", options->scene,
                   "Scene file whose integrator is meant (default: the one by option)")
      ->type_name("SCENE");
  options->integrator.addTo(*command);
  command->footer(
      "Prints each estimator of the integrator with its path expression, and whether together they take\n"
      "every path into account exactly once. Of a scene that is rendered by \"auto\" it prints what the "
      "trial\n"
      "chooses, for which the scene is built and a few blocks of it are rendered.\n\n"
      "Examples:\n"
      "  recurse explain scene.pbrt\n"
      "  recurse explain --integrator photonmap\n"
      "  recurse explain --integrator photonmap --direct photons");
  command->callback([options, &chosen] { chosen = [options] { return explain(*options); }; });
}

} // namespace recurse::apps
