/** @file
 * Stills: the classes add up to the whole picture with every integrator, and files contain all of them.
 */
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "recurse/core/io/error.h"
#include "recurse/core/threads/parallel.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/pathclasses/pathExpression.h"
#include "recurse/render/render.h"
#include "recurse/report/stills/stills.h"
#include "recurse/scene/directives/loader.h"
#include "report/stills/sheet.h"

using namespace recurse;
namespace fs = std::filesystem;

namespace {

Film renderClasses(const std::string& sceneName, const std::string& integratorName,
                   const std::vector<PathClass>& list, int size = 32, int samples = 4) {
  Diagnostics diagnostics;
  const std::string file = std::string(RECURSE_SOURCE_DIR) + "/tests/scenes/" + sceneName + ".pbrt";
  SceneOverrides overrides;
  overrides.width = overrides.height = size;
  const auto scene = buildScene(loadScene(file, diagnostics), overrides, diagnostics);
  std::string parameters; // few photons are enough, because the test checks sums only
  for (const ParameterSpec& p : plugIns().integrators.find(integratorName)->parameters) {
    if (!p.ignored && p.name == "passes") parameters += " \"integer passes\" 1";
    if (!p.ignored && p.name == "photons") parameters += " \"integer photons\" 20000";
  }
  const auto integrator =
      plugIns().integrators.make(parseParameterText(integratorName, parameters), {}, diagnostics);
  diagnostics.throwIfErrors();
  const PathClasses classes(list);
  Film film(scene->film().crop, classes.layerCount());
  const ThreadPool pool(2);
  const std::atomic<bool> stop{false};
  render(*scene, *integrator, classes, {.samplesPerPixel = samples}, film, stop, nullptr, nullptr);
  return film;
}

/** Film of given colours: pixel by pixel, layer by layer. */
Film filmOf(int width, int height, size_t layers, const std::vector<Rgb>& values) {
  Film film(PixelBounds{0, 0, width, height}, layers);
  for (size_t p = 0; p < film.bounds().area(); ++p) film.add(p, 0, 1, &values[p * layers], BLACK);
  return film;
}

struct TemporaryFolder {
  TemporaryFolder() {
    name = (fs::temp_directory_path() / ("recurse-stills-test-" + std::to_string(::getpid()))).string();
  }
  ~TemporaryFolder() { fs::remove_all(name); }
  std::string name;
};

std::string planError(const std::vector<PathClass>& classes) {
  try {
    planStills(classes);
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::BAD_USAGE);
    return error.what();
  }
  return "";
}

} // namespace

TEST(Stills, ClassesAddUpWithEveryIntegrator) {
  std::vector<PathClass> classes = defaultStillClasses();
  const size_t count = classes.size();
  classes.push_back({"whole", "all"});
  for (const char* scene : {"cornell-mix", "furnace"})
    for (const std::string& integrator : plugIns().integrators.names()) {
      const Film film = renderClasses(scene, integrator, classes);
      double light = 0;
      for (size_t p = 0; p < film.bounds().area(); ++p) {
        Rgbd sum{0};
        for (size_t i = 0; i < count; ++i) sum += Rgbd(film.value(p, i));
        const Rgbd whole(film.value(p, count));
        light += whole.g;
        for (int c = 0; c < 3; ++c)
          ASSERT_NEAR(sum[c], whole[c], 4e-6 * whole[c]) << scene << ", " << integrator << ", pixel " << p;
      }
      // The furnace has no light from the white sky of ambient occlusion.
      EXPECT_TRUE(light > 0 || integrator == "ambientocclusion") << scene << ", " << integrator;
    }
}

TEST(Stills, DefaultClassesNeedNothingAdded) {
  for (const bool media : {false, true}) {
    const StillsPlan plan = planStills(defaultStillClasses(media));
    EXPECT_TRUE(plan.additive());
    EXPECT_EQ(plan.shown, defaultStillClasses(media).size());
    EXPECT_EQ(plan.classes.size(), plan.shown);
    EXPECT_TRUE(plan.remarks.empty());
  }
}

