/** @file
 * Models through Assimp: positions, materials, pictures, lights and cameras of small files that the tests
 * write.
 */
#include <cstring>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <set>
#include <unistd.h>

#include "model/importTesting.h"
#include "recurse/core/image/image.h"
#include "sanitized.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** A triangle (0,0,0) (1,0,0) (0,1,0) with texture coordinates, as the buffer of a glTF file. */
std::string triangleBuffer() {
  const float numbers[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, /* uv */ 0, 0, 1, 0, 0, 1};
  const uint16_t indices[] = {0, 1, 2};
  std::string out(reinterpret_cast<const char*>(numbers), sizeof numbers);
  out.append(reinterpret_cast<const char*>(indices), sizeof indices);
  return out;
}

/** A glTF file of nodes and materials around that triangle. */
std::string gltf(const std::string& nodes, const std::string& material, const std::string& more = {}) {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[)" + nodes +
         R"(],"meshes":[{"name":"tri","primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2,)" +
         R"("material":0}]}],"materials":[)" + material +
         R"(],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},)" +
         R"({"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"},)" +
         R"({"bufferView":2,"componentType":5123,"count":3,"type":"SCALAR"}],)" +
         R"("bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24},)" +
         R"({"buffer":0,"byteOffset":60,"byteLength":6}],"buffers":[{"uri":"m.bin","byteLength":66}])" +
         more + "}";
}

class MeshFile : public ImportTest {
 protected:
  void SetUp() override {
    ImportTest::SetUp();
    write("m.bin", triangleBuffer());
  }
  static constexpr const char* ONE_NODE = R"({"mesh":0})";
};

} // namespace

TEST_F(MeshFile, NodeTransformsPlaceMeshes) {
  write("m.gltf", gltf(R"({"children":[1],"translation":[10,0,0]},{"mesh":0,"scale":[2,3,4]})", "{}"));
  const SceneDescription scene = load("Translate 0 100 0 Shape \"mesh\" \"string filename\" \"m.gltf\"");
  ASSERT_EQ(scene.shapes.size(), 1u);
  const Vec3d corner = transformPoint(scene.shapes[0].worldFromObject, {1, 1, 0});
  EXPECT_NEAR(corner.x, 12, 1e-6);
  EXPECT_NEAR(corner.y, 103, 1e-6);
  const std::unique_ptr<Scene> built = build(scene);
  ASSERT_TRUE(built);
  EXPECT_EQ(built->contents().triangles, 1u);
}

TEST_F(MeshFile, AMeshInSeveralNodesIsOneObject) {
  write("m.gltf", gltf(R"({"children":[1,2]},{"mesh":0},{"mesh":0,"translation":[0,0,5]})", "{}"));
  const SceneDescription scene = load("Translate 1 0 0 Shape \"mesh\" \"string filename\" \"m.gltf\"");
  EXPECT_EQ(scene.objects.size(), 1u);
  ASSERT_EQ(scene.instances.size(), 2u);
  EXPECT_EQ(Vec3d(scene.instances[1].worldFromInstance[3]), Vec3d(1, 0, 5));
  EXPECT_TRUE(build(scene));
  // An object cannot contain a second object, so it has the shapes twice.
  const SceneDescription nested =
      load("ObjectBegin \"o\" Shape \"mesh\" \"string filename\" \"m.gltf\" ObjectEnd\n"
           "ObjectInstance \"o\"");
  EXPECT_EQ(nested.objects.at("o").shapes.size(), 2u);
  EXPECT_TRUE(build(nested));
}

TEST(ImportWriter, RepeatedNamesAreUniqueAlsoWhereTheyAreCut) {
  SceneImport import;
  const ImportContext context;
  ImportWriter out(import, context);
  std::set<std::string> names;
  for (const size_t length : {1u, 62u, 63u, 64u, 100u})
    for (int i = 0; i < 120; ++i) EXPECT_TRUE(names.insert(out.uniqueName(std::string(length, 'a'))).second);
  EXPECT_TRUE(names.insert(out.uniqueName("a_2")).second);
}

TEST(ImportWriter, NamesOfFilesAreValidInTheText) {
  SceneImport import;
  const ImportContext context;
  ImportWriter out(import, context);
  EXPECT_EQ(out.addFile("my \"map\".P\\N\"G", "1"), "my__map_.p_n_g");
  EXPECT_EQ(out.addFile("maps/leaf-2.PNG", "2"), "leaf-2.png");
  EXPECT_EQ(out.addFile("leaf-2.png", "3"), "leaf-2_2.png");
  EXPECT_EQ(import.files.size(), 3u);
}

