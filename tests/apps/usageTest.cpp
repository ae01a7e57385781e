/** @file
 * Help, exit statuses and error messages of the program.
 */
#include "program.h"

#include "sanitized.h"

using namespace programTesting;

namespace {
class ProgramUsage : public Program {};
} // namespace

TEST_F(ProgramUsage, HelpOfEverySubcommandHasExamples) {
  for (const char* name : {"render", "compare", "info", "classes", "explain", "reference"}) {
    const Outcome o = run({name, "--help"});
    EXPECT_EQ(o.status, 0) << name;
    EXPECT_TRUE(has(o.out, "Usage: recurse ")) << o.out;
    EXPECT_TRUE(has(o.out, "Examples:\n  recurse " + std::string(name))) << o.out;
    std::istringstream lines(o.out);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 110u) << line;
  }
  const Outcome all = run({"--help"});
  EXPECT_EQ(all.status, 0);
  EXPECT_TRUE(has(all.out, "Exit status"));
  const Outcome version = run({"--version"});
  EXPECT_EQ(version.status, 0);
  EXPECT_TRUE(has(version.out, "Recurse 0.")) << version.out;
}

TEST_F(ProgramUsage, BadUsageIsStatus2AndSaysWhatWouldDo) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"rendre", "scene.pbrt"}, "did you mean render?"},
      {{"rendr", "scene.pbrt", "--spp", "4"}, "did you mean render?"},
      {{"scene.pbrt"}, "To render: recurse render scene.pbrt -o scene.png"},
      {{"missing.pbrt.gz", "--spp", "4"}, "To render: recurse render missing.pbrt.gz -o missing.png"},
      {{"-o", "a.png", "scene.pbrt"}, "To render: recurse render scene.pbrt"},
      {{"--no-such-option"}, "unknown option --no-such-option\n"},
      {{"render", "scene.pbrt", "--threads", "2"}, "unknown option --threads; did you mean --nthreads?"},
      {{"render", "scene.pbrt", "--threads=2"}, "unknown option --threads; did you mean --nthreads?"},
      {{"render", "scene.pbrt", "-x", "2"}, "unknown option -x\n"},
      {{"render", "scene.pbrt", "first", "second"}, "unexpected arguments: first second\n"},
      {{"render"}, "required"},
      {{"render", "scene.pbrt", "--spp"}, "--spp"},
      {{"render", "scene.pbrt", "--stats=", "-q"}, "--stats: the value is empty"},
      {{"render", "scene.pbrt", "--spp", "0"}, "whole number from 1"},
      {{"render", "scene.pbrt", "--spp", "2.5"}, "whole number"},
      {{"render", "scene.pbrt", "--no-such-option"}, "--no-such-option"},
      {{"render", "scene.pbrt", "--sp", "4"}, "did you mean --spp"},
      {{"render", "scene.pbrt", "--res", "8x8"}, "did you mean --resume or --resolution?"},
      {{"render", "scene.pbrt", "--time", "8s"}, "did you mean --time-limit"},
      {{"render", "scene.pbrt", "--samples", "8"}, "did you mean --spp"},
      {{"render", "scene.pbrt", "--depth", "8"}, "did you mean --maxdepth"},
      {{"compare", "a.exr", "b.exr", "--fail-abve=relmse=1"}, "did you mean --fail-above?"},
      {{"render", "scene.pbrt", "-o", "a.bmp2"}, ".exr .hdr .pfm .png"},
      {{"render", "scene.pbrt", "-o", "a.exr", "-o", "a.exr"}, "twice"},
      {{"render", "scene.pbrt", "--integrator", "phtonmap"}, "did you mean photonmap"},
      {{"render", "scene.pbrt", "--integrator", "path", "--photons", "10"}, "has no parameter 'photons'"},
      {{"render", "scene.pbrt", "--photons", "-5"}, "--photons"},
      {{"render", "scene.pbrt", "--radius", "0"}, "--radius"},
      {{"render", "scene.pbrt", "--direct", "somehow"}, "shadowrays"},
      {{"render", "scene.pbrt", "--photon-index", "octree"}, "kdtree"},
      {{"render", "scene.pbrt", "--set", "nonsense=1"}, "nonsense"},
      {{"render", "scene.pbrt", "--set", "nonsense"}, "NAME=VALUE"},
      {{"render", "scene.pbrt", "--time-limit", "soon"}, "1h30m"},
      {{"render", "scene.pbrt", "--resolution", "640"}, "640x480"},
      {{"render", "scene.pbrt", "--cropwindow", "0,1,1"}, "x0,x1,y0,y1"},
      {{"render", "scene.pbrt", "--resolution", "8x8", "--resolution", "9x9"},
       "recurse: --resolution: given twice; accepted: once\n"},
      {{"inspect", "scene.pbrt", "-o", "e.png"}, "-o e.png: the output is a page, such as look.html"},
      {{"figure", "cost", "scene.pbrt", "-o", "x.html"}, ".tiff .svg"},
      {{"render", "scene.pbrt", "--seed", "-1"}, "--seed"},
      {{"render", "scene.pbrt", "--nthreads", "0"}, "--nthreads"},
      {{"render", "scene.pbrt", "--progress", "loud"}, "plain"},
      {{"render", "scene.pbrt", "--paths", "L("}, "column"},
      {{"render", "scene.pbrt", "--class", "LDE"}, "NAME=EXPRESSION"},
      {{"convert", "house.obj", "-o", "a\"b.pbrt"}, "quotes"},
      {{"render", "scene.pbrt", "--class", "a=L("}, "column"},
      {{"render", "scene.pbrt", "--class", "a=LDE", "--paths", "LDE"}, "cannot be combined with --paths"},
      {{"render", "scene.pbrt", "-q", "-v"}, "excludes"},
      {{"compare", "a.exr"}, "required"},
      {{"compare", "a.exr", "b.exr", "--fail-above", "beauty=1"}, "relmse"},
      {{"compare", "a.exr", "b.exr", "--fail-above", "relmse"}, "METRIC=NUMBER"},
      {{"compare", "a.exr", "b.exr", "--fail-above", "relmse_noise_free=1"}, "two independent references"},
      {{"classes", "LX"}, "column 2"},
      {{"reference", "sphre"}, "sphere"},
      {{"explain", "--integrator", "nothing"}, "photonmap"},
  };
  for (const auto& [arguments, message] : cases) {
    const Outcome o = run(arguments);
    std::string line;
    for (const std::string& a : arguments) line += a + " ";
    EXPECT_EQ(o.status, 2) << line << o.err;
    EXPECT_TRUE(has(o.err, message)) << line << "\n" << o.err;
    EXPECT_TRUE(o.out.empty()) << line << o.out;
  }
}

