/** @file
 * Directives other than transforms: recorded data and scopes.
 */
#include "sceneTesting.h"

using namespace recurse;

namespace {

/** Objects nested in a number of levels, with an instance of the outermost in the world. */
std::string towerOfObjects(int levels) {
  std::string tower = "WorldBegin ObjectBegin \"0\" Shape \"a\" ObjectEnd ";
  for (int i = 0; i < levels; ++i)
    tower += "ObjectBegin \"" + std::to_string(i + 1) + "\" ObjectInstance \"" + std::to_string(i) +
             "\" ObjectEnd ";
  return tower + "ObjectInstance \"" + std::to_string(levels) + "\"";
}

} // namespace

TEST(Directives, Settings) {
  const SceneDescription s = parseGood(R"(
    Film "rgb" "integer xresolution" [ 10 ] "string filename" "a.exr"
    PixelFilter "box" Sampler "independent" "integer pixelsamples" 4
    Integrator "path" Accelerator "bvh" ColorSpace "sRGB"
    Camera "orthographic"
    WorldBegin)");
  EXPECT_EQ(s.film.type, "rgb");
  EXPECT_EQ(s.film.parameters.at(0).numbers.at(0), 10);
  EXPECT_EQ(s.film.parameters.at(1).strings.at(0), "a.exr");
  EXPECT_EQ(s.filter.type, "box");
  EXPECT_EQ(s.sampler.type, "independent");
  EXPECT_EQ(s.integrator.type, "path");
  EXPECT_EQ(s.accelerator.type, "bvh");
  EXPECT_EQ(s.camera.type, "orthographic");
  EXPECT_EQ(s.camera.location.line, 5);
  EXPECT_FALSE(parseGood("WorldBegin").camera.given());
}

TEST(Directives, TheLastOfTwoCamerasWins) {
  Diagnostics diagnostics;
  const SceneDescription s =
      parse("Camera \"perspective\" Translate 1 0 0 Camera \"orthographic\" WorldBegin", diagnostics);
  EXPECT_EQ(s.camera.type, "orthographic");
  EXPECT_EQ(s.worldFromCamera[3].x, -1);
  EXPECT_FALSE(diagnostics.hasErrors());
  EXPECT_CONTAINS(diagnostics.format(), "warning: this Camera replaces the one at test.pbrt:1");
}

TEST(Directives, CamerasWithDifferentNamesAreAllKept) {
  const std::string cameras =
      "MediumInterface \"fog\" Camera \"perspective\" \"string name\" \"door\" "
      "MediumInterface \"\" Translate 1 0 0 Camera \"orthographic\" \"string name\" \"plan\" "
      "Translate 1 0 0 Camera \"spherical\" WorldBegin "
      "CoordSysTransform \"camera\" Shape \"sphere\"";
  const auto chosen = [&](const std::string& name) {
    Diagnostics diagnostics;
    SceneDescription s = parseScene(cameras, "test.pbrt", "", diagnostics, name);
    EXPECT_EQ(diagnostics.format(), "");
    EXPECT_EQ(s.otherCameras.size(), 2u);
    EXPECT_EQ(s.shapes.at(0).worldFromObject, s.worldFromCamera) << name;
    return s;
  };
  for (const char* name : {"", "door", "attic"}) { // the first one if the name does not exist
    const SceneDescription door = chosen(name);
    EXPECT_EQ(door.camera.type, "perspective") << name;
    EXPECT_EQ(door.cameraName, "door");
    EXPECT_EQ(door.cameraMedium, "fog");
    EXPECT_EQ(door.worldFromCamera[3].x, 0);
    EXPECT_EQ(door.otherCameras.at(0).cameraName, "plan");
    EXPECT_EQ(door.otherCameras.at(1).cameraName, "");
  }
  const SceneDescription plan = chosen("plan");
  EXPECT_EQ(plan.camera.type, "orthographic");
  EXPECT_EQ(plan.cameraMedium, "");
  EXPECT_EQ(plan.worldFromCamera[3].x, -1);
  EXPECT_EQ(plan.otherCameras.at(0).cameraName, "door");
  EXPECT_EQ(plan.otherCameras.at(0).worldFromCamera[3].x, 0);
  EXPECT_CONTAINS(
      messages("Camera \"a\" \"string name\" \"x\" Camera \"b\" \"string name\" \"x\" WorldBegin"),
      "warning: this Camera replaces the one at test.pbrt:1");
}

