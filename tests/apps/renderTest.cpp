/** @file
 * `recurse render`: outputs, settings, statistics, limits and interrupts.
 */
#include "program.h"

#include <cmath>
#include <limits>

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "recurse/core/image/image.h"

using namespace programTesting;
using recurse::Image;
using recurse::readImage;

namespace {
class ProgramRender : public Program {};
} // namespace

TEST_F(ProgramRender, RendersToSeveralFiles) {
  const Outcome o = run({"render", "scene.pbrt", "-o", "a.exr", "-o", "a.png", "-o", "a.hdr", "-o", "a.jpg",
                         "--integrator", "path", "--spp", "3", "--seed", "5"});
  ASSERT_EQ(o.status, 0) << o.err;
  for (const char* name : {"a.exr", "a.png", "a.hdr", "a.jpg"}) {
    const Image image = readImage(file(name));
    EXPECT_EQ(image.width, 24);
    EXPECT_EQ(image.height, 16);
  }
  Image image = readImage(file("a.exr"));
  EXPECT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B"}));
  EXPECT_GT(image.rgb(12, 14).g, 0.01f);
  EXPECT_EQ(image.metadata["recurse:seed"], "5");
  EXPECT_EQ(image.metadata["recurse:samples"], "3");
  EXPECT_EQ(image.metadata["recurse:scene"], "scene.pbrt");
  EXPECT_EQ(image.metadata["recurse:classes"], "all");
  EXPECT_TRUE(has(image.metadata["Software"], "Recurse 0."));
  EXPECT_TRUE(has(image.metadata["recurse:settings"], "--integrator path --spp 3 --seed 5"));
  EXPECT_TRUE(has(o.err, "written: a.exr, a.png, a.hdr, a.jpg")) << o.err;
  EXPECT_TRUE(has(o.err, "ended by the number of samples")) << o.err;
  EXPECT_EQ(leftBehind(), 0u);
}

TEST_F(ProgramRender, FilmNamesTheDefaultOutput) {
  EXPECT_EQ(run({"render", "scene.pbrt", "--integrator", "path", "-q"}).status, 0);
  EXPECT_EQ(readImage(file("film.exr")).metadata["recurse:samples"], "2");
}

TEST_F(ProgramRender, SameSeedSamePictureWhateverTheThreads) {
  for (const char* integrator : {"path", "photonmap"}) {
    std::vector<std::string> base = {"render", "scene.pbrt", "--integrator", integrator, "-q"};
    if (std::string(integrator) == "photonmap") base.insert(base.end(), {"--photons", "50k"});
    const auto picture = [&](const std::string& name, const std::vector<std::string>& more) {
      std::vector<std::string> arguments = base;
      arguments.insert(arguments.end(), {"-o", name});
      arguments.insert(arguments.end(), more.begin(), more.end());
      const Outcome o = run(arguments);
      EXPECT_EQ(o.status, 0) << o.err;
      EXPECT_FALSE(has(o.err, "samples")) << o.err; // a quiet run prints warnings only
      return readImage(file(name)).pixels;
    };
    const auto one = picture("one.exr", {"--nthreads", "1"});
    EXPECT_TRUE(one == picture("two.exr", {"--nthreads", "2"})) << integrator;
    EXPECT_FALSE(one == picture("other.exr", {"--seed", "9"})) << integrator;
  }
}

TEST_F(ProgramRender, ResolutionCropAndExposure) {
  ASSERT_EQ(
      run({"render", "scene.pbrt", "--integrator", "path", "-q", "--resolution", "40x20", "-o", "w.exr"})
          .status,
      0);
  const Image whole = readImage(file("w.exr"));
  EXPECT_EQ(whole.width, 40);
  EXPECT_EQ(whole.height, 20);
  ASSERT_EQ(run({"render", "scene.pbrt", "--integrator", "path", "-q", "--resolution", "40x20",
                 "--cropwindow", "0.5,1,0.25,0.75", "-o", "c.exr", "-o", "dark.png", "--exposure", "-20"})
                .status,
            0);
  const Image crop = readImage(file("c.exr"));
  ASSERT_EQ(crop.width, 20);
  ASSERT_EQ(crop.height, 10);
  for (int x = 0; x < 20; ++x) EXPECT_EQ(crop.rgb(x, 3), whole.rgb(x + 20, 8)); // a part of the same picture
  EXPECT_EQ(readImage(file("dark.png")).rgb(10, 5), recurse::BLACK);
}