TEST(Stills, WhatIsLeftOverBecomesAClass) {
  const StillsPlan plan = planStills({{"rest", "LDE"}, {"lamp", "LE"}});
  ASSERT_EQ(plan.classes.size(), 3u);
  EXPECT_EQ(plan.classes[2].name, "rest_");
  EXPECT_TRUE(plan.additive());
  const PathAutomaton rest = PathAutomaton::compile(plan.classes[2].expression);
  EXPECT_TRUE(rest.equivalent(PathAutomaton::compile("all - LDE - LE")));
  ASSERT_EQ(plan.remarks.size(), 1u);
  EXPECT_NE(plan.remarks[0].find("rest_"), std::string::npos);
}

TEST(Stills, OverlappingClassesGetTheWholePictureBeside) {
  const StillsPlan plan = planStills({{"a", "L.*E"}, {"b", "LD+E"}, {"c", "L[SD]E"}});
  EXPECT_EQ(plan.classes.size(), 3u); // a contains all paths
  EXPECT_EQ(plan.beauty, 0);
  EXPECT_EQ(plan.shown, 3u);
  const StillsPlan other = planStills({{"b", "LD+E"}, {"c", "L[SD]E"}});
  ASSERT_EQ(other.classes.size(), 4u);
  EXPECT_EQ(other.classes[2].name, "rest");
  EXPECT_EQ(other.classes[3].name, "all");
  EXPECT_EQ(other.beauty, 3);
  EXPECT_EQ(other.shown, 3u);
  EXPECT_FALSE(other.additive());
  EXPECT_NE(other.remarks[0].find("LDE"), std::string::npos) << other.remarks[0];

  // Two pixels of the four classes: the whole is a layer of its own, not the sum.
  const Stills stills =
      makeStills(filmOf(2, 1, 4, {Rgb(1), Rgb(2), Rgb(3), Rgb(5), Rgb(0), Rgb(1), Rgb(0), Rgb(1)}), other, 2);
  ASSERT_EQ(stills.layers.size(), 4u);
  EXPECT_EQ(stills.image.rgb(0, 0), Rgb(10));
  EXPECT_EQ(stills.image.rgb(1, 0), Rgb(2));
  EXPECT_FALSE(stills.additive);
  EXPECT_NEAR(stills.layers[1].share, 1.0 / 6, 1e-6);
  EXPECT_NEAR(double(stills.layers[2].mean.g), 3, 1e-6);
}

TEST(Stills, BadNamesAndExpressionsAreRefused) {
  EXPECT_NE(planError({}), "");
  for (const char* name : {"", "a.b", "a/b", "..", "-a", "a b", "beauty", "ä"})
    EXPECT_NE(planError({{name, "LE"}}), "") << name;
  EXPECT_NE(planError({{"a", "LE"}, {"A", "LDE"}}).find("two classes"), std::string::npos);
  const std::string message = planError({{"lamp", "L("}});
  EXPECT_NE(message.find("class lamp"), std::string::npos) << message;
  EXPECT_NE(message.find("column"), std::string::npos) << message;
  EXPECT_NE(planError({{"none", "LE & LDE"}}), "");
}

TEST(Stills, ExposureBringsThePercentileToNearlyWhite) {
  Image image(100, 10, {"R", "G", "B"});
  for (size_t i = 0; i < 500; ++i) // the second half is black, and does not count
    for (size_t c = 0; c < 3; ++c) image.pixels[i * 3 + c] = i < 495 ? 0.25f : 1000.0f;
  const double shown = 0.25 * std::exp2(double(automaticExposure(image)));
  EXPECT_NEAR(1.055 * std::pow(shown, 1 / 2.4) - 0.055, double(STILLS_DISPLAY_WHITE), 1e-3);
  EXPECT_EQ(automaticExposure(Image(3, 3, {"R", "G", "B"})), 0);
}