TEST(Directives, Options) {
  const SceneDescription s = parseGood("Option \"seed\" 7 Option \"Disable-Pixel_Jitter\" true "
                                       "Option \"string mseReferenceImage\" \"a.exr\" WorldBegin");
  EXPECT_EQ(s.options.at("seed").numbers.at(0), 7);
  EXPECT_TRUE(s.options.at("disablepixeljitter").booleans.at(0));
  EXPECT_EQ(s.options.at("msereferenceimage").strings.at(0), "a.exr");
  EXPECT_CONTAINS(messages("Option \"seeed\" 7 WorldBegin"), "did you mean \"seed\"");
  EXPECT_CONTAINS(messages("Option \"force-diffuse\" true WorldBegin"), "\"forcediffuse\" has no effect");
  EXPECT_EQ(messages("Option \"forcediffuse\" false WorldBegin"), "");
  EXPECT_CONTAINS(messages("Option \"seed\" 7.5 WorldBegin"), "whole number");
  EXPECT_CONTAINS(messages("Option \"seed\" true WorldBegin"), "expected a number");
}

TEST(Directives, MaterialsScope) {
  const SceneDescription s = parseGood(R"(WorldBegin
    Shape "a"
    Material "conductor"
    AttributeBegin NamedMaterial "later" Shape "b" Material "" Shape "c" AttributeEnd
    Shape "d"
    Material "none" Shape "e" Material "interface" Shape "f"
    MakeNamedMaterial "later" "string type" [ "diffuse" ] "rgb reflectance" [ 1 0 0 ])");
  using Kind = MaterialReference::Kind;
  ASSERT_EQ(s.shapes.size(), 6u);
  EXPECT_EQ(s.shapes[0].material.kind, Kind::INDEX);
  EXPECT_EQ(s.materials.at(static_cast<size_t>(s.shapes[0].material.index)).type, "diffuse");
  EXPECT_EQ(s.shapes[1].material.kind, Kind::NAME);
  EXPECT_EQ(s.shapes[1].material.name, "later");
  EXPECT_EQ(s.shapes[1].material.location.line, 4);
  EXPECT_EQ(s.shapes[2].material.kind, Kind::NONE);
  EXPECT_EQ(s.materials.at(static_cast<size_t>(s.shapes[3].material.index)).type, "conductor");
  EXPECT_EQ(s.shapes[4].material.kind, Kind::NONE);
  EXPECT_EQ(s.shapes[5].material.kind, Kind::NONE);
  const ParsedDirective& later = s.namedMaterials.at("later");
  EXPECT_EQ(later.type, "diffuse");
  ASSERT_EQ(later.parameters.size(), 1u);
  EXPECT_EQ(later.parameters[0].name, "reflectance");
  EXPECT_CONTAINS(messages("WorldBegin MakeNamedMaterial \"m\" \"rgb reflectance\" [1 1 1]"),
                  "\"string type\"");
  EXPECT_CONTAINS(messages("WorldBegin MakeNamedMaterial \"m\" \"string type\" \"a\" "
                           "MakeNamedMaterial \"m\" \"string type\" \"a\""),
                  "already defined");
}

TEST(Directives, TexturesAndMaterialsShareNoNames) {
  const SceneDescription s = parseGood(R"(WorldBegin
    Translate 1 0 0
    Texture "a" "spectrum" "constant" "rgb value" [1 0 0]
    Texture "a" "float" "constant" "float value" 1
    MakeNamedMaterial "a" "string type" "diffuse" "texture reflectance" "a")");
  ASSERT_EQ(s.textures.size(), 2u);
  EXPECT_TRUE(s.textures[0].spectrum);
  EXPECT_EQ(s.textures[0].texture.type, "constant");
  EXPECT_EQ(s.textures[0].worldFromTexture[3].x, 1);
  EXPECT_FALSE(s.textures[1].spectrum);
  EXPECT_EQ(s.namedMaterials.at("a").parameters.at(0).strings.at(0), "a");
  EXPECT_CONTAINS(messages("WorldBegin Texture \"a\" \"float\" \"c\" Texture \"a\" \"float\" \"c\""),
                  "already defined, at test.pbrt:1");
  EXPECT_CONTAINS(messages("WorldBegin Texture \"a\" \"color\" \"c\""), "\"float\" \"spectrum\"");
}

