/** @file
 * Work after the samples of a render (feature layers, the explanation of a black picture) stops on request.
 */
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "apps/run/blackPicture.h"
#include "apps/run/renderOutput.h"
#include "recurse/scene/directives/loader.h"

using namespace recurse;
using namespace recurse::apps;

namespace {

/** Each ray intersects thousands of surfaces. */
std::string slowRays() {
  std::string text =
      "Film \"rgb\" \"integer xresolution\" 64 \"integer yresolution\" 64\nLookAt 0 0 -5  0 0 0  0 1 0\n"
      "Camera \"perspective\" \"float fov\" 10\nWorldBegin\nLightSource \"point\"\n"
      "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ .001 .001 .001 ] \"rgb "
      "sigma_s\" [ 0 0 0 ]\nMaterial \"interface\"\n"
      "MediumInterface \"m\" \"\"\n";
  for (int i = 0; i < 1500; ++i) text += "Shape \"sphere\" \"float radius\" 1\n";
  return text;
}

LoadedScene loadedFrom(const std::string& text) {
  const auto read = [&](Diagnostics& diagnostics) { return parseScene(text, "test", ".", diagnostics); };
  return loadAndBuild("test", read, LoadOverrides(), IntegratorOptions());
}

class WhatFollows : public ::testing::Test {
 protected:
  /** Calls work(stop) with a stop that is set from the beginning or after a while; fails if the work
   * continues for long. */
  template <class Work> void stops(const Work& work) {
    for (const bool atOnce : {true, false}) {
      std::atomic<bool> stop{atOnce};
      const auto start = std::chrono::steady_clock::now();
      std::jthread later([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
        stop = true;
      });
      work(stop);
      EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 4);
    }
  }
};

} // namespace

TEST_F(WhatFollows, FeatureLayersEndByAnInterrupt) {
  const LoadedScene loaded = loadedFrom(slowRays());
  for (const char* layer : {"depth", "cryptoobject"}) {
    FeatureSettings features;
    features.layers = {layer};
    stops([&](const std::atomic<bool>& stop) {
      Image image(64, 64, {"R", "G", "B"});
      EXPECT_FALSE(addFeatures(image, loaded, features, stop));
      EXPECT_EQ(image.channels.size(), 3u);
    });
  }
}

TEST_F(WhatFollows, TheReasonOfABlackPictureEndsByAnInterrupt) {
  const LoadedScene slow = loadedFrom(slowRays());
  const Film black(slow.scene->film().crop, 1);
  stops([&](const std::atomic<bool>& stop) {
    EXPECT_EQ(blackPictureText(slow, PathClasses(), black, stop), "");
  });
  const LoadedScene unlit = loadedFrom("WorldBegin\nShape \"sphere\"\n");
  EXPECT_EQ(blackPictureText(unlit, PathClasses(), black, std::atomic<bool>{true}), "");
  EXPECT_NE(blackPictureText(unlit, PathClasses(), black, std::atomic<bool>{false}), "");
}