TEST_F(MeshFile, TwoOfThemDoNotClash) {
  write("m.gltf", gltf(R"({"children":[1,2]},{"mesh":0},{"mesh":0,"translation":[0,0,5]})",
                       R"({"pbrMetallicRoughness":{"metallicFactor":0.5}})"));
  const SceneDescription scene = load("Shape \"mesh\" \"string filename\" \"m.gltf\"\nTranslate 9 9 9\n"
                                      "Shape \"mesh\" \"string filename\" \"m.gltf\"");
  EXPECT_EQ(scene.objects.size(), 2u);
  EXPECT_EQ(scene.namedMaterials.size(), 4u);
  EXPECT_TRUE(build(scene));
}

TEST_F(MeshFile, MetalAndRoughnessBecomeConductorPlasticOrBoth) {
  const auto materialOf = [this](const std::string& factors) {
    write("m.gltf", gltf(ONE_NODE, R"({"pbrMetallicRoughness":{"baseColorFactor":[0.25,0.5,0.75,1],)" +
                                       factors + "}}"));
    const SceneDescription scene = load("Shape \"mesh\" \"string filename\" \"m.gltf\"");
    EXPECT_TRUE(build(scene));
    return scene.materials.at(static_cast<size_t>(scene.shapes.at(0).material.index));
  };
  const ParsedDirective plastic = materialOf(R"("metallicFactor":0,"roughnessFactor":0.5)");
  EXPECT_EQ(plastic.type, "plastic");
  EXPECT_NEAR(numberOf(plastic, "roughness"), 0.25, 1e-6); // alpha is the square
  EXPECT_NEAR(numberOf(plastic, "reflectance", 2), 0.75, 1e-6);
  EXPECT_EQ(materialOf(R"("metallicFactor":1,"roughnessFactor":0.5)").type, "conductor");
  const ParsedDirective mixed = materialOf(R"("metallicFactor":0.3,"roughnessFactor":0.5)");
  EXPECT_EQ(mixed.type, "mix");
  EXPECT_NEAR(numberOf(mixed, "amount"), 0.3, 1e-6);
}

TEST_F(MeshFile, PicturesLieTheRightWayUp) {
  // Upper half red, lower half blue: glTF's v = 0 is the upper edge, at the lower corner of the triangle.
  Image picture(2, 2, {"R", "G", "B"});
  for (int x = 0; x < 2; ++x) {
    picture.at(x, 0)[0] = 1;
    picture.at(x, 1)[2] = 1;
  }
  writeImage(directory + "/red blue.png", picture);
  write("m.gltf",
        gltf(ONE_NODE, R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0},"metallicFactor":0}})",
             R"(,"textures":[{"source":0}],"images":[{"uri":"red%20blue.png"}])"));
  const SceneDescription scene = load("Shape \"mesh\" \"string filename\" \"m.gltf\"");
  const std::unique_ptr<Scene> built = build(scene);
  ASSERT_TRUE(built);
  EXPECT_GT(albedo(*built, {0.3, 0.1, 0}).r, 0.5f);
  EXPECT_LT(albedo(*built, {0.3, 0.1, 0}).b, 0.2f);
  EXPECT_GT(albedo(*built, {0.1, 0.8, 0}).b, 0.5f);
}

TEST_F(MeshFile, AMissingPictureIsAWarningAndCannotBeOverlooked) {
  write("m.gltf",
        gltf(ONE_NODE, R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0},"metallicFactor":0}})",
             R"(,"textures":[{"source":0}],"images":[{"uri":"gone.png"}])"));
  const SceneDescription scene = load("Shape \"mesh\" \"string filename\" \"m.gltf\"");
  EXPECT_NE(messages.find("there is no picture \"gone.png\""), std::string::npos) << messages;
  EXPECT_TRUE(build(scene));
  ASSERT_EQ(scene.textures.size(), 1u);
  EXPECT_EQ(scene.textures[0].texture.type, "checkerboard");
}

