/** @file
 * `recurse converge`: new, continued, refused and interrupted studies.
 */
#include "program.h"

#include <nlohmann/json.hpp>

#include "recurse/core/image/image.h"
#include "recurse/core/io/fileLock.h"

using namespace programTesting;
using recurse::Image;
using recurse::readImage;

namespace {

class ConvergeProgram : public Program {
 protected:
  /** Makes a reference for the scene of the fixture. */
  void makeReference(const std::string& name, const std::string& seed) const {
    ASSERT_EQ(run({"render", "scene.pbrt", "-q", "-o", name, "--integrator", "path", "--spp", "256", "--seed",
                   seed})
                  .status,
              0);
  }
  nlohmann::json study(const std::string& name = "study") const {
    return nlohmann::json::parse(contents(file(name + "/converge.json")));
  }
  static size_t lines(const std::string& text) { return size_t(std::count(text.begin(), text.end(), '\n')); }
};

const std::string PATHS = "path=--integrator path",
                  PHOTONS = "pm=--integrator photonmap --set passes=1 --photons 2k --radius 0.4";

} // namespace

TEST_F(ConvergeProgram, MakesItsReferenceAndGoesOn) {
  const std::vector<std::string> arguments = {
      "converge", "scene.pbrt", "-o",    "study", "--samples",         "4,16", "--seeds", "3",
      "--run",    PATHS,        "--run", PHOTONS, "--reference-error", "0.02"};
  const Outcome first = run(arguments);
  ASSERT_EQ(first.status, 0) << first.err;
  for (const char* part :
       {"two pictures by path tracing", "relMSE of their mean", "ε 0.01", "picture 12 of 12"})
    EXPECT_TRUE(has(first.err, part)) << part << "\n" << first.err;
  for (const char* part : {"bias²", "time to", "no trim", "error ~"})
    EXPECT_TRUE(has(first.out, part)) << first.out;
  // Such short renders may take the same time, which gives no slope; convergeTest.cpp uses given times.
  EXPECT_TRUE(has(first.out, "t^") || has(first.out, "no fit")) << first.out;
  const nlohmann::json j = study();
  ASSERT_EQ(j["cells"].size(), 12u);
  EXPECT_EQ(lines(contents(file("study/cells.csv"))), 13u);
  EXPECT_EQ(lines(contents(file("study/points.csv"))), 5u);
  EXPECT_TRUE(has(contents(file("study/index.html")), "relmse_noise_free"));
  EXPECT_TRUE(exists("study/plot.gp"));
  double errors[2] = {0, 0}; // for path: with four times the samples a quarter of the error
  for (const auto& cell : j["cells"]) {
    EXPECT_GT(cell["seconds"], 0);
    EXPECT_EQ(cell["samples_per_pixel"], cell["budget"] == "4" ? 4 : 16);
    EXPECT_EQ(cell["photons"], cell["run"] == "pm" ? 2000 : 0);
    if (cell["run"] == "path") errors[cell["budget"] == "4" ? 0 : 1] += double(cell["relmse_noise_free"]);
  }
  EXPECT_NEAR(errors[0] / errors[1], 4, 1.5);
  const Image reference = readImage(file("study/reference.exr"));
  EXPECT_GE(reference.channel("a.R"), 0);

  // A second run renders nothing; with a different seed it renders the missing pictures. The reference does
  // not change.
  const Outcome again = run(arguments);
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_FALSE(has(again.err, "picture ")) << again.err;
  EXPECT_EQ(again.out, first.out);
  std::vector<std::string> more = arguments;
  more[7] = "4";
  const Outcome grown = run(more);
  EXPECT_EQ(grown.status, 0) << grown.err;
  EXPECT_EQ(study()["cells"].size(), 16u);
  EXPECT_EQ(j["cells"][0], study()["cells"][0]);
  EXPECT_EQ(readImage(file("study/reference.exr")).pixels, reference.pixels);
}

