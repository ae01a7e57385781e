/** @file
 * Pictures with metadata, statistics as JSON and in words.
 */
#include "apps/run/renderOutput.h"

#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "apps/options/optionText.h"
#include "apps/run/console.h"
#include "recurse/core/threads/interrupt.h"

namespace recurse::apps {

namespace {

double perSecond(double count, double seconds) { return seconds > 0 ? count / seconds : 0; }

uint64_t peakMemoryBytes() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<uint64_t>(usage.ru_maxrss) * 1024; // Linux counts in kilobytes
}

} // namespace

std::string classesText(const std::vector<PathClass>& classes) {
  std::string out;
  for (const PathClass& c : classes)
    out += (out.empty() ? "" : "; ") + (c.name == c.expression ? c.name : c.name + " = " + c.expression);
  return out;
}

double RenderReport::samplesPerPixel() const {
  return double(statistics.samples) / (double(width) * double(height));
}

const char* RenderReport::stopReason() const {
  switch (statistics.stopReason) {
  case StopReason::TIME:
    return "time";
  case StopReason::ERROR:
    return "error";
  case StopReason::INTERRUPTED:
    return "interrupted";
  default:
    return "samples";
  }
}

std::map<std::string, std::string> metadataOf(const RenderReport& report) {
  return {{"Software", std::string("Recurse ") + VERSION},
          {"recurse:version", VERSION},
          {"recurse:scene", report.loaded.fileName},
          {"recurse:settings", report.commandLine},
          {"recurse:seed", std::to_string(report.seed)},
          {"recurse:samples", formatted("%.9g", report.samplesPerPixel())},
          {"recurse:seconds", formatted("%.3f", report.statistics.renderSeconds)},
          {"recurse:classes", classesText(report.classes)},
          {"recurse:ended", report.stopReason()}};
}

Image pictureOf(const Film& film, const std::vector<PathClass>& classes, float imagingRatio,
                const ExtraLayers& extra) {
  std::vector<std::string> channels = {"R", "G", "B"};
  for (size_t layer = 1; layer < film.layerCount(); ++layer)
    for (const char* c : {".R", ".G", ".B"}) channels.push_back(classes[layer].name + c);
  const size_t colours = channels.size();
  if (extra.error) channels.emplace_back("error.Y");
  if (extra.samples) channels.emplace_back("samples.N");
  Image image(film.bounds().width(), film.bounds().height(), channels);
  std::vector<double> errors;
  if (extra.error) errors = film.standardErrors();
  const std::vector<size_t> nearest = film.nearestSampled(FIRST_SAMPLE_REACH);
  for (size_t pixel = 0; pixel < film.bounds().area(); ++pixel) {
    const size_t from = nearest.empty() ? pixel : nearest[pixel];
    float* more = &image.pixels[pixel * channels.size() + colours - 1];
    if (extra.error) *++more = static_cast<float>(errors[from]) * imagingRatio;
    if (extra.samples) *++more = static_cast<float>(film.samples(pixel));
    for (size_t layer = 0; layer < film.layerCount(); ++layer) {
      const Rgb value = film.value(from, layer) * imagingRatio;
      for (int c = 0; c < 3; ++c) image.pixels[pixel * channels.size() + layer * 3 + size_t(c)] = value[c];
    }
  }
  return image;
}

Image pictureOf(const Film& film, const RenderReport& report) {
  Image image = pictureOf(film, report.classes, report.loaded.scene->film().imagingRatio, report.extra);
  image.metadata = metadataOf(report);
  return image;
}

bool addFeatures(Image& image, const LoadedScene& loaded, const FeatureSettings& features,
                 const std::atomic<bool>& stop) {
  if (features.layers.empty()) return true;
  try {
    const InterruptibleWork looking(&stop);
    checkInterrupted();
    image = withChannels(image, renderFeatures(*loaded.scene, *loaded.integrator, features));
    return true;
  } catch (const Interrupted&) {
    say("warning: interrupted before the --layers were computed: the picture does not have them\n");
    return false;
  }
}

namespace {

/** Statistics of kernel radii; null without estimates. */
nlohmann::ordered_json radiiJson(const KernelRadii& radii) {
  if (radii.count() == 0) return nullptr;
  return {{"geometric_mean", radii.mean()}, {"counts", radii.bins}};
}

/** Processor time by phase [s]. */
nlohmann::ordered_json processorSplitJson(const RenderStatistics& s) {
  const double learning = s.learningProcessorSeconds, photons = s.photonProcessorSeconds;
  return {{"learning", learning},
          {"photons", photons},
          {"camera_paths", std::max(0.0, s.processorSeconds - learning - photons)}};
}

/** Guide of the latest pass; null without one. */
nlohmann::ordered_json guideJson(const std::optional<GuideStatistics>& guide) {
  if (!guide) return nullptr;
  return {{"cells", guide->cells},
          {"cells_on", guide->cellsOn},
          {"fraction_on", guide->fractionOn()},
          {"records", guide->records},
          {"gain", guide->gain}};
}

/** Histograms of the ratio of kernel radius and footprint; "from": lower bound of each bin. */
nlohmann::ordered_json radiusOverFootprintJson(const TransportCounts& counts) {
  std::array<int, KernelRadii::BINS> from{};
  for (size_t i = 1; i < from.size(); ++i) from[i] = 1 << (i - 1);
  return {{"from", from},
          {"caustic_photons", radiiJson(counts.causticRadii)},
          {"other_photons", radiiJson(counts.otherRadii)}};
}

} // namespace