TEST_F(MeshFile, EmittingMaterialsAndLightsAreTakenOrLeft) {
  const char* NODES =
      R"({"children":[1,2]},{"mesh":0},{"translation":[0,0,7],"extensions":{"KHR_lights_punctual":{"light":0}}})";
  write("m.gltf",
        gltf(NODES, R"({"emissiveFactor":[1,0.5,0.25]})",
             R"(,"extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[)"
             R"({"type":"point","color":[1,1,1],"intensity":3,"name":"lamp"}]}})"));
  const SceneDescription lit = load("Translate 1 0 0 Shape \"mesh\" \"string filename\" \"m.gltf\"");
  EXPECT_EQ(lit.areaLights.size(), 1u);
  EXPECT_EQ(lit.shapes.at(0).areaLight, 0);
  ASSERT_EQ(lit.lights.size(), 1u);
  EXPECT_NEAR(numberOf(lit.lights[0].light, "I", 1), 3, 1e-5);
  EXPECT_EQ(Vec3d(lit.lights[0].worldFromLight[3]), Vec3d(1, 0, 0));
  EXPECT_EQ(numberOf(lit.lights[0].light, "from", 2), 7);
  EXPECT_TRUE(build(lit));
  EXPECT_EQ(messages, "");
  const SceneDescription moving = load("ActiveTransform EndTime Translate 0 2 0 ActiveTransform All\nShape "
                                       "\"mesh\" \"string filename\" \"m.gltf\"");
  EXPECT_NE(messages.find("test.pbrt:3:7: warning: lights of the file do not move"), std::string::npos)
      << messages;
  EXPECT_EQ(moving.lights.at(0).worldFromLight, Mat4d(1));
  EXPECT_TRUE(moving.shapes.at(0).worldFromObjectLast);
  const SceneDescription dark = load("Shape \"mesh\" \"string filename\" \"m.gltf\" \"bool lights\" false");
  EXPECT_TRUE(dark.areaLights.empty());
  EXPECT_TRUE(dark.lights.empty());
}

TEST_F(MeshFile, WithoutMaterialsTheSurroundingOneCounts) {
  write("m.gltf", gltf(ONE_NODE, "{}"));
  const SceneDescription scene =
      load("Material \"dielectric\" Shape \"mesh\" \"string filename\" \"m.gltf\" \"bool materials\" false");
  EXPECT_EQ(scene.materials.at(static_cast<size_t>(scene.shapes.at(0).material.index)).type, "dielectric");
}

TEST_F(MeshFile, CamerasLookWhereTheirNodesDo) {
  const char* NODES = R"({"children":[1,2]},{"mesh":0},{"name":"eye","translation":[0,0,8],"camera":0})";
  write(
      "m.gltf",
      gltf(NODES, "{}",
           R"(,"cameras":[{"type":"perspective","perspective":{"yfov":0.6,"aspectRatio":2,"znear":0.1}}])"));
  const SceneDescription scene =
      load("Translate 5 0 0 Shape \"mesh\" \"string filename\" \"m.gltf\" \"string camera\" \"eye\"");
  const Mat4d& camera = scene.worldFromCamera;
  EXPECT_NEAR(camera[3].x, 5, 1e-6);
  EXPECT_NEAR(camera[3].z, 8, 1e-6);
  EXPECT_NEAR(camera[2].z, -1, 1e-6); // forward
  EXPECT_NEAR(camera[0].x, 1, 1e-6);  // not mirrored
  EXPECT_FALSE(scene.worldFromCameraLast);
  const SceneDescription moving =
      load("ActiveTransform EndTime Translate 0 2 0 ActiveTransform All "
           "Shape \"mesh\" \"string filename\" \"m.gltf\" \"string camera\" \"eye\"");
  ASSERT_TRUE(moving.worldFromCameraLast);
  EXPECT_NEAR((*moving.worldFromCameraLast)[3].y, moving.worldFromCamera[3].y + 2, 1e-6);
  load("Shape \"mesh\" \"string filename\" \"m.gltf\" \"string camera\" \"ear\"", true);
  EXPECT_NE(messages.find("has no camera \"ear\""), std::string::npos) << messages;
  EXPECT_NE(messages.find("\"eye\""), std::string::npos) << messages;
  Diagnostics diagnostics;
  SceneDescription named =
      parseScene("Camera \"perspective\" \"string name\" \"mine\" WorldBegin Shape \"mesh\" "
                 "\"string filename\" \"m.gltf\" \"string camera\" \"eye\"",
                 "test.pbrt", directory, diagnostics);
  expandImports(named, diagnostics, false);
  EXPECT_EQ(named.worldFromCamera, Mat4d(1));
  EXPECT_NE(diagnostics.format().find("camera \"mine\" of the scene stays where it is"), std::string::npos);
}