TEST_F(ConvergeProgram, RefusesWhatDoesNotBelong) {
  makeReference("a.exr", "100");
  makeReference("b.exr", "101");
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"converge",    "scene.pbrt", "-o",   "study",
                                          "--reference", "a.exr",      "b.exr"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  };
  const Outcome fine = with({"--samples", "2", "--run", PATHS, "--seeds", "1"});
  ASSERT_EQ(fine.status, 0) << fine.err;
  const auto refused = [&](const std::vector<std::string>& more, const std::string& why) {
    const Outcome o = with(more);
    EXPECT_EQ(o.status, 2) << o.err;
    EXPECT_TRUE(has(o.err, why)) << why << "\n" << o.err;
  };
  refused({"--samples", "2", "--run", "path=--integrator path --maxdepth 2"},
          "run path: there path, maxdepth -1");
  refused({"--times", "1s", "--run", PATHS}, "budgets: there samples, now time");
  refused({"--samples", "2", "--run", PATHS + " --spp 3"}, "--run path: --spp is set by the budgets");
  refused({"--samples", "2", "--run", PATHS + " --resolution 3x3"}, "--resolution is for all runs");
  refused({"--samples", "2", "--run", PATHS + " --radius 3"},
          "--run path: --radius: the integrator 'path' has no");
  refused({"--samples", "2", "--run", "--integrator path"}, "is not NAME=");
  refused({"--samples", "2,x"}, "--samples: 'x' is not a whole number");
  refused({"--photons", "1k", "--run", PATHS}, "--run path: --photons: the integrator 'path' has no");
  refused({"--samples", "2", "--resolution", "8x8"}, "a.exr has 24x16 pixels, but the scene has 8x8");
  std::ofstream(file("scene.pbrt"), std::ios::app) << "# changed\n";
  refused({"--samples", "2", "--run", PATHS}, "content of the scene: there");
  EXPECT_EQ(study()["cells"].size(), 1u);
}

TEST_F(ConvergeProgram, PhotonBudgets) {
  makeReference("a.exr", "100");
  const Outcome o = run({"converge", "scene.pbrt", "-o", "study", "--reference", "a.exr", "--photons",
                         "1k,4k", "--seeds", "1", "--run", "pm=--set passes=1 --radius 0.4 --spp 2", "-q"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_FALSE(has(o.err, "picture 1 of") || has(o.err, "written:")) << o.err;
  EXPECT_TRUE(has(o.out, "the errors and bias² include its own noise")) << o.out;
  const nlohmann::json j = study();
  ASSERT_EQ(j["cells"].size(), 2u);
  EXPECT_EQ(j["cells"][1]["photons"], 4000);
  EXPECT_EQ(j["cells"][1]["samples_per_pixel"], 2);
  EXPECT_TRUE(j["cells"][1]["relmse_noise_free"].is_null());
}

TEST_F(ConvergeProgram, NamesThePlotOnlyWhereItWroteOne) {
  makeReference("a.exr", "100");
  ASSERT_EQ(
      std::system(("cd " + folder +
                   " && PATH=/nowhere " RECURSE_PROGRAM " converge scene.pbrt -o study --reference a.exr "
                   "--samples 1 --seeds 1 --run path='--integrator path' >out 2>log")
                      .c_str()),
      0);
  const std::string said = contents(file("log"));
  EXPECT_TRUE(has(said, "plot.png was not made")) << said;
  ASSERT_TRUE(has(said, "written: study/index.html")) << said;
  EXPECT_FALSE(has(said.substr(said.find("written:")), "plot.png")) << said;
}

TEST_F(ConvergeProgram, OneProcessAtATimeInAFolder) {
  makeReference("a.exr", "100");
  std::filesystem::create_directories(file("study"));
  const recurse::FileLock held(file("study/"));
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"converge", "scene.pbrt", "-o", "study", "--reference", "a.exr", "--samples",
                                 "1", "--seeds", "1"},
        std::vector<std::string>{"stills", "scene.pbrt", "-o", "study", "--spp", "1"},
        std::vector<std::string>{"methods", "scene.pbrt", "-o", "study", "--spp", "1"}}) {
    const Outcome o = run(command);
    EXPECT_EQ(o.status, 1) << command[0] << o.err;
    EXPECT_TRUE(has(o.err, "study/: another process uses it")) << command[0] << o.err;
  }
}

TEST_F(ConvergeProgram, InterruptKeepsWhatIsFinished) {
  makeReference("a.exr", "100");
  const auto withTimes = [](const std::string& times) {
    return std::vector<std::string>{"converge", "scene.pbrt", "-o",    "study", "--reference", "a.exr",
                                    "--times",  times,        "--run", PATHS,   "--seeds",     "2"};
  };
  const Outcome stopped = run(withTimes("100ms,1h"), [&](pid_t child) {
    EXPECT_TRUE(appears("study/cells/path-0.1s-seed1.exr"));
    ::kill(child, SIGINT);
  });
  EXPECT_EQ(stopped.status, 130) << stopped.err;
  EXPECT_TRUE(has(stopped.err, "run the same command to")) << stopped.err;
  const nlohmann::json kept = study()["cells"];
  ASSERT_EQ(kept.size(), 2u);
  EXPECT_TRUE(exists("study/index.html"));
  EXPECT_EQ(leftBehind(), 0u);
  const Outcome rest = run(withTimes("100ms,200ms"));
  EXPECT_EQ(rest.status, 0) << rest.err;
  ASSERT_EQ(study()["cells"].size(), 4u);
  for (const size_t i : {0u, 1u}) EXPECT_EQ(study()["cells"][i], kept[i]);
}
