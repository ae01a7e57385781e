/** @file
 * Two references, to which batches of samples are added until their difference is small enough.
 */
#include "apps/converge/convergeReference.h"

#include <cmath>
#include <filesystem>

#include "apps/load/missedLight.h"
#include "apps/options/optionText.h"

namespace recurse::apps {

namespace {

/** Longest duration of a batch [s]: an interrupted batch is lost. */
constexpr double LONGEST_BATCH = 60;
constexpr int FIRST_BATCH = 32; ///< samples per pixel

struct Halves {
  Image a, b;
  int64_t samples = 0; ///< per pixel, of each half
  int64_t batches = 0;
  double seconds = 0; ///< of rendering, both together
};

/** Seed of a batch; the batches of a study never use the seeds of its runs. */
uint64_t batchSeed(uint64_t seed, int64_t batch, uint64_t half) {
  return seed ^ (0x9e3779b97f4a7c15ull * (2 * static_cast<uint64_t>(batch) + half + 1));
}

void addBatch(Image& mean, int64_t samples, const Image& batch, int64_t batchSamples) {
  const double share = double(batchSamples) / double(samples + batchSamples);
  for (size_t i = 0; i < mean.pixels.size(); ++i)
    mean.pixels[i] = static_cast<float>(double(mean.pixels[i]) +
                                        (double(batch.pixels[i]) - double(mean.pixels[i])) * share);
}

/** Reference as a file: the mean as R, G, B, and the halves as layers. */
Image fileOf(const Halves& halves, const std::string& identity) {
  Image file(halves.a.width, halves.a.height, {"R", "G", "B", "a.R", "a.G", "a.B", "b.R", "b.G", "b.B"});
  const Image mean = meanImage(halves.a, halves.b);
  for (size_t p = 0; p < mean.pixels.size() / 3; ++p)
    for (size_t c = 0; c < 3; ++c) {
      file.pixels[9 * p + c] = mean.pixels[3 * p + c];
      file.pixels[9 * p + 3 + c] = halves.a.pixels[3 * p + c];
      file.pixels[9 * p + 6 + c] = halves.b.pixels[3 * p + c];
    }
  file.metadata = {{"recurse:reference", identity},
                   {"recurse:samples", std::to_string(halves.samples)},
                   {"recurse:batches", std::to_string(halves.batches)},
                   {"recurse:seconds", formatted("%.3f", halves.seconds)}};
  return file;
}

Halves readHalves(const std::string& fileName, const std::string& identity) {
  const Image file = readImage(fileName);
  const auto text = [&](const char* name) {
    const auto found = file.metadata.find(name);
    return found == file.metadata.end() ? std::string() : found->second;
  };
  if (text("recurse:reference") != identity)
    throw Error(fileName + " is a reference of another scene or of other settings (" +
                    text("recurse:reference") + "; now " + identity +
                    "). Choose another folder, or remove that file",
                ExitStatus::BAD_USAGE);
  Halves halves;
  halves.samples = parseCount(fileName, text("recurse:samples"), 1, int64_t(1) << 40);
  halves.batches = parseCount(fileName, text("recurse:batches"), 1, int64_t(1) << 40);
  halves.seconds = parseReal(fileName, text("recurse:seconds"));
  for (auto [half, layer] : {std::pair{&halves.a, "a."}, {&halves.b, "b."}}) {
    *half = Image(file.width, file.height, {"R", "G", "B"});
    for (size_t c = 0; c < 3; ++c) {
      const int from = file.channel(layer + std::string(1, "RGB"[c]));
      if (from < 0) throw Error(fileName + ": the layers a and b are missing");
      for (size_t p = 0; p < half->pixels.size() / 3; ++p)
        half->pixels[3 * p + c] = file.pixels[p * file.channels.size() + size_t(from)];
    }
  }
  return halves;
}

} // namespace

References ownReferences(LoadedScene& loaded, const RenderOptions& options, const ReferencePlan& plan,
                         const std::string& sceneHash, const std::string& folder) {
  RenderOptions path = options;
  path.adaptive = false;
  path.verbose = false;
  const auto use = [&](const char* name) {
    path.integrator.setIntegrator(name);
    Diagnostics diagnostics;
    loaded.integratorDirective = path.integrator.directive(loaded.description.integrator);
    loaded.integrator = makeIntegrator(loaded.integratorDirective, path.lenient, diagnostics);
    diagnostics.throwIfErrors();
  };
  use("path");
  const std::string missed = missedPaths(loaded, PathClasses().classes());
  if (!missed.empty()) use("sppm");
  const uint64_t seed = path.plan().settings(*loaded.scene).seed;
  const PixelBounds& crop = loaded.scene->film().crop;
  std::string identity = loaded.integratorDirective.type;
  for (const std::string& setting : settingsOf(loaded.integratorDirective)) identity += ", " + setting;
  identity += "; seed " + std::to_string(seed) + "; scene " + sceneHash + "; " + std::to_string(crop.x0) +
              " " + std::to_string(crop.y0) + " " + std::to_string(crop.width()) + "x" +
              std::to_string(crop.height());

  const std::string fileName = (std::filesystem::path(folder) / "reference.exr").string();
  Halves halves;
  if (std::filesystem::exists(fileName)) halves = readHalves(fileName, identity);
  std::optional<ReferenceError> error;
  if (halves.samples > 0) error = referenceError(halves.a, halves.b);
  double spent = 0;
  bool timeUp = false;
  // The upper end of the confidence interval has to reach the target, because rare bright paths make
  // estimates from few samples too low rather than too high.
  while (!error || error->relMse.high > plan.relMse) {
    int64_t batch = FIRST_BATCH;
    double left = -1;
    if (error) {
      // The squared error is inversely proportional to the number of samples.
      const double wanted = double(halves.samples) * (error->relMse.high / plan.relMse - 1) * 1.05,
                   perSample = halves.seconds / double(halves.samples);
      left = wanted * perSample;
      double most = LONGEST_BATCH / perSample;
      if (plan.seconds > 0) {
        left = std::min(left, plan.seconds - spent);
        most = std::min(most, (plan.seconds - spent) / perSample);
        if (most < 1) {
          timeUp = true;
          break;
        }
      }
      batch = static_cast<int64_t>(
          std::clamp(std::min(wanted, 3 * double(halves.samples)), 1.0, std::max(1.0, most)));
    }
    const double spentBefore = spent;
    Image pictures[2];
    for (uint64_t half : {0, 1}) {
      path.samples = std::to_string(batch);
      path.seed = std::to_string(batchSeed(seed, halves.batches, half));
      const auto retell = [&](RenderProgress& p) {
        p.phase =
            std::string("reference ") + (half == 0 ? "a" : "b") + ", " +
            (error ? "relMSE " + formatted("%.2g", error->relMse.high) : std::to_string(batch) + " samples") +
            ", wanted " + formatted("%.2g", plan.relMse);
        p.secondsLeft = left < 0 ? -1 : std::max(0.0, left - (spent - spentBefore) - p.elapsed);
      };
      const RenderResult result = renderLoaded(loaded, PathClasses(), path.plan(), path, retell);
      if (result.isInterrupted())
        throw Error("interrupted while the reference was rendered; its samples are kept in " + fileName +
                        "; run the same command to continue",
                    ExitStatus::INTERRUPTED);
      pictures[half] = pictureOf(result.film, result.report("recurse render"));
      halves.seconds += result.statistics.renderSeconds;
      spent += result.statistics.renderSeconds;
    }
    if (halves.samples == 0) {
      halves.a = pictures[0];
      halves.b = pictures[1];
    } else {
      addBatch(halves.a, halves.samples, pictures[0], batch);
      addBatch(halves.b, halves.samples, pictures[1], batch);
    }
    halves.samples += batch;
    ++halves.batches;
    writeImage(fileName, fileOf(halves, identity));
    error = referenceError(halves.a, halves.b);
  }
  References out = makeReferences({halves.a, halves.b}, {"a", "b"});
  out.description = std::string("r is the mean of two pictures by ") +
                    (missed.empty() ? "path tracing, " : "progressive photon mapping, ") +
                    std::to_string(halves.samples) + " samples per pixel each; " + error->text() + "; " +
                    (missed.empty() ? "light that path tracing did not find is missing in both"
                                    : "path tracing cannot find " + missed +
                                          " of this scene; both have the bias of photon maps");
  if (timeUp)
    out.description +=
        "; the wanted " + formatted("%.3g", plan.relMse) + " was not reached within --reference-time";
  return out;
}

} // namespace recurse::apps
