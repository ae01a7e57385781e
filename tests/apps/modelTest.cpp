/** @file
 * Models on the command line: `recurse convert`, and `recurse render` of a model itself.
 */
#include "program.h"

#include "model/gameFileTesting.h"
#include "recurse/core/image/image.h"

using namespace programTesting;
using recurse::Image;
using recurse::readImage;

namespace {

class ProgramModel : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    std::filesystem::create_directories(file("models"));
    write("models/box.obj",
          "mtllib box.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
          "vt 0 0\nvt 1 0\nvt 1 1\nusemtl red\nf 5/1 6/2 7/3 8/1\nf 2/1 1/2 4/3 3/1\n"
          "f 1/1 5/2 8/3 4/1\nf 6/1 2/2 3/3 7/1\nf 8/1 7/2 3/3 4/1\nf 1/1 2/2 6/3 5/1\n");
    write("models/box.mtl", "newmtl red\nKd 1 1 1\nmap_Kd red.png\n");
    Image red(1, 1, {"R", "G", "B"});
    red.at(0, 0)[0] = 0.8f;
    writeImage(file("models/red.png"), red);
  }
};

/** Mean of the middle of a picture. */
recurse::Rgb middle(const Image& image) {
  recurse::Rgb sum(0);
  for (int y = 9; y < 15; ++y)
    for (int x = 13; x < 19; ++x) sum += image.rgb(x, y);
  return sum / 36.0f;
}

} // namespace

TEST_F(ProgramModel, IsRenderedAsItIs) {
  const Outcome o = run({"render", "models/box.obj", "-o", "box.exr", "--resolution", "32x24", "--spp", "4",
                         "--integrator", "path"});
  ASSERT_EQ(o.status, 0) << o.err;
  const Image picture = readImage(file("box.exr"));
  EXPECT_GT(middle(picture).r, 0.2f);
  EXPECT_LT(middle(picture).g, 0.1f);
  EXPECT_NEAR(picture.rgb(0, 0).g, 0.5f, 0.01f); // the sky: the whole box is in the view
  const Outcome check = run({"render", "models/box.obj", "--check"});
  EXPECT_TRUE(has(check.out, "1 mesh, 12 triangles, 1 material, 1 picture")) << check.out;
}

TEST_F(ProgramModel, IsConvertedToASceneThatStandsByItself) {
  Outcome o = run({"convert", "models/box.obj", "-o", "made.pbrt"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(std::filesystem::exists(file("made-files/red.png")));
  const std::vector<std::string> settings = {"--resolution", "32x24", "--spp", "4", "--integrator", "path"};
  const auto picture = [&](const std::string& scene, const std::string& output) {
    std::vector<std::string> arguments = {"render", scene, "-o", output};
    arguments.insert(arguments.end(), settings.begin(), settings.end());
    const Outcome rendered = run(arguments);
    EXPECT_EQ(rendered.status, 0) << rendered.err;
    return readImage(file(output)).pixels;
  };
  const std::vector<float> direct = picture("models/box.obj", "a.exr");
  std::filesystem::remove_all(file("models"));
  EXPECT_EQ(picture("made.pbrt", "b.exr"), direct);
}

TEST_F(ProgramModel, TheCameraLooksAtTheInstancesOfAMeshNotAtTheMesh) {
  const float numbers[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  write("models/m.bin", std::string(reinterpret_cast<const char*>(numbers), sizeof numbers));
  write(
      "models/m.gltf",
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[)"
      R"({"mesh":0,"translation":[1000,0,0]},{"mesh":0,"translation":[1001,0,0]}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
      R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],)"
      R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"uri":"m.bin","byteLength":36}]})");
  ASSERT_EQ(run({"convert", "models/m.gltf", "-o", "made.pbrt"}).status, 0);
  std::istringstream text(contents(file("made.pbrt")));
  for (std::string word; word != "LookAt";) ASSERT_TRUE(text >> word);
  double eye[3], center[3];
  for (double& x : eye) text >> x;
  for (double& x : center) text >> x;
  EXPECT_NEAR(center[0], 1001, 1e-3);
}

