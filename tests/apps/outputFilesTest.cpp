/** @file
 * Files that commands write: their positions, existing files, and refusals.
 */
#include "program.h"

#include <sys/stat.h>

#include "recurse/core/image/image.h"

using namespace programTesting;

namespace {

class OutputFiles : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    std::filesystem::create_directories(file("in"));
    std::filesystem::rename(file("scene.pbrt"), file("in/scene.pbrt"));
  }
  /** Renders a scene whose film has this name in the folder "in" without -o. */
  Outcome renderFilm(const std::string& name) const {
    std::string text = scene();
    text.replace(text.find("film.exr"), 8, name);
    write("in/film.pbrt", text);
    return runIn(file("in"), {"render", "film.pbrt", "--integrator", "path", "--spp", "1", "-q"});
  }
  static void writePicture(const std::string& name) {
    recurse::Image grey(8, 8, {"R", "G", "B"});
    for (float& value : grey.pixels) value = 0.5f;
    writeImage(name, grey);
  }
};

} // namespace

TEST_F(OutputFiles, AFilmsNameLeadsNowhereButToTheCurrentFolder) {
  for (const std::string& name :
       {file("out.exr"), std::string("../out.exr"), std::string("x/../../out.exr")}) {
    const Outcome o = renderFilm(name);
    EXPECT_EQ(o.status, 0) << o.err;
    EXPECT_FALSE(exists("out.exr")) << name;
    EXPECT_TRUE(exists("in/out.exr")) << name;
    EXPECT_TRUE(has(o.err, "out.exr in the current folder") && has(o.err, "-o")) << o.err;
    std::filesystem::remove(file("in/out.exr"));
    std::filesystem::remove(file("out.exr"));
  }
  // A symbolic link next to the scene.
  writePicture(file("holiday.exr"));
  const std::string before = contents(file("holiday.exr"));
  std::filesystem::create_symlink("../holiday.exr", file("in/link.exr"));
  EXPECT_EQ(renderFilm("link.exr").status, 2);
  std::filesystem::create_directory_symlink("..", file("in/up"));
  EXPECT_EQ(renderFilm("up/holiday.exr").status, 0);
  EXPECT_EQ(contents(file("holiday.exr")), before);
  // Plain names, and folders below.
  std::filesystem::create_directories(file("in/pictures"));
  for (const std::string name : {"plain.exr", "pictures/a.exr"}) {
    const Outcome o = renderFilm(name);
    EXPECT_EQ(o.status, 0) << o.err;
    EXPECT_EQ(o.err.find("current folder"), std::string::npos) << o.err;
    EXPECT_TRUE(exists("in/" + name));
  }
}