TEST_F(ProgramRender, RepeatedOptionsTakeOneValueEach) {
  const Outcome o = run({"render", "-q", "--integrator", "path", "-o", "a.exr", "-o", "b.png", "scene.pbrt"});
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(readImage(file("a.exr")).width, readImage(file("b.png")).width);
  EXPECT_EQ(run({"render", "-q", "-o", "c.exr", "--integrator", "path", "--set", "maxdepth=1", "scene.pbrt"})
                .status,
            0);
}

TEST_F(ProgramRender, CropsAreThoseOfTheFilm) {
  // In single precision .3 times 400 is above 120.
  write("crop.pbrt",
        scene("Film \"rgb\" \"integer xresolution\" 400 \"integer yresolution\" 10 \"float cropwindow\" "
              "[ .3 .7 0 1 ]\n"));
  ASSERT_EQ(run({"render", "crop.pbrt", "--integrator", "path", "-q", "-o", "film.exr"}).status, 0);
  ASSERT_EQ(run({"render", "scene.pbrt", "--integrator", "path", "-q", "--resolution", "400x10",
                 "--cropwindow", ".3,.7,0,1", "-o", "option.exr"})
                .status,
            0);
  EXPECT_EQ(readImage(file("film.exr")).width, 160);
  EXPECT_EQ(readImage(file("option.exr")).width, 160);
}

TEST_F(ProgramRender, CropsOfSplatsAndTheirErrorsHaveTheBitsOfTheWholePicture) {
  for (const char* integrator : {"bdpt", "lightpath"}) {
    const std::vector<std::string> render = {
        "render", "scene.pbrt", "--integrator", integrator, "-q",
        "--spp",  "2",          "--resolution", "16x12",    "--error-layer"};
    std::vector<std::string> whole = render, part = render;
    whole.insert(whole.end(), {"-o", "w.exr"});
    part.insert(part.end(), {"--cropwindow", ".5,1,.5,1", "-o", "c.exr"});
    ASSERT_EQ(run(whole).status, 0);
    ASSERT_EQ(run(part).status, 0);
    const Image w = readImage(file("w.exr")), c = readImage(file("c.exr"));
    ASSERT_EQ(w.channels, c.channels);
    for (int y = 0; y < c.height; ++y)
      for (int x = 0; x < c.width; ++x)
        for (size_t i = 0; i < c.channels.size(); ++i)
          EXPECT_EQ(c.at(x, y)[i], w.at(x + 8, y + 6)[i]) << integrator << " " << c.channels[i];
  }
}

TEST_F(ProgramRender, TimeLimitHoldsForLoading) {
  write("slow.pbrt", slowScene());
  const Outcome o = runAMinute({"render", "slow.pbrt", "--time-limit", "1s", "-o", "a.exr"});
  EXPECT_EQ(o.status, 1);
  EXPECT_TRUE(has(o.err, "the time limit ended before the scene was loaded")) << o.err;
  EXPECT_EQ(leftBehind(), 0u);
}

TEST_F(ProgramRender, AFilmTooLargeForTheMemoryIsRefusedBeforeItTakesAny) {
  const Outcome o =
      run({"render", "scene.pbrt", "--resolution", "60000x60000", "--memory", "2G", "-o", "a.exr"});
  EXPECT_EQ(o.status, 1);
  EXPECT_TRUE(has(o.err, "a film of 60000x60000 pixels needs about")) << o.err;
}

TEST_F(ProgramRender, FilmScalesByTheImagingRatio) {
  write("bright.pbrt", scene("Film \"rgb\" \"integer xresolution\" 24 \"integer yresolution\" 16 "
                             "\"float exposuretime\" 2 \"float iso\" 200\n"));
  ASSERT_EQ(run({"render", "scene.pbrt", "--integrator", "path", "-q", "-o", "a.exr"}).status, 0);
  ASSERT_EQ(run({"render", "bright.pbrt", "--integrator", "path", "-q", "-o", "b.exr"}).status, 0);
  const Image a = readImage(file("a.exr")), b = readImage(file("b.exr"));
  EXPECT_NEAR(b.rgb(12, 14).r, 4 * a.rgb(12, 14).r, 1e-6);
}

