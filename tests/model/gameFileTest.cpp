/** @file
 * Models and maps of games, from small files that the tests write: MD2 with PCX skins, and Quake III maps in
 * archives. Invalid values in a file cause errors that name the position.
 */
#include <cstring>
#include <functional>
#include <random>

#include "core/image/pcx.h"
#include "importers/md2/md2Model.h"
#include "importers/quake3/gameFiles.h"
#include "importers/quake3/gameShader.h"
#include "importers/quake3/quake3Bsp.h"
#include "model/gameFileTesting.h"
#include "model/importTesting.h"
#include "recurse/core/image/image.h"
#include "recurse/core/io/zipArchive.h"
#include "recurse/model/scene/keptParts.h"
#include "recurse/model/scene/plugIns.h"
#include "sanitized.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

std::string pngFile(const std::string& path, const Rgb& left, const Rgb& right) {
  Image image(2, 1, {"R", "G", "B"});
  for (int c = 0; c < 3; ++c) {
    image.at(0, 0)[c] = left[c];
    image.at(1, 0)[c] = right[c];
  }
  writeImage(path, image);
  return readFileBytes(path);
}

class GameFile : public ImportTest {
 protected:
  const Mat4d& camera(const SceneDescription& s) { return s.worldFromCamera; }
  const LightDescription& light(const SceneDescription& s, const std::string& type) {
    for (const LightDescription& l : s.lights)
      if (l.light.type == type) return l;
    throw std::logic_error("there is no light " + type);
  }
};

} // namespace

TEST_F(GameFile, Md2IsInterpolatedBetweenKeyframes) {
  write("m.md2", md2File());
  for (const auto& [frame, size] : {std::pair("0", 1.0), {"1", 2.0}, {"0.25", 1.25}}) {
    ParsedDirective use =
        parseParameterText("md2", std::string("\"string filename\" \"m.md2\" \"float frame\" ") + frame);
    use.directory = directory;
    Diagnostics diagnostics;
    const auto import = plugIns().imports.make(use, {}, diagnostics);
    ASSERT_TRUE(import) << diagnostics.format();
    EXPECT_NEAR(import->bounds.upper.x, size, 1e-5) << frame;
    EXPECT_NEAR(import->bounds.upper.z, 5 + size, 1e-5) << frame;
  }
  load("Shape \"md2\" \"string filename\" \"m.md2\" \"float frame\" 1.5", true);
  EXPECT_NE(messages.find("has no frame 1.5"), std::string::npos) << messages;
}

TEST_F(GameFile, Md2IsAnimatedByATrack) {
  write("m.md2", md2File());
  write("film.pbrt", "Animate \"pose\" \"float times\" [ 0 8 ] \"float values\" [ 0 1 ]\nWorldBegin\n"
                     "Shape \"md2\" \"string filename\" \"m.md2\" \"float frame\" $pose\n");
  KeptParts kept;
  // Edges of the triangle have the length of the pose, from 1 to 2.
  for (const auto& [frame, size] : {std::pair(0.0, 1.0), {2.0, 1.25}, {5.0, 1.625}, {8.0, 2.0}}) {
    Diagnostics diagnostics;
    const SceneDescription description = loadScene(directory + "/film.pbrt", diagnostics, frame);
    const std::unique_ptr<Scene> scene = buildScene(description, {}, diagnostics, &kept);
    ASSERT_TRUE(scene) << diagnostics.format();
    const Vec3d from(0.1, 1, 0);
    for (const auto& [across, met] : {std::pair(size - 0.12, true), {size - 0.08, false}}) {
      Hit hit;
      const Vec3f origin(from + Vec3d(0, 0, 5 + across) - scene->origin());
      EXPECT_EQ(scene->intersect({origin, {0, -1, 0}}, hit), met) << frame << " " << across;
    }
  }
}

