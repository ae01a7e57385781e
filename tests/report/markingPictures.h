/** @file
 * Pictures for tests of marks: stills, and what students make of them.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "recurse/report/stills/stills.h"
#include "sceneRendering.h"

namespace markingPictures {

using namespace recurse;

/** Stills of a scene with the default classes. */
inline Stills renderedStills(const std::string& text, int samples, uint64_t seed,
                             const std::string& integratorName = "path", const std::string& parameters = "") {
  const StillsPlan plan = planStills(defaultStillClasses());
  const auto scene = recurse::testing::sceneFrom(text);
  const auto integrator = recurse::testing::integratorFrom(integratorName, parameters);
  return makeStills(
      recurse::testing::renderScene(*scene, *integrator, PathClasses(plan.classes), samples, seed).film, plan,
      1);
}

/** Sum of the layers, each with a factor that may depend on the pixel. */
template <class Factor> Image sumOfLayers(const Stills& stills, const Factor& factor) {
  Image out(stills.image.width, stills.image.height, {"R", "G", "B"});
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      for (size_t i = 1; i < stills.layers.size(); ++i)
        for (size_t c = 0; c < 3; ++c)
          out.at(x, y)[c] +=
              static_cast<float>(factor(stills.layers[i].name, x, y)) * stills.image.at(x, y)[3 * i + c];
  return out;
}

/** Noise in proportion to the light, as with fewer samples. */
inline Image grained(const Image& image, double deviation, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0, deviation);
  Image out = image;
  for (float& value : out.pixels) value *= static_cast<float>(std::max(0.0, 1 + normal(generator)));
  return out;
}

/** Picture after rounding to 8 bits. */
inline Image inEightBits(const Image& image) {
  Image out = image;
  out.fromIntegers = true;
  for (float& value : out.pixels)
    value = linearFromSrgb(std::round(255 * srgbFromLinear(std::clamp(value, 0.0f, 1.0f))) / 255);
  return out;
}

/** Stills of uniform layers with noise, without rendering. */
inline Stills syntheticStills(const std::vector<Image>& layers, const std::vector<std::string>& names) {
  std::vector<std::string> channels = {"R", "G", "B"};
  std::string classes;
  for (const std::string& name : names) {
    for (const char* c : {".R", ".G", ".B"}) channels.push_back(name + c);
    classes += (classes.empty() ? "" : "; ") + name + " = " + name;
  }
  Image image(layers[0].width, layers[0].height, channels);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (size_t i = 0; i < layers.size(); ++i)
        for (size_t c = 0; c < 3; ++c) {
          image.at(x, y)[3 * (i + 1) + c] = layers[i].at(x, y)[c];
          image.at(x, y)[c] += layers[i].at(x, y)[c];
        }
  image.metadata["recurse:classes"] = classes;
  return stillsOf(image, "synthetic");
}

/** Slowly varying light: waves of a length in pixels. */
inline Image waves(double level, double length, double phase) {
  Image image(64, 48, {"R", "G", "B"});
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (size_t c = 0; c < 3; ++c)
        image.at(x, y)[c] = static_cast<float>(
            level * (1 + 0.8 * std::sin((x + 0.4 * y) / length + phase + double(c)) * std::cos(y / length)));
  return image;
}

} // namespace markingPictures
