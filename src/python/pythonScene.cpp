/** @file
 * Loading and rendering for Python, as in the commands of the program.
 */
#include "python/pythonScene.h"

#include <mutex>

#include "apps/run/console.h"
#include "python/commandOptions.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/core/threads/resources.h"
#include "recurse/pathclasses/pathExpression.h"
#include "recurse/render/featureLayers.h"
#include "recurse/scene/directives/loader.h"
#include "recurse/transport/integrator/sceneNames.h"

namespace recurse::python {

namespace {

/** Lock of all work: the thread pool and the messages belong to the whole process. */
std::mutex busy;

class Work {
 public:
  explicit Work(std::vector<std::string>& warnings, int threads = 0)
      : guard(busy), pool(threads), listening([this, &warnings](const std::string& text) {
          const std::lock_guard one(mutex);
          if (!text.empty()) warnings.push_back(text.substr(0, text.find_last_not_of('\n') + 1));
        }) {}

 private:
  const std::lock_guard<std::mutex> guard;
  std::mutex mutex;
  const ThreadPool pool;
  const apps::Listening listening;
};

/** Options of a render, with those that choose a camera. */
struct OptionsOfScene : apps::RenderOptions {
  void addTo(CLI::App& command) {
    RenderOptions::addTo(command);
    model.addTo(command);
  }
};

apps::RenderOptions parsedOptions(const std::string& fileName, const std::vector<std::string>& given) {
  apps::RenderOptions out = commandOptions<OptionsOfScene>(given);
  out.scene = fileName;
  out.progress = "off";
  out.quiet = true;
  return out;
}

PathClasses pathClassesOf(const std::vector<PathClass>& classes, const apps::LoadedScene& loaded) {
  std::vector<PathClass> all = {{"all", "all"}};
  all.insert(all.end(), classes.begin(), classes.end());
  return sceneClasses(all, *loaded.scene, loaded.integrator.get());
}

bool isSame(const apps::LoadOverrides& a, const apps::LoadOverrides& b) {
  return a.width == b.width && a.height == b.height && a.cropWindow == b.cropWindow &&
         a.lenient == b.lenient && a.compact == b.compact && a.model.map == b.model.map &&
         a.model.camera == b.model.camera;
}

} // namespace

PythonScene::PythonScene(std::string name, std::shared_ptr<const std::string> sceneText, std::string folder,
                         bool lenient)
    : fileName(std::move(name)), text(std::move(sceneText)), directory(std::move(folder)) {
  const Work work(warnings);
  setWorkLimit(INFINITY); // that of a render before was of its own options
  apps::LoadOverrides overrides;
  overrides.lenient = lenient;
  require(overrides);
}

void PythonScene::require(const apps::LoadOverrides& overrides) {
  if (loaded.scene && isSame(built, overrides)) return;
  const apps::IntegratorOptions options;
  if (text) {
    const auto read = [&](Diagnostics& diagnostics) {
      SceneDescription scene = parseScene(*text, fileName, directory, diagnostics, overrides.model.camera);
      if (!diagnostics.hasErrors()) apps::requireCamera(scene, overrides.model.camera);
      return scene;
    };
    loaded = apps::loadAndBuild(fileName, read, overrides, options);
  } else {
    loaded = apps::loadAndBuild(fileName, overrides, options);
  }
  built = overrides;
}

RenderResult PythonScene::render(const RenderRequest& request,
                                 const std::function<void(const RenderProgress&)>& progress) {
  const apps::RenderOptions options = parsedOptions(fileName, request.options);
  apps::RenderPlan plan = options.plan();
  plan.overrides.lenient |= built.lenient;
  plan.endsWithFirstPicture = true;
  requireFeatureLayers(request.features);
  const Work work(warnings, plan.threads);
  require(plan.overrides);
  apps::replaceIntegrator(loaded, options.integrator, plan.overrides.lenient);
  const PathClasses classes = pathClassesOf(request.classes, loaded);
  requireFeatureLayers(request.features, *loaded.integrator);
  apps::withdrawStop();
  apps::RenderResult result =
      apps::renderLoaded(loaded, classes, plan, options, [&](RenderProgress& p) { progress(p); });
  apps::RenderReport report = result.report("recurse render");
  report.extra = request.extra;
  Image image = apps::pictureOf(result.film, report);
  if (!request.features.empty()) {
    FeatureSettings features;
    features.layers = request.features;
    image = withChannels(image, renderFeatures(*loaded.scene, *loaded.integrator, features));
  }
  result.explainBlackness();
  return {std::make_shared<Image>(std::move(image)), apps::statisticsJson(report)};
}

PathLists PythonScene::paths(const RenderRequest& request, int x, int y, int64_t samples) {
  const apps::RenderOptions options = parsedOptions(fileName, request.options);
  apps::RenderPlan plan = options.plan();
  plan.overrides.lenient |= built.lenient;
  const Work work(warnings, plan.threads);
  require(plan.overrides);
  apps::replaceIntegrator(loaded, options.integrator, plan.overrides.lenient);
  const PathClasses classes = pathClassesOf(request.classes, loaded);
  apps::withdrawStop();
  const apps::GracefulStop graceful;
  std::vector<RecordedPixel> pixels(1);
  pixels[0].x = x;
  pixels[0].y = y;
  recordPixels(*loaded.scene, *loaded.integrator, classes, plan.settings(*loaded.scene), samples, pixels,
               graceful.flag());
  return listPaths(*loaded.scene, pixels[0]);
}

std::vector<PhotonRecord> PythonScene::photons(const PhotonRequest& request) const {
  std::vector<std::string> none;
  const Work work(none);
  return listPhotons(*loaded.scene, request);
}

std::string PythonScene::report() const { return apps::sceneReport(loaded); }

void PythonScene::stop() { apps::requestStop(); }

std::vector<std::string> PythonScene::takeWarnings() { return std::exchange(warnings, {}); }

} // namespace recurse::python
