/** @file
 * Warnings about boundaries of media that are not closed, and none about closed ones.
 */
#include <gtest/gtest.h>

#include "recurse/model/scene/scene.h"
#include "recurse/scene/directives/loader.h"

using namespace recurse;

namespace {

/** Warnings of a scene with the media "m" and "n". */
std::string warningsOf(const std::string& shapes) {
  Diagnostics diagnostics;
  const std::string text = "LookAt 90 80 70 0 0 0 0 0 1 Camera \"perspective\"\nWorldBegin\n"
                           "MakeNamedMedium \"m\" \"string type\" \"homogeneous\"\n"
                           "MakeNamedMedium \"n\" \"string type\" \"homogeneous\"\n"
                           "MediumInterface \"m\" \"\"\nMaterial \"interface\"\n" +
                           shapes;
  const SceneDescription description = parseScene(text, "test.pbrt", ".", diagnostics);
  EXPECT_TRUE(buildScene(description, {}, diagnostics)) << diagnostics.format();
  return diagnostics.format();
}

void expectClosed(const std::string& shapes) { EXPECT_EQ(warningsOf(shapes), "") << shapes; }

/** Expects one warning, by default at line 7. */
void expectOpen(const std::string& shapes, int edges, int line = 7) {
  const std::string told = warningsOf(shapes), title = "warning: the boundary between ";
  EXPECT_NE(told.find("test.pbrt:" + std::to_string(line) + ":7: " + title), std::string::npos)
      << told << shapes;
  EXPECT_NE(told.find(": " + std::to_string(edges) + (edges == 1 ? " edge is open" : " edges are open")),
            std::string::npos)
      << told << shapes;
  EXPECT_EQ(told.find(title), told.rfind(title)) << told;
}

const std::string CUBE_POINTS = "\"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1]\n";
const std::string SIX_FACES[] = {"0 2 3 0 3 1", "4 5 7 4 7 6", "0 1 5 0 5 4",
                                 "2 6 7 2 7 3", "0 4 6 0 6 2", "1 3 7 1 7 5"};

std::string mesh(const std::string& indices) {
  return "Shape \"trianglemesh\" \"integer indices\" [" + indices + "] " + CUBE_POINTS;
}

/** Faces of a cube from `first` on, each as a separate mesh. */
std::string faces(size_t first) {
  std::string out;
  for (size_t i = first; i < 6; ++i) out += mesh(SIX_FACES[i]);
  return out;
}

std::string quad(const std::string& corners) {
  return "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [" + corners + "]\n";
}

const std::string SIDES = "Shape \"cylinder\"\n", TOP = "Shape \"disk\" \"float height\" 1\n",
                  BOTTOM = "ReverseOrientation\nShape \"disk\" \"float height\" -1\nReverseOrientation\n";

} // namespace

TEST(OpenBoundaries, ShapesThatCloseAreNotTold) {
  for (const char* shape : {"sphere", "box", "torus", "cylinder\" \"bool caps\" \"true", "loopsubdiv"}) {
    const std::string rest =
        shape == std::string("loopsubdiv")
            ? "\"integer indices\" [0 1 2 0 3 1 1 3 2 0 2 3] \"point3 P\" [0 0 0 1 0 0 0 1 0 0 0 1]"
            : "";
    expectClosed("Shape \"" + std::string(shape) + "\" " + rest + "\n");
  }
  std::string cube;
  for (const std::string& face : SIX_FACES) cube += face + " ";
  expectClosed(mesh(cube));
  // Each face has vertices of its own.
  expectClosed("Shape \"trianglemesh\" \"integer indices\" [0 2 1 3 4 5 6 7 8 9 10 11] \"point3 P\" [0 0 0 1 "
               "0 0 0 1 0 "
               "0 0 0 1 0 0 0 0 1  0 0 0 0 0 1 0 1 0  1 0 0 0 1 0 0 0 1]\n");
}