TEST_F(ProgramRender, OptionsOverrideTheFile) {
  write("depth.pbrt", scene("Integrator \"path\" \"integer maxdepth\" 7 \"bool regularize\" true\n"));
  const auto integratorLine = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"render", "depth.pbrt", "--check"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome o = run(arguments);
    EXPECT_EQ(o.status, 0) << o.err;
    const size_t at = o.out.find("integrator");
    return at == std::string::npos ? o.out : o.out.substr(at, o.out.find('\n', at) - at);
  };
  EXPECT_TRUE(has(integratorLine({}), "path: maxdepth 7")) << integratorLine({});
  EXPECT_TRUE(has(integratorLine({"--maxdepth", "3"}), "path: maxdepth 3"));
  EXPECT_TRUE(has(integratorLine({"--maxdepth", "-1"}), "path: maxdepth -1"));
  // A second integrator keeps the parameters that it knows.
  const std::string photons =
      integratorLine({"--integrator", "photonmap", "--photons", "2M", "--radius", "0.25"});
  for (const char* part : {"photonmap: ", "maxdepth 7", "photons 2000000", "radius 0.25"})
    EXPECT_TRUE(has(photons, part)) << photons;
  EXPECT_TRUE(has(integratorLine({"--set", "lightsamples=4"}), "lightsamples 4"));
  // The exception is the radius, which was chosen for the integrator of the file.
  write("depth.pbrt", scene("Integrator \"sppm\" \"integer maxdepth\" 7 \"float radius\" .5\n"));
  EXPECT_TRUE(has(integratorLine({}), "radius 0.5")) << integratorLine({});
  const std::string other = integratorLine({"--integrator", "photonmap"});
  EXPECT_TRUE(has(other, "maxdepth 7") && !has(other, "radius 0.5")) << other;
}

TEST_F(ProgramRender, WhoGetsAPathTracerByTheFileIsToldOfPhotons) {
  write("public.pbrt", scene("Integrator \"volpath\"\n"));
  const char* remark = "--integrator auto often has less noise";
  EXPECT_TRUE(has(run({"render", "public.pbrt", "--spp", "1", "-o", "a.exr"}).err, remark));
  EXPECT_FALSE(has(run({"render", "public.pbrt", "--spp", "1", "-q", "-o", "a.exr"}).err, remark));
  for (const char* integrator : {"path", "auto"})
    EXPECT_FALSE(has(
        run({"render", "public.pbrt", "--spp", "1", "-o", "a.exr", "--integrator", integrator}).err, remark));
}

TEST_F(ProgramRender, CheckReportsWithoutRendering) {
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"render", "scene.pbrt", "--check"}, {"info", "scene.pbrt"}}) {
    const Outcome o = run(arguments);
    EXPECT_EQ(o.status, 0) << o.err;
    for (const char* part :
         {"24x16", "4 triangles", "1 on surfaces", "reflection", "auto", "memory", "photon map about"})
      EXPECT_TRUE(has(o.out, part)) << part << "\n" << o.out;
    EXPECT_FALSE(exists("film.exr"));
  }
}

TEST_F(ProgramRender, StatisticsTellWhatAutoHasChosen) {
  const Outcome o =
      run({"render", "scene.pbrt", "--integrator", "auto", "--stats", "s.json", "-q", "-o", "a.exr"});
  ASSERT_EQ(o.status, 0) << o.err;
  const nlohmann::json json = nlohmann::json::parse(contents(file("s.json")));
  bool isTold = false;
  for (const std::string note : json["notes"])
    isTold = isTold || note.starts_with("auto uses photonmap: the picture (below 9216 pixels) is too small");
  EXPECT_TRUE(isTold) << o.err;
}