TEST_F(ProgramUsage, WithoutArgumentsAQuickStartOfCommandsThatExist) {
  const Outcome o = run({});
  EXPECT_EQ(o.status, 0) << o.err;
  std::istringstream lines(o.out);
  int count = 0, examples = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    EXPECT_LE(line.size(), 100u) << line;
    std::istringstream words(line);
    std::string program, command;
    words >> program >> command;
    if (!line.starts_with("  recurse ")) continue;
    ++examples;
    const Outcome help = run({command, "--help"});
    EXPECT_EQ(help.status, 0) << line;
    for (std::string word; words >> word;)
      EXPECT_TRUE(!word.starts_with("-") || has(help.out, word)) << word << " of " << line;
  }
  EXPECT_EQ(count, 10) << o.out;
  EXPECT_GE(examples, 8) << o.out;
}

TEST_F(ProgramUsage, ReferenceFindsWhatAWordMeansAndTheTextsThatHaveIt) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> cases = {
      {"fog", {"MakeNamedMedium \"homogeneous\"", "MakeNamedMedium \"uniformgrid\""}},
      {"glass", {"Material \"dielectric\"", "Material \"thindielectric\""}},
      {"caustics", {"Integrator \"photonmap\"", "\"bool causticsonly\""}},
      {"lambert", {"Material \"diffuse\""}},
      {"Phong", {"Material \"blinnphong\""}},
      {"mirror", {"Material \"conductor\""}},
      {"area", {"AreaLightSource \"diffuse\""}},
      {"pinhole", {"\"float lensradius\""}},                               // a text of a parameter
      {"espresso", {"MakeNamedMedium \"homogeneous\" \"string preset\""}}, // a value of one
      {"finalgather", {"Integrator \"photonmap\" "}},                      // a parameter's name
      {"motion blur", {"ActiveTransform", "\"float shutteropen\""}},
      {"motion", {"TransformTimes"}},
      {"WorldEn", {}},
  };
  for (const auto& [word, parts] : cases) {
    const Outcome o = run({"reference", word});
    EXPECT_EQ(o.status, parts.empty() ? 2 : 0) << word << o.err;
    for (const std::string& part : parts) EXPECT_TRUE(has(o.out, part)) << word << "\n" << o.out;
    std::istringstream lines(o.out);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  }
  // Every shape has the parameter: it is one match.
  const std::string alpha = run({"reference", "opacity"}).out;
  EXPECT_EQ(alpha.find("alpha"), alpha.rfind("alpha")) << alpha;
  const std::string two = run({"reference", "sphere", "fog"}).out;
  EXPECT_TRUE(has(two, "\"float zmin\"") && has(two, "'fog' is probably:")) << two;
}

