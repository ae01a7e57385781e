/** @file
 * `recurse stills`: files, summary, errors.
 */
#include "program.h"

#include <algorithm>
#include <map>

#include <nlohmann/json.hpp>

#include "recurse/core/image/image.h"

using namespace programTesting;

namespace {

const std::vector<std::string> ALL_FILES = {"stills.exr", "sheet.png", "index.html", "common/beauty.png",
                                            "own/beauty.png"};

} // namespace

class StillsCommand : public Program {};

TEST_F(StillsCommand, WritesEverythingAndTellsShares) {
  const Outcome o =
      run({"stills", "scene.pbrt", "-o", "new/folder", "--photons", "2000", "--stats", "s.json"});
  ASSERT_EQ(o.status, 0) << o.err;
  for (const std::string& name : ALL_FILES) EXPECT_TRUE(exists("new/folder/" + name)) << name;
  for (const char* name : {"emitted", "direct-diffuse", "caustic", "remainder"}) {
    EXPECT_TRUE(exists("new/folder/common/" + std::string(name) + ".png")) << name;
    EXPECT_TRUE(exists("new/folder/own/" + std::string(name) + ".png")) << name;
    EXPECT_TRUE(has(o.out, name)) << o.out;
  }
  EXPECT_TRUE(exists("s.json"));
  EXPECT_TRUE(has(o.out, "100.00 %")) << o.out;
  EXPECT_TRUE(has(o.out, "LS+DS*E")) << o.out;
  EXPECT_FALSE(has(o.out, "note:")) << o.out;
  EXPECT_EQ(leftBehind(), 0u);
  const Outcome info = run({"info", "new/folder/stills.exr"});
  EXPECT_TRUE(has(info.out, "direct-diffuse.G")) << info.out;
  EXPECT_TRUE(has(info.out, "direct-diffuse = LDE")) << info.out;
  EXPECT_TRUE(has(info.out, "recurse stills scene.pbrt")) << info.out;
}

TEST_F(StillsCommand, ShowsMediaWhereThereAre) {
  ASSERT_EQ(run({"stills", "scene.pbrt", "-o", "clear", "-q", "--integrator", "path"}).status, 0);
  EXPECT_FALSE(exists("clear/common/medium-direct.png"));
  write("fog.pbrt", scene("MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\n"
                          "MediumInterface \"\" \"fog\"\n"));
  const Outcome o = run({"stills", "fog.pbrt", "-o", "fog", "--integrator", "path"});
  ASSERT_EQ(o.status, 0) << o.err;
  for (const char* name : {"medium-direct", "medium-caustic", "medium-multiple", "surface-lit-by-medium"}) {
    EXPECT_TRUE(exists("fog/common/" + std::string(name) + ".png")) << name;
    EXPECT_TRUE(has(o.out, name)) << o.out;
  }
  EXPECT_TRUE(has(o.out, "LS+VE")) << o.out;
  // With --class there are no default classes.
  ASSERT_EQ(
      run({"stills", "fog.pbrt", "-o", "asked", "-q", "--integrator", "path", "--class", "v=medium"}).status,
      0);
  EXPECT_FALSE(exists("asked/common/medium-direct.png"));
}