TEST_F(ProgramRender, StatisticsHaveTheirKeys) {
  const Outcome o = run({"render", "scene.pbrt", "--integrator", "photonmap", "--photons", "3000", "--set",
                         "passes=1", "--stats", "s.json", "-o", "a.exr"});
  ASSERT_EQ(o.status, 0) << o.err;
  const nlohmann::json json = nlohmann::json::parse(contents(file("s.json")));
  for (const char* key : {"render_seconds",
                          "photon_seconds",
                          "balance_seconds",
                          "gather_seconds",
                          "rays",
                          "photons_emitted",
                          "photons_stored",
                          "peak_memory_bytes",
                          "non_finite",
                          "weight_cut",
                          "samples_per_pixel",
                          "passes",
                          "threads",
                          "load_seconds",
                          "build_seconds",
                          "rays_per_second",
                          "seed",
                          "scene",
                          "integrator",
                          "stop_reason",
                          "cores_busy",
                          "version",
                          "notes",
                          "warnings",
                          "resolution"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_EQ(json["photons_emitted"], 3000);
  EXPECT_EQ(json["non_finite"], 0);
  EXPECT_EQ(json["samples_per_pixel"], 2);
  EXPECT_EQ(json["samples_of_a_pixel"], (nlohmann::json{{"least", 2}, {"median", 2}, {"most", 2}}));
  EXPECT_EQ(json["stop_reason"], "samples");
  EXPECT_EQ(json["resolution"], nlohmann::json({24, 16}));
  EXPECT_GT(json["peak_memory_bytes"], 1000000);
  EXPECT_TRUE(has(o.err, "written: a.exr, s.json")) << o.err;
}

TEST_F(ProgramRender, StatisticsSplitProcessorTime) {
  const auto split = [&](const std::string& integrator) {
    const Outcome o =
        run({"render", "scene.pbrt", "--integrator", integrator, "--spp", "4", "--stats", "s.json"});
    EXPECT_EQ(o.status, 0) << o.err;
    const nlohmann::json json = nlohmann::json::parse(contents(file("s.json")));
    const nlohmann::json parts = json["processor_seconds_by_part"];
    double sum = 0;
    for (const char* part : {"learning", "photons", "camera_paths"}) sum += parts[part].get<double>();
    EXPECT_NEAR(sum, json["processor_seconds"], 1e-9);
    return parts;
  };
  const nlohmann::json mapped = split("photonmap"), traced = split("path");
  EXPECT_GT(mapped["learning"], 0);
  EXPECT_GT(mapped["photons"], 0);
  EXPECT_GT(mapped["camera_paths"], 0);
  EXPECT_LT(traced["photons"], 0.01);
}

TEST_F(ProgramRender, StatisticsHaveTheGuide) {
  const auto render = [&](const std::string& guided) {
    return run({"render", "scene.pbrt", "--integrator", "path", "--set", "guided=" + guided, "--spp", "4",
                "--stats", "s.json", "-o", "a.exr"});
  };
  const Outcome o = render("true");
  ASSERT_EQ(o.status, 0) << o.err;
  const nlohmann::json json = nlohmann::json::parse(contents(file("s.json"))), guide = json["guide"];
  EXPECT_GT(guide["cells"], 0);
  EXPECT_GT(guide["records"], 0);
  EXPECT_NEAR(guide["fraction_on"], guide["cells_on"].get<double>() / guide["cells"].get<double>(), 1e-9);
  EXPECT_GT(json["processor_seconds_by_part"]["learning"], 0);
  EXPECT_TRUE(has(o.err, "guide: " + guide["cells"].dump() + " cells, ")) << o.err;
  EXPECT_GT(guide["gain"], 0);
  EXPECT_TRUE(has(o.err, " % of them sampled, learned from " + guide["records"].dump() + " records; "))
      << o.err;
  EXPECT_TRUE(has(o.err, "; learning took ")) << o.err;
  render("false");
  EXPECT_TRUE(nlohmann::json::parse(contents(file("s.json")))["guide"].is_null());
}

TEST_F(ProgramRender, LayersOfTheGuideNeedAGuide) {
  const std::vector<std::string> words = {"render", "scene.pbrt", "--spp",        "4",   "--layers", "guide",
                                          "-o",     "a.exr",      "--integrator", "path"};
  const Outcome without = run(words);
  EXPECT_EQ(without.status, 2);
  EXPECT_TRUE(
      has(without.err, "--layers: 'guide' is of path guiding; add --integrator path --set guided=true"))
      << without.err;
  std::vector<std::string> guided = words;
  guided.insert(guided.end(), {"--set", "guided=true"});
  ASSERT_EQ(run(guided).status, 0);
  EXPECT_TRUE(has(run({"info", "a.exr"}).out, "guide.Y"));
}

TEST_F(ProgramRender, ProgressAsJsonAndOff) {
  const Outcome json =
      run({"render", "scene.pbrt", "--integrator", "path", "--progress", "json", "-o", "a.exr"});
  std::istringstream lines(json.err);
  int objects = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("{")) continue;
    const nlohmann::json object = nlohmann::json::parse(line);
    ++objects;
    for (const char* key :
         {"phase", "fraction", "elapsed", "seconds_left", "samples_per_pixel", "rays_per_second"})
      EXPECT_TRUE(object.contains(key)) << line;
  }
  EXPECT_GT(objects, 0) << json.err;
  const Outcome off =
      run({"render", "scene.pbrt", "--integrator", "path", "--progress", "off", "-o", "a.exr"});
  EXPECT_FALSE(has(off.err, "%"));
  const Outcome plain = run({"render", "scene.pbrt", "--integrator", "path", "-o", "a.exr"});
  EXPECT_FALSE(has(plain.err, "\r")) << "a file is no terminal";
}