TEST_F(MeshFile, CopyOfAnImportHasTheChosenCamera) {
  write("m.gltf", gltf(R"({"children":[1,2]},{"mesh":0},{"name":"eye","camera":0})", "{}",
                       R"(,"cameras":[{"type":"perspective","perspective":{"yfov":0.6,"znear":0.1}}])"));
  const ParsedDirective directive = parseParameterText("mesh", "\"string filename\" \"" + directory +
                                                                   "/m.gltf\" \"string camera\" \"eye\"");
  Diagnostics diagnostics;
  std::unique_ptr<SceneImport> original = plugIns().imports.make(directive, {"", ""}, diagnostics);
  ASSERT_TRUE(original) << diagnostics.format();
  const SceneImport copy = *original;
  original->cameras.clear();
  ASSERT_TRUE(copy.chosenCamera());
  EXPECT_EQ(copy.chosenCamera(), &copy.cameras.at(0));
  EXPECT_EQ(copy.chosenCamera()->name, "eye");
}

TEST_F(MeshFile, MtlIsMapped) {
  write("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 4\n"
                 "usemtl c\nf 1 3 4\nusemtl d\nf 2 3 4\n");
  write("m.mtl", "newmtl a\nKd .1 .2 .3\nillum 1\nnewmtl b\nKd .1 .2 .3\nKs .5 .5 .5\nNs 98\nillum 2\n"
                 "newmtl c\nKd 0 0 0\nKs .9 .8 .7\nNs 1000\nillum 3\nnewmtl d\nNi 1.3\nillum 7\nd .1\n");
  const SceneDescription scene = load("Shape \"mesh\" \"string filename\" \"m.obj\"");
  std::map<std::string, ParsedDirective> byType;
  for (const ShapeDescription& s : scene.shapes) {
    const ParsedDirective& m = scene.materials.at(static_cast<size_t>(s.material.index));
    byType[m.type] = m;
  }
  ASSERT_EQ(byType.size(), 4u);
  EXPECT_NEAR(numberOf(byType.at("diffuse"), "reflectance", 1), 0.2, 1e-6);
  EXPECT_NEAR(numberOf(byType.at("plastic"), "roughness"), std::sqrt(0.02), 1e-6);
  EXPECT_NEAR(numberOf(byType.at("conductor"), "reflectance", 1), 0.8, 1e-6);
  EXPECT_NEAR(numberOf(byType.at("dielectric"), "eta"), 1.3, 1e-6);
  EXPECT_TRUE(build(scene));
}

TEST_F(MeshFile, TellsWhatWasTakenAndLeft) {
  write("m.gltf", gltf(ONE_NODE, "{}"));
  const SceneDescription scene = load("Shape \"mesh\" \"string filename\" \"m.gltf\"");
  ASSERT_EQ(scene.importNotes.size(), 1u);
  EXPECT_EQ(scene.importNotes[0], "mesh: 1 mesh, 1 triangle, 1 material");
}

TEST_F(MeshFile, BrokenFilesAreErrorsThatNameTheFile) {
  for (const char* text : {"", "{", "no glTF at all", R"({"asset":{"version":"2.0"}})"}) {
    write("m.gltf", text);
    load("Shape \"mesh\" \"string filename\" \"m.gltf\"", true);
    EXPECT_NE(messages.find("m.gltf: cannot be used"), std::string::npos) << messages;
  }
  write("m.bin", "short");
  write("m.gltf", gltf(ONE_NODE, "{}"));
  load("Shape \"mesh\" \"string filename\" \"m.gltf\"", true);
  EXPECT_NE(messages.find("m.gltf: cannot be used"), std::string::npos) << messages;
  load("Shape \"mesh\" \"string filename\" \"gone.gltf\"", true);
  EXPECT_NE(messages.find("there is no file \"gone.gltf\""), std::string::npos) << messages;
}