TEST(Stills, FilesHoldEveryLayer) {
  const TemporaryFolder folder;
  const StillsPlan plan = planStills(defaultStillClasses());
  Stills stills = makeStills(renderClasses("cornell-mix", "photonmap", plan.classes, 16, 2), plan, 1);
  stills.title = "a <b> & \"c\".pbrt";
  stills.label = "test";
  describeStills(stills);
  const std::vector<std::string> written = writeStills(folder.name, stills);
  EXPECT_EQ(written.size(), 3 + 2 * stills.layers.size());
  for (const std::string& name : written) EXPECT_GT(fs::file_size(name), 0u) << name;
  size_t found = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder.name)) found += entry.is_regular_file();
  EXPECT_EQ(found, written.size());

  const Image exr = readImage(folder.name + "/stills.exr");
  EXPECT_EQ(exr.channels.size(), 3 * stills.layers.size());
  for (const PathClass& c : plan.classes)
    for (const char* channel : {".R", ".G", ".B"}) EXPECT_GE(exr.channel(c.name + channel), 0) << c.name;
  const Stills again = readStills(folder.name);
  ASSERT_EQ(again.layers.size(), stills.layers.size());
  EXPECT_EQ(again.image.channels, stills.image.channels);
  EXPECT_EQ(again.image.pixels, stills.image.pixels);
  EXPECT_EQ(again.title, stills.title);
  EXPECT_EQ(again.label, stills.label);
  EXPECT_TRUE(again.additive);
  for (size_t i = 0; i < stills.layers.size(); ++i) {
    EXPECT_EQ(again.layers[i].name, stills.layers[i].name);
    EXPECT_EQ(again.layers[i].expression, stills.layers[i].expression);
    EXPECT_EQ(again.layers[i].share, stills.layers[i].share);
  }
}

TEST(Stills, ClassesWithAnyNamesAreReadBack) {
  const TemporaryFolder folder;
  const std::vector<PathClass> classes = {
      {"both", "L'a; b'.*E"}, {"quotes", "L'it''s; = '.*E"}, {"one", "L'x'D'y; z'E"}, {"plain", "LVE"}};
  Stills stills = makeStills(filmOf(1, 1, 6, std::vector<Rgb>(6, Rgb(1))), planStills(classes), 1);
  stills.remarks = {"lamp is light.pbrt; line 3", "the lamp's light; of both"};
  describeStills(stills);
  writeStills(folder.name, stills);
  const Stills again = readStills(folder.name);
  ASSERT_EQ(again.layers.size(), stills.layers.size());
  for (size_t i = 0; i < stills.layers.size(); ++i) {
    EXPECT_EQ(again.layers[i].name, stills.layers[i].name);
    EXPECT_EQ(again.layers[i].expression, stills.layers[i].expression);
  }
  EXPECT_EQ(again.remarks, stills.remarks);
}

TEST(Stills, PageNeedsNothingButItself) {
  const StillsPlan plan = planStills({{"lamp", "LE"}, {"floor", "LDE"}});
  Stills stills = makeStills(filmOf(1, 1, 3, {Rgb(1), Rgb(2), Rgb(3)}), plan, 1);
  stills.title = "</script><b>&.pbrt";
  const std::string page = stillsPage(stills, &stills);
  EXPECT_EQ(page.find("<b>&"), std::string::npos);
  EXPECT_NE(page.find("<title>&lt;/script&gt;&lt;b&gt;&amp;.pbrt"), std::string::npos);
  for (const char* outside : {"http:", "https:", "src=", "@import", "url("})
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  const std::string begin = "<script type=\"application/json\" id=\"data\">";
  const size_t at = page.find(begin) + begin.size();
  const auto data = nlohmann::json::parse(page.substr(at, page.find("</script>", at) - at));
  EXPECT_EQ(data["sets"].size(), 2u);
  EXPECT_EQ(data["sets"][0]["title"], stills.title);
  ASSERT_EQ(data["sets"][0]["layers"].size(), 4u);
  EXPECT_FALSE(data["sets"][0]["layers"][0].contains("pixels")); // the page computes the sum
  EXPECT_EQ(data["sets"][0]["layers"][1]["name"], "lamp");
  EXPECT_TRUE(data["sets"][0]["layers"][3].contains("pixels"));

  Stills larger = makeStills(filmOf(2, 1, 3, std::vector<Rgb>(6, Rgb(1))), plan, 1);
  EXPECT_THROW(stillsPage(stills, &larger), Error);
}

