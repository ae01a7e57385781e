/** @file
 * `recurse info`: contents of a picture or a scene file.
 */
#include <array>
#include <cmath>
#include <filesystem>

#include "apps/commands/commands.h"
#include "apps/load/loadedScene.h"
#include "apps/load/modelScene.h"
#include "apps/options/optionText.h"
#include "recurse/core/image/image.h"

namespace recurse::apps {

namespace {

std::string column(const std::string& text, size_t width) {
  return text.size() < width ? text + std::string(width - text.size(), ' ') : text + " ";
}

std::string channelLine(const Image& image, size_t channel) {
  const size_t stride = image.channels.size();
  double sum = 0, low = INFINITY, high = -INFINITY;
  size_t finite = 0, bad = 0;
  for (size_t i = channel; i < image.pixels.size(); i += stride) {
    const double value = double(image.pixels[i]);
    if (!std::isfinite(value)) {
      ++bad;
      continue;
    }
    ++finite;
    sum += value;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  std::string out = "  " + column(image.channels[channel], 12);
  if (finite > 0)
    out += "min " + column(formatted("%.6g", low), 14) + "mean " +
           column(formatted("%.6g", sum / double(finite)), 14) + "max " + column(formatted("%.6g", high), 14);
  out += std::to_string(bad) + " not finite\n";
  return out;
}

std::string pixelReport(const std::string& fileName, const std::string& pixel) {
  const Image image = readImage(fileName);
  const std::array<int, 2> at = parsePixel("--pixel", pixel, {0, 0, image.width, image.height});
  std::string out;
  for (size_t channel = 0; channel < image.channels.size(); ++channel)
    out += column(image.channels[channel], 26) + formatted("%.9g", double(image.at(at[0], at[1])[channel])) +
           "\n";
  return out;
}

std::string imageReport(const std::string& fileName) {
  const Image image = readImage(fileName);
  std::string out = fileName + "\n  " + column("size", 12) + std::to_string(image.width) + "x" +
                    std::to_string(image.height) + " pixels, " + std::to_string(image.channels.size()) +
                    (image.channels.size() == 1 ? " channel\n" : " channels\n");
  for (size_t channel = 0; channel < image.channels.size(); ++channel) out += channelLine(image, channel);
  for (const auto& [name, value] : image.metadata) out += "  " + column(name, 22) + value + "\n";
  return out;
}

} // namespace

void addInfoCommand(CLI::App& app, Command& chosen) {
  auto fileName = std::make_shared<std::string>();
  auto pixel = std::make_shared<std::string>();
  auto lenient = std::make_shared<bool>(false);
  auto model = std::make_shared<ModelChoice>();
  CLI::App* command = app.add_subcommand("info", "Describe a picture or a scene file");
  command->add_option("file", *fileName, "A picture, or a scene file (.pbrt, .pbrt.gz)")
      ->required()
      ->type_name("FILE");
  command
      ->add_option("--pixel", *pixel,
                   "Print only the values of this pixel of the picture, counted from the top left")
      ->type_name("X,Y");
  model->addTo(*command);
  command->add_flag("--lenient", *lenient, "Unknown parameters in the scene are warnings instead of errors");
  command->footer("For a picture: size, channels (linear values; not-finite values are counted), metadata.\n"
                  "For a scene: the report of 'recurse render --check'.\n\n"
                  "Examples:\n"
                  "  recurse info picture.exr\n"
                  "  recurse info picture.exr --pixel 120,80\n"
                  "  recurse info scene.pbrt");
  command->callback([fileName, pixel, lenient, model, &chosen] {
    chosen = [fileName, pixel, lenient, model] {
      if (!pixel->empty()) {
        print(pixelReport(*fileName, *pixel));
      } else if (isSceneFile(*fileName) || isModelFile(*fileName)) {
        LoadOverrides overrides;
        overrides.lenient = *lenient;
        overrides.model = *model;
        print(sceneReport(loadAndBuild(*fileName, overrides, {})));
      } else {
        print(imageReport(*fileName));
      }
      return ExitStatus::DONE;
    };
  });
}

} // namespace recurse::apps