TEST_F(ProgramRender, TimeLimitIsRespected) {
  const Outcome o = run({"render", "scene.pbrt", "--integrator", "path", "--time-limit", "1s", "-o", "a.exr",
                         "--stats", "s.json"});
  ASSERT_EQ(o.status, 0) << o.err;
  const nlohmann::json json = nlohmann::json::parse(contents(file("s.json")));
  EXPECT_EQ(json["stop_reason"], "time");
  EXPECT_GE(json["samples_per_pixel"], 1);
  EXPECT_LT(json["render_seconds"], 60);
  EXPECT_TRUE(has(o.err, "ended by the time limit")) << o.err;
}

TEST_F(ProgramRender, PathClassesSelectLight) {
  ASSERT_EQ(
      run({"render", "scene.pbrt", "--integrator", "path", "-q", "--paths", "LE", "-o", "a.exr"}).status, 0);
  Image image = readImage(file("a.exr"));
  EXPECT_EQ(image.rgb(12, 14), recurse::BLACK); // the floor reflects light, but does not emit
  EXPECT_EQ(image.metadata["recurse:classes"], "LE");
}

TEST_F(ProgramRender, ClassesBecomeLayersBesideThePicture) {
  const std::vector<std::string> render = {"render", "scene.pbrt", "--integrator", "path", "-q", "-o"};
  const auto rendered = [&](const std::string& name, const std::vector<std::string>& options) {
    std::vector<std::string> all = render;
    all.push_back(name);
    all.insert(all.end(), options.begin(), options.end());
    EXPECT_EQ(run(all).status, 0);
    return readImage(file(name));
  };
  const Image whole = rendered("whole.exr", {});
  const Image image = rendered("a.exr", {"--class", "seen=LE", "--class", "lit=all - LE"});
  const int seen = image.channel("seen.R"), lit = image.channel("lit.R");
  ASSERT_GE(seen, 0);
  ASSERT_GE(lit, 0);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      EXPECT_EQ(image.rgb(x, y), whole.rgb(x, y));
      EXPECT_NEAR(image.at(x, y)[seen] + image.at(x, y)[lit], whole.rgb(x, y).r, 1e-5f * whole.rgb(x, y).r);
    }
  EXPECT_GT(image.at(12, 14)[lit], 0);
  EXPECT_TRUE(has(image.metadata.at("recurse:settings"), "--class seen=LE"))
      << image.metadata.at("recurse:settings");
}

TEST_F(ProgramRender, InterruptWritesWhatThereIs) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const Outcome o = run({"render", "scene.pbrt", "--integrator", "path", "--spp", "1000000000", "-o",
                           "a.exr", "--stats", "s.json", "--progress", "json"},
                          onceUnderWay(signal));
    EXPECT_EQ(o.status, 130) << o.err;
    EXPECT_LT(o.seconds, 120); // including the minute that a sample may take
    const Image image = readImage(file("a.exr"));
    EXPECT_GT(image.rgb(12, 14).g, 0.01f);
    EXPECT_EQ(nlohmann::json::parse(contents(file("s.json")))["stop_reason"], "interrupted");
    std::filesystem::remove(file("a.exr"));
    EXPECT_EQ(leftBehind(), 0u);
  }
}

