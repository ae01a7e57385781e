/** @file
 * Examples of doc-files/first-plug-ins.md, and the integrators that are meant to be read.
 */
#include "rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

std::unique_ptr<Scene> exampleScene(int size) {
  Diagnostics diagnostics;
  const SceneDescription description =
      loadScene(RECURSE_SOURCE_DIR "/doc-files/examples/first.pbrt", diagnostics);
  SceneOverrides overrides;
  overrides.width = overrides.height = size;
  std::unique_ptr<Scene> scene = buildScene(description, overrides, diagnostics);
  EXPECT_FALSE(diagnostics.hasErrors()) << diagnostics.format();
  return scene;
}

} // namespace

TEST(Examples, TheirSceneIsTheSameByPathsFromTheCameraAndFromTheLights) {
  const auto scene = exampleScene(32);
  ASSERT_TRUE(scene);
  const Rendered path = renderScene(*scene, "path", "", samples(256)),
                 both = renderScene(*scene, "bdpt", "", samples(128));
  EXPECT_GT(path.mean(), 0.05);
  EXPECT_LT(path.standardError(), 0.03 * path.mean());
  EXPECT_NEAR(path.mean(), both.mean(), 4 * std::hypot(path.standardError(), both.standardError()));
}

TEST(Examples, SimplePhotonMapOfAWhiteRoomIsItsClosedForm) {
  // Inside of a sphere that emits E and reflects a half, the radiance is E / (1 - 1/2) everywhere, through
  // glass as well.
  const Rendered r =
      renderText(view(16, "0 -.9 0  0 0 0  0 0 1", 60) + R"(
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [ 1 2 3 ] "bool twosided" true
  Material "diffuse" "rgb reflectance" [ .5 .5 .5 ]
  Shape "sphere" "float radius" 1
AttributeEnd
Material "dielectric" "float eta" 1.5
Shape "sphere" "float radius" .3
)",
                 "simplephotonmap", "\"integer photons\" 40000 \"float radius\" .2", samples(16));
  Rgb mean(0);
  for (size_t i = 0; i < r.pixels(); ++i) mean += r.value(i) / float(r.pixels());
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean[c] / float(2 * (c + 1)), 1, 0.015);
}

TEST(Examples, SimplePhotonMapSeesTheRoomThatPathsSee) {
  const auto scene = exampleScene(24);
  ASSERT_TRUE(scene);
  const Rendered path = renderScene(*scene, "path", "", samples(256)),
                 map = renderScene(*scene, "simplephotonmap",
                                   "\"integer photons\" 300000 \"integer gatherphotons\" 60", samples(16));
  // Density estimates near edges miss photons beyond the edge: slightly darker.
  EXPECT_NEAR(map.mean() / path.mean(), 1, 0.02 + 4 * path.standardError() / path.mean());
}
