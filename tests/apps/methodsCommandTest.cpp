/** @file
 * `recurse methods`: new, continued and refused runs, and methods that cannot render a scene.
 */
#include "program.h"

#include <nlohmann/json.hpp>

#include "recurse/core/image/image.h"

using namespace programTesting;

namespace {

class MethodsProgram : public Program {
 protected:
  nlohmann::json report(const std::string& folder = "out") const {
    return nlohmann::json::parse(contents(file(folder + "/methods.json")));
  }
};

const std::vector<std::string> COMMAND = {
    "methods",         "scene.pbrt", "-o",       "out",
    "--spp",           "4",          "--method", "whitted",
    "--method",        "path",       "--method", "few=--integrator vpl --set lightpaths=4",
    "--reference-spp", "64"};

} // namespace

TEST_F(MethodsProgram, MakesReportAndGoesOn) {
  const Outcome first = run(COMMAND);
  ASSERT_EQ(first.status, 0) << first.err;
  const nlohmann::json j = report();
  ASSERT_EQ(j["methods"].size(), 3u);
  EXPECT_EQ(j["methods"][0]["claims"], "LD?S*E");
  EXPECT_EQ(j["methods"][1]["claims"], "all");
  EXPECT_EQ(j["methods"][1]["missing"], 0.0);
  EXPECT_TRUE(has(j["methods"][2]["settings"], "lightpaths 4"));
  for (const auto& m : j["methods"]) EXPECT_EQ(m["samples_per_pixel"], 4.0);
  EXPECT_TRUE(exists("out/sheet.png") && exists("out/index.html"));
  EXPECT_FALSE(exists("out/reference-a.exr.checkpoint"));
  // Existing pictures are kept, and missing ones are rendered.
  const std::string kept = contents(file("out/method-path.exr"));
  ASSERT_EQ(run({"info", "out/method-path.exr"}).status, 0);
  std::filesystem::remove(file("out/method-few.exr"));
  EXPECT_EQ(run(COMMAND).status, 0);
  EXPECT_EQ(contents(file("out/method-path.exr")), kept);
  EXPECT_TRUE(exists("out/method-few.exr"));
}

TEST_F(MethodsProgram, AmbientOcclusionShowsAClosedRoom) {
  write("room.pbrt", scene("", "Shape \"sphere\" \"float radius\" 9\n"));
  const Outcome o = run({"methods", "room.pbrt", "-o", "out", "--spp", "4", "--method", "ambientocclusion",
                         "--reference-spp", "1"});
  ASSERT_EQ(o.status, 0) << o.err;
  double light = 0;
  const nlohmann::json j = report();
  for (const double mean : j["methods"][0]["class_means"]) light += mean;
  EXPECT_GT(light, 0.2) << j["methods"][0]["settings"];
}

TEST_F(MethodsProgram, NoMethodTakesMuchLongerThanItsTime) {
  // A sample of every pixel would take minutes.
  const Outcome o =
      run({"methods", "scene.pbrt", "-o", "out", "--time-limit", "2s", "--reference-spp", "1", "--resolution",
           "768x512", "--method", "slow=--integrator vpl --set lightpaths=40000"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_NE(report()["methods"][0]["failure"], "");
  // The first sample of every pixel may take a second more.
  const recurse::Image picture = recurse::readImage(file("out/method-slow.exr"));
  EXPECT_LT(std::stod(picture.metadata.at("recurse:seconds")), 60);
}

TEST_F(MethodsProgram, PhotonsHaveNoMoreTimeThanTheirMethod) {
  const Outcome o =
      run({"methods", "scene.pbrt", "-o", "out", "--time-limit", "0.5s", "--reference-spp", "1", "--method",
           "many=--integrator photonmap --set passes=1 --set photons=1000000000", "--method", "whitted"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_LT(o.seconds, 60);
  const nlohmann::json j = report();
  EXPECT_TRUE(has(j["methods"][0]["failure"], "no sample was ready in time")) << j["methods"][0]["failure"];
  EXPECT_EQ(j["methods"][1]["failure"], "");
}

TEST_F(MethodsProgram, InterruptKeepsWhatIsFinished) {
  const auto withSecond = [](const std::string& method) {
    return std::vector<std::string>{"methods",         "scene.pbrt", "-o",       "out",  "--spp",    "4",
                                    "--method",        "whitted",    "--method", method, "--method", "bdpt",
                                    "--reference-spp", "4"};
  };
  // A sample of every pixel would take minutes.
  const Outcome stopped =
      run(withSecond("slow=--integrator path --set lightsamples=1000000"), [&](pid_t child) {
        EXPECT_TRUE(appears("out/method-whitted.exr"));
        ::kill(child, SIGINT);
      });
  EXPECT_EQ(stopped.status, 130) << stopped.err;
  EXPECT_TRUE(has(stopped.err, "run the same command to continue")) << stopped.err;
  EXPECT_EQ(report()["methods"][0]["failure"], "");
  for (const size_t i : {1u, 2u}) EXPECT_EQ(report()["methods"][i]["failure"], "not rendered: interrupted");
  EXPECT_EQ(leftBehind(), 0u);
  const std::string kept = contents(file("out/method-whitted.exr"));
  const Outcome rest = run(withSecond("path"));
  EXPECT_EQ(rest.status, 0) << rest.err;
  EXPECT_TRUE(contents(file("out/method-whitted.exr")) == kept);
  const auto finished = report();
  for (const auto& m : finished["methods"]) EXPECT_EQ(m["failure"], "");
}

TEST_F(MethodsProgram, RefusesWhatDoesNotFit) {
  const auto refused = [&](std::vector<std::string> more, const std::string& words) {
    std::vector<std::string> arguments = {"methods", "scene.pbrt", "-o", "out", "--reference-spp", "1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << words;
    EXPECT_TRUE(has(outcome.err, words)) << outcome.err;
  };
  refused({"--method", "nothing"}, "there is no integrator 'nothing'");
  refused({"--method", "path", "--method", "path"}, "path is given twice");
  refused({"--spp", "1", "--time-limit", "1s"}, "only one of");
  refused({"--method", "a=--integrator path --spp 3"}, "--spp");
  ASSERT_EQ(
      run({"methods", "scene.pbrt", "-o", "out", "--reference-spp", "1", "--spp", "1", "--method", "path"})
          .status,
      0);
  refused({"--spp", "2", "--method", "path"}, "is a picture with other settings");
}
