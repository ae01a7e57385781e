/** @file
 * Transforms: composed from the right, in double, with pbrt's conventions.
 */
#include "sceneTesting.h"

using namespace recurse;

namespace {

Mat4d shapeTransform(const std::string& directives) {
  const SceneDescription s = parseGood("WorldBegin " + directives + " Shape \"sphere\"");
  return s.shapes.at(0).worldFromObject;
}

void expectPoint(const Mat4d& m, const Vec3d& from, const Vec3d& to, double tolerance = 1e-12) {
  const Vec3d p = transformPoint(m, from);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(p[i], to[i], tolerance) << "component " << i;
}

} // namespace

TEST(Transforms, ComposeFromTheRight) {
  expectPoint(shapeTransform("Translate 1 2 3 Scale 2 2 2"), {1, 1, 1}, {3, 4, 5});
  expectPoint(shapeTransform("Scale 2 2 2 Translate 1 2 3"), {1, 1, 1}, {4, 6, 8});
  expectPoint(shapeTransform("Translate 9 9 9 Identity Translate 1 0 0"), {0, 0, 0}, {1, 0, 0});
}

TEST(Transforms, RotateCounterclockwiseInDegrees) {
  expectPoint(shapeTransform("Rotate 90 0 0 1"), {1, 0, 0}, {0, 1, 0}, 0);
  expectPoint(shapeTransform("Rotate 90 0 5 0"), {0, 0, 1}, {1, 0, 0}, 0);
  expectPoint(shapeTransform("Rotate 120 1 1 1"), {1, 0, 0}, {0, 1, 0});
  expectPoint(shapeTransform("Rotate 450 1e-200 0 0"), {0, 1, 0}, {0, 0, 1}, 0);
}

TEST(Transforms, MatricesAreColumnByColumn) {
  expectPoint(shapeTransform("Scale 5 5 5 Transform [1 0 0 0  0 2 0 0  0 0 1 0  7 8 9 1]"), {1, 1, 1},
              {8, 10, 10});
  expectPoint(shapeTransform("Translate 1 0 0 ConcatTransform [2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1]"), {1, 1, 1},
              {3, 2, 2});
  expectPoint(shapeTransform("Transform [2 0 0 0  0 2 0 0  0 0 2 0  2 0 0 2]"), {0, 0, 0}, {1, 0, 0});
}

TEST(Transforms, LookAtMakesTheCamera) {
  const SceneDescription s = parseGood("LookAt 1 2 3  1 2 10  0 1 0 Camera \"perspective\" WorldBegin");
  expectPoint(s.worldFromCamera, {0, 0, 0}, {1, 2, 3});
  expectPoint(s.worldFromCamera, {0, 0, 1}, {1, 2, 4});
  expectPoint(s.worldFromCamera, {0, 1, 0}, {1, 3, 3});
  expectPoint(s.worldFromCamera, {1, 0, 0}, {2, 2, 3});
  const SceneDescription mirrored =
      parseGood("Scale -1 1 1 LookAt 0 0 5 0 0 0 0 1 0 Camera \"perspective\" WorldBegin");
  // The camera's x axis points to the world's -x, and Scale mirrors it.
  expectPoint(mirrored.worldFromCamera, {1, 0, 1}, {1, 0, 4});
}

TEST(Transforms, LookAtComposesLikeTheOthers) {
  const SceneDescription s =
      parseGood("Translate 0 0 1 LookAt 0 0 0 0 0 1 0 1 0 Camera \"perspective\" WorldBegin");
  expectPoint(s.worldFromCamera, {0, 0, 1}, {0, 0, 0});
}

TEST(Transforms, CoordinateSystems) {
  const SceneDescription s =
      parseGood("Translate 0 0 -5 Camera \"perspective\" WorldBegin "
                "AttributeBegin CoordSysTransform \"camera\" Shape \"sphere\" AttributeEnd "
                "Translate 3 0 0 CoordinateSystem \"here\" Identity Shape \"sphere\" "
                "CoordSysTransform \"here\" Shape \"sphere\" "
                "CoordSysTransform \"world\" Shape \"sphere\"");
  expectPoint(s.shapes.at(0).worldFromObject, {0, 0, 0}, {0, 0, 5});
  expectPoint(s.shapes.at(1).worldFromObject, {0, 0, 0}, {0, 0, 0});
  expectPoint(s.shapes.at(2).worldFromObject, {0, 0, 0}, {3, 0, 0});
  expectPoint(s.shapes.at(3).worldFromObject, {0, 0, 0}, {0, 0, 0});
  EXPECT_CONTAINS(messages("WorldBegin CoordSysTransform \"wrold\""), "no coordinate system \"wrold\"");
}

TEST(Transforms, WorldBeginResets) {
  const SceneDescription s = parseGood("Translate 1 1 1 WorldBegin Shape \"sphere\"");
  expectPoint(s.shapes.at(0).worldFromObject, {0, 0, 0}, {0, 0, 0});
}

