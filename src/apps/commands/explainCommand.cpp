/** @file
 * `recurse explain`: which estimator of an integrator takes which light paths into account.
 */
#include "apps/commands/commands.h"
#include "apps/load/loadedScene.h"
#include "apps/options/integratorOptions.h"
#include "recurse/pathclasses/pathExpression.h"
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
       runFirstForwardPass(*loaded.scene, *loaded.integrator, PathClasses(), settings).notes)
    text += note + "\n";
  return text;
}

/** The estimators that find paths in a scene without media. */
std::vector<EstimatorDomain> withoutMedia(std::vector<EstimatorDomain> domains) {
  std::erase_if(domains, [](const EstimatorDomain& d) {
    return d.fromMedia ||
           PathAutomaton::compile("(" + d.expression + ") & surface", PathAutomaton::Empty::ALLOWED)
               .isEmpty();
  });
  return domains;
}

ExitStatus explain(const ExplainOptions& o) {
  Diagnostics diagnostics;
  ParsedDirective fromFile;
  if (!o.scene.empty()) fromFile = loadScene(o.scene, diagnostics).integrator;
  const ParsedDirective directive = o.integrator.directive(fromFile);
  LoadedScene loaded; // outlives its integrator
  std::unique_ptr<Integrator> integrator = makeIntegrator(directive, false, diagnostics);
  diagnostics.throwIfErrors();
  std::string text = integratorText(directive) + "\n\n";
  if (const std::string choices = integrator->choices(); !choices.empty()) {
    text += "It chooses for each scene: " + choices + ".\n";
    if (o.scene.empty()) {
      text += "Without a scene, these are the estimators before the choice:\n\n";
    } else {
      loaded = loadAndBuild(o.scene, {}, o.integrator);
      text += chosenFor(loaded) + "\n";
      integrator = std::move(loaded.integrator);
    }
  }
  const std::vector<EstimatorDomain> domains = integrator->domains();
  const bool hasNoMedia = loaded.scene && !loaded.scene->hasMedia();
  text += formatDomains(hasNoMedia ? withoutMedia(domains) : domains);
  const std::string claims = integrator->claims();
  const DomainReport atSurfaces = checkDomains(domains, claims.empty() ? "surface" : claims),
                     everywhere = checkDomains(domains);
  text += "\n";
  if (everywhere.sound())
    text += "Each path is estimated exactly once.\n";
  else if (atSurfaces.sound() && !claims.empty())
    text += "The paths " + claims + " are estimated exactly once; the method leaves out all other paths.\n";
  else if (atSurfaces.sound() && everywhere.overlaps.empty())
    text += "Each path is estimated exactly once, except paths with scattering in a medium: they are left "
            "out.\n";
  else
    text += atSurfaces.text();
  if (!text.ends_with('\n')) text += "\n";
  if (const std::string supposed = integrator->suppositions(); !supposed.empty())
    text += "It assumes " + supposed + ".\n";
  if (const std::string missed = missedOfDeltaLights(domains); !missed.empty())
    text += "No estimator finds these paths of point, spot and distant lights: " + missed +
            " (except straight through thin panes).\n";
  print(text);
  return atSurfaces.sound() ? ExitStatus::DONE : ExitStatus::FAILED;
}

} // namespace

void addExplainCommand(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<ExplainOptions>();
  CLI::App* command =
      app.add_subcommand("explain", "Explain which estimators of an integrator compute which light paths");
  command
      ->add_option("scene", options->scene,
                   "Scene file with the integrator (default: the integrator of the options)")
      ->type_name("SCENE");
  options->integrator.addTo(*command);
  command->footer(
      "Prints each estimator of the integrator with its path expression, and checks that together they\n"
      "estimate each path exactly once. For the integrator \"auto\" the scene is loaded and a few blocks of\n"
      "it are rendered, and the estimators of the chosen integrator are printed.\n\n"
      "Examples:\n"
      "  recurse explain scene.pbrt\n"
      "  recurse explain --integrator photonmap\n"
      "  recurse explain --integrator photonmap --direct photons");
  command->callback([options, &chosen] { chosen = [options] { return explain(*options); }; });
}

} // namespace recurse::apps