TEST_F(ProgramUsage, NamesOfOtherRenderersSuggestThePlugIn) {
  write("other.pbrt",
        scene("", "Material \"glass\"\nShape \"sphere\"\nMaterial \"lambert\"\nShape \"sphere\"\n"
                  "LightSource \"area\"\nMakeNamedMedium \"m\" \"string type\" \"fog\"\n"
                  "Material \"interface\"\nMediumInterface \"m\" \"\"\nShape \"sphere\"\n"));
  const Outcome o = run({"render", "other.pbrt", "--check"});
  EXPECT_EQ(o.status, 3);
  for (const char* part : {"unknown Material \"glass\"; did you mean \"dielectric\" or \"thindielectric\"?",
                           "unknown Material \"lambert\"; did you mean \"diffuse\"",
                           "unknown LightSource \"area\"; did you mean AreaLightSource \"diffuse\"?",
                           "\"fog\"; did you mean \"homogeneous\" or \"uniformgrid\"?"})
    EXPECT_TRUE(has(o.err, part)) << part << "\n" << o.err;
  for (const char* name : {"pathtracer", "pt"})
    EXPECT_TRUE(has(run({"render", "scene.pbrt", "--integrator", name}).err, "did you mean path?")) << name;
  EXPECT_TRUE(has(run({"render", "scene.pbrt", "--integrator", "photonma"}).err,
                  "did you mean photonmap or simplephotonmap?"));
  const std::vector<std::pair<std::string, std::string>> lines = {
      {"LightSource \"ambient\"", "unknown LightSource \"ambient\"; did you mean \"infinite\"?"},
      {"LightSource \"env\"", "unknown LightSource \"env\"; did you mean \"infinite\"?"},
      {"AreaLightSource \"light\"\nShape \"sphere\"", "did you mean \"diffuse\"?"},
      {"AreaLightSource \"mesh\"\nShape \"sphere\"", "did you mean \"diffuse\"?"},
      {"Fog",
       "unknown directive 'Fog'; did you mean MakeNamedMedium \"name\" \"string type\" \"homogeneous\""}};
  for (const auto& [line, part] : lines) {
    write("other.pbrt", scene("", line + "\n"));
    const Outcome wrong = run({"render", "other.pbrt", "--check"});
    EXPECT_EQ(wrong.status, 3) << line;
    EXPECT_TRUE(has(wrong.err, part)) << line << "\n" << wrong.err;
  }
}

TEST_F(ProgramUsage, UnknownTypeOfAnUnusedMediumIsWarnedOf) {
  write("unused.pbrt", scene("", "MakeNamedMedium \"m\" \"string type\" \"fog\"\n"));
  const Outcome o = run({"render", "unused.pbrt", "--check"});
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(has(o.err, "unused.pbrt:") && has(o.err, "warning: unknown medium type \"fog\"; did you mean"))
      << o.err;
}