TEST_F(GameFile, Md2WearsItsSkinTheRightWayUp) {
  write("m.md2", md2File("players/nobody/Skin.PCX"));
  write("skin.pcx", pcxFile());
  const SceneDescription scene = load("Rotate -90 1 0 0 Shape \"md2\" \"string filename\" \"m.md2\"");
  EXPECT_EQ(messages, "");
  const std::unique_ptr<Scene> built = build(scene);
  ASSERT_TRUE(built);
  // The front, towards -y in the file, faces z after the rotation; z in the file becomes y.
  const Hit hit = hitAt(*built, {0.05, 5.05, 0});
  EXPECT_NEAR(hit.point.geometricNormal.z, 1, 1e-5);
  // The lower corner has texture coordinates at the lower edge of the picture, which is white.
  EXPECT_GT(albedo(*built, {0.02, 5.02, 0}).g, 0.9f);
  EXPECT_GT(albedo(*built, {0.02, 5.02, 0}).r, 0.9f);
  EXPECT_GT(albedo(*built, {0.02, 5.97, 0}).r, 0.9f); // the upper one red
  EXPECT_LT(albedo(*built, {0.02, 5.97, 0}).g, 0.1f);
}

TEST_F(GameFile, Md2WithoutItsSkinIsAWarning) {
  write("m.md2", md2File("gone.pcx"));
  const SceneDescription scene = load("Shape \"md2\" \"string filename\" \"m.md2\"");
  EXPECT_NE(messages.find("its skin \"gone.pcx\" does not exist"), std::string::npos) << messages;
  EXPECT_TRUE(build(scene));
}

TEST_F(GameFile, WhatAnMd2LiesAboutIsAnErrorWithItsPlace) {
  const auto message = [&](const std::function<void(Bytes&)>& lie) {
    Bytes b{md2File()};
    lie(b);
    write("m.md2", b.data);
    load("Shape \"md2\" \"string filename\" \"m.md2\"", true);
    return messages;
  };
  const auto says = [&](const std::function<void(Bytes&)>& lie, const std::string& what) {
    EXPECT_NE(message(lie).find(what), std::string::npos) << messages;
  };
  says([](Bytes& b) { b.over(0, 'X'); }, "m.md2: at byte 0: this is no MD2 model");
  says([](Bytes& b) { b.over<int32_t>(4, 9); }, "at byte 4: MD2 version 9");
  says([](Bytes& b) { b.over<int32_t>(24, -1); }, "at byte 24: the number of vertices is -1");
  says([](Bytes& b) { b.over<int32_t>(24, 1000); },
       "at byte 16: a frame of 52 bytes cannot hold 1000 vertices");
  says([](Bytes& b) { b.over<int32_t>(32, 1 << 20); }, "the list of triangles would take");
  says([](Bytes& b) { b.over<int32_t>(40, 3); }, "the list of frames would take 156 bytes");
  says([](Bytes& b) { b.over<int32_t>(48, 1 << 30); }, "at byte 48: the offset of the texture coordinates");
  says([](Bytes& b) { b.over<uint16_t>(80, 3); }, "at byte 80: a triangle names vertex 3; there are 3");
  says([](Bytes& b) { b.over<uint16_t>(86, 7); }, "a triangle names texture coordinate 7");
  says([](Bytes& b) { b.over(92, std::nanf("")); }, "at byte 92: the scale of a frame is not finite");
  says([](Bytes& b) { b.data.resize(40); }, "m.md2: at byte");
}

