/** @file
 * Scenes of several files: Include as insertion of tokens, Import as a scope, compression, paths.
 */
#include <sys/stat.h>
#include <zlib.h>

#include "sceneTesting.h"

using namespace recurse;

namespace {

SceneDescription load(const TemporaryDirectory& d, const std::string& name, std::string* messages = nullptr) {
  Diagnostics diagnostics;
  SceneDescription s = loadScene(d.path(name), diagnostics);
  if (messages)
    *messages = diagnostics.format();
  else
    EXPECT_FALSE(diagnostics.hasErrors()) << diagnostics.format();
  return s;
}

std::string messagesOf(const TemporaryDirectory& d, const std::string& name) {
  std::string text;
  load(d, name, &text);
  return text;
}

void writeCompressed(const std::string& path, const std::string& text) {
  gzFile f = gzopen(path.c_str(), "wb");
  gzwrite(f, text.data(), static_cast<unsigned>(text.size()));
  gzclose(f);
}

} // namespace

TEST(Files, ParametersContinueAcrossIncludes) {
  const TemporaryDirectory d;
  d.write("a.pbrt",
          "WorldBegin Shape \"m\" \"float a\" 1 Include \"b.pbrt\" \"float d\" [ 4 Include \"n.txt\" 6 ] "
          "Include \"c.pbrt\" \"float e\" 1");
  d.write("b.pbrt", "\"float b\" 2 \"float c\" [3]");
  d.write("n.txt", "5");
  d.write("c.pbrt", "Shape \"begun here\"");
  const SceneDescription s = load(d, "a.pbrt");
  ASSERT_EQ(s.shapes.size(), 2u);
  const auto& p = s.shapes[0].shape.parameters;
  ASSERT_EQ(p.size(), 4u);
  EXPECT_EQ(p[1].name, "b");
  EXPECT_EQ(p[3].numbers, (std::vector<double>{4, 5, 6}));
  EXPECT_EQ(s.shapes[1].shape.parameters.at(0).name, "e");
}

TEST(Files, IncludeSharesTheState) {
  const TemporaryDirectory d;
  d.write("a.pbrt", "Include \"sub/settings.pbrt\" WorldBegin Include \"sub/b.pbrt\" Shape \"s\"");
  d.write("sub/settings.pbrt", "Camera \"perspective\"");
  d.write("sub/b.pbrt", "Translate 1 0 0");
  const SceneDescription s = load(d, "a.pbrt");
  EXPECT_TRUE(s.camera.given());
  EXPECT_EQ(s.shapes.at(0).worldFromObject[3].x, 1);
}

TEST(Files, ImportIsAScope) {
  const TemporaryDirectory d;
  d.write("a.pbrt", "WorldBegin Translate 1 0 0 Material \"m\" Import \"b.pbrt\" Shape \"after\" "
                    "ObjectBegin \"o\" Import \"c.pbrt\" ObjectEnd NamedMaterial \"n\"");
  d.write(
      "b.pbrt",
      "Translate 1 0 0 Material \"other\" Shape \"inside\" MakeNamedMaterial \"n\" \"string type\" \"x\"");
  d.write("c.pbrt", "Shape \"in the object\"");
  const SceneDescription s = load(d, "a.pbrt");
  ASSERT_EQ(s.shapes.size(), 2u);
  EXPECT_EQ(s.shapes[0].worldFromObject[3].x, 2);
  EXPECT_EQ(s.shapes[1].worldFromObject[3].x, 1);
  EXPECT_EQ(s.materials.at(static_cast<size_t>(s.shapes[1].material.index)).type, "m");
  EXPECT_EQ(s.objects.at("o").shapes.size(), 1u);
  EXPECT_EQ(s.namedMaterials.count("n"), 1u);
}

