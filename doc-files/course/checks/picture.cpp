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
constexpr int REFERENCE_SAMPLES = 512; ///< of a pixel
/** Mean brightness over the reference's from which a picture gets no marks. */
constexpr double MAX_BRIGHTNESS = 10;
constexpr size_t MAX_STATEMENTS = 3;

/** Classes of paths that the exercises treat in different ways. */
const std::vector<PathClass> CLASSES = {{"emission", "LE"},
                                        {"mirrored-emission", "LS+E"},
                                        {"direct", "LDE"},
                                        {"mirrored-direct", "LDS+E"},
                                        {"caustic", "LS+DS*E"},
                                        {"indirect-1", "LDDE"},
                                        {"indirect-2-and-more", "LDDD+E"},
                                        {"other", "L(S|D)*E - (LS*E|LDS*E|LS+DS*E|LDD+E)"}};

std::unique_ptr<Scene> sceneOf(const std::string& fileName) {
  Diagnostics diagnostics;
  const SceneDescription description = loadScene(fileName, diagnostics);
  std::unique_ptr<Scene> scene = diagnostics.hasErrors() ? nullptr : buildScene(description, {}, diagnostics);
  diagnostics.throwIfErrors();
  return scene;
}

Stills rendered(const Scene& scene, Integrator& integrator, const std::vector<PathClass>& classes,
                int samples, uint64_t seed) {
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

/** File of the reference. Its name contains all inputs except the scene: the version of Recurse, the number
 * of samples and the classes. */
std::string referenceFileName() {
  std::string classes;
  for (const PathClass& c : CLASSES) classes += c.name + " " + c.expression + "\n";
  return OUTPUT + text("stills-%s-%d-%08x.exr", COURSE_RECURSE_VERSION, REFERENCE_SAMPLES,
                       unsigned(std::hash<std::string>()(classes)));
}

/** Stills of the scene by Recurse's own path tracer, from their file if that is newer than the scene. */
Stills reference(const Scene& scene) {
  const std::string fileName = referenceFileName();
  if (fs::exists(fileName) && fs::last_write_time(fileName) > fs::last_write_time(SCENE))
    return readStills(fileName);
  std::printf("(renders the reference, once)\n");
  std::fflush(stdout);
  Diagnostics diagnostics;
  const std::unique_ptr<Integrator> path =
      plugIns().integrators.make(parseParameterText("path", ""), {}, diagnostics);
  diagnostics.throwIfErrors();
  Stills stills = rendered(scene, *path, CLASSES, REFERENCE_SAMPLES, 2);
  stills.title = "room.pbrt";
  stills.label = "path, " + std::to_string(REFERENCE_SAMPLES) + " samples per pixel";
  describeStills(stills);
  writeImage(fileName, stills.image);
  return stills;
}

/** Mean luminance of the pixels, by the first three channels: R, G and B. */
double meanLuminance(const Image& image) {
  double sum = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) sum += double(luminance(image.rgb(x, y)));
  return sum / (double(image.width) * image.height);
}

void printMarks(const Marking& marking) {
  std::printf("\n%-22s%-10s%-10s%s\n", "class of paths", "share", "state", "factor");
  for (const ClassMark& mark : marking.classes) {
    if (mark.share <= 0) continue;
    const bool isKnown = mark.state != ClassState::UNKNOWN;
    std::printf("%-22s%4.1f %%    %-10s%-9s %s\n", mark.name.c_str(), 100 * mark.share,
                CLASS_STATE_NAMES[size_t(mark.state)], isKnown ? text("%.3g", mark.factor).c_str() : "-",
                mark.expression.c_str());
  }
  const std::vector<MarkingStatement> statements = markingStatements(marking);
  for (size_t i = 0; i < std::min(statements.size(), MAX_STATEMENTS); ++i)
    std::printf("\n* %s\n%s", statements[i].what.c_str(), wrapped(statements[i].advice, "  ").c_str());
  if (statements.size() > MAX_STATEMENTS)
    std::printf("\n%zu more statements are on the page.\n", statements.size() - MAX_STATEMENTS);
  if (statements.empty()) std::printf("\nNo errors were found in the classes that could be judged.\n");
}

} // namespace

bool markPicture(Tracer& tracer, const std::string& name, int samples) {
  const std::unique_ptr<Scene> scene = sceneOf(SCENE);
  const Stills stills = reference(*scene);
  const Image picture = pictureOf(tracer, *scene, samples);
  const std::string fileName = OUTPUT + name + ".exr", page = OUTPUT + name + "-marks.html";
  writeImage(fileName, picture);
  std::printf("\nPicture: %s\n", fileName.c_str());
  if (const double ratio = meanLuminance(picture) / meanLuminance(stills.image); !(ratio < MAX_BRIGHTNESS)) {
    std::printf(
        "%s", wrapped(text("It is %.3g times as bright as it should be, and gets no marks: surfaces reflect "
                           "more light than they receive, or a density is too small.",
                           ratio),
                      "")
                  .c_str());
    return false;
  }
  const Marking marking = markExercise(picture, stills);
  writeFileAtomically(page, markingPage(marking, stills, name));
  std::printf("Marks:   %s\n", page.c_str());
  printMarks(marking);
  return marking.isRight();
}

void renderPicture(Tracer& tracer, const std::string& scene, const std::string& output, int samples) {
  const std::unique_ptr<Scene> loaded = sceneOf(scene);
  writeImage(output, pictureOf(tracer, *loaded, samples));
}

} // namespace course
