/** @file
 * Statistics of kernel radii: known ratios to the width of a pixel.
 */
#include "rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

constexpr double RADIUS = 0.6, PIXEL = 2.0 / 16; ///< width of a pixel of the orthographic camera

/** A floor seen from above, and a wall that reflects light onto it. */
std::string floorFromAbove() {
  return view(16, 16, "0 0 5  0 0 0  0 1 0", "Camera \"orthographic\"") + R"(
Material "diffuse" "rgb reflectance" [ .7 .7 .7 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -3 -3 0  3 -3 0  3 3 0  -3 3 0 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -3 2 0  3 2 0  3 2 4  -3 2 4 ]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 20 20 20 ]
Translate -2 0 3
Shape "sphere" "float radius" .2
AttributeEnd
)";
}

KernelRadii radii(const char* integrator, const std::string& parameters) {
  return renderText(floorFromAbove(), integrator, parameters, 1).statistics.counts.otherRadii;
}

} // namespace

TEST(KernelRadii, AreCountedInWidthsOfAPixel) {
  const std::string one =
      "\"integer passes\" 1 \"integer photons\" 20000 \"bool edges\" false \"float radius\" ";
  const KernelRadii wide = radii("photonmap", one + number(RADIUS)), narrow = radii("photonmap", one + "0.1");
  EXPECT_EQ(wide.count(), 256u);
  EXPECT_EQ(wide.bins[3], 256u); // 4.8 is in [4, 8)
  EXPECT_NEAR(wide.mean(), RADIUS / PIXEL, 1e-4);
  EXPECT_EQ(narrow.bins[0], 256u); // 0.8
  EXPECT_EQ(radii("path", "").count(), 0u);
}

TEST(KernelRadii, OfManyPassesShrinkWithTheRadius) {
  KernelRadii expected;
  const double areas[] = {1, (1 + 0.5) / 2, (1 + 0.5) / 2 * (2 + 0.5) / 3};
  for (const double area : areas) expected.add(static_cast<float>(RADIUS * std::sqrt(area)), float(PIXEL));
  const KernelRadii found = renderText(floorFromAbove(), "sppm",
                                       "\"integer photonsperiteration\" 20000 \"bool edges\" false "
                                       "\"float alpha\" .5 \"integer finalgather\" 0 \"float radius\" " +
                                           number(RADIUS),
                                       3)
                                .statistics.counts.otherRadii;
  EXPECT_EQ(found.count(), 3u * 256);
  EXPECT_NEAR(found.mean(), expected.mean(), 1e-3);
}