TEST(Files, ImportErrors) {
  const TemporaryDirectory d;
  d.write("early.pbrt", "Import \"x.pbrt\" WorldBegin");
  d.write("x.pbrt", "Shape \"s\"");
  EXPECT_CONTAINS(messagesOf(d, "early.pbrt"), "Import must stand after WorldBegin");
  d.write("open.pbrt", "WorldBegin Import \"y.pbrt\" Shape \"s\"");
  d.write("y.pbrt", "AttributeBegin");
  EXPECT_CONTAINS(messagesOf(d, "open.pbrt"), "y.pbrt:1:1: error: this block has no AttributeEnd");
  d.write("closed.pbrt", "WorldBegin AttributeBegin Import \"z.pbrt\" AttributeEnd");
  d.write("z.pbrt", "AttributeEnd");
  EXPECT_CONTAINS(messagesOf(d, "closed.pbrt"), "in the imported file");
  d.write("object.pbrt", "WorldBegin ObjectBegin \"o\" Import \"w.pbrt\" ObjectEnd");
  d.write("w.pbrt", "ObjectEnd");
  EXPECT_CONTAINS(messagesOf(d, "object.pbrt"), "file that imports this one");
}

TEST(Files, RecursionIsAnErrorWithTheChain) {
  const TemporaryDirectory d;
  d.write("a.pbrt", "WorldBegin Include \"b.pbrt\"");
  d.write("b.pbrt", "Import \"c.pbrt\"");
  d.write("c.pbrt", "Include \"./a.pbrt\"");
  const std::string text = messagesOf(d, "a.pbrt");
  EXPECT_CONTAINS(text, "would repeat forever");
  EXPECT_CONTAINS(text,
                  "a.pbrt includes " + d.path("b.pbrt") + " includes " + d.path("c.pbrt") + " includes ");
}

TEST(Files, DepthAndTextOfIncludesAreLimited) {
  const TemporaryDirectory d;
  d.write("a.pbrt", "WorldBegin Include \"0.pbrt\"");
  for (int i = 0; i < 100; ++i)
    d.write(std::to_string(i) + ".pbrt", "Include \"" + std::to_string(i + 1) + ".pbrt\"");
  EXPECT_CONTAINS(messagesOf(d, "a.pbrt"), "64 levels deep");
  // Each file includes the next one twice: 2^40 tokens without a limit.
  for (int i = 0; i < 40; ++i) {
    const std::string next = "Include \"" + std::to_string(i + 1) + ".pbrt\" ";
    d.write(std::to_string(i) + ".pbrt", next + next);
  }
  d.write("40.pbrt", "");
  EXPECT_CONTAINS(messagesOf(d, "a.pbrt"), "too long in total");
  EXPECT_CONTAINS(messagesOf(d, "a.pbrt"), "64 GiB");
}

TEST(Files, ManySmallFilesMayBeIncluded) {
  const TemporaryDirectory d;
  std::string all = "WorldBegin\n";
  for (int i = 0; i < 100001; ++i) all += "Include \"b.pbrt\"\n";
  d.write("a.pbrt", all);
  d.write("b.pbrt", "AttributeBegin AttributeEnd");
  EXPECT_EQ(messagesOf(d, "a.pbrt"), "");
}

TEST(Files, RepeatedIncludeIsFine) {
  const TemporaryDirectory d;
  d.write("a.pbrt", "WorldBegin Include \"b.pbrt\" Include \"b.pbrt\"");
  d.write("b.pbrt", "Shape \"s\"");
  EXPECT_EQ(load(d, "a.pbrt").shapes.size(), 2u);
}

TEST(Files, PathsAreRelativeToTheNamingFileThenToTheTop) {
  const TemporaryDirectory d;
  d.write("top.pbrt", "WorldBegin Include \"sub/a.pbrt\" \"string texture\" \"t.png\"");
  d.write("sub/a.pbrt", "Include \"both.pbrt\" Include \"onlytop.pbrt\" "
                        "Shape \"plymesh\" \"string filename\" \"m.ply\" \"string atTop\" \"n.ply\"");
  d.write("sub/both.pbrt", "Shape \"sub\"");
  d.write("both.pbrt", "Shape \"top\"");
  d.write("onlytop.pbrt", "Shape \"onlytop\"");
  d.write("sub/m.ply", "x");
  d.write("n.ply", "x");
  d.write("t.png", "x");
  d.write("sub/t.png", "x");
  const SceneDescription s = load(d, "top.pbrt");
  ASSERT_EQ(s.shapes.size(), 3u);
  EXPECT_EQ(s.shapes[0].shape.type, "sub");
  EXPECT_EQ(s.shapes[1].shape.type, "onlytop");
  Diagnostics diagnostics;
  const Parameters p = bindParameters(s.shapes[2].shape,
                                      {stringParameter("filename", "", ""), stringParameter("atTop", "", ""),
                                       stringParameter("texture", "", "")},
                                      diagnostics, false);
  EXPECT_FALSE(diagnostics.hasErrors()) << diagnostics.format();
  EXPECT_EQ(p.filePath("filename"), d.path("sub/m.ply"));
  EXPECT_EQ(p.filePath("atTop"), d.path("n.ply"));
  // The parameter is in the top file, though the directive began in the included one.
  EXPECT_EQ(p.filePath("texture"), d.path("t.png"));
  EXPECT_EQ(p.directory(), d.path("sub"));
}