TEST_F(ProgramRender, FailedRunsLoseNoPicture) {
  const std::vector<std::string> render = {"render", "scene.pbrt", "--integrator", "path",
                                           "-q",     "-o",         "a.exr"};
  ASSERT_EQ(run(render).status, 0);
  const std::string before = contents(file("a.exr"));

  write("bad.pbrt", scene("", "Shape \"spheer\"\n"));
  EXPECT_EQ(run({"render", "bad.pbrt", "-o", "a.exr"}).status, 3);
  EXPECT_TRUE(contents(file("a.exr")) == before);

  // Killed during the render.
  const Outcome killed = run({"render", "scene.pbrt", "--integrator", "path", "--spp", "1000000000", "-o",
                              "a.exr", "--progress", "json"},
                             onceUnderWay(SIGKILL));
  EXPECT_EQ(killed.status, 128 + SIGKILL);
  EXPECT_TRUE(contents(file("a.exr")) == before);

  // A full disk at the time of writing, simulated by the limit on the size of files.
  const std::string command = "cd '" + folder + "' && (ulimit -f 0; trap '' XFSZ; '" + RECURSE_PROGRAM +
                              "' render scene.pbrt --integrator path -q -o a.exr) > out.txt 2>&1";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_TRUE(contents(file("a.exr")) == before);
  EXPECT_EQ(leftBehind(), 0u);
}

TEST_F(ProgramRender, FilesOfTheSceneAreNotWrittenOver) {
  ASSERT_EQ(run({"render", "scene.pbrt", "--integrator", "path", "-q", "-o", "slide.png"}).status, 0);
  const std::string before = contents(file("slide.png"));
  write("show.pbrt", scene("", "LightSource \"projection\" \"string filename\" \"slide.png\"\n"));
  for (const char* option : {"-o", "--preview", "--stats"}) {
    const Outcome o = run({"render", "show.pbrt", "-q", "-o", "a.exr", option, "./slide.png"});
    EXPECT_EQ(o.status, 2) << option;
    EXPECT_TRUE(has(o.err, "is a file of the scene and cannot be overwritten")) << o.err;
  }
  EXPECT_EQ(contents(file("slide.png")), before);
}

TEST_F(ProgramRender, OneUnwritableOutputKeepsTheOthers) {
  // The folder is removed during the render.
  std::filesystem::create_directory(file("gone"));
  const Outcome o = run({"render", "scene.pbrt", "--integrator", "path", "--spp", "1000000000", "-o",
                         "gone/a.exr", "-o", "b.exr", "--progress", "json"},
                        [&](pid_t child) {
                          EXPECT_TRUE(isUnderWay());
                          std::filesystem::remove(file("gone"));
                          ::kill(child, SIGINT);
                        });
  EXPECT_EQ(o.status, 1);
  EXPECT_TRUE(has(o.err, "gone/a.exr")) << o.err;
  EXPECT_TRUE(exists("b.exr"));
}

namespace {

/** A port of this machine that is in use, with a listener if `listens`. */
class TakenPort {
 public:
  explicit TakenPort(bool listens) : socket(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(::bind(socket, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size), 0);
    if (listens) {
      EXPECT_EQ(::listen(socket, 1), 0);
    }
    name = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  }
  ~TakenPort() { ::close(socket); }
  TakenPort(const TakenPort&) = delete;
  TakenPort& operator=(const TakenPort&) = delete;
  std::string name;