TEST(Directives, AreaLightsScope) {
  const SceneDescription s = parseGood(R"(WorldBegin
    AttributeBegin AreaLightSource "diffuse" "rgb L" [1 1 1] Shape "a" Shape "b"
      AreaLightSource "" Shape "c" AttributeEnd
    Shape "d")");
  ASSERT_EQ(s.areaLights.size(), 1u);
  EXPECT_EQ(s.shapes.at(0).areaLight, 0);
  EXPECT_EQ(s.shapes.at(1).areaLight, 0);
  EXPECT_EQ(s.shapes.at(2).areaLight, -1);
  EXPECT_EQ(s.shapes.at(3).areaLight, -1);
}

TEST(Directives, LightsAndOrientation) {
  const SceneDescription s = parseGood(R"(WorldBegin
    AttributeBegin Translate 1 2 3 LightSource "point" "rgb I" [1 1 1] ReverseOrientation Shape "a" AttributeEnd
    Shape "b")");
  EXPECT_EQ(s.lights.at(0).light.type, "point");
  EXPECT_EQ(s.lights.at(0).worldFromLight[3].z, 3);
  EXPECT_TRUE(s.shapes.at(0).reverseOrientation);
  EXPECT_FALSE(s.shapes.at(1).reverseOrientation);
}

TEST(Directives, Media) {
  const SceneDescription s = parseGood(R"(
    MediumInterface "" "fog"
    MakeNamedMedium "fog" "string type" "homogeneous" "float scale" 2
    Camera "perspective"
    WorldBegin
    AttributeBegin MediumInterface "milk" "fog" Shape "a" MediumInterface "milk" Shape "b" AttributeEnd
    LightSource "point")");
  EXPECT_EQ(s.cameraMedium, "fog");
  EXPECT_EQ(s.media.at("fog").type, "homogeneous");
  EXPECT_EQ(s.worldFromMedium.count("fog"), 1u);
  EXPECT_EQ(s.shapes.at(0).medium.inside, "milk");
  EXPECT_EQ(s.shapes.at(0).medium.outside, "fog");
  EXPECT_EQ(s.shapes.at(1).medium.outside, "milk");
  // WorldBegin keeps the medium, as in pbrt-v4.
  EXPECT_EQ(s.lights.at(0).medium, "fog");
}

TEST(Directives, Objects) {
  const SceneDescription s = parseGood(R"(WorldBegin
    Translate 1 0 0
    ObjectBegin "o" Translate 0 1 0 Material "mirror4" Shape "a" Shape "b" ObjectEnd
    Scale 2 2 2
    ObjectInstance "o"
    Shape "c")");
  ASSERT_EQ(s.objects.at("o").shapes.size(), 2u);
  // A point of the object is moved by the transform at its definition, and then by the one at the instance.
  const Vec3d inInstance = transformPoint(s.objects.at("o").shapes[0].worldFromObject, {0, 0, 0});
  EXPECT_EQ(inInstance, Vec3d(1, 1, 0));
  EXPECT_EQ(transformPoint(s.instances.at(0).worldFromInstance, inInstance), Vec3d(3, 2, 0));
  ASSERT_EQ(s.shapes.size(), 1u);
  EXPECT_EQ(s.shapes[0].material.index, 0);
}