TEST_F(ProgramUsage, BadScenesAreStatus3WithPlaceAndCount) {
  for (const char* command : {"render", "explain", "info"}) {
    const Outcome o = run({command, "nothing.pbrt"});
    EXPECT_EQ(o.status, 1) << command;
    EXPECT_TRUE(has(o.err, "nothing.pbrt")) << o.err;
    EXPECT_TRUE(has(o.err, "o such file")) << o.err;
  }
  Outcome o;
  write("bad.pbrt", scene("", "Shape \"sphere\" \"float radus\" 1\nShape \"spheer\"\n"));
  for (const char* mode : {"--check", "--quiet"}) {
    o = run({"render", "bad.pbrt", mode});
    EXPECT_EQ(o.status, 3);
    EXPECT_TRUE(has(o.err, "bad.pbrt:14:")) << o.err;
    EXPECT_TRUE(has(o.err, "radius")) << o.err;
    EXPECT_TRUE(has(o.err, "bad.pbrt:15:")) << o.err;
    EXPECT_TRUE(has(o.err, "^\n")) << o.err;
    EXPECT_TRUE(has(o.err, "2 errors\n")) << o.err;
    EXPECT_FALSE(exists("film.exr"));
  }
  write("lenient.pbrt", scene("", "Shape \"sphere\" \"float radus\" 1\n"));
  o = run({"render", "lenient.pbrt", "--check", "--lenient"});
  EXPECT_EQ(o.status, 0);
  EXPECT_TRUE(has(o.err, "warning: ")) << o.err;

  write("integrator.pbrt", scene("Integrator \"magic\"\n"));
  o = run({"render", "integrator.pbrt"});
  EXPECT_EQ(o.status, 3);
  EXPECT_TRUE(has(o.err, "integrator.pbrt:5:")) << o.err;
}

TEST_F(ProgramUsage, UnwritableOutputsAreFoundBeforeRendering) {
  for (const std::vector<std::string>& output :
       std::vector<std::vector<std::string>>{{"-o", "nowhere/a.exr"},
                                             {"-o", "good.exr", "-o", "nowhere/a.png"},
                                             {"--stats", "nowhere/a.json"}}) {
    std::vector<std::string> arguments = {"render", "scene.pbrt", "--spp", "100000000"};
    arguments.insert(arguments.end(), output.begin(), output.end());
    const Outcome o = run(arguments);
    EXPECT_EQ(o.status, 1);
    EXPECT_TRUE(has(o.err, "nowhere/a.")) << o.err;
    EXPECT_TRUE(has(o.err, "no such folder")) << o.err;
    EXPECT_FALSE(exists("good.exr"));
  }
}

TEST_F(ProgramUsage, FullDiskIsTold) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP();
  const std::string command =
      std::string("cd '") + folder + "' && '" + RECURSE_PROGRAM + "' reference > /dev/full 2> full.txt";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_TRUE(has(contents(file("full.txt")), "No space left")) << contents(file("full.txt"));
}

TEST_F(ProgramUsage, ReferenceClassesAndExplain) {
  const Outcome markdown = run({"reference", "--markdown"});
  EXPECT_EQ(markdown.status, 0);
  for (const char* part : {"# Scene files", "## Shape", "sphere", "photonmap", "LookAt"})
    EXPECT_TRUE(has(markdown.out, part)) << part;
  const Outcome one = run({"reference", "sphere"});
  EXPECT_TRUE(has(one.out, "\"float radius\"")) << one.out;
  EXPECT_FALSE(has(one.out, "LookAt"));

  EXPECT_TRUE(has(run({"classes"}).out, "caustic"));
  EXPECT_TRUE(has(run({"classes", "LS+DE"}).out, "LSDE"));
  EXPECT_TRUE(has(run({"classes", "mine=LDE", "LD+E"}).out, "not disjoint"));

  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"explain", "scene.pbrt"},
                                             {"explain", "--integrator", "path"},
                                             {"explain", "--direct", "photons"}}) {
    const Outcome o = run(arguments);
    EXPECT_EQ(o.status, 0) << o.err << o.out;
    EXPECT_TRUE(has(o.out, "LS*E")) << o.out;
    EXPECT_TRUE(has(o.out, "Each path is estimated exactly once")) << o.out;
  }
}

