/** @file
 * Output of a render: pictures, statistics, a summary.
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

/** Layers of a picture in addition to colours. */
struct ExtraLayers {
  bool error = false;   ///< the standard error of each pixel's luminance as error.Y
  bool samples = false; ///< the number of samples of each pixel as samples.N
};

/** Data on a finished render, for its outputs. */
struct RenderReport {
  const LoadedScene& loaded;
  const RenderStatistics& statistics;
  uint64_t seed = 0;
  std::vector<PathClass> classes;
  std::string commandLine; ///< command line that gives the same picture
  int width = 0, height = 0;
  ExtraLayers extra = {};

  double samplesPerPixel() const;
  const char* stopReason() const;
};

constexpr const char* VERSION = RECURSE_VERSION;

/** Metadata of a picture: version, scene, settings, statistics. */
std::map<std::string, std::string> metadataOf(const RenderReport& report);
/** Classes of a render as a text. */
std::string classesText(const std::vector<PathClass>& classes);
/** The film as a picture. The first layer is R, G, B; later layers have the names of their classes. */
Image pictureOf(const Film& film, const std::vector<PathClass>& classes, float imagingRatio,
                const ExtraLayers& extra);
/** The film of a render as a picture, with its metadata. */
Image pictureOf(const Film& film, const RenderReport& report);
/** Adds the channels of the requested feature layers. False, with a warning instead of the channels, if
 * `stop` is true or becomes so. */
bool addFeatures(Image& image, const LoadedScene& loaded, const FeatureSettings& features,
                 const std::atomic<bool>& stop);
/** The text of --stats. */
std::string statisticsJson(const RenderReport& report);
/** Summary in a few lines. `notes`: includes the notes on automatic choices. */
std::string renderSummary(const RenderReport& report, const std::vector<std::string>& outputs, bool notes);

} // namespace recurse::apps
