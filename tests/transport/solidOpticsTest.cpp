/** @file
 * Light through constructive solids: a lens has its focus by the lensmaker's equation, a solid looks like its
 * mesh, and the caustic of moving glass is the same by paths and by photons.
 */
#include "classRendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Root mean square distance from the axis of the light behind a plano-convex lens of radius 1, on a screen
 * at the distance `below` from its flat side. */
double spotRadius(double below) {
  constexpr int SIZE = 32;
  constexpr double HALF = .08;
  const std::string n = std::to_string(SIZE), w = std::to_string(HALF), z = std::to_string(-below);
  const std::string aperture = ".1", height = ".00501256289"; // height of the dome, 1 - sqrt(1 - .1²)
  const Rendered picture = renderText(
      "Film \"rgb\" \"integer xresolution\" " + n + " \"integer yresolution\" " + n +
          "\nPixelFilter \"box\"\nLookAt 0 0 -.5  0 0 -1  0 1 0\n"
          "Camera \"orthographic\" \"float screenwindow\" [-" +
          w + " " + w + " -" + w + " " + w +
          "]\nWorldBegin\n"
          "LightSource \"distant\" \"point3 from\" [0 0 1] \"point3 to\" [0 0 0]\n"
          "ObjectBegin \"ball\" Translate 0 0 -1 Translate 0 0 " +
          height +
          " Shape \"sphere\" ObjectEnd\n"
          "ObjectBegin \"above\" Shape \"box\" \"point3 p1\" [-1 -1 0] \"point3 p2\" [1 1 1] ObjectEnd\n"
          "AttributeBegin Material \"dielectric\" \"float eta\" 1.5\n"
          "Shape \"csg\" \"string operation\" \"intersection\" \"string operands\" [\"ball\" \"above\"] "
          "\"bool onematerial\" true AttributeEnd\n"
          "Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n"
          "Shape \"disk\" \"float innerradius\" " +
          aperture +
          " \"float radius\" .3\n"
          "Material \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\n"
          "Shape \"disk\" \"float radius\" .2 \"float height\" " +
          z + "\n",
      "lightpath", "", 1024);
  double light = 0, moment = 0;
  for (int y = 0; y < SIZE; ++y)
    for (int x = 0; x < SIZE; ++x) {
      const double px = ((x + .5) / SIZE * 2 - 1) * HALF, py = ((y + .5) / SIZE * 2 - 1) * HALF;
      const double v = double(picture.value(size_t(y * SIZE + x)).g);
      light += v;
      moment += v * (px * px + py * py);
    }
  EXPECT_GT(light, 0);
  const double pixel = 2 * HALF / SIZE; // the second moment includes the width of a pixel
  return std::sqrt(moment / light - pixel * pixel / 6);
}

} // namespace

TEST(SolidOptics, ALensFocusesWhereTheLensmakersEquationSays) {
  // Light converges to a point: the radius is a linear function of the distance, with opposite sign beyond.
  const double before = 1.4, beyond = 2.6;
  const double a = spotRadius(before), b = spotRadius(beyond);
  const double focus = (before * b + beyond * a) / (a + b);
  // 1 / f = (n - 1) / r; measured from the flat side the focal distance is shorter because of the thickness
  // of the glass.
  const double thickness = 1 - std::sqrt(1 - .01), expected = 1 / .5 - thickness / 1.5;
  EXPECT_NEAR(focus, expected, .01 * expected);
  EXPECT_NEAR(a, .1 / std::sqrt(2.0) * (1 - before / expected), .03 * a);
}

TEST(SolidOptics, ASolidLooksLikeItsMesh) {
  // A cube with a quarter cut out, from two boxes and from the triangles of its twelve corners.
  const std::string rest = view(SANITIZED ? 16 : 32, "2.5 3 2  .5 .5 .4  0 0 1", 35) +
                           "LightSource \"infinite\" \"rgb L\" [.3 .4 .5]\n"
                           "LightSource \"point\" \"point3 from\" [3 1 4] \"rgb I\" [9 8 7]\n"
                           "Material \"diffuse\" \"rgb reflectance\" [.7 .5 .3]\n";
  const std::string solid =
      "ObjectBegin \"cube\" Shape \"box\" \"point3 p1\" [0 0 0] \"point3 p2\" [1 1 1] ObjectEnd\n"
      "ObjectBegin \"cut\" Shape \"box\" \"point3 p1\" [.5 .5 -1] \"point3 p2\" [2 2 2] ObjectEnd\n"
      "Shape \"csg\" \"string operation\" \"difference\" \"string operands\" [\"cube\" \"cut\"] "
      "\"bool onematerial\" true\n";
  // Floor and roof are three squares each, with walls around them.
  const std::string mesh =
      "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 .5 0 .5 .5 0 .5 1 0 0 1 0  "
      "0 0 1 1 0 1 1 .5 1 .5 .5 1 .5 1 1 0 1 1] \"integer indices\" [6 7 9 7 8 9 6 9 11 9 10 11  "
      "0 3 1 1 3 2 0 5 3 3 5 4  0 1 7 0 7 6  1 2 8 1 8 7  2 3 9 2 9 8  3 4 10 3 10 9  4 5 11 4 11 10  "
      "5 0 6 5 6 11]\n";
  for (const char* integrator : {"path", "raycast"}) {
    const Rendered a = renderText(rest + solid, integrator, "", 256),
                   b = renderText(rest + mesh, integrator, "", 256);
    for (size_t i = 0; i < a.pixels(); ++i)
      EXPECT_NEAR(a.value(i).g, b.value(i).g, 0.1f * b.value(i).g) << integrator << " " << i;
    EXPECT_NEAR(a.mean(), b.mean(), 0.003 * b.mean()) << integrator;
  }
}

TEST(SolidOptics, TheCausticOfMovingGlassIsTheSameByPathsAndByPhotons) {
  // The lamp is large, so that paths find it.
  const auto scene = sceneFrom(
      view(8, "0 -2.5 1.5  0 0 0  0 0 1", 40) +
      "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [5 5 5] Material \"diffuse\" \"rgb reflectance\" "
      "[0 0 0]\n"
      "Translate 0 0 2.5 ReverseOrientation Shape \"disk\" \"float radius\" 1.6 AttributeEnd\n"
      "Material \"diffuse\" \"rgb reflectance\" [.5 .5 .5] Shape \"disk\" \"float radius\" 3\n"
      "AttributeBegin ActiveTransform EndTime Translate .6 .2 .3 ActiveTransform All Translate -.3 0 .6\n"
      "Material \"dielectric\" Shape \"sphere\" \"float radius\" .4 AttributeEnd\n");
  ASSERT_TRUE(scene);
  const std::vector<PathClass> caustic = {{"caustic", "LS+DE"}};
  const PathClasses caustics(caustic);
  const BatchMeans paths = classMeans(*scene, {"path", ""}, caustics, 512, 6);
  const BatchMeans photons =
      classMeans(*scene, {"photonmap", "\"integer photons\" 20000 \"integer passes\" 16"}, caustics, 64, 6);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_GT(paths.mean(i), 0.01);
    const double error = std::hypot(paths.standardError(i), photons.standardError(i));
    EXPECT_NEAR(photons.mean(i), paths.mean(i), 4 * error + 0.02 * paths.mean(i)) << i;
    EXPECT_LT(error, 0.03 * paths.mean(i)) << i << " " << paths.standardError(i) / paths.mean(i) << " "
                                           << photons.standardError(i) / paths.mean(i);
  }
}