TEST_F(ProgramUsage, ExplainTellsWhatAutoChooses) {
  // A coat under a uniform sky, at the number of pixels that a trial needs.
  write("coat.pbrt", "Film \"rgb\" \"integer xresolution\" 96 \"integer yresolution\" 96\n"
                     "LookAt 0 1.5 4  0 .4 0  0 1 0\nCamera \"perspective\" \"float fov\" 40\nWorldBegin\n"
                     "LightSource \"infinite\" \"rgb L\" [1 1 1]\n"
                     "Material \"coateddiffuse\" \"float roughness\" .001\n"
                     "Shape \"sphere\" \"float radius\" .6\n");
  const std::string chosen = run({"explain", "coat.pbrt"}).out;
  EXPECT_TRUE(has(chosen, "auto chose path: at equal cost") && !has(chosen, "photon map")) << chosen;
  const std::string forced = run({"explain", "coat.pbrt", "--set", "passes=1"}).out;
  EXPECT_TRUE(has(forced, "auto uses photonmap: a single photon map is requested")) << forced;
  const std::string any = run({"explain", "--integrator", "auto"}).out;
  EXPECT_TRUE(has(any, "It chooses for each scene: photonmap; path;") && has(any, "photon map")) << any;
  EXPECT_TRUE(has(any, "auto: default parameters\n") && !has(any, "nothing")) << any;
  // Rows of media are for scenes with media, and for explanations without a scene.
  EXPECT_TRUE(has(any, "shadow rays in media") && has(any, "light from emitting media")) << any;
  EXPECT_TRUE(has(forced, "shadow rays") && !has(forced, "medi")) << forced;
  EXPECT_TRUE(has(forced, "auto: passes 1, others default\n")) << forced;
}

TEST_F(ProgramUsage, ErrorsOfAllPartsOfASceneAreToldAtOnce) {
  write("bad.pbrt", "Camera \"perspective\" \"float fov\" 500\n"
                    "WorldBegin\n"
                    "LightSource \"point\" \"rgb I\" [ 1 1 ]\n"
                    "Material \"nonsense\"\n"
                    "Shape \"sphere\" \"float radus\" 1\n"
                    "Shape \"spheer\"\n"
                    "NamedMaterial \"nope\"\n"
                    "Shape \"disk\" \"float radus\" 1\n");
  const Outcome o = run({"render", "bad.pbrt"});
  EXPECT_EQ(o.status, 3);
  for (const char* line : {":1:", ":3:", ":4:", ":5:", ":6:", ":7:", ":8:"})
    EXPECT_TRUE(has(o.err, "bad.pbrt" + std::string(line))) << line << o.err;
}

TEST_F(ProgramUsage, NumbersThatOverflowAreErrorsOfTheScene) {
  write("bright.pbrt", "Film \"rgb\" \"float iso\" 1e38 \"float exposuretime\" 1e38\nWorldBegin\n");
  const Outcome o = run({"render", "bright.pbrt"});
  EXPECT_EQ(o.status, 3);
  EXPECT_TRUE(has(o.err, "too large")) << o.err;
  EXPECT_EQ(run({"render", "scene.pbrt", "--radius", "1e19", "-q"}).status, 2);
  const Outcome largest = run({"render", "scene.pbrt", "--radius", "1e17", "--photons", "1k"});
  EXPECT_EQ(largest.status, 0);
  EXPECT_FALSE(has(largest.err, "not finite")) << largest.err;
}

TEST_F(ProgramUsage, WhatDoesNotFitInMemoryIsToldBeforeItIsTaken) {
  if (recurse::testing::SANITIZED) GTEST_SKIP() << "sanitizers take the addresses that are left";
  const std::string command = std::string("ulimit -v 4000000; cd '") + folder + "' && timeout 60 '" +
                              RECURSE_PROGRAM +
                              "' render scene.pbrt --photons 2e9 --direct photons -q 2> memory.txt";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_TRUE(has(contents(file("memory.txt")), "photons needs about")) << contents(file("memory.txt"));
}