TEST_F(MeshFile, PlyFilesAreReadByOurOwnReader) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "nan 0 0\n7 0 0\n8 0 0\n7 1 0\n";
  write("m.ply", head + "3 1 2 9\n");
  load("Shape \"mesh\" \"string filename\" \"m.ply\"", true);
  EXPECT_NE(messages.find("m.ply:14: face 0 names vertex 9; there are 0 to 3"), std::string::npos)
      << messages;
  write("m.ply", head + "3 1 2 3\n");
  const std::unique_ptr<Scene> scene = build(load("Shape \"mesh\" \"string filename\" \"m.ply\""));
  EXPECT_NE(messages.find("1 vertices are not finite"), std::string::npos) << messages;
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->contents().triangles, 1u);
  EXPECT_NEAR(scene->origin().x, 7.5, 1e-6); // the bounds exclude a vertex without faces
}

TEST_F(MeshFile, NodesThatFlattenOrOverflowAreLeftOut) {
  for (const char* matrix :
       {"1,0,0,0, 1,1e-16,0,0, 0,0,1,0, 0,0,0,1", "1,0,0,0, 0,1,0,0, 0,0,1,0, 1e39,0,0,1"}) {
    write("m.gltf",
          gltf(R"({"mesh":0,"children":[1]},{"mesh":0,"matrix":[)" + std::string(matrix) + "]}", "{}"));
    const SceneDescription scene = load("Shape \"mesh\" \"string filename\" \"m.gltf\"");
    ASSERT_EQ(scene.importNotes.size(), 1u);
    EXPECT_NE(scene.importNotes[0].find("left out: 1 mesh in a node with a singular transform"),
              std::string::npos)
        << scene.importNotes[0];
  }
}

TEST_F(MeshFile, FaultsOfAssimpAreErrorsThatNameTheFile) {
  // Assimp 5.2 recurses into each node, and no stack is large enough for this depth.
  constexpr int DEPTH = 200000;
  std::string nodes;
  for (int i = 0; i < DEPTH; ++i) nodes += "<node>";
  for (int i = 0; i < DEPTH; ++i) nodes += "</node>";
  write("m.dae",
        "<COLLADA version=\"1.4.1\"><library_visual_scenes><visual_scene id=\"a\">" + nodes +
            "</visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#a\"/></scene>"
            "</COLLADA>");
  EXPECT_EXIT(
      {
        load("Shape \"mesh\" \"string filename\" \"m.dae\"", true);
        std::fputs(messages.c_str(), stderr);
        std::_Exit(3);
      },
      ::testing::ExitedWithCode(3), "m.dae: cannot be used");
}

TEST_F(MeshFile, ErrorsInsideOfOneNameItAndItsDirective) {
  write("huge.obj", "v 0 0 0\nv 1e30 0 0\nv 0 1e30 0\nf 1 2 3\n");
  const SceneDescription scene = load("Shape \"mesh\" \"string filename\" \"huge.obj\"");
  Diagnostics diagnostics;
  EXPECT_FALSE(buildScene(scene, {}, diagnostics));
  const std::string said = diagnostics.format();
  EXPECT_EQ(said.find("test.pbrt:2:7: error: the shape is too large"), 0u) << said;
  EXPECT_NE(said.find("\"huge.obj\""), std::string::npos) << said;
  for (const auto& [name, content] : *scene.shapes.at(0).shape.files)
    EXPECT_TRUE(name.starts_with("huge.obj/")) << name;
}

TEST_F(MeshFile, MemoryBeyondItsSizeIsRefused) {
  if (SANITIZED) GTEST_SKIP() << "sanitizers end a program that runs out of memory";
  // A word among the indices of a COLLADA file, and an invalid stride.
  write("m.dae", R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema"
version="1.4.1"><asset><up_axis>Y_UP</up_axis></asset><library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="12">-1 -1 0 1 -1 0 1 1 0 -1 1 0</float_array><technique_common>
<accessor source="#pa" count="4" stride="-1e308"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="2">
<input semantic="VERTEX" source="#v" offset="0"/><p>0 inf 2 0 2 3</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="vs"><node id="n"><instance_geometry url="#g"/>
</node></visual_scene></library_visual_scenes><scene><instance_visual_scene url="#vs"/></scene></COLLADA>)");
  load("Shape \"mesh\" \"string filename\" \"m.dae\"", true);
  EXPECT_NE(messages.find("m.dae: cannot be used: it needs more memory than a file of this size should"),
            std::string::npos)
      << messages;
}