TEST_F(OutputFiles, OneFileIsNotWrittenForTwoPurposes) {
  const std::string scene = "in/scene.pbrt";
  const std::vector<std::string> render = {"render", scene, "--integrator", "path", "--spp", "1", "-q"};
  ASSERT_EQ(run({"render", scene, "--integrator", "path", "--spp", "4", "-q", "--sample-range", "0:2",
                 "--checkpoint", "a.rck"})
                .status,
            0);
  for (const char* name : {"a.exr", "b.exr", "in/c.png"}) writePicture(file(name));
  std::filesystem::create_symlink("a.exr", file("soft.exr"));
  std::filesystem::create_hard_link(file("a.exr"), file("hard.exr"));
  std::filesystem::create_directory_symlink("in", file("folder"));
  std::filesystem::copy_file(file("a.rck"), file("r.exr"));
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), render.begin(), render.end());
    return more;
  };
  const std::string self = std::filesystem::canonical(folder).filename().string();
  const std::vector<std::vector<std::string>> commands = {
      with({"-o", "x.exr", "--stats", "x.exr"}),
      with({"-o", "x.exr", "--stats", "./in/../x.exr"}),
      with({"-o", "x.exr", "--stats", "../" + self + "/x.exr"}),
      with({"-o", "x.exr", "--stats", file("x.exr")}),
      with({"-o", "in/x.exr", "--stats", "folder/x.exr"}),
      with({"-o", "x.exr", "--checkpoint", "x.exr"}),
      with({"-o", "x.exr", "--checkpoint", "./x.exr"}),
      with({"-o", "x.exr", "--stats", "c.rck", "--checkpoint", "c.rck"}),
      with({"-o", "x.exr", "--preview", "./x.exr"}),
      with({"-o", "x.exr", "-o", "./x.exr"}),
      with({"-o", "a.exr", "-o", "hard.exr"}),
      with({"-o", "a.exr", "--stats", "soft.exr"}),
      {"compare", "a.exr", "b.exr", "-o", "a.exr"},
      {"compare", "a.exr", "b.exr", "-o", "./b.exr"},
      {"compare", "a.exr", "b.exr", "-o", "soft.exr"},
      {"compare", "soft.exr", "b.exr", "-o", "hard.exr"},
      {"compare", "b.exr", "b.exr", "a.exr", "-o", "a.exr"},
      {"compare", "b.exr", "b.exr", "--noise-free", "b.exr", "a.exr", "-o", "a.exr"},
      {"develop", "in/c.png", "-o", "folder/c.png"},
      {"develop", "a.exr", "-o", "d.png", "-o", "./d.png"},
      {"merge", "r.exr", "-o", "r.exr"},
      {"merge", "a.rck", "--checkpoint", "a.rck"},
      {"merge", "a.rck", "--partial", "-o", "x.exr", "--checkpoint", "x.exr"},
      {"stills", scene, "-o", "s", "--spp", "1", "--stats", "s/stills.exr"},
      {"stills", scene, "-o", "s", "--spp", "1", "--stats", "s/common/caustic.png"},
      {"converge", scene, "-o", "s", "--samples", "1", "--reference", "s/cells/a.exr"},
  };
  std::filesystem::create_directories(file("s/cells"));
  std::filesystem::create_directories(file("s/common"));
  writePicture(file("s/cells/a.exr"));
  std::map<std::string, std::string> before;
  for (const char* name : {"a.exr", "b.exr", "in/c.png", "r.exr", "a.rck", "s/cells/a.exr"})
    before[name] = contents(file(name));
  for (const std::vector<std::string>& arguments : commands) {
    const Outcome o = run(arguments);
    std::string line;
    for (const std::string& a : arguments) line += a + " ";
    EXPECT_EQ(o.status, 2) << line << o.err;
    EXPECT_TRUE(has(o.err, "same file") || has(o.err, "cannot be overwritten") || has(o.err, "in the folder"))
        << line << o.err;
    EXPECT_FALSE(exists("x.exr") || exists("in/x.exr") || exists("d.png")) << line;
    for (const auto& [name, text] : before) EXPECT_TRUE(contents(file(name)) == text) << line << name;
  }
  // /dev/null may be named twice.
  EXPECT_EQ(run(with({"-o", "x.exr", "--stats", "/dev/null"})).status, 0);
}