TEST_F(ProgramUsage, TheProgramTakesNoMoreMemoryThanItMay) {
  const Outcome refused =
      run({"render", "scene.pbrt", "--photons", "20M", "--direct", "photons", "--memory", "300M", "-q"});
  EXPECT_EQ(refused.status, 1);
  EXPECT_TRUE(has(refused.err, "photons needs about")) << refused.err;
  EXPECT_EQ(run({"render", "scene.pbrt", "--photons", "10k", "--memory", "30G", "-q"}).status, 0);
  for (const auto& [integrator, number] :
       {std::pair("bdpt", "lightpaths=20M"), std::pair("vcm", "photons=20M")}) {
    const Outcome paths =
        run({"render", "scene.pbrt", "--integrator", integrator, "--set", number, "--memory", "300M", "-q"});
    EXPECT_EQ(paths.status, 1);
    EXPECT_TRUE(has(paths.err, "20000000 light paths needs about")) << paths.err;
  }
  EXPECT_EQ(run({"render", "scene.pbrt", "--memory", "much"}).status, 2);
}

TEST_F(ProgramUsage, LongNamesAreNeitherComparedNorPrintedBack) {
  constexpr size_t LENGTH = 10000000;
  write("long.pbrt", scene("", "NamedMaterial \"" + std::string(LENGTH, 'a') + "\"\nShape \"sphere\"\n"));
  const Outcome o = run({"render", "long.pbrt"});
  EXPECT_EQ(o.status, 3);
  EXPECT_TRUE(has(o.err, "there is no material named \"aaaa")) << o.err.substr(0, 1000);
  EXPECT_LT(o.err.size(), 2000u);
  write("long.pbrt", scene("", "Shape \"" + std::string(LENGTH, 'a') + "\"\n"));
  const Outcome shape = run({"render", "long.pbrt"});
  EXPECT_EQ(shape.status, 3);
  EXPECT_TRUE(has(shape.err, "unknown Shape \"aaaa")) << shape.err.substr(0, 1000);
}

TEST_F(ProgramUsage, ShapesThatAreReadFromFilesAreAmongThoseThatThereAre) {
  write("shape.pbrt", scene("", "Shape \"quakemap\"\n"));
  const Outcome o = run({"render", "shape.pbrt"});
  EXPECT_EQ(o.status, 3);
  EXPECT_TRUE(has(o.err, "did you mean \"quake3map\"?")) << o.err;
  EXPECT_TRUE(has(o.err, "\"mesh\"") && has(o.err, "\"md2\"") && has(o.err, "\"quake3map\"\n")) << o.err;
}

TEST_F(ProgramUsage, LightThatAnIntegratorCannotFindIsTold) {
  write("glass.pbrt",
        scene("", "LightSource \"point\" \"point3 from\" [ 0 3 0 ]\n"
                  "Material \"dielectric\"\nTranslate 0 .5 0\nShape \"sphere\" \"float radius\" .2\n"));
  const auto warned = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"render", "glass.pbrt", "-q", "--spp", "1", "-o", "a.exr"});
    const Outcome o = run(arguments);
    EXPECT_EQ(o.status, 0) << o.err;
    return has(o.err, "is missing");
  };
  EXPECT_TRUE(warned({"--integrator", "path"}));
  EXPECT_FALSE(warned({"--integrator", "path", "--paths", "LDE"}));
  EXPECT_FALSE(warned({"--integrator", "photonmap", "--photons", "1k"}));
  EXPECT_TRUE(has(run({"explain", "--integrator", "path"}).out,
                  "No estimator finds these paths of point, spot and distant lights: LS+D"));
  EXPECT_FALSE(has(run({"explain", "--integrator", "photonmap"}).out, "No estimator finds"));
  // The integrator of references must be able to find the light.
  const Outcome study = run({"converge", "glass.pbrt", "-o", "study", "--samples", "1", "--seeds", "2",
                             "--reference-error", "10", "--run", "p=--integrator path"});
  EXPECT_TRUE(has(study.err, "two pictures by progressive photon mapping")) << study.err;
}

