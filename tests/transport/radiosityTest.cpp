/** @file
 * Radiosity against closed forms and against `path` on matt surfaces.
 */
#include "classRendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** The inside of a cube of edge 2; `walls` precedes each wall of two triangles. */
std::string box(const std::string& walls) {
  const auto wall = [](const char* points) {
    return "Shape \"trianglemesh\" \"integer indices\" [ 0 1 2  0 2 3 ] \"point3 P\" [ " +
           std::string(points) + " ]\n";
  };
  return walls + wall("-1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1") + wall("-1 -1 1  -1 1 1  1 1 1  1 -1 1") +
         wall("-1 -1 -1  -1 -1 1  1 -1 1  1 -1 -1") + wall("-1 1 -1  1 1 -1  1 1 1  -1 1 1") +
         wall("-1 -1 -1  -1 1 -1  -1 1 1  -1 -1 1") + wall("1 -1 -1  1 -1 1  1 1 1  1 1 -1");
}

/** A room of triangles with a lamp, 2 wide, open to the camera. */
std::string mattRoom(const std::string& things) {
  return view(16, "0 -2.8 .1  0 0 0  0 0 1", 50) + R"(
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 9 8 7 ]
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -.4 -.4 .9  -.4 .4 .9  .4 .4 .9  .4 -.4 .9 ]
AttributeEnd
Material "diffuse" "rgb reflectance" [ .7 .5 .3 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 1  -1 1 1  1 1 1  1 -1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 1 -1  1 1 -1  1 1 1  -1 1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  -1 1 -1  -1 1 1  -1 -1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ 1 -1 -1  1 -1 1  1 1 1  1 1 -1 ]
)" + things;
}

} // namespace

/** If all surfaces emit E and reflect ρ, the radiance is E / (1 - ρ) everywhere: in an empty box, and with
 * two cubes that touch at a corner. */
TEST(Radiosity, FurnaceOfAClosedBox) {
  const ThreadPool pool;
  const auto cube = [](const char* place) {
    return std::string("AttributeBegin\nTranslate ") + place + "\nScale .1 .1 .1\nReverseOrientation\n" +
           box("") + "AttributeEnd\n";
  };
  const std::string cubes = cube(".5 .1 0") + cube(".7 .3 .2");
  for (const auto& [albedo, more] : {std::pair<double, std::string>{0.5, ""}, {0.8, ""}, {0.8, cubes}}) {
    const auto scene = sceneFrom(
        view(12, "0 0 0  1 .3 .2  0 0 1", 80) +
        box("AreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ]\nMaterial \"diffuse\" \"rgb reflectance\" [ " +
            std::to_string(albedo) + " " + std::to_string(albedo) + " 0 ]\n") +
        more);
    const Rendered r = renderScene(
        *scene, "radiosity", "\"float patchsize\" .5 \"integer rays\" " + std::to_string(samples(400000)),
        samples(64));
    for (size_t p = 0; p < r.pixels(); ++p) {
      // The direct light of a pixel is noisy.
      EXPECT_NEAR(r.value(p).g, 1 / (1 - albedo), (SANITIZED ? 0.3 : 0.06) / (1 - albedo)) << albedo;
      EXPECT_NEAR(r.value(p).b, 1, 1e-5);
    }
    EXPECT_NEAR(r.mean() - 0.0722, 0.9278 / (1 - albedo), 0.01 * 0.9278 / (1 - albedo));
  }
}

/** Furnace inside of further shapes, also with edges between different kinds of patches. */
TEST(Radiosity, FurnaceOfShapes) {
  const ThreadPool pool;
  const std::string inside = "ReverseOrientation\n";
  const std::pair<const char*, std::string> shapes[] = {
      {"sphere", inside + "Shape \"sphere\""},
      {"ellipsoid", inside + "Scale 1 .5 2\nShape \"sphere\""},
      {"box", inside + "Shape \"box\""},
      {"cylinder", inside + "Shape \"cylinder\" \"bool caps\" true"},
      {"bilinear patches",
       inside + "Shape \"bilinearmesh\" \"integer indices\" [ 0 2 1 3  4 5 6 7  0 1 4 5  "
                "2 6 3 7  0 4 2 6  1 3 5 7 ] \"point3 P\" [ -1 -1 -1  1 -1 -1  -1 1 -1  1 1 -1  "
                "-1 -1 1  1 -1 1  -1.5 1 1.5  1 1 1 ]"},
      {"halves", inside + "Shape \"sphere\" \"float zmax\" 0\n"
                          "Shape \"cone\"\n"}};
  for (const auto& [name, shape] : shapes) {
    const auto scene = sceneFrom(view(12, "0 0 0  1 .3 .2  0 0 1", 80) +
                                 "AreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ]\n"
                                 "Material \"diffuse\" \"rgb reflectance\" [ .5 .5 0 ]\n" +
                                 shape);
    ASSERT_TRUE(scene) << name;
    const Rendered r = renderScene(
        *scene, "radiosity", "\"float patchsize\" .3 \"integer rays\" " + std::to_string(samples(400000)),
        samples(64));
    EXPECT_TRUE(r.statistics.warnings.empty()) << name;
    for (size_t p = 0; p < r.pixels(); ++p) EXPECT_NEAR(r.value(p).g, 2, SANITIZED ? 0.6 : 0.15) << name;
    EXPECT_NEAR(r.mean() - 0.0722, 0.9278 * 2, 0.01 * 2) << name;
  }
}