TEST(Files, MissingFiles) {
  const TemporaryDirectory d;
  d.write("sub/a.pbrt", "WorldBegin\nInclude \"no.pbrt\" Include 5 Shape \"s\" Include");
  const std::string text = messagesOf(d, "sub/a.pbrt");
  EXPECT_CONTAINS(text, "a.pbrt:2:9: error: Include: no such file: \"no.pbrt\"");
  EXPECT_CONTAINS(text, "tried " + d.path("sub/no.pbrt"));
  EXPECT_CONTAINS(text, "Include needs a file name in quotes, found '5'");
  EXPECT_CONTAINS(text, "Include needs a file name in quotes, found the end of the file");
  Diagnostics diagnostics;
  EXPECT_THROW(loadScene(d.path("absent.pbrt"), diagnostics), Error);
  EXPECT_THROW(loadScene(d.path(""), diagnostics), Error);
  EXPECT_THROW(loadScene("", diagnostics), Error);
}

TEST(Files, OnlyRegularFilesAreRead) {
  const TemporaryDirectory d;
  ASSERT_EQ(mkfifo(d.path("pipe").c_str(), 0600), 0);
  d.write("a.pbrt", "WorldBegin Include \"pipe\" Include \"/dev/zero\" Include \".\" Include \"\"");
  const std::string text = messagesOf(d, "a.pbrt");
  EXPECT_CONTAINS(text, "not a regular file");
  EXPECT_CONTAINS(text, "/dev/zero");
}

TEST(Files, CompressedByContent) {
  const TemporaryDirectory d;
  writeCompressed(d.path("a.pbrt.gz"), "WorldBegin Include \"b.pbrt\" Include \"c.pbrt.gz\"");
  writeCompressed(d.path("b.pbrt"), "Shape \"b\"");
  d.write("c.pbrt.gz", "Shape \"not compressed\"");
  const SceneDescription s = load(d, "a.pbrt.gz");
  EXPECT_EQ(s.shapes.size(), 2u);
}

TEST(Files, DamagedCompressionIsAnError) {
  const TemporaryDirectory d;
  std::string text = "WorldBegin ";
  for (int i = 0; i < 5000; ++i) text += "Translate " + std::to_string(i * 7919 % 10007) + " 0 0 ";
  writeCompressed(d.path("whole.gz"), text);
  std::ifstream in(d.path("whole.gz"), std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  Diagnostics diagnostics;
  EXPECT_NO_THROW(loadScene(d.path("whole.gz"), diagnostics));
  d.write("cut.gz", bytes.substr(0, bytes.size() / 2));
  EXPECT_THROW(loadScene(d.path("cut.gz"), diagnostics), Error);
  d.write("tail.gz", bytes.substr(0, bytes.size() - 4));
  EXPECT_THROW(loadScene(d.path("tail.gz"), diagnostics), Error);
  std::string damaged = bytes;
  damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 0x55);
  d.write("damaged.gz", damaged);
  EXPECT_THROW(loadScene(d.path("damaged.gz"), diagnostics), Error);
  d.write("a.pbrt", "WorldBegin Include \"cut.gz\" Shape \"s\"");
  EXPECT_CONTAINS(messagesOf(d, "a.pbrt"), "cut.gz");
}