std::string statisticsJson(const RenderReport& report) {
  const RenderStatistics& s = report.statistics;
  nlohmann::ordered_json json = {
      {"version", VERSION},
      {"scene", report.loaded.fileName},
      {"integrator", report.loaded.integratorDirective.type},
      {"settings", report.commandLine},
      {"seed", report.seed},
      {"resolution", {report.width, report.height}},
      {"threads", s.threads},
      {"stop_reason", report.stopReason()},
      {"load_seconds", report.loaded.loadSeconds},
      {"build_seconds", report.loaded.buildSeconds},
      {"render_seconds", s.renderSeconds},
      {"processor_seconds", s.processorSeconds},
      {"processor_seconds_by_part", processorSplitJson(s)},
      {"guide", guideJson(s.guide)},
      {"cores_busy", perSecond(s.processorSeconds, s.renderSeconds)},
      {"photon_seconds", s.photonSeconds},
      {"balance_seconds", s.balanceSeconds},
      {"gather_seconds", s.gatherSeconds},
      {"passes", s.passes},
      {"photon_maps", s.photonsEmitted > 0 ? s.forwardPasses : 0},
      {"relative_error", s.error >= 0 ? nlohmann::ordered_json(s.error) : nlohmann::ordered_json(nullptr)},
      {"samples", s.samples},
      {"samples_per_pixel", report.samplesPerPixel()},
      {"samples_of_a_pixel", {{"least", s.least}, {"median", s.median}, {"most", s.most}}},
      {"rays", s.counts.rays},
      {"rays_per_second", perSecond(double(s.counts.rays), s.renderSeconds)},
      {"photons_emitted", s.photonsEmitted},
      {"photons_stored", s.photonsStored},
      {"photons_refused", s.photonsRefused},
      {"photons_emitted_per_second", perSecond(double(s.photonsEmitted), s.photonSeconds)},
      {"photons_stored_per_second", perSecond(double(s.photonsStored), s.photonSeconds)},
      {"photon_map_bytes", s.mapBytes},
      {"gathers", s.counts.gathers},
      {"photons_found", s.counts.photonsFound},
      {"radius_over_footprint", radiusOverFootprintJson(s.counts)},
      {"non_finite", s.counts.nonFinite},
      {"splats_saturated", s.splatsSaturated},
      {"weight_cut", s.counts.truncatedThroughput},
      {"peak_memory_bytes", peakMemoryBytes()},
      {"notes", s.notes},
      {"warnings", s.warnings}};
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string renderSummary(const RenderReport& report, const std::vector<std::string>& outputs, bool notes) {
  const RenderStatistics& s = report.statistics;
  std::string out = std::to_string(report.width) + "x" + std::to_string(report.height) + " pixels, " +
                    formatted("%.4g", report.samplesPerPixel()) +
                    (report.samplesPerPixel() == 1 ? " sample per pixel, in " : " samples per pixel, in ") +
                    durationText(s.renderSeconds) + " on " + std::to_string(s.threads) +
                    (s.threads == 1 ? " thread" : " threads") + " (" +
                    formatted("%.2f", perSecond(s.processorSeconds, s.renderSeconds)) +
                    " cores busy); ended by ";
  out += s.stopReason == StopReason::SAMPLES ? "the number of samples"
         : s.stopReason == StopReason::TIME  ? "the time limit"
         : s.stopReason == StopReason::ERROR ? "the error target"
                                             : "an interrupt";
  out += "\n";
  if (s.error >= 0)
    out +=
        "relative standard error of the picture (95th percentile of pixels): " + formatted("%.3g", s.error) +
        (s.oneMap               ? "; it does not include noise and bias of the single photon map\n"
         : s.photonsEmitted > 0 ? "; it does not include the bias of the photon map\n"
                                : "\n");
  if (s.least != s.most)
    out += "samples per pixel: " + std::to_string(s.least) + " to " + std::to_string(s.most) + ", median " +
           std::to_string(s.median) + "\n";
  if (s.photonsEmitted > 0 && s.mapBytes > 0)
    out += "photons: " + countText(double(s.photonsEmitted)) + " emitted, " +
           countText(double(s.photonsStored)) + " stored in " + durationText(s.photonSeconds) + " (" +
           countText(perSecond(double(s.photonsStored), s.photonSeconds)) + "/s), map of " +
           bytesText(double(s.mapBytes)) + " balanced in " + durationText(s.balanceSeconds) + "\n";
  else if (s.photonsEmitted > 0)
    out +=
        "light paths: " + countText(double(s.photonsEmitted)) + " in " + durationText(s.photonSeconds) + "\n";
  out += "picture: " + countText(double(s.counts.rays)) + " rays in all, " +
         countText(perSecond(double(s.counts.rays), s.renderSeconds)) + " rays/s, peak memory " +
         bytesText(double(peakMemoryBytes())) + "\n";
  if (notes && s.guide)
    out += guideText(*s.guide) + "; learning took " + durationText(s.learningProcessorSeconds) +
           " of processor time\n";
  if (notes)
    for (const std::string& note : s.notes) out += note + "\n";
  if (s.counts.truncatedThroughput > 0)
    out += "path weight lost by the limits of depth and weight: " +
           formatted("%.3g", s.counts.truncatedThroughput / double(s.samples)) + " per sample\n";
  if (s.counts.nonFinite > 0)
    out += "warning: " + std::to_string(s.counts.nonFinite) +
           " contributions were not finite and were left out; please report this error of the program\n";
  if (s.splatsSaturated > 0)
    out += "warning: " + std::to_string(s.splatsSaturated) +
           " contributions of light paths were too bright for the film and were clipped: light is missing "
           "there\n";
  std::string list;
  for (const std::string& file : outputs) list += (list.empty() ? "" : ", ") + file;
  if (!list.empty()) out += "written: " + list + "\n";
  return out;
}

} // namespace recurse::apps