TEST_F(OutputFiles, AConvertedModelDoesNotTakeThePlaceOfItsFiles) {
  std::filesystem::create_directories(file("made-files"));
  write("made-files/mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  ASSERT_EQ(run({"convert", "made-files/mesh.obj", "-o", "made.pbrt"}).status, 0);
  std::vector<std::string> meshes;
  for (const auto& entry : std::filesystem::directory_iterator(file("made-files")))
    if (entry.path().extension() == ".ply") meshes.push_back(entry.path().filename().string());
  ASSERT_EQ(meshes.size(), 1u);
  // Model instead of a scene: a mesh with the name that its copy would have.
  std::string model;
  for (int i = 0; i < 2 && model.empty(); ++i) {
    ASSERT_EQ(run({"convert", "made-files/" + meshes[0], "-o", "again.pbrt"}).status, 0);
    for (const auto& entry : std::filesystem::directory_iterator(file("again-files")))
      model = entry.path().filename().string();
  }
  std::filesystem::copy_file(file("again-files/" + model), file("made-files/" + model),
                             std::filesystem::copy_options::overwrite_existing);
  const Outcome o = run({"convert", "made-files/" + model, "-o", "made.pbrt"});
  EXPECT_EQ(o.status, 2) << o.err;
  EXPECT_TRUE(has(o.err, "cannot be overwritten")) << o.err;
}

TEST_F(OutputFiles, NamedPipesAreNotWaitedFor) {
  for (const char* name : {"p.exr", "p.rck", "p.bin", "p.mtl", "p.ply", "p.json"})
    ASSERT_EQ(::mkfifo(file(name).c_str(), 0600), 0);
  write("m.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "buffers": [{"byteLength": 36, "uri": "p.bin"}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}]})");
  write("m.obj", "mtllib p.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::string scene = "in/scene.pbrt";
  const std::vector<std::string> quick = {"--integrator", "path", "--spp", "1", "-q"};
  for (std::vector<std::string> arguments : {std::vector<std::string>{"render", scene, "-o", "p.exr"},
                                             {"render", scene, "-o", "a.exr", "--stats", "p.json"},
                                             {"merge", "p.rck", "-o", "a.exr"},
                                             {"info", "p.exr"},
                                             {"compare", "p.exr", "p.exr"},
                                             {"convert", "m.gltf", "-o", "m.pbrt"},
                                             {"convert", "p.ply", "-o", "m.pbrt"}}) {
    const std::string command = arguments[0] + " " + arguments[1];
    if (arguments[0] == "render") arguments.insert(arguments.end(), quick.begin(), quick.end());
    const Outcome o = runAMinute(arguments);
    EXPECT_NE(o.status, 128 + SIGKILL) << command;
    EXPECT_NE(o.status, 0) << command;
    EXPECT_TRUE(has(o.err, "p.")) << command << ": " << o.err;
  }
  // A model with missing materials loses only the materials.
  EXPECT_EQ(runAMinute({"convert", "m.obj", "-o", "m.pbrt"}).status, 0);
}

TEST_F(OutputFiles, StandardOutputIsAFileToWriteTo) {
  const std::string command =
      "cd '" + file("in") + "' && '" + RECURSE_PROGRAM +
      "' render scene.pbrt --integrator path --spp 1 -q -o a.exr --stats /dev/stdout | "
      "cat >stats.json";
  ASSERT_EQ(std::system(command.c_str()), 0);
  EXPECT_TRUE(has(contents(file("in/stats.json")), "\"stop_reason\""));
}

TEST_F(OutputFiles, MessagesAndListingsMoveNoCursor) {
  recurse::Image grey(2, 2, {"R", "G", "B"});
  grey.metadata["note"] = "\x1b]0;title\x07 \xc2\x9b"
                          "31m red \x7f";
  grey.metadata["comment"] = "two\r\nlines";
  writeImage(file("a.exr"), grey);
  std::filesystem::copy_file(file("a.exr"), file("\x1b[2Jb.exr"));
  write("bad.pbrt", "Film \"rgb\" \"string \x1b[31mname\" \"a\"\nWorldBegin\nShape \"\x1b[31msphere\"\n");
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"info", "a.exr"},
        {"info", "\x1b[2Jb.exr"},
        {"info", "\x1b[2Jmissing.exr"},
        {"render", "bad.pbrt"},
        {"compare", "\x1b[2Jb.exr", "a.exr"},
        {"develop", "a.exr", "-o", "\x1b[31m.png"},
        {"render", "in/scene.pbrt", "--integrator", "path", "--spp", "1", "-o", "\x1b[31m.exr"},
        {"\x1b[31m"}}) {
    const Outcome o = run(arguments);
    for (const std::string& text : {o.out, o.err})
      EXPECT_EQ(text.find_first_of("\x1b\x07\x7f\r"), std::string::npos) << arguments[0] << ": " << text;
    EXPECT_EQ((o.out + o.err).find("\xc2\x9b"), std::string::npos);
  }
  EXPECT_TRUE(has(run({"info", "a.exr"}).out, "\\x1b]0;title\\x07")) << run({"info", "a.exr"}).out;
}