TEST(Directives, ObjectsStandInObjects) {
  const std::string text = R"(WorldBegin
    ObjectBegin "leaf" Scale 2 2 2 Shape "a" ObjectEnd
    ObjectBegin "twig" AttributeBegin Translate 0 1 0 Scale -1 1 1 ObjectInstance "leaf" AttributeEnd ObjectEnd
    ObjectBegin "tree" Shape "trunk" Translate 3 0 5 ObjectInstance "twig" ObjectInstance "leaf" ObjectEnd
    )";
  const SceneDescription s = parseGood(text + "Translate 100 0 0 ObjectInstance \"tree\"");
  // Positions of the leaves in the space of their shapes; all other instances are resolved.
  std::vector<Vec3d> leaves;
  for (const InstanceDescription& i : s.instances) {
    if (i.object == "leaf")
      leaves.push_back(
          transformPoint(i.worldFromInstance * s.objects.at("leaf").shapes[0].worldFromObject, {1, 2, 3}));
    else
      EXPECT_EQ(i.object, "tree");
  }
  EXPECT_EQ(s.instances.size(), 3u);
  ASSERT_EQ(leaves.size(), 2u);
  EXPECT_EQ(leaves[0], Vec3d(101, 5, 11));
  EXPECT_EQ(leaves[1], Vec3d(105, 4, 11));

  // Moving objects and operands of solids are single objects with all their shapes.
  const SceneDescription moving =
      parseGood(text + "ActiveTransform EndTime Rotate 90 0 0 1 ActiveTransform All ObjectInstance \"tree\" "
                       "Shape \"csg\" \"string operands\" [ \"twig\" \"leaf\" ]");
  ASSERT_EQ(moving.instances.size(), 1u);
  const ObjectDescription& whole = moving.objects.at(moving.instances[0].object);
  ASSERT_EQ(whole.shapes.size(), 3u);
  EXPECT_EQ(transformPoint(whole.shapes[1].worldFromObject, {1, 2, 3}), Vec3d(1, 5, 11));
  const std::vector<std::string>& operands = moving.shapes.at(0).shape.parameters.at(0).strings;
  EXPECT_EQ(moving.objects.at(operands.at(0)).shapes.size(), 1u);
  EXPECT_EQ(operands.at(1), "leaf");
  const SceneDescription byAttribute = parseGood(
      text + "Attribute \"shape\" \"string operands\" [ \"twig\" \"leaf\" ] Shape \"csg\" Shape \"csg\"");
  const auto& attributes = byAttribute.shapes.at(0).shape.attributes;
  ASSERT_TRUE(attributes);
  EXPECT_EQ(attributes->at(0).strings, operands);
  EXPECT_EQ(byAttribute.objects.at(attributes->at(0).strings.at(0)).shapes.size(), 1u);
  EXPECT_EQ(byAttribute.shapes.at(1).shape.attributes, attributes);
}

TEST(Directives, ObjectErrors) {
  EXPECT_CONTAINS(messages("WorldBegin ObjectBegin \"a\" ObjectBegin \"b\" ObjectEnd"), "inside the object");
  EXPECT_CONTAINS(messages("WorldBegin ObjectBegin \"a\" ObjectEnd ObjectBegin \"a\" Shape \"s\" ObjectEnd"),
                  "already defined");
  EXPECT_CONTAINS(messages("WorldBegin ObjectBegin \"a\" ObjectInstance \"a\" ObjectEnd"),
                  "would contain itself");
  EXPECT_CONTAINS(messages("WorldBegin ObjectBegin \"a\" ObjectInstance \"b\" ObjectEnd "
                           "ObjectBegin \"b\" ObjectInstance \"a\" ObjectEnd ObjectInstance \"a\""),
                  "would contain itself");
  EXPECT_CONTAINS(messages("WorldBegin ObjectBegin \"b\" ObjectEnd ObjectBegin \"a\" ActiveTransform EndTime "
                           "Translate 1 0 0 ObjectInstance \"b\" ObjectEnd"),
                  "cannot move by itself");
  std::string tower = "WorldBegin ObjectBegin \"0\" Shape \"a\" ObjectEnd ";
  for (int i = 1; i < 30; ++i) {
    const std::string below = "ObjectInstance \"" + std::to_string(i - 1) + "\" ";
    tower += "ObjectBegin \"" + std::to_string(i) + "\" " + below + below + "ObjectEnd ";
  }
  EXPECT_CONTAINS(messages(tower + "ObjectInstance \"29\""), "too many objects are in");
  EXPECT_CONTAINS(messages(towerOfObjects(5000)), "more than 256 levels");
  EXPECT_EQ(parseGood(towerOfObjects(256)).instances.size(), 1u);
  EXPECT_CONTAINS(messages("WorldBegin ObjectEnd"), "without ObjectBegin");
  EXPECT_CONTAINS(messages("WorldBegin ObjectBegin \"a\""), "has no ObjectEnd");
  EXPECT_CONTAINS(messages("WorldBegin ObjectBegin \"a\" AttributeBegin ObjectEnd"), "still open");
  EXPECT_CONTAINS(messages("WorldBegin ObjectBegin \"a\" AttributeEnd ObjectEnd"),
                  "ObjectBegin at test.pbrt:1");
}

TEST(Directives, AttributesAreDefaults) {
  const SceneDescription s = parseGood(R"(WorldBegin
    AttributeBegin
      Attribute "shape" "float radius" 2 "string note" "x"
      Attribute "shape" "float radius" 3
      Shape "sphere"
      Shape "sphere" "float radius" 4
    AttributeEnd
    Shape "sphere")");
  const std::vector<ParameterSpec> specs = {realParameter("radius", "1", "")};
  const double expected[] = {3, 4, 1};
  for (size_t i = 0; i < 3; ++i) {
    Diagnostics diagnostics;
    const Parameters p = bindParameters(s.shapes.at(i).shape, specs, diagnostics, false);
    EXPECT_EQ(p.real("radius"), expected[i]);
    EXPECT_EQ(diagnostics.all().size(), 0u) << diagnostics.format();
  }
  EXPECT_CONTAINS(messages("WorldBegin Attribute \"shapes\" \"float radius\" 1"), "\"shape\" \"light\"");
}