TEST_F(StillsCommand, TellsOverlapsAndWhatIsLeftOver) {
  const Outcome o = run(
      {"stills", "scene.pbrt", "-o", "s", "--integrator", "path", "--class", "a=LD+E", "--class", "b=LDE"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(has(o.out, "a and b overlap")) << o.out;
  EXPECT_TRUE(has(o.out, "rest")) << o.out;
  EXPECT_TRUE(exists("s/common/rest.png"));
  EXPECT_FALSE(exists("s/common/all.png"));
  const Outcome quiet = run({"stills", "scene.pbrt", "-o", "s", "-q", "--integrator", "path"});
  EXPECT_EQ(quiet.status, 0);
  EXPECT_EQ(quiet.out + quiet.err, "");
}

TEST_F(StillsCommand, LightOfNoLampIsInTheLayerOfNoLamp) {
  write("ambient.pbrt", scene("Integrator \"raycast\" \"rgb ambient\" [ .5 .5 .5 ]\n"));
  write("occlusion.pbrt", scene("Integrator \"ambientocclusion\"\n"));
  write("lamp.pbrt", scene("Integrator \"raycast\"\n"));
  const auto greenOf = [&](const std::string& name) {
    const Outcome o = run({"stills", name + ".pbrt", "-o", name, "--by", "light"});
    EXPECT_EQ(o.status, 0) << o.err;
    const recurse::Image image = recurse::readImage(file(name + "/stills.exr"));
    std::map<std::string, double> sums;
    for (size_t c = 0; c < image.channels.size(); ++c)
      if (image.channels[c].ends_with("G"))
        for (size_t i = c; i < image.pixels.size(); i += image.channels.size())
          sums[image.channels[c]] += double(image.pixels[i]);
    return sums;
  };
  std::map<std::string, double> occlusion = greenOf("occlusion");
  EXPECT_EQ(occlusion["light-1.G"], 0);
  EXPECT_GT(occlusion["rest.G"], 0);
  EXPECT_NEAR(occlusion["rest.G"], occlusion["G"], 1e-3 * occlusion["G"]);
  std::map<std::string, double> ambient = greenOf("ambient"), lamp = greenOf("lamp");
  EXPECT_EQ(lamp.count("rest.G"), 0u);
  EXPECT_GT(ambient["rest.G"], 0);
  EXPECT_NEAR(ambient["light-1.G"], lamp["light-1.G"], 1e-3 * lamp["light-1.G"]);
}

TEST_F(StillsCommand, ComparesWithOtherStills) {
  ASSERT_EQ(run({"stills", "scene.pbrt", "-o", "a", "-q", "--photons", "2000"}).status, 0);
  const Outcome o =
      run({"stills", "scene.pbrt", "-o", "b", "-q", "--integrator", "path", "--compare", "a/stills.exr"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_GT(contents(file("b/index.html")).size(), contents(file("a/index.html")).size());
  const Outcome size = run({"stills", "scene.pbrt", "-o", "c", "--resolution", "8x8", "--compare", "a"});
  EXPECT_EQ(size.status, 2);
  EXPECT_TRUE(has(size.err, "24x16")) << size.err;
  const Outcome missing = run({"stills", "scene.pbrt", "-o", "c", "--compare", "nowhere"});
  EXPECT_EQ(missing.status, 1);
  EXPECT_TRUE(has(missing.err, "nowhere")) << missing.err;
  EXPECT_FALSE(exists("c"));
}

TEST_F(StillsCommand, CompareHasARowForEachClass) {
  for (const char* seed : {"1", "2", "3"})
    ASSERT_EQ(run({"stills", "scene.pbrt", "-o", seed, "-q", "--integrator", "path", "--seed", seed}).status,
              0);
  const Outcome table = run({"compare", "1", "2/stills.exr"});
  ASSERT_EQ(table.status, 0) << table.err;
  EXPECT_TRUE(has(table.out, "relMSE of classes")) << table.out;
  const Outcome o = run({"compare", "1", "2", "3", "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  const nlohmann::json classes = nlohmann::json::parse(o.out)["classes"];
  const auto layer = std::find_if(classes.begin(), classes.end(),
                                  [](const nlohmann::json& one) { return one["name"] == "direct-diffuse"; });
  ASSERT_NE(layer, classes.end()) << o.out;
  EXPECT_EQ((*layer)["expression"], "LDE");
  EXPECT_GT((*layer)["relmse_at_1"], 0);
  EXPECT_TRUE(layer->contains("relmse_noise_free_at_8"));
}

TEST_F(StillsCommand, ErrorsSayWhatIsWrong) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"stills", "scene.pbrt"}, "--output"},
      {{"stills", "scene.pbrt", "-o", "s", "--class", "LDE"}, "NAME=EXPRESSION"},
      {{"stills", "scene.pbrt", "-o", "s", "--class", "a="}, "NAME=EXPRESSION"},
      {{"stills", "scene.pbrt", "-o", "s", "--class", "a=L("}, "column"},
      {{"stills", "scene.pbrt", "-o", "s", "--class", "../a=LE"}, "'../a'"},
      {{"stills", "scene.pbrt", "-o", "s", "--class", "a=LE", "--class", "a=LDE"}, "two classes"},
      {{"stills", "scene.pbrt", "-o", "s", "--spp", "0"}, "--spp"},
  };
  for (const auto& [arguments, message] : cases) {
    const Outcome o = run(arguments);
    EXPECT_EQ(o.status, 2) << message;
    EXPECT_TRUE(has(o.err, message)) << o.err;
  }
  EXPECT_FALSE(exists("s"));
  write("file", "");
  const Outcome notFolder = run({"stills", "scene.pbrt", "-o", "file"});
  EXPECT_EQ(notFolder.status, 1);
  EXPECT_TRUE(has(notFolder.err, "file")) << notFolder.err;
  EXPECT_EQ(run({"stills", "nowhere.pbrt", "-o", "s"}).status, 1);
}

TEST_F(StillsCommand, HelpHasExamples) {
  const Outcome o = run({"stills", "--help"});
  EXPECT_EQ(o.status, 0);
  EXPECT_TRUE(has(o.out, "Examples:\n  recurse stills scene.pbrt")) << o.out;
  EXPECT_TRUE(has(o.out, "98th percentile")) << o.out;
}

TEST_F(StillsCommand, InfoReadsOnePixel) {
  ASSERT_EQ(run({"stills", "scene.pbrt", "-o", "s", "-q", "--photons", "100"}).status, 0);
  const Outcome o = run({"info", "s/stills.exr", "--pixel", "3,4"});
  EXPECT_EQ(o.status, 0);
  EXPECT_TRUE(o.out.starts_with("R  ")) << o.out;
  EXPECT_TRUE(has(o.out, "caustic.B")) << o.out;
  EXPECT_EQ(run({"info", "s/stills.exr", "--pixel", "24,0"}).status, 2);
  EXPECT_EQ(run({"info", "s/stills.exr", "--pixel", "1"}).status, 2);
}