TEST(Transforms, BlocksRestore) {
  const SceneDescription s =
      parseGood("WorldBegin Translate 1 0 0 AttributeBegin Translate 1 0 0 TransformBegin Translate 1 0 0 "
                "TransformEnd Shape \"sphere\" AttributeEnd Shape \"sphere\"");
  expectPoint(s.shapes.at(0).worldFromObject, {0, 0, 0}, {2, 0, 0});
  expectPoint(s.shapes.at(1).worldFromObject, {0, 0, 0}, {1, 0, 0});
}

TEST(Transforms, MotionBlurIsRefusedWhereItIsUsed) {
  const char* const moving = "TransformTimes 0 1 WorldBegin ActiveTransform EndTime Translate 1 0 0 ";
  const SceneDescription s = parseGood(std::string(moving) + "Shape \"sphere\"");
  expectPoint(s.shapes.at(0).worldFromObject, {0, 0, 0}, {0, 0, 0});
  ASSERT_TRUE(s.shapes.at(0).worldFromObjectLast);
  expectPoint(*s.shapes.at(0).worldFromObjectLast, {0, 0, 0}, {1, 0, 0});
  EXPECT_EQ(messages(std::string(moving) + "Identity Shape \"sphere\""), "");
  EXPECT_EQ(messages(std::string(moving) + "ActiveTransform StartTime Translate 1 0 0 Shape \"sphere\""), "");
  EXPECT_EQ(messages(std::string(moving) + "ActiveTransform All"), "");
  EXPECT_TRUE(parseGood(std::string(moving) + "ObjectBegin \"o\" ObjectEnd ObjectInstance \"o\"")
                  .instances.at(0)
                  .worldFromInstanceLast);
  EXPECT_CONTAINS(messages(std::string(moving) + "LightSource \"point\""), "a LightSource does not move");
  EXPECT_CONTAINS(messages("TransformTimes 1 1"), "start < end");
}

TEST(Transforms, WhatCannotBeInvertedIsAnError) {
  EXPECT_CONTAINS(messages("Scale 1 0 1 Camera \"perspective\" WorldBegin"), "singular");
  EXPECT_CONTAINS(messages("Rotate 90 0 0 0 WorldBegin"), "axis");
  EXPECT_CONTAINS(messages("LookAt 0 0 0 0 0 0 0 1 0 WorldBegin"), "target other than the eye");
  EXPECT_CONTAINS(messages("LookAt 0 0 0 0 1 0 0 1 0 WorldBegin"), "up vector");
  EXPECT_CONTAINS(messages("Transform [1 0 0 0 2 0 0 0 0 0 1 0 0 0 0 1] Camera \"perspective\" WorldBegin"),
                  "singular");
  EXPECT_CONTAINS(messages("WorldBegin Transform [1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1] LightSource \"point\""),
                  "projection");
  EXPECT_CONTAINS(messages("WorldBegin Scale 1e300 1 1 Scale 1e300 1 1 Shape \"sphere\""), "overflows");
  EXPECT_CONTAINS(messages("Translate 1 2 WorldBegin"), "3 numbers");
  EXPECT_CONTAINS(messages("Translate 1 2 3 4 WorldBegin"), "takes 3 numbers");
  EXPECT_EQ(messages("Scale 1e-30 1e-30 1e-30 WorldBegin"), "");
}

TEST(Transforms, WhatPlacesNothingMayBeSingularOrProject) {
  const std::string flat = "WorldBegin AttributeBegin Scale 0 0 0 ",
                    projected = "WorldBegin AttributeBegin Transform [1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1] ";
  for (const std::string& begin : {flat, projected}) {
    EXPECT_EQ(messages(begin + "Material \"diffuse\" AttributeEnd Shape \"sphere\""), "");
    EXPECT_EQ(messages(begin + "Identity Shape \"sphere\" AttributeEnd"), "");
    EXPECT_EQ(messages(begin + "LightSource \"infinite\" AttributeEnd"), "");
    EXPECT_NE(messages(begin + "LightSource \"infinite\" \"string filename\" \"a.exr\" AttributeEnd"), "");
    EXPECT_NE(messages(begin + "Texture \"t\" \"float\" \"constant\" Shape \"sphere\" AttributeEnd"), "");
  }
  EXPECT_EQ(messages("Scale 0 0 0 WorldBegin Shape \"sphere\""), "");
}

TEST(Transforms, WhatMadeThemSingularIsToldOnceAndByItsPlace) {
  const std::string text =
      messages("WorldBegin\nTranslate 1 0 0\nScale 1 0 1\nTranslate 1 0 0\nShape \"sphere\"\nShape \"disk\"");
  EXPECT_CONTAINS(text, ":3:1: error: the current transform becomes singular");
  EXPECT_EQ(text.find("singular"), text.rfind("singular")) << text;
}