TEST(Directives, WrongSideOfWorldBegin) {
  Diagnostics diagnostics;
  const SceneDescription s =
      parse("Camera \"perspective\" Shape \"a\" Shape \"b\" LightSource \"c\"", diagnostics);
  EXPECT_EQ(errorCount(diagnostics), 1u) << diagnostics.format();
  EXPECT_CONTAINS(diagnostics.format(), "Shape must stand after WorldBegin");
  EXPECT_EQ(s.shapes.size(), 2u);
  EXPECT_CONTAINS(messages("WorldBegin Film \"rgb\" Shape \"a\""), "Film must stand before WorldBegin");
  EXPECT_CONTAINS(messages("WorldBegin WorldBegin"), "a second WorldBegin");
  EXPECT_CONTAINS(messages("Camera \"perspective\""), "no WorldBegin");
  EXPECT_CONTAINS(messages(""), "no WorldBegin");
}

TEST(Directives, Blocks) {
  EXPECT_CONTAINS(messages("WorldBegin AttributeEnd"), "AttributeEnd without AttributeBegin");
  EXPECT_CONTAINS(messages("WorldBegin\nAttributeBegin\nShape \"a\""),
                  "test.pbrt:2:1: error: this block has no AttributeEnd");
  std::string deep = "WorldBegin ";
  for (int i = 0; i < 5000; ++i) deep += "AttributeBegin ";
  EXPECT_CONTAINS(messages(deep), "blocks are open");
}

TEST(Directives, LampsWithoutAShape) {
  const std::string lamp = "WorldBegin\nAttributeBegin AreaLightSource \"diffuse\" ";
  EXPECT_CONTAINS(messages(lamp + "AttributeEnd Shape \"a\""), "test.pbrt:2:32: warning: no shape follows");
  EXPECT_EQ(messages(lamp + "Shape \"a\" AttributeEnd"), "");
  EXPECT_EQ(messages("WorldBegin AreaLightSource \"\""), "");
}

TEST(Directives, ColorSpaces) {
  EXPECT_EQ(messages("ColorSpace \"rec2020\" WorldBegin"), "");
  const SceneDescription scene =
      parseGood("ColorSpace \"rec2020\" WorldBegin AttributeBegin ColorSpace \"sRGB\" "
                "Shape \"a\" \"rgb c\" [1 0 0] AttributeEnd Shape \"b\" \"rgb c\" [1 0 0]");
  EXPECT_EQ(scene.shapes[0].shape.parameters[0].numbers, std::vector<double>({1, 0, 0}));
  EXPECT_NE(scene.shapes[1].shape.parameters[0].numbers, std::vector<double>({1, 0, 0}));
  EXPECT_CONTAINS(messages("ColorSpace \"foo\" WorldBegin"), "accepted: \"srgb\"");
}

TEST(Directives, OldFormatIsRecognised) {
  for (const char* text :
       {"Film \"image\" WorldBegin", "SurfaceIntegrator \"path\" WorldBegin", "WorldBegin Material \"matte\"",
        "WorldBegin WorldEnd", "Integrator \"directlighting\" WorldBegin",
        "WorldBegin Texture \"a\" \"color\" \"c\"",
        "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"uber\"",
        "WorldBegin LightSource \"point\" \"blackbody I\" [5500 2]"})
    EXPECT_CONTAINS(messages(text), "looks like a pbrt-v3 file") << text;
  EXPECT_CONTAINS(messages("WorldBegin LightSource \"point\" \"color I\" [1 1 1]"), "pbrt-v3 file");
  EXPECT_CONTAINS(messages("WorldBegin LightSource \"point\" \"color I\" [1 1 1]"), "pbrt-v4 calls it 'rgb'");
  EXPECT_EQ(messages("Film \"rgb\" Integrator \"path\" WorldBegin Material \"diffuse\""), "");
  const std::string twice = messages("WorldBegin Material \"matte\" Material \"glass\"");
  EXPECT_EQ(twice.find("pbrt-v3 file"), twice.rfind("pbrt-v3 file"));
}