TEST_F(ProgramUsage, IntegratorsThatStandForOthersSaySo) {
  write("mlt.pbrt", scene("Integrator \"mlt\" \"integer chains\" 10\n"));
  const Outcome o = run({"render", "mlt.pbrt", "-q", "-o", "mlt.exr"});
  EXPECT_EQ(o.status, 0);
  EXPECT_TRUE(has(o.err, "mlt.pbrt:5:12: warning: \"mlt\" is rendered by \"path\"")) << o.err;
}

TEST_F(ProgramUsage, IntegratorsOfTheCommandLineHaveNoPlaceInTheFile) {
  write("fog.pbrt", scene("Integrator \"bdpt\"\n",
                          "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\"\n"
                          "MediumInterface \"fog\" \"\"\nMaterial \"interface\"\nShape \"sphere\"\n"));
  const auto warning = [&](const char* integrator) {
    return run({"render", "fog.pbrt", "-q", "-o", "fog.exr", "--integrator", integrator}).err;
  };
  EXPECT_TRUE(has(warning("bdpt"), "fog.pbrt:5:12: warning: \"bdpt\" cannot render media"))
      << warning("bdpt");
  EXPECT_EQ(warning("vcm").find("warning: \"vcm\" cannot render media"), 0u) << warning("vcm");
}

TEST_F(ProgramUsage, ErrorsThatRepeatAreToldOnceWithTheirPlaces) {
  std::string shapes;
  for (int i = 0; i < 5; ++i) shapes += "Shape \"sphere\" \"float radus\" 1\n";
  write("many.pbrt", scene("", shapes));
  const Outcome o = run({"render", "many.pbrt", "--check"});
  EXPECT_EQ(o.status, 3);
  EXPECT_EQ(o.err.find("has no parameter"), o.err.rfind("has no parameter")) << o.err;
  EXPECT_TRUE(has(o.err, "and 4 more like it: many.pbrt:15, many.pbrt:16, many.pbrt:17, many.pbrt:18"))
      << o.err;
  EXPECT_TRUE(has(o.err, "refused: 5 errors\n")) << o.err;
}

TEST_F(ProgramUsage, WhatOfPbrtIsApproximatedOrRefusedIsSaid) {
  write("spectral.pbrt", "Film \"spectral\"\nWorldBegin\n");
  Outcome o = run({"render", "spectral.pbrt", "--check"});
  EXPECT_EQ(o.status, 3);
  EXPECT_TRUE(has(o.err, "light is red, green and blue")) << o.err;

  for (const char* film : {"Film \"rgb\" \"string sensor\" \"canon_eos_5d\"", "Film \"gbuffer\""}) {
    write("film.pbrt", scene(film + std::string("\n")));
    o = run({"render", "film.pbrt", "--check"});
    EXPECT_EQ(o.status, 0) << o.err;
    EXPECT_TRUE(has(o.err, "warning: ")) << o.err;
    EXPECT_TRUE(has(o.out, "in short")) << o.out;
    EXPECT_TRUE(has(o.out, "warning")) << o.out;
  }
  o = run({"render", "scene.pbrt", "--check"});
  EXPECT_TRUE(o.out.ends_with("rendered as the file says\n")) << o.out;
}

TEST_F(ProgramUsage, NormalsThatAreNoNumbersAreLeftOut) {
  write("mesh.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "property float nx\nproperty float ny\nproperty float nz\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n"
        "0 0 0 nan nan nan\n1 0 0 nan nan nan\n0 1 0 nan nan nan\n3 0 1 2\n");
  write("ply.pbrt", scene("", "Shape \"plymesh\" \"string filename\" \"mesh.ply\"\n"));
  const Outcome o = run({"render", "ply.pbrt", "-q", "-o", "ply.exr"});
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(has(o.err, "3 vertices have normals that are not finite")) << o.err;
}