TEST_F(ProgramModel, AMapOfAGameIsChosenWithItsCamera) {
  using namespace recurse::testing;
  BspWriter map;
  map.shader("textures/floor");
  map.square(0, 0);
  map.entities = "{ \"classname\" \"worldspawn\" }\n"
                 "{ \"classname\" \"light\" \"origin\" \"40 40 60\" }\n"
                 "{ \"classname\" \"info_player_deathmatch\" \"origin\" \"-20 40 4\" \"angle\" \"180\" }\n"
                 "{ \"classname\" \"info_player_deathmatch\" \"origin\" \"-20 40 4\" \"angle\" \"0\" }\n";
  std::filesystem::create_directories(file("game"));
  const std::string red = contents(file("models/red.png"));
  write("game/a-pictures.pk3", zipFile({{"textures/floor.png", red}}));
  write("game/broken.pk3", "no archive");
  write("game/maps.pk3", zipFile({{"maps/one.bsp", map.file()}, {"maps/two.bsp", map.file()}}));
  const auto render = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"render", "game/maps.pk3", "-o", "m.exr",        "--resolution",
                                          "32x24",  "--spp",         "1",  "--integrator", "path"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  };
  const Outcome several = render({});
  EXPECT_EQ(several.status, 3);
  EXPECT_TRUE(has(several.err, "--map, of: one, two")) << several.err;
  const Outcome o = render({"--map", "two", "--camera", "spawn:2"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_FALSE(has(o.err, "no picture")) << o.err;
  const recurse::Rgb floor = readImage(file("m.exr")).rgb(16, 20);
  EXPECT_GT(floor.r, 0);
  EXPECT_EQ(floor.g, 0); // by the picture in the archive next to it
  const Outcome away = render({"--map", "two", "--camera", "spawn 1"});
  ASSERT_EQ(away.status, 0) << away.err;
  EXPECT_EQ(readImage(file("m.exr")).rgb(16, 20).r, 0);
  const Outcome none = render({"--map", "two", "--camera", "spawn:3"});
  EXPECT_EQ(none.status, 2);
  EXPECT_TRUE(has(none.err, "there are: spawn:1, spawn:2")) << none.err;
  EXPECT_EQ(run({"render", "scene.pbrt", "--camera", "spawn:1"}).status, 2);
  EXPECT_EQ(run({"render", "models/box.obj", "--map", "two"}).status, 2);
  // A map outside of archives, next to the archives of its game.
  std::filesystem::create_directories(file("game/maps"));
  write("game/maps/three.bsp", map.file());
  const Outcome loose = run({"render", "game/maps/three.bsp", "-o", "m.exr", "--resolution", "32x24", "--spp",
                             "1", "--integrator", "path", "--camera", "spawn:2"});
  ASSERT_EQ(loose.status, 0) << loose.err;
  EXPECT_FALSE(has(loose.err, "no picture")) << loose.err;
  EXPECT_GT(readImage(file("m.exr")).rgb(16, 20).r, 0);
}

TEST_F(ProgramModel, MapsOfOpenArenaAreRendered) {
  const std::string maps = "/usr/share/games/openarena/baseoa/pak1-maps.pk3";
  if (!std::filesystem::exists(maps))
    GTEST_SKIP() << "Debian's packages openarena-081-maps, openarena-081-textures and openarena-data are not "
                    "installed";
  for (const char* map : {"aggressor", "oa_ctf2", "suspended"}) {
    const Outcome o = run({"render", maps, "--map", map, "--camera", "spawn:1", "--integrator", "path",
                           "--spp", "4", "--resolution", "64x48", "-o", "map.exr"});
    ASSERT_EQ(o.status, 0) << map << o.err;
    const Image picture = readImage(file("map.exr"));
    int lit = 0;
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 64; ++x) lit += recurse::maxComponent(picture.rgb(x, y)) > 0 ? 1 : 0;
    EXPECT_GT(lit, 48 * 64 / 2) << map;
  }
}