TEST(Radiosity, IsPathTracingOfMattRooms) {
  const ThreadPool pool;
  const std::string triangles = R"(
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -.5 -.5 -.5  .1 -.5 -.5  .1 .2 -.3  -.5 .2 -.3 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1 ]
)";
  const std::string shapes = R"(
Shape "bilinearmesh" "point3 P" [ -1 -1 -1  1 -1 -1  -1 1 -1  1 1 -1 ] "point2 uv" [ 0 0  0 3  3 0  3 3 ]
Shape "bilinearmesh" "point3 P" [ -.9 -.3 -.8  -.3 -.3 -.4  -.9 .5 .1  -.3 .5 -.7 ]
AttributeBegin
Translate .5 .3 -.7
Shape "sphere" "float radius" .3
Translate -.5 -.6 0
Shape "box" "point3 p1" [ -.2 -.2 -.3 ] "point3 p2" [ .15 .2 .1 ]
AttributeEnd
)";
  const std::string leaves = R"(
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  1 -1 -1  1 1 -1  -1 1 -1 ]
Texture "holes" "float" "checkerboard" "float tex1" 0 "float tex2" 1 "float uscale" 7 "float vscale" 7
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point2 uv" [ 0 0  1 0  1 1  0 1 ] "texture alpha" "holes"
  "point3 P" [ -.9 .2 -.9  .9 .2 -.9  .9 .2 .9  -.9 .2 .9 ]
Shape "disk" "float radius" .3 "float height" -.1 "float alpha" .5
)";
  const PathClasses classes(
      {{"lamp", "LE"}, {"direct", "LDE"}, {"two", "LDDE"}, {"three", "LDDDE"}, {"more", "LDDDD+E"}});
  for (const std::string& things : {triangles, shapes, leaves}) {
    const auto scene = sceneFrom(mattRoom(things));
    ASSERT_TRUE(scene);
    const Way way{"radiosity", "\"float patchsize\" .15 \"integer rays\" " + std::to_string(samples(400000))};
    const BatchMeans means = classMeans(*scene, way, classes, samples(32), 4),
                     truth = classMeans(*scene, {"path", ""}, classes, samples(256), 8);
    constexpr double MESH_ERROR = 0.02;
    for (size_t i = 0; i < 3 * classes.layerCount(); ++i) {
      const double error = std::hypot(means.standardError(i), truth.standardError(i));
      EXPECT_NEAR(means.mean(i), truth.mean(i), 5 * error + MESH_ERROR * truth.mean(i))
          << classes.classes()[i / 3].name << things;
      EXPECT_LT(error, (SANITIZED ? 0.1 : 0.03) * truth.mean(i)) << classes.classes()[i / 3].name;
    }
  }
}

TEST(Radiosity, SaysWhatItIgnores) {
  const auto scene =
      sceneFrom(litCorner(8) + "Material \"conductor\"\nShape \"trianglemesh\" \"integer indices\" "
                               "[ 0 1 2 ] \"point3 P\" [ 0 0 1  1 0 1  0 1 1 ]\n");
  const Rendered r = renderScene(*scene, "radiosity", "\"integer rays\" 1000", 1);
  ASSERT_EQ(r.statistics.warnings.size(), 1u);
  EXPECT_NE(r.statistics.warnings[0].find("1 of the scene's shapes"), std::string::npos);
}

TEST(Radiosity, TooSmallPatchesAreRefusedBeforeTheyAreMade) {
  const auto scene = sceneFrom(mattRoom(""));
  const auto told = [&](const std::string& patchSize) -> std::string {
    try {
      renderScene(*scene, "radiosity", "\"integer rays\" 100 \"float patchsize\" " + patchSize, 1);
    } catch (const Error& e) {
      return e.what();
    }
    return {};
  };
  EXPECT_EQ(told(".5"), "");
  EXPECT_NE(told("1e-6").find("\"patchsize\" 1e-06 makes"), std::string::npos) << told("1e-6");
}
