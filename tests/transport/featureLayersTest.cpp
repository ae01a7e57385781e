/** @file
 * Feature layers against the geometry of simple scenes.
 */
#include "transport/rendering.h"

#include "guidedScenes.h"
#include "recurse/render/featureLayers.h"

using namespace recurse;

namespace {

Image features(const std::string& text, FeatureSettings settings) {
  const auto scene = recurse::testing::sceneFrom(text);
  const auto path = recurse::testing::integratorFrom("path", "");
  return renderFeatures(*scene, *path, settings);
}

std::vector<std::string> allLayers() {
  std::vector<std::string> names;
  for (const FeatureLayer& layer : featureLayers())
    if (*layer.channels && layer.isOfScene) names.emplace_back(layer.name); // without the mattes
  return names;
}

const std::string SMALL_FILM = "Film \"rgb\" \"integer xresolution\" 33 \"integer yresolution\" 33\n"
                               "LookAt 1 2 -5  1 2 0  0 1 0\nCamera \"perspective\" \"float fov\" 40\n";
/** A wall at z = 3, eight units in front of the camera. */
const std::string BACK_WALL =
    "Material \"diffuse\" \"rgb reflectance\" [.8 .4 .1]\n"
    "Shape \"bilinearmesh\" \"point3 P\" [-20 -20 3  20 -20 3  -20 20 3  20 20 3]\n";

} // namespace

TEST(FeatureLayers, OfAWallAreItsGeometry) {
  const Image f = features(SMALL_FILM + "WorldBegin\n" + BACK_WALL, {allLayers(), 4, false, 1});
  ASSERT_EQ(f.channels, (std::vector<std::string>{"albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y",
                                                  "normal.Z", "geonormal.X", "geonormal.Y", "geonormal.Z",
                                                  "depth.Z", "position.X", "position.Y", "position.Z"}));
  for (int x : {0, 16, 30}) {
    const float* p = f.at(x, 16);
    EXPECT_NEAR(p[0], 0.8f, 1e-4f);
    EXPECT_NEAR(p[2], 0.1f, 1e-4f);
    EXPECT_NEAR(p[5], -1, 1e-5f);
    EXPECT_NEAR(p[8], -1, 1e-5f);
    // Value at the pixel's centre; the layer has the mean over the pixel.
    const float across = std::abs(float(x) + 0.5f - 16.5f) / 16.5f * std::tan(0.349066f);
    EXPECT_NEAR(p[9], 8 * std::sqrt(1 + across * across), 0.02f) << x;
    EXPECT_NEAR(std::abs(p[10] - 1), 8 * across, 0.1f) << x;
    EXPECT_NEAR(p[12], 3, 1e-4f);
  }
}

TEST(FeatureLayers, NothingIsBlackAndEdgesAreMeansOfWhatIsThere) {
  const Image f = features(SMALL_FILM + "WorldBegin\n" + "Translate 1 2 0\n" +
                               "Material \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\nShape \"sphere\"\n",
                           {{"albedo", "depth"}, 16, false, 1});
  EXPECT_EQ(f.at(0, 0)[0], 0);
  EXPECT_EQ(f.at(0, 0)[3], 0);
  EXPECT_NEAR(f.at(16, 16)[3], 4, 0.01f);
  int edges = 0;
  for (int x = 0; x < 33; ++x) {
    const float albedo = f.at(x, 16)[0], depth = f.at(x, 16)[3];
    if (albedo > 0.01f && albedo < 0.49f) {
      ++edges;
      EXPECT_GT(depth, 4.5f); // not mixed with the empty background
      EXPECT_LT(depth, 5.1f);
    }
  }
  EXPECT_GT(edges, 0);
}

TEST(FeatureLayers, MirrorsAndGlassAreLookedThroughOnRequest) {
  const std::string mirror = "Material \"conductor\" \"rgb reflectance\" [1 1 1]\n"
                             "Shape \"bilinearmesh\" \"point3 P\" [-9 -9 0  9 -9 0  -9 9 0  9 9 0]\n";
  const std::string behind =
      "Material \"diffuse\" \"rgb reflectance\" [.8 .4 .1]\n"
      "Shape \"bilinearmesh\" \"point3 P\" [-20 -20 -9  20 -20 -9  -20 20 -9  20 20 -9]\n";
  const Image in = features(SMALL_FILM + "WorldBegin\n" + mirror + behind, {{"albedo", "depth"}, 4, true, 1});
  EXPECT_NEAR(in.at(16, 16)[0], 0.8f, 1e-4f);
  EXPECT_NEAR(in.at(16, 16)[3], 5 + 9, 0.02f); // distance to the mirror and back
  const Image on =
      features(SMALL_FILM + "WorldBegin\n" + mirror + behind, {{"albedo", "depth"}, 4, false, 1});
  EXPECT_NEAR(on.at(16, 16)[0], 1, 0.02f);
  EXPECT_NEAR(on.at(16, 16)[3], 5, 0.02f);
}

TEST(FeatureLayers, AlbedoOfGlassIsAllTheLight) {
  const Image f =
      features(SMALL_FILM + "WorldBegin\nTranslate 1 2 0\nMaterial \"dielectric\"\nShape \"sphere\"\n",
               {{"albedo"}, 16, false, 1});
  EXPECT_NEAR(f.at(16, 16)[1], 1, 1e-4f);
}

namespace {

/** Layer of the guide after a render of 16 samples. */
Image guideLayer(const std::string& text) {
  const auto scene = recurse::testing::sceneFrom(text);
  const auto path = recurse::testing::integratorFrom("path", "\"bool guided\" true");
  recurse::testing::renderScene(*scene, *path, PathClasses(), 16, 1);
  return renderFeatures(*scene, *path, {{"guide"}, 4, false, 1});
}

} // namespace

TEST(FeatureLayers, TheGuideIsOneWhereItIsSampledAndZeroWhereItIsOff) {
  const Image below = guideLayer(recurse::testing::floorBelowHole(0.3));
  EXPECT_EQ(below.channels, std::vector<std::string>{"guide.Y"});
  for (const float share : below.pixels) EXPECT_EQ(share, 1);
  for (const float share : guideLayer(recurse::testing::floorBelowHole(0)).pixels) EXPECT_EQ(share, 0);
}

TEST(FeatureLayers, TheGuideIsSeenInAMirror) {
  // A small mirror in front of the middle of the floor shows the floor in front of it.
  const std::string mirror =
      "Material \"conductor\" \"rgb reflectance\" [1 1 1]\n"
      "Shape \"bilinearmesh\" \"point3 P\" [-.05 .02 -.3  .05 .02 -.3  -.05 .08 -.3  .05 .08 -.3]\n";
  for (const float share : guideLayer(recurse::testing::floorBelowHole(0.3) + mirror).pixels)
    EXPECT_EQ(share, 1);
}

TEST(FeatureLayers, TheGuideNeedsAnIntegratorThatLearns) {
  EXPECT_THROW(features(recurse::testing::floorBelowHole(0.3), {{"guide"}, 1, false, 1}), Error);
}