TEST_F(ProgramModel, WrongUsageIsExplained) {
  EXPECT_EQ(run({"convert", "scene.pbrt", "-o", "made.pbrt"}).status, 2);
  EXPECT_EQ(run({"convert", "models/box.obj", "-o", "made.txt"}).status, 2);
  const Outcome o = run({"convert", "models/gone.obj", "-o", "made.pbrt"});
  EXPECT_EQ(o.status, 1); // as of a scene file
  EXPECT_TRUE(has(o.err, "cannot read models/gone.obj: no such file")) << o.err;
  EXPECT_FALSE(std::filesystem::exists(file("made.pbrt")));
}

TEST_F(ProgramModel, FilesOutsideOfItsFolderAreNotCopied) {
  write("secret.png", "this is a secret");
  write("models/own.png", "this is the model's own");
  std::filesystem::create_symlink("../secret.png", file("models/link.png"));
  std::filesystem::create_symlink("own.png", file("models/inside.png"));
  write("secret.bin", std::string(36, '\x3f'));
  const auto copied = [&](const std::string& text) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(file("made-files")))
      if (has(contents(entry.path()), text)) return true;
    return false;
  };
  const auto model = [&](const std::string& picture, const std::string& buffer) {
    write("models/m.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
      "nodes": [{"mesh": 0}], "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}], "textures": [{"source": 0}],
      "images": [{"uri": ")" + picture +
                               R"("}], "buffers": [{"byteLength": 36, "uri": ")" + buffer + R"("}],
      "bufferViews": [{"buffer": 0, "byteLength": 36}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}]})");
  };
  write("models/m.bin", std::string("\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x80\x3f\0\0\0\0\0\0\0\0"
                                    "\0\0\0\0\0\0\x80\x3f\0\0\0\0",
                                    36));
  for (const std::string& name : {file("secret.png"), std::string("../secret.png"), std::string("link.png"),
                                  std::string("../models/../secret.png"), std::string("%2e%2e/secret.png")}) {
    model(name, "m.bin");
    const Outcome o = run({"convert", "models/m.gltf", "-o", "made.pbrt"});
    EXPECT_EQ(o.status, 0) << o.err;
    EXPECT_FALSE(copied("secret")) << name;
    EXPECT_TRUE(has(o.err, "outside of the model's folder") && has(o.err, "--allow-outside")) << o.err;
    std::filesystem::remove_all(file("made-files"));
    const Outcome allowed = run({"convert", "models/m.gltf", "-o", "made.pbrt", "--allow-outside"});
    EXPECT_EQ(allowed.status, 0) << allowed.err;
    EXPECT_TRUE(copied("secret")) << name;
    EXPECT_TRUE(has(allowed.err, "outside of the model's folder")) << allowed.err;
    std::filesystem::remove_all(file("made-files"));
  }
  for (const std::string name : {"own.png", "inside.png", "../models/own.png"}) {
    model(name, "m.bin");
    const Outcome o = run({"convert", "models/m.gltf", "-o", "made.pbrt"});
    EXPECT_TRUE(copied("the model's own")) << name;
    EXPECT_FALSE(has(o.err, "outside")) << o.err;
    std::filesystem::remove_all(file("made-files"));
  }
  // Files from which a mesh is read are copied, too.
  model("own.png", "../secret.bin");
  EXPECT_EQ(run({"convert", "models/m.gltf", "-o", "made.pbrt"}).status, 3);
  EXPECT_FALSE(exists("made.pbrt") && exists("made-files"));
  EXPECT_EQ(run({"convert", "models/m.gltf", "-o", "made.pbrt", "--allow-outside"}).status, 0);
}