TEST(OpenBoundaries, ShapesThatCloseTogetherAreNotTold) {
  expectClosed(faces(0));
  expectClosed(SIDES + TOP + BOTTOM);
  std::string patches;
  for (const char* corners : {"0 1 2 3", "4 5 6 7", "0 1 4 5", "2 3 6 7", "0 2 4 6", "1 3 5 7"})
    patches += "Shape \"bilinearmesh\" \"integer indices\" [" + std::string(corners) + "] " + CUBE_POINTS;
  expectClosed(patches);
  // The top has two halves: its edges are parts of the edges of the sides.
  expectClosed(mesh(SIX_FACES[0]) + faces(2) + quad("0 0 1 .5 0 1 .5 1 1 0 1 1") +
               quad("1 0 1 .5 0 1 .5 1 1 1 1 1"));
  // A face of opposite orientation with exchanged media.
  expectClosed(faces(1) + "ReverseOrientation\nMediumInterface \"\" \"m\"\n" + mesh(SIX_FACES[0]));
  // Two media with a common wall.
  expectClosed(faces(1) + "MediumInterface \"n\" \"\"\nScale 1 1 -1\nReverseOrientation\n" + faces(1) +
               "MediumInterface \"m\" \"n\"\n" + mesh(SIX_FACES[0]));
  expectClosed("ObjectBegin \"o\"\n" + faces(0) +
               "ObjectEnd\nRotate 20 1 2 3\nScale 1 2 3\nObjectInstance \"o\"\n");
}

TEST(OpenBoundaries, OpaqueSurfacesClose) {
  const std::string ground =
      "MediumInterface \"\" \"\"\nMaterial \"diffuse\"\n" + quad("-9 -9 0 9 -9 0 9 9 0 -9 9 0");
  expectClosed(faces(1) + ground);
  expectOpen(faces(1) + "MediumInterface \"\" \"\"\nMaterial \"thindielectric\"\n" +
                 quad("-9 -9 0 9 -9 0 9 9 0 -9 9 0"),
             4, 8);
  // Water in a basin.
  expectClosed(quad("0 0 .9 1 0 .9 1 1 .9 0 1 .9") + "MediumInterface \"\" \"\"\nMaterial \"diffuse\"\n" +
               mesh(SIX_FACES[0]) + faces(2));
}

TEST(OpenBoundaries, OpenOnesAreToldOnceWithTheirPlace) {
  expectOpen(quad("0 0 0 1 0 0 1 1 0 0 1 0"), 4);
  expectOpen(faces(1), 4, 8); // the first shape with an open edge
  expectOpen(mesh("0 3 1 " + SIX_FACES[1]), 7);
  expectOpen("Shape \"disk\"\n", 16);
  expectOpen(SIDES, 32);
  expectOpen(SIDES + TOP, 16);
  expectOpen("Shape \"sphere\" \"float zmax\" .5\n", 16);
  expectOpen("Shape \"sphere\" \"float phimax\" 90\n", 32);
  expectOpen("Shape \"torus\" \"float phimax\" 90\n", 32);
  expectOpen("Shape \"cone\"\n", 16);
  expectOpen("Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 1]\n", 4);
  expectOpen("Shape \"curve\" \"point3 P\" [0 0 0 1 0 0 1 1 0 1 1 1]\n", 1);
  expectOpen(
      "ObjectBegin \"o\"\nShape \"disk\"\nObjectEnd\nObjectInstance \"o\"\nTranslate 9 0 0\nObjectInstance "
      "\"o\"\n",
      16, 8);
  // One warning for each pair of media.
  const std::string two =
      warningsOf("Shape \"disk\"\nMediumInterface \"n\" \"m\"\nTranslate 0 0 1\nShape \"disk\"\n");
  EXPECT_NE(two.find("between empty space and medium \"m\""), std::string::npos) << two;
  EXPECT_NE(two.find("between medium \"m\" and medium \"n\""), std::string::npos) << two;
}

TEST(OpenBoundaries, ABoundaryOfVeryManyEdgesIsLookedAtInParts) {
  // 150,000 separate triangles.
  std::string points, indices;
  for (int i = 0; i < 150000; ++i) {
    const std::string x = std::to_string(i % 400), y = std::to_string(i / 400);
    points += " " + x + " " + y + " 0 " + x + ".5 " + y + " 0 " + x + " " + y + ".5 0";
    indices +=
        " " + std::to_string(3 * i) + " " + std::to_string(3 * i + 1) + " " + std::to_string(3 * i + 2);
  }
  const std::string told = warningsOf("Shape \"trianglemesh\" \"integer indices\" [" + indices +
                                      "] \"point3 P\" [" + points + "]\n");
  EXPECT_NE(told.find("test.pbrt:7:7: warning: the boundary between "), std::string::npos);
  EXPECT_NE(told.find(": at least 65536 edges are open"), std::string::npos) << told.substr(0, 300);
}