TEST(Stills, ContactSheetShowsEveryLayerTwice) {
  const StillsPlan plan = planStills({{"lamp", "LE"}, {"floor", "LDE"}});
  const int width = 20, height = 10;
  std::vector<Rgb> values;
  for (int p = 0; p < width * height; ++p)
    values.insert(values.end(), {Rgb(4, 0, 0), Rgb(0, 0.01f, 0), Rgb(0)});
  const Stills stills = makeStills(filmOf(width, height, 3, values), plan, 1);
  const SheetLayout s = sheetLayout(width, height, stills.layers.size());
  const Image sheet = contactSheet(stills);
  EXPECT_EQ(sheet.width, s.width());
  EXPECT_EQ(sheet.height, s.height());
  EXPECT_GE(s.columns * s.rows, 4);
  EXPECT_EQ(s.pictureWidth, width * s.enlarge);
  EXPECT_EQ(s.shrink, 1);
  // Red appears for the beauty and the lamp, twice each; green for the floor at its own exposure.
  size_t red = 0, green = 0;
  for (int y = 0; y < sheet.height; ++y)
    for (int x = 0; x < sheet.width; ++x) {
      red += sheet.rgb(x, y).r > 0.7f && sheet.rgb(x, y).b == 0;
      green += sheet.rgb(x, y).g > 0.7f && sheet.rgb(x, y).r == 0;
    }
  EXPECT_EQ(red, 4u * size_t(s.pictureWidth * s.pictureHeight));
  EXPECT_EQ(green, size_t(s.pictureWidth * s.pictureHeight));
}

TEST(Stills, CaptionsInASheetOfSmallPicturesDoNotOverlap) {
  const auto dots = [](const std::string& left, const std::string& right) {
    SheetCell cell;
    cell.left = cell.right = Image(6, 60, {"R", "G", "B"});
    cell.leftCaption = left;
    cell.rightCaption = right;
    const Image sheet = drawSheet("", "", {cell});
    int count = 0;
    for (size_t i = 0; i < sheet.pixels.size(); i += 3) count += sheet.pixels[i] > 0.1f;
    return count;
  };
  const std::string left = "1.23 s, 4096 spp", right = "not in it";
  EXPECT_EQ(dots(left, right), dots(left, "") + dots("", right));
  EXPECT_GT(dots(left, ""), 100);
}

TEST(Stills, ContactSheetOfAnySizeOfPicture) {
  for (const auto& [width, height] : {std::pair{1, 1}, {1000, 3}, {3, 1000}, {641, 480}}) {
    const SheetLayout s = sheetLayout(width, height, 11);
    EXPECT_GE(s.columns * s.rows, 11);
    EXPECT_LE(s.pictureWidth, 320);
    EXPECT_LE(s.pictureHeight, 320);
    EXPECT_GE(s.pictureWidth, 1);
    EXPECT_GE(s.pictureHeight, 1);
    const StillsPlan plan = planStills({{"everything", "all"}});
    const Stills stills = makeStills(
        filmOf(width, height, 1, std::vector<Rgb>(size_t(width) * size_t(height), Rgb(1))), plan, 1);
    const Image sheet = contactSheet(stills);
    EXPECT_EQ(sheet.height, sheetLayout(width, height, 2).height());
  }
}