 private:
  int socket;
};

/** A latitude-longitude map of grey, with one pixel of a different value. */
std::string environmentMap(int width, int height, float pixel) {
  std::string out = "PF\n" + std::to_string(width) + " " + std::to_string(height) + "\n-1.0\n";
  for (int i = 0; i < width * height * 3; ++i) {
    const float value = i / 3 == width * height / 3 ? pixel : 0.5f;
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  return out;
}

} // namespace

TEST_F(ProgramRender, WhatIsTakenFromPbrtAndNotDoneIsAWarning) {
  const auto warnings = [&](const std::string& header) {
    write("named.pbrt",
          "Film \"rgb\"\nCamera \"perspective\"\n" + header + "\nWorldBegin\nShape \"sphere\"\n");
    return run({"render", "named.pbrt", "--check"}).err;
  };
  EXPECT_TRUE(has(warnings("Sampler \"pmj02bn\""),
                  "warning: \"pmj02bn\" is not available: samples are Owen-scrambled Sobol' points"));
  for (const std::string name : {"independent", "stratified", "halton", "sobol", "paddedsobol", "zsobol"})
    EXPECT_FALSE(has(warnings("Sampler \"" + name + "\""), "Sobol")) << name;
}

TEST_F(ProgramRender, WithoutItsDisplayServerItGoesOn) {
  const TakenPort nobody(false);
  const Outcome o = run({"render", "scene.pbrt", "--integrator", "path", "--spp", "1", "-q", "-o", "a.exr",
                         "--display-server", nobody.name});
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(has(o.err, nobody.name + ": Connection refused; the render continues without it")) << o.err;
  EXPECT_TRUE(exists("a.exr"));
}

TEST_F(ProgramRender, APortInUseIsSaidBeforeTheRender) {
  const TakenPort taken(true);
  const Outcome o = run({"render", "scene.pbrt", "--integrator", "path", "--spp", "1", "-o", "a.exr",
                         "--live", "--live-address", taken.name});
  EXPECT_EQ(o.status, 1);
  EXPECT_TRUE(has(o.err, "cannot listen at " + taken.name) && has(o.err, "in use")) << o.err;
}

TEST_F(ProgramRender, EnvironmentMapsAtTheEdgeAreRendered) {
  const std::string lit = scene("", "LightSource \"infinite\" \"string filename\" \"map.pfm\"\n");
  write("lit.pbrt", lit);
  const auto render = [&](int width, int height, float pixel) {
    write("map.pfm", environmentMap(width, height, pixel));
    return run({"render", "lit.pbrt", "--integrator", "path", "--spp", "2", "-q", "-o", "a.pfm"});
  };
  for (const auto& [width, pixel] : {std::pair(1, 0.5f), std::pair(32, 1e30f), std::pair(32, -1.0f)}) {
    const Outcome o = render(width, (width + 1) / 2, pixel);
    ASSERT_EQ(o.status, 0) << o.err;
    EXPECT_EQ(has(o.err, "negative"), pixel < 0) << o.err;
    for (const float value : recurse::readImage(file("a.pfm")).pixels) ASSERT_TRUE(std::isfinite(value));
  }
  const Outcome o = render(32, 16, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(o.status, 3);
  EXPECT_TRUE(has(o.err, "is no number")) << o.err;
  write("map.pfm", environmentMap(32, 16, 1).substr(0, 400));
  EXPECT_TRUE(has(run({"render", "lit.pbrt", "-q"}).err, "it is cut off or damaged"));
}

TEST_F(ProgramRender, TheFilmLimitsSamplesAndBalancesWhite) {
  const auto mean = [&](const std::string& film, const char* name, size_t channel) {
    write("film.pbrt",
          scene("Film \"rgb\" \"integer xresolution\" 24 \"integer yresolution\" 16 " + film + "\n"));
    const Outcome o = run({"render", "film.pbrt", "--integrator", "path", "--spp", "64", "-o", name});
    EXPECT_EQ(o.status, 0) << o.err;
    const recurse::Image image = recurse::readImage(file(name));
    double sum = 0, largest = 0;
    for (size_t i = channel; i < image.pixels.size(); i += image.channels.size()) {
      sum += double(image.pixels[i]);
      largest = std::max(largest, double(image.pixels[i]));
    }
    return std::pair(sum, largest);
  };
  // White light: X, Y and Z are .9505, 1 and 1.089 times its luminance.
  EXPECT_GT(mean("", "a.exr", 0).second, 0.3);
  EXPECT_LE(mean("\"float maxcomponentvalue\" 0.1", "b.exr", 0).second, 0.1 / 1.089 * 1.01);
  // White is blue after white balance for candlelight, and red after white balance for the sky.
  const double red = mean("", "r.exr", 0).first, blue = mean("", "r.exr", 2).first;
  EXPECT_NEAR(red, blue, 1e-3 * red);
  EXPECT_GT(mean("\"float whitebalance\" 2500", "c.exr", 2).first,
            2 * mean("\"float whitebalance\" 2500", "c.exr", 0).first);
  EXPECT_LT(mean("\"float whitebalance\" 15000", "d.exr", 2).first,
            0.8 * mean("\"float whitebalance\" 15000", "d.exr", 0).first);
  // White balance for D65 has no effect.
  EXPECT_NEAR(mean("\"float whitebalance\" 6504", "e.exr", 2).first, blue, 0.01 * blue);
}
