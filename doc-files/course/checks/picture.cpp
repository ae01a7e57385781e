/** @file
 * Pictures of the tracers, and their marks by classes of paths.
 */
#include <atomic>
#include <cstdio>
#include <filesystem>

#include <recurse/core/image/image.h>
#include <recurse/core/threads/parallel.h>
#include <recurse/pathclasses/pathExpression.h>
#include <recurse/render/render.h>
#include <recurse/report/develop/develop.h>
#include <recurse/report/marking/marking.h>
#include <recurse/scene/directives/loader.h>

#include "checks/checks.h"

namespace course {

namespace {

namespace fs = std::filesystem;

const std::string SCENE = COURSE_SOURCE_DIR "/scenes/room.pbrt";
const std::string OUTPUT = COURSE_BINARY_DIR "/";
constexpr int SAMPLES = 64, REFERENCE_SAMPLES = 512; ///< of a pixel

std::unique_ptr<Scene> sceneOf(const std::string& fileName) {
  Diagnostics diagnostics;
  const SceneDescription description = loadScene(fileName, diagnostics);
  std::unique_ptr<Scene> scene = diagnostics.hasErrors() ? nullptr : buildScene(description, {}, diagnostics);
  diagnostics.throwIfErrors();
  return scene;
}

Stills rendered(const Scene& scene, Integrator& integrator, const std::vector<PathClass>& classes, int samples,
                uint64_t seed) {
  const ThreadPool pool;
  const StillsPlan plan = planStills(classes);
  const PathClasses compiled(plan.classes);
  Film film(scene.film().crop, compiled.layerCount());
  RenderSettings settings;
  settings.samplesPerPixel = samples;
  settings.seed = seed;
  const std::atomic<bool> stop{false};
  render(scene, integrator, compiled, settings, film, stop, nullptr, nullptr);
  return makeStills(film, plan, scene.film().imagingRatio);
}

Image pictureOf(Tracer& tracer, const Scene& scene, int samples) {
  return rendered(scene, tracer, {{"all", "L(S|D|V)*E"}}, samples, 1).layerImage(0);
}

/** Stills of the scene by Recurse's own path tracer, from their file if that is newer than the scene. */
Stills reference(const Scene& scene) {
  const std::string fileName = OUTPUT + "stills.exr";
  if (fs::exists(fileName) && fs::last_write_time(fileName) > fs::last_write_time(SCENE)) return readStills(fileName);
  std::printf("(renders the reference, once)\n");
  std::fflush(stdout);
  Diagnostics diagnostics;
  const std::unique_ptr<Integrator> path = plugIns().integrators.make(parseParameterText("path", ""), {}, diagnostics);
  diagnostics.throwIfErrors();
  Stills stills = rendered(scene, *path, defaultStillClasses(), REFERENCE_SAMPLES, 2);
  stills.title = "room.pbrt";
  stills.label = "path, " + std::to_string(REFERENCE_SAMPLES) + " samples per pixel";
  describeStills(stills);
  writeImage(fileName, stills.image);
  return stills;
}

} // namespace

bool markPicture(Tracer& tracer, const std::string& name) {
  const std::unique_ptr<Scene> scene = sceneOf(SCENE);
  const Stills stills = reference(*scene);
  const Image picture = pictureOf(tracer, *scene, SAMPLES);
  const std::string fileName = OUTPUT + name + ".exr", page = OUTPUT + name + "-marks.html";
  writeImage(fileName, picture);
  const Marking marking = markExercise(picture, stills);
  writeFileAtomically(page, markingPage(marking, stills, name));
  std::printf("%s\n", markingText(marking).c_str());
  std::printf("Picture: %s\nMarks:   %s\n", fileName.c_str(), page.c_str());
  return marking.isRight();
}

void renderPicture(Tracer& tracer, const std::string& scene, const std::string& output, int samples) {
  const std::unique_ptr<Scene> loaded = sceneOf(scene);
  writeImage(output, pictureOf(tracer, *loaded, samples));
}

} // namespace course
