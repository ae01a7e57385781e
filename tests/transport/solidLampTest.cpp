/** @file
 * Emissive solids, against lamps made of their surfaces.
 */
#include "rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Half a spheroid and its disc above a floor, with the camera below the lamp. */
std::string floorUnderLamp(const std::string& lamp) {
  return "Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4\nPixelFilter \"box\"\n"
         "LookAt 0 0 .5  0 0 0  0 1 0 Camera \"orthographic\" \"float screenwindow\" [-2 2 -2 2]\n"
         "WorldBegin Material \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\nShape \"disk\" \"float radius\" 9\n"
         "ObjectBegin \"ball\" Shape \"sphere\" ObjectEnd\n"
         "ObjectBegin \"half\" Shape \"box\" \"point3 p1\" [-1.1 -1.1 0] \"point3 p2\" [1.1 1.1 1.1] "
         "ObjectEnd\n"
         "ObjectBegin \"other half\" Shape \"box\" \"point3 p1\" [-1.1 -1.1 -1.1] \"point3 p2\" [1.1 1.1 0] "
         "ObjectEnd\n"
         "AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n"
         "Translate .5 .3 1.5 Rotate 200 1 .3 0 Scale .6 .6 .9\n" +
         lamp;
}

} // namespace

TEST(SolidLamp, LightsAsItsSurfacesDo) {
  const Rendered expected =
      renderText(floorUnderLamp("Shape \"sphere\" \"float zmin\" 0\nReverseOrientation Shape \"disk\"\n"),
                 "path", "", 4096);
  for (const char* operands : {"\"intersection\" \"string operands\" [\"ball\" \"half\"]",
                               "\"difference\" \"string operands\" [\"ball\" \"other half\"]"}) {
    const std::string lamp = std::string("Shape \"csg\" \"string operation\" ") + operands;
    for (const Way& way : {Way{"path", ""}, Way{"lightpath", ""}, Way{"bdpt", ""}}) {
      const Rendered picture = renderText(floorUnderLamp(lamp), way.integrator, way.parameters,
                                          way.integrator == std::string("bdpt") ? 4096 : 16384);
      EXPECT_NEAR(picture.mean(), expected.mean(), 0.015 * expected.mean()) << operands << way.integrator;
      if (way.integrator != std::string("path")) continue; // single pixels are noisy
      for (size_t i = 0; i < expected.pixels(); ++i)
        EXPECT_NEAR(picture.value(i).g, expected.value(i).g, 0.08f * expected.value(i).g)
            << operands << way.integrator << i;
    }
  }
}