TEST_F(GameFile, PcxIsReadAndChecked) {
  write("p.pcx", pcxFile());
  const Image image = readImage(directory + "/p.pcx");
  ASSERT_EQ(image.width, 4);
  ASSERT_EQ(image.height, 4);
  EXPECT_EQ(image.rgb(3, 0), Rgb(1, 0, 0));
  EXPECT_EQ(image.rgb(0, 1), Rgb(0, 1, 0));
  EXPECT_EQ(image.rgb(1, 2), Rgb(0, 0, 1));
  EXPECT_EQ(image.rgb(2, 3), Rgb(1, 1, 1));
  const auto message = [&](const std::function<void(Bytes&)>& lie) -> std::string {
    Bytes b{pcxFile()};
    lie(b);
    write("p.pcx", b.data);
    try {
      readImage(directory + "/p.pcx");
    } catch (const Error& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_NE(message([](Bytes& b) { b.data.resize(100); }).find("p.pcx: cannot be read"), std::string::npos);
  EXPECT_NE(message([](Bytes& b) { b.over<uint16_t>(8, 60000); }).find("shorter than its width"),
            std::string::npos);
  EXPECT_NE(message([](Bytes& b) { b.over<uint16_t>(10, 60000); }).find("too short for its size"),
            std::string::npos);
  EXPECT_NE(message([](Bytes& b) { b.over<uint16_t>(10, 20); }).find("ends before the picture is complete"),
            std::string::npos);
  EXPECT_NE(message([](Bytes& b) { b.data.pop_back(); }).find("palette"), std::string::npos);
}

TEST_F(GameFile, QuakeMapHasItsSurfacesPicturesAndUnits) {
  BspWriter map;
  map.shader("textures/wall");
  map.shader("textures/common/caulk", 0x80);
  map.square(0, 40);
  map.square(1, 80); // is not drawn
  write("m.pk3", zipFile({{"maps/one.bsp", map.file()},
                          {"textures/wall.png", pngFile(directory + "/x.png", {0.8f, 0, 0}, {0, 0, 0.8f})}}));
  const SceneDescription scene = load("Shape \"quake3map\" \"string pak\" \"m.pk3\"");
  EXPECT_EQ(messages, "");
  const std::unique_ptr<Scene> built = build(scene);
  ASSERT_TRUE(built);
  EXPECT_EQ(built->contents().triangles, 2u);
  const Hit hit = hitAt(*built, {1.1, 0.7, 0.5});
  EXPECT_NEAR(hit.point.position.z + built->origin().z, 1, 1e-5); // 40 units are a metre
  EXPECT_NEAR(hit.point.geometricNormal.z, 1, 1e-6);
  EXPECT_GT(albedo(*built, {0.2, 0.5, 1}).r, 0.5f); // s along x
  EXPECT_GT(albedo(*built, {1.8, 0.5, 1}).b, 0.5f);
}

TEST_F(GameFile, LaterArchivesWinAndMapsMayBeLoose) {
  BspWriter map;
  map.shader("textures/Wall");
  map.square(0, 0);
  const std::string red = pngFile(directory + "/x.png", {0.8f, 0, 0}, {0.8f, 0, 0}),
                    blue = pngFile(directory + "/x.png", {0, 0, 0.8f}, {0, 0, 0.8f});
  write("a.pk3", zipFile({{"maps/one.bsp", map.file()}, {"textures/wall.png", red}}));
  write("b.pk3", zipFile({{"TEXTURES/WALL.png", blue}}));
  std::filesystem::create_directories(directory + "/maps");
  std::filesystem::create_directories(directory + "/textures");
  write("maps/Two.bsp", map.file());
  const auto colour = [&](const std::string& paks) {
    const SceneDescription scene = load("Shape \"quake3map\" \"string pak\" [ " + paks + " ]");
    EXPECT_EQ(messages, "") << paks;
    const std::unique_ptr<Scene> built = build(scene);
    return built ? albedo(*built, {1, 0.5, 1}) : BLACK;
  };
  EXPECT_GT(colour("\"a.pk3\" \"b.pk3\"").b, 0.5f);
  EXPECT_GT(colour("\"b.pk3\" \"a.pk3\"").r, 0.5f);
  EXPECT_GT(colour("\"a.pk3\" \"maps/Two.bsp\"").r, 0.5f);
  write("textures/WALL.png", blue); // next to the folder of the map
  EXPECT_GT(colour("\"a.pk3\" \"maps/Two.bsp\"").b, 0.5f);
  EXPECT_GT(colour("\"maps/Two.bsp\" \"a.pk3\"").r, 0.5f);
  load("Shape \"quake3map\" \"string pak\" [ \"a.pk3\" \"gone.pk3\" ]", true);
  EXPECT_NE(messages.find("there is no file \"gone.pk3\""), std::string::npos) << messages;
}

TEST_F(GameFile, QuakeFacesMayShareTheirIndices) {
  BspWriter map;
  map.shader("textures/wall");
  map.square(0, 0);
  for (int i = 1; i < 100; ++i) { // as q3map2 writes them
    const int32_t firstVertex = map.vertexCount;
    for (const Vec2f& c : {Vec2f(0, 0), Vec2f(0, 1), Vec2f(1, 1), Vec2f(1, 0)})
      map.vertex({80 * c.x, 80 * c.y, float(i)}, c, {0, 0, 1});
    map.face(0, 1, firstVertex, 0);
  }
  const Quake3Bsp bsp = readQuake3Bsp("m.bsp", map.file());
  ASSERT_EQ(bsp.faces.size(), 100u);
  EXPECT_EQ(bsp.faces.back().triangles.size(), 2u);
}

TEST_F(GameFile, MissingPicturesAreOneWarning) {
  BspWriter map;
  for (int i = 0; i < 8; ++i) {
    map.shader("textures/wall" + std::to_string(i));
    map.square(i, float(i));
  }
  write("m.pk3", zipFile({{"maps/one.bsp", map.file()}}));
  load("Shape \"quake3map\" \"string pak\" \"m.pk3\"");
  EXPECT_NE(messages.find("there are no pictures for 8 textures: \"textures/wall0\", "), std::string::npos)
      << messages;
  EXPECT_EQ(messages.find("warning"), messages.rfind("warning")) << messages;
}

TEST_F(GameFile, QuakePatchIsCurved) {
  // A quarter of a cylinder around the y axis, approximated by a parabola: the middle of its profile is at
  // (P0 + 2 P1 + P2) / 4.
  BspWriter map;
  map.shader("textures/wall");
  for (int row = 0; row < 3; ++row)
    for (const Vec2f& c : {Vec2f(0, 80), Vec2f(80, 80), Vec2f(80, 0)})
      map.vertex({c.x, float(40 * row), c.y}, {0, 0}, {0, 0, 1});
  map.face(0, 2, 0, 0, 3, 3);
  write("m.pk3", zipFile({{"maps/one.bsp", map.file()}}));
  const SceneDescription scene = load("Shape \"quake3map\" \"string pak\" \"m.pk3\"");
  EXPECT_NE(messages.find("no picture for \"textures/wall\""), std::string::npos) << messages;
  const std::unique_ptr<Scene> built = build(scene);
  ASSERT_TRUE(built);
  const Hit hit = hitAt(*built, {1.5, 1.01, 3});
  EXPECT_NEAR(hit.point.position.z + built->origin().z, 1.5, 0.0026); // a tenth of a unit
  EXPECT_NEAR(std::abs(hit.point.shadingNormal.x), std::sqrt(0.5f), 1e-2);
  // Triangles are within the tolerance of the true surface everywhere.
  Quake3Bsp bsp = readQuake3Bsp("test", map.file());
  const int steps = patchSteps(bsp, 0.1, 32);
  tessellatePatch(bsp.faces[0], steps);
  double worst = 0;
  for (const glm::uvec3& t : bsp.faces[0].triangles) {
    const auto at = [&](int k) { return bsp.faces[0].vertices[t[k]].position; };
    const Vec3d middle = 0.5 * (at(0) + at(1)); // the curve: x = 80 (2u - u²), z = 80 (1 - u²)
    double nearest = INFINITY;
    for (int i = 0; i <= 4000; ++i) {
      const double u = i / 4000.0;
      nearest = std::min(nearest, std::hypot(80 * u * (2 - u) - middle.x, 80 * (1 - u * u) - middle.z));
    }
    worst = std::max(worst, nearest);
  }
  EXPECT_LT(worst, 0.1);
  EXPECT_GT(steps, 4);
}

TEST_F(GameFile, QuakeLightIsInPhysicalUnits) {
  BspWriter map;
  map.shader("textures/lamp");
  map.shader("textures/sky", 0x4);
  map.square(0, 0);
  map.square(1, 400);
  map.entities =
      "{ \"classname\" \"worldspawn\" }\n"
      "{ \"classname\" \"light\" \"origin\" \"40 80 120\" \"light\" \"64\" \"_color\" \"1 .5 0\" }\n"
      "{ \"classname\" \"light\" \"origin\" \"0 0 100\" \"target\" \"t\" \"radius\" \"48\" }\n"
      "{ \"classname\" \"info_null\" \"origin\" \"0 0 0\" \"targetname\" \"t\" }\n"
      "{ \"classname\" \"info_player_deathmatch\" \"origin\" \"40 40 14\" \"angle\" \"90\" }\n";
  write("m.pk3",
        zipFile({{"maps/one.bsp", map.file()},
                 {"scripts/a.shader", "// lamps\ntextures/lamp\n{\n q3map_surfacelight 1000\n cull none\n}\n"
                                      "textures/sky\n{\n surfaceparm sky\n q3map_sun 0 0 2 64 90 30\n"
                                      " q3map_surfacelight 100\n}\n"}}));
  const SceneDescription scene =
      load("Shape \"quake3map\" \"string pak\" \"m.pk3\" \"string camera\" \"spawn 1\"");
  const double unit = 3.14159265358979 / 64; // irradiance of a lightmap value of 1
  ASSERT_EQ(scene.areaLights.size(), 1u);
  EXPECT_NEAR(numberOf(scene.areaLights[0], "L"), 1000 * 0.25 * unit, 1e-9);
  const ParsedDirective& point = light(scene, "point").light;
  EXPECT_NEAR(numberOf(point, "I", 0), 64 * 7500 * unit / 1600, 1e-9);
  EXPECT_NEAR(numberOf(point, "I", 1), 32 * 7500 * unit / 1600, 1e-9);
  EXPECT_NEAR(numberOf(point, "from", 2), 3, 1e-12);
  const ParsedDirective& spot = light(scene, "spot").light;
  EXPECT_NEAR(std::tan(glm::radians(numberOf(spot, "coneangle"))), 0.64, 1e-9);
  const ParsedDirective& sun = light(scene, "distant").light;
  EXPECT_NEAR(numberOf(sun, "L", 2), 64 * unit, 1e-9);
  EXPECT_NEAR(numberOf(sun, "from", 0), 0, 1e-9);
  EXPECT_NEAR(numberOf(sun, "from", 1), std::sqrt(0.75), 1e-9);
  EXPECT_NEAR(numberOf(sun, "from", 2), 0.5, 1e-9);
  EXPECT_NEAR(numberOf(light(scene, "infinite").light, "L"), 100 * 0.25 * unit, 1e-9);
  EXPECT_EQ(Vec3d(camera(scene)[3]), Vec3d(1, 1, 1));
  EXPECT_NEAR(camera(scene)[2].y, 1, 1e-12); // looks north
  EXPECT_NEAR(camera(scene)[0].x, 1, 1e-12); // east is to the right
  EXPECT_TRUE(build(scene));
}

TEST_F(GameFile, QuakeFlamesGiveTheLightThatTheirScriptSays) {
  // The picture is the opacity, and the radiance compensates for its mean.
  BspWriter map;
  map.shader("textures/flame");
  map.square(0, 0);
  write("m.pk3", zipFile({{"maps/one.bsp", map.file()},
                          {"textures/flame.png", pngFile(directory + "/x.png", {1, 1, 1}, {0, 0, 0})},
                          {"scripts/a.shader",
                           "textures/flame\n{\n q3map_surfacelight 1000\n {\n map textures/flame.tga\n"
                           "  blendFunc add\n }\n}\n"}}));
  const SceneDescription scene = load("Shape \"quake3map\" \"string pak\" \"m.pk3\"");
  ASSERT_EQ(scene.areaLights.size(), 1u);
  const double radiance = 1000 * 0.25 * 3.14159265358979 / 64;
  EXPECT_NEAR(numberOf(scene.areaLights[0], "L"), radiance / 0.5, 1e-6 * radiance); // tolerance of floats
  EXPECT_TRUE(build(scene));
}

TEST_F(GameFile, QuakeScriptsCutOutAndEmit) {
  GameShaders shaders;
  std::vector<std::string> warnings;
  readGameShaders(
      "s",
      "Textures/Grate.tga\n{ cull disable\n /* two\nlines */ {\n map textures/g.tga\n alphaFunc GE128\n}\n}\n"
      "textures/flame\n{\n{ animMap 10 a.tga b.tga\nblendFunc add\n}\n}\n"
      "textures/wall\n{\n{ map $lightmap\n}\n{ map w.tga\nblendFunc filter\n}\n}\n"
      "textures/grate { q3map_surfacelight 9\n}\n",
      shaders, warnings);
  EXPECT_TRUE(warnings.empty());
  ASSERT_EQ(shaders.size(), 3u);
  const GameShader& grate = shaders.at("textures/grate");
  EXPECT_TRUE(grate.isTwoSided);
  EXPECT_EQ(grate.surfaceLight, 0); // the first definition counts
  ASSERT_TRUE(grate.base());
  EXPECT_NEAR(*grate.base()->alphaThreshold, 128 / 255.0, 1e-6);
  EXPECT_TRUE(shaders.at("textures/flame").base()->isAdditive());
  EXPECT_EQ(shaders.at("textures/flame").base()->image, "a.tga");
  EXPECT_EQ(shaders.at("textures/wall").base()->image, "w.tga");
  readGameShaders("s", "a\n{\nq3map_surfacelight much\n", shaders, warnings);
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_EQ(warnings[0], "s:3: \"q3map_surfacelight\" has no number 1");
  EXPECT_EQ(warnings[1], "s:1: the block of \"a\" has no end");
}

TEST_F(GameFile, WhatAMapLiesAboutIsAnErrorWithItsPlace) {
  BspWriter good;
  good.shader("textures/wall");
  good.square(0, 0);
  const auto says = [&](const std::function<void(BspWriter&)>& lie, const std::string& what) {
    BspWriter map = good;
    lie(map);
    try {
      readQuake3Bsp("m.bsp", map.file());
      ADD_FAILURE() << "nothing is wrong, instead of: " << what;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(what), std::string::npos) << e.what();
    }
  };
  says([](BspWriter& m) { m.faces.over<int32_t>(0, 1); },
       "m.bsp (list of faces): at byte 0: the shader of a face is 1; it can be 0 to 0");
  says([](BspWriter& m) { m.faces.over<int32_t>(12, 5); }, "at byte 12: the first vertex of a face is 5");
  says([](BspWriter& m) { m.faces.over<int32_t>(16, -4); },
       "at byte 16: the number of vertices of a face is -4");
  says([](BspWriter& m) { m.faces.over<int32_t>(24, 5); }, "5 indices are not a multiple of 3");
  says([](BspWriter& m) { m.faces.over<int32_t>(24, 600); },
       "at byte 24: the number of indices of a face is 600");
  says([](BspWriter& m) { m.indices.over<int32_t>(8, 4); },
       "m.bsp (list of indices): at byte 8: an index of a face is 4; it can be 0 to 3");
  says([](BspWriter& m) { m.vertices.over(4, std::nanf("")); },
       "m.bsp (list of vertices): at byte 4: a vertex is not finite");
  says([](BspWriter& m) { m.shaders.data.pop_back(); }, "71 bytes are not a multiple of 72");
  says([](BspWriter& m) { m.faces.over<int32_t>(8, 2); }, "a patch of 0 by 0 points has 4 vertices");
  says([](BspWriter& m) { m.entities = "{ \"a\" "; }, "a quoted word is expected");
  says([](BspWriter& m) { m.entities = "{ \"a\" \"b\" "; }, "an entity has no end");
  const std::string file = good.file();
  for (const auto& [at, value] : {std::pair(4, 47), {8, 1 << 30}, {12, 1 << 30}, {16, -1}}) {
    Bytes b{file};
    b.over<int32_t>(static_cast<size_t>(at), value);
    EXPECT_THROW(readQuake3Bsp("m.bsp", b.data), Error);
  }
}

TEST_F(GameFile, ArchivesThatLieAreErrors) {
  const std::map<std::string, std::string> files = {{"Maps/One.txt", "twelve bytes"}};
  const std::string good = zipFile(files);
  write("a.zip", good);
  {
    const GameFiles game({directory + "/a.zip"});
    EXPECT_EQ(game.read("maps\\one.TXT"), "twelve bytes");
    EXPECT_FALSE(game.has("maps/two.txt"));
  }
  const auto readAll = [&](const std::string& bytes) {
    write("a.zip", bytes);
    const ZipArchive zip(directory + "/a.zip");
    for (const std::string& name : zip.names()) zip.read(name);
  };
  for (const char* bytes : {"", "PK", "no archive"}) EXPECT_THROW(readAll(bytes), Error);
  Bytes damaged{good};
  damaged.over(45, 'T'); // in the content: its checksum is wrong
  EXPECT_THROW(readAll(damaged.data), Error);
  write("m.pk3", good);
  load("Shape \"quake3map\" \"string pak\" \"m.pk3\"", true);
  EXPECT_NE(messages.find("m.pk3 has no map"), std::string::npos) << messages;
}

TEST_F(GameFile, MutatedFilesNeverDoMoreThanFail) {
  // The fuzzers in tests/fuzz continue with these without a limit.
  const int times = SANITIZED ? 1000 : 5000;
  BspWriter map;
  map.shader("textures/wall");
  map.square(0, 0);
  for (int i = 0; i < 9; ++i) map.vertex({float(i % 3), float(i / 3), 0}, {0, 0}, {0, 0, 1});
  map.face(0, 2, 4, 6, 3, 3);
  std::mt19937 random(1);
  const auto mutated = [&random](std::string bytes) {
    const unsigned changes = 1 + random() % 4;
    for (unsigned i = 0; i < changes; ++i) {
      const size_t at = random() % bytes.size();
      const int32_t values[] = {
          0, -1, 1, 0x7fffffff, static_cast<int32_t>(random()), static_cast<int32_t>(random() % 64)};
      const int32_t value = values[random() % 6];
      std::memcpy(&bytes[at], &value, std::min<size_t>(1 + random() % 4, bytes.size() - at));
    }
    if (random() % 8 == 0) bytes.resize(random() % bytes.size());
    return bytes;
  };
  int fine = 0;
  const auto attempt = [&fine](const std::function<void()>& read) {
    try {
      read();
      ++fine;
    } catch (const Error&) {
      // expected result
    }
  };
  for (int i = 0; i < times; ++i) {
    attempt([&] {
      Quake3Bsp bsp = readQuake3Bsp("m", mutated(map.file()));
      const int steps = patchSteps(bsp, 0.1, 8);
      for (Quake3Bsp::Face& face : bsp.faces)
        if (face.patchWidth > 0) tessellatePatch(face, steps);
    });
    attempt([&] {
      const std::string bytes = mutated(md2File("skin.pcx"));
      const Md2Model model("m", bytes);
      model.skins();
      model.animations();
      model.pose(double(model.frames() - 1) / 2);
    });
    attempt([&] { detail::tgaOfPcx("p", mutated(pcxFile())); });
  }
  EXPECT_GT(fine, times / 10); // some changes are harmless, and the rest causes errors
  EXPECT_LT(fine, 3 * times);
}
