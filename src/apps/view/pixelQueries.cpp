/** @file
 * Answers to questions about pixels.
 */
#include "apps/view/pixelQueries.h"

#include <algorithm>

#include "apps/run/firstPicture.h"
#include "recurse/core/io/error.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/core/threads/watchdog.h"
#include "recurse/transport/integrator/sceneNames.h"

namespace recurse::apps {

namespace {

constexpr int64_t RECORDED_SAMPLES = 16;
constexpr size_t SHOWN_PHOTONS = 100000;
constexpr int64_t REFERENCE_PATHS = 16384;
constexpr std::chrono::seconds REFERENCE_TIME{1};
/** Duration of the render over that of the answers. */
constexpr int LEAST_RENDERING = 50;

/** R, G and B of a picture. */
Image colourOf(const Image& picture) {
  Image image(picture.width, picture.height, {"R", "G", "B"});
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) std::copy_n(picture.at(x, y), 3, image.at(x, y));
  return image;
}

} // namespace

PixelQueries::PixelQueries(std::shared_ptr<const Scene> ofRender, PathClasses classes, std::string title,
                           std::string label, int maxDepth, uint64_t seed)
    : owner(std::move(ofRender)), scene(*owner), classes(std::move(classes)), title(std::move(title)),
      label(std::move(label)), maxDepth(maxDepth), seed(seed) {}

void PixelQueries::ask(int x, int y) {
  const PixelBounds& crop = scene.film().crop;
  if (x < 0 || y < 0 || x >= crop.width() || y >= crop.height())
    throw Error("the pixel is outside of the picture", ExitStatus::BAD_USAGE);
  const std::lock_guard<std::mutex> guard(mutex);
  asked = {x, y, asked.number + 1, false};
  waits = true;
}

PixelQuestion PixelQueries::question() const {
  const std::lock_guard<std::mutex> guard(mutex);
  return asked;
}

std::shared_ptr<Inspection> PixelQueries::inspectionOf(const PixelQuestion& now, const RenderPause& pause,
                                                       std::string& expression) const {
  const PixelBounds& crop = scene.film().crop;
  auto inspection = std::make_shared<Inspection>();
  inspection->title = title;
  inspection->label = label;
  inspection->isLive = true;
  RecordedPixel pixel;
  pixel.x = crop.x0 + now.x;
  pixel.y = crop.y0 + now.y;
  pause.record(pixel.x, pixel.y, RECORDED_SAMPLES, pixel.record);
  inspection->pixels.push_back(std::move(pixel));
  const Integrator& integrator = pause.integrator();
  inspection->notes = recordNotes(integrator);
  if (const std::vector<LampGroup> lamps = lampGroups(scene);
      lamps.size() == 1 && !integrator.addsLightOfNoLamp())
    inspection->lamps = {lamps.front().name};
  inspection->photons = photonsOf(integrator, SHOWN_PHOTONS, inspection->photonsInMap);
  inspection->kinds = surfaceKindsOf(scene, classes, inspection->photons);
  inspection->shownPhotons = SHOWN_PHOTONS;
  inspection->photonName = integrator.photonName();
  integrator.visitPhotonBoxes(BOX_LEVELS, [&](const PhotonBox& box) { inspection->boxes.push_back(box); });
  if (!inspection->photons.empty())
    expression = photonExpression(classes, inspection->photons, integrator.photonPaths(), inspection->kinds);
  return inspection;
}

void PixelQueries::answer(const RenderPause& pause) {
  const Clock::time_point start = Clock::now();
  const PixelQuestion now = question();
  std::shared_ptr<Inspection> inspection;
  std::string expression, why;
  try {
    inspection = inspectionOf(now, pause, expression);
  } catch (const std::exception& error) { // such as lack of memory; the render goes on
    why = std::string("The paths of the pixel could not be recorded: ") + error.what();
  }
  const Clock::time_point end = Clock::now();
  due = end + LEAST_RENDERING * (end - start);
  const std::lock_guard<std::mutex> guard(mutex);
  answered = std::move(inspection);
  failure = why;
  photonPaths = expression;
  if (asked.number != now.number) return; // another question has come meanwhile
  asked.isAnswered = true;
  waits = false;
}

std::string PixelQueries::page(const Image& picture) {
  std::shared_ptr<Inspection> inspection;
  {
    const std::lock_guard<std::mutex> guard(mutex);
    if (!failure.empty()) throw Error(failure);
    inspection = answered;
  }
  if (!inspection) return "";
  inspection->picture = colourOf(picture); // the render's thread does not use a published answer
  return inspectPage(scene, classes, *inspection);
}

void PixelQueries::prepareReferences(const std::string& expression) {
  if (path && referencePaths == expression) return;
  path = pathTracerThatLearnsNothing(maxDepth); // learning would delay the first answer
  referenceClasses = std::make_unique<PathClasses>(sceneClasses({{"photons", expression}}, scene));
  path->prepare(scene, *referenceClasses);
  referencePaths = expression;
}

std::string PixelQueries::reference(const Vec3f& position, const Vec3f& normal) {
  std::string expression;
  {
    const std::lock_guard<std::mutex> guard(mutex);
    expression = photonPaths;
  }
  if (expression.empty()) throw Error("the render has no photons");
  if (!(std::abs(glm::length(normal) - 1) < 1e-3f) || !isFinite(position))
    throw Error("the normal is not a unit vector", ExitStatus::BAD_USAGE);
  prepareReferences(expression);
  setThreadFloatMode();
  std::atomic<bool> isOver{false};
  const Clock::time_point end = Clock::now() + REFERENCE_TIME;
  const Watchdog watchdog([&] {
    if (stopped || Clock::now() >= end) isOver = true;
  });
  const std::optional<ReferencePoint> found =
      referenceAt(scene, *path, *referenceClasses, position, normal, REFERENCE_PATHS, seed, isOver);
  if (stopped) throw Error("the render has ended");
  if (!found)
    throw Error("no path tracing: no surface of the scene is close to this point of the simplified mesh, the "
                "surface is not diffuse alone, or the scene moves or has fog");
  return referenceText(scene, *found);
}

} // namespace recurse::apps
