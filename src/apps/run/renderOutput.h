/** @file
 * What a render leaves behind: pictures, statistics, a summary.
 */
#pragma once

#include <atomic>
#include <map>
#include <string>
#include <vector>

#include "apps/load/loadedScene.h"
#include "recurse/core/image/image.h"
#include "recurse/render/featureLayers.h"
#include "recurse/render/renderSettings.h"

namespace recurse::apps {

/** What a picture is to have besides colours. */
struct ExtraLayers {
  bool error = false;   ///< the standard error of each pixel's luminance as error.Y
  bool samples = false; ///< the number of samples of each pixel as samples.N
};

/** Everything that is told about a finished render. */
struct RenderReport {
  const LoadedScene& loaded;
  const RenderStatistics& statistics;
  uint64_t seed = 0;
  std::vector<PathClass> classes;
  std::string commandLine; ///< one that gives the same picture
  int width = 0, height = 0;
  ExtraLayers extra = {};

  double samplesPerPixel() const;
  const char* stopReason() const;
};

constexpr const char* VERSION = RECURSE_VERSION;

/** What a picture says of how it came about. */
std::map<std::string, std::string> metadataOf(const RenderReport& report);
/** The classes of a render as a text. */
std::string classesText(const std::vector<PathClass>& classes);
/** The film as a picture. The first layer is R, G, B; the others are called after their classes. */
Image pictureOf(const Film& film, const std::vector<PathClass>& classes, float imagingRatio,
                const ExtraLayers& extra);
/** The same of a render, with its metadata. */
Image pictureOf(const Film& film, const RenderReport& report);
/** Adds the channels of the feature layers that are asked for. False, and a warning instead of the channels,
 * where `stop` is true or becomes so. */
bool addFeatures(Image& image, const Scene& scene, const FeatureSettings& features,
                 const std::atomic<bool>& stop);
/** The text of --stats. */
std::string statisticsJson(const RenderReport& report);
/** A few lines for a person. `notes`: with what was chosen by itself. */
std::string renderSummary(const RenderReport& report, const std::vector<std::string>& outputs, bool notes);

} // namespace recurse::apps