TEST(OpenBoundaries, TheSameMediumOnBothSidesIsNoBoundary) {
  expectClosed("MediumInterface \"m\" \"m\"\nMaterial \"diffuse\"\nShape \"disk\"\n" + faces(1));
}

TEST(CameraMedium, IsTheOneAroundTheCameraOrElseTheOneNamed) {
  std::string warnings;
  const auto build = [&](const std::string& beforeCamera, const std::string& shapes) {
    Diagnostics diagnostics;
    const std::string media = "MakeNamedMedium \"m\" \"string type\" \"homogeneous\"\n"
                              "MakeNamedMedium \"n\" \"string type\" \"homogeneous\"\n";
    const SceneDescription description = parseScene(
        media + beforeCamera + "Camera \"perspective\"\nWorldBegin\nMediumInterface \"\" \"\"\n" + shapes,
        "test.pbrt", ".", diagnostics);
    const auto scene = buildScene(description, {}, diagnostics);
    warnings = diagnostics.format();
    const uint16_t number = scene->cameraMedium();
    return number ? scene->mediumNames()[number - 1u] : std::string();
  };
  const std::string
      boundary = "AttributeBegin\nMaterial \"interface\"\nMediumInterface \"m\" \"\"\nShape \"sphere\"\n"
                 "AttributeEnd\n",
      pillar = "AttributeBegin\nMaterial \"diffuse\"\nTranslate 0 0 .5\nShape \"sphere\" \"float "
               "radius\" .3\nAttributeEnd\n",
      room = "AttributeBegin\nMaterial \"diffuse\"\nShape \"sphere\" \"float radius\" .5\nAttributeEnd\n",
      outside = "LookAt 0 0 -5 0 0 0 0 1 0\n", away = "LookAt 0 0 5 0 0 9 0 1 0\n",
      named = "MediumInterface \"\" \"n\"\n";
  for (const std::string& shapes : {boundary, pillar + boundary, boundary + pillar}) {
    EXPECT_EQ(build("", shapes), "m");
    EXPECT_NE(warnings.find("the camera is inside of medium \"m\", not of empty space"), std::string::npos)
        << warnings;
    EXPECT_NE(warnings.find("MediumInterface \"\" \"m\" before it"), std::string::npos) << warnings;
    EXPECT_EQ(build(named, shapes), "m");
    EXPECT_NE(warnings.find("inside of medium \"m\", not of medium \"n\""), std::string::npos) << warnings;
    for (const std::string& where : {outside, away}) {
      EXPECT_EQ(build(where, shapes), "");
      EXPECT_EQ(warnings, "");
    }
  }
  // A closed room hides the boundary.
  EXPECT_EQ(build("", room + boundary), "");
  EXPECT_EQ(warnings, "");
  EXPECT_EQ(build(named, room + boundary), "n");
  EXPECT_EQ(warnings, "");
  EXPECT_EQ(build("", "MediumInterface \"m\" \"m\"\n" + room), "m");
  EXPECT_EQ(build("", "Material \"subsurface\"\nShape \"sphere\"\n"), "");
  EXPECT_EQ(warnings, "");
}

TEST(CameraMedium, OpaqueWallsOfATubAreNoBoundaryOfItsWater) {
  const auto mediumOf = [](const std::string& camera) {
    Diagnostics diagnostics;
    const auto scene =
        buildScene(parseScene("MakeNamedMedium \"water\" \"string type\" \"homogeneous\"\n" + camera +
                                  "Camera \"perspective\"\nWorldBegin\nMediumInterface \"\" \"\"\n"
                                  "Material \"diffuse\"\nShape \"disk\" \"float radius\" 50\n"
                                  "Shape \"cylinder\" \"float zmin\" .1 \"float zmax\" 2\n"
                                  "Shape \"disk\" \"float height\" .1\nMediumInterface \"water\" \"\"\n"
                                  "Material \"dielectric\"\nShape \"disk\" \"float height\" 1.8\n",
                              "test.pbrt", ".", diagnostics),
                   {}, diagnostics);
    return scene->cameraMedium();
  };
  EXPECT_EQ(mediumOf("LookAt 4 0 1  0 0 1.5  0 0 1\n"), 0); // outside, below the water level
  EXPECT_EQ(mediumOf("LookAt 0 0 1.9  0 0 0  0 1 0\n"), 0);
  EXPECT_EQ(mediumOf("LookAt 0 0 1  0 0 0  0 1 0\n"), 1);
  EXPECT_EQ(mediumOf("LookAt 0 0 1  0 0 3  0 1 0\n"), 1);
}
