/** @file
 * What path classes cost: eight classes at once, and one narrow class alone, against the plain picture.
 *
 * The scene is the Cornell box with glass, at a quarter of its resolution. The three kinds of render take
 * turns in every round, and the first round does not count; a ratio is the median over the rounds of the
 * time for the class render over that for the plain one of the same round. Times are processor time of all
 * threads: load on the machine moves them less than time on the wall.
 *
 * The last line is for programs: the larger ratio of the integrators for eight classes, and for the narrow
 * class, LS+DE.
 */
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include "recurse/core/threads/parallel.h"
#include "recurse/pathclasses/pathExpression.h"
#include "recurse/render/render.h"
#include "recurse/scene/directives/loader.h"

using namespace recurse;

namespace {

double processorSeconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

double median(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return v.size() % 2 ? v[v.size() / 2] : 0.5 * (v[v.size() / 2 - 1] + v[v.size() / 2]);
}

std::unique_ptr<Scene> load(const char* file, int size) {
  Diagnostics diagnostics;
  const SceneDescription description = loadScene(file, diagnostics);
  SceneOverrides overrides;
  overrides.width = overrides.height = size;
  std::unique_ptr<Scene> scene;
  if (!diagnostics.hasErrors()) scene = buildScene(description, overrides, diagnostics);
  if (!scene) {
    std::fputs(diagnostics.format().c_str(), stderr);
    std::exit(1);
  }
  return scene;
}

/** The first seven default classes of stills, and all others in one class. */
PathClasses eightClasses() {
  std::vector<PathClass> classes = defaultStillClasses();
  classes.resize(7);
  std::string others;
  for (const PathClass& c : classes) others += (others.empty() ? "" : "|") + c.expression;
  classes.push_back({"rest", "all - (" + others + ")"});
  return PathClasses(classes);
}

double secondsFor(const Scene& scene, const char* integrator, const char* parameters,
                  const PathClasses& classes, int samplesPerPixel) {
  Diagnostics diagnostics;
  const auto made = plugIns().integrators.make(parseParameterText(integrator, parameters), {}, diagnostics);
  Film film(scene.film().crop, classes.layerCount());
  RenderSettings settings;
  settings.samplesPerPixel = samplesPerPixel;
  const std::atomic<bool> stop{false};
  const double start = processorSeconds();
  render(scene, *made, classes, settings, film, stop, nullptr, nullptr);
  return processorSeconds() - start;
}

} // namespace

int main(int count, char** arguments) {
  int rounds = 9;
  std::string file = RECURSE_SOURCE_DIR "/scenes/cornell-glass.pbrt";
  for (int i = 1; i < count; ++i) {
    if (std::strcmp(arguments[i], "--rounds") == 0 && i + 1 < count)
      rounds = std::max(1, std::atoi(arguments[++i]));
    else if (arguments[i][0] != '-')
      file = arguments[i];
    else {
      std::fprintf(stderr, "usage: stills [SCENE] [--rounds N]\n");
      return 2;
    }
  }
  const ThreadPool pool;
  const auto scene = load(file.c_str(), 200);
  const PathClasses plain, eight = eightClasses(), narrow(std::vector<PathClass>{{"caustic", "LS+DE"}});
  std::printf("eight classes: %zu states on the light side, %zu on the side of the eye\n",
              eight.lightStateCount(), eight.cameraStateCount());
  struct Way {
    const char* name;
    const char* integrator;
    const char* parameters;
    int samplesPerPixel;
  };
  const Way ways[] = {{"path", "path", "", 16},
                      {"photonmap", "photonmap", "\"integer photons\" 200000", 8},
                      {"photonmap, direct light by photons", "photonmap",
                       "\"integer photons\" 200000 \"string direct\" \"photons\"", 8}};
  double worstEight = 0, worstNarrow = 0;
  for (const Way& way : ways) {
    std::vector<double> plainTimes, eightRatios, narrowRatios;
    for (int round = 0; round <= rounds; ++round) {
      const auto time = [&](const PathClasses& classes) {
        return secondsFor(*scene, way.integrator, way.parameters, classes, way.samplesPerPixel);
      };
      // The order turns round, so that a drift of the clock rate favours none.
      double p, e;
      if (round % 2) {
        p = time(plain);
        e = time(eight);
      } else {
        e = time(eight);
        p = time(plain);
      }
      const double n = time(narrow);
      if (round == 0) continue;
      plainTimes.push_back(p);
      eightRatios.push_back(e / p);
      narrowRatios.push_back(n / p);
    }
    const auto [least, most] = std::minmax_element(eightRatios.begin(), eightRatios.end());
    const double eightRatio = median(eightRatios), narrowRatio = median(narrowRatios);
    std::printf("%-36s plain %.2f s   eight classes × %.3f (%.3f to %.3f)   LS+DE × %.3f\n", way.name,
                median(plainTimes), eightRatio, *least, *most, narrowRatio);
    worstEight = std::max(worstEight, eightRatio);
    worstNarrow = std::max(worstNarrow, narrowRatio);
  }
  std::printf("stills: eight_classes_vs_plain=%.3f narrow_class_vs_plain=%.3f\n", worstEight, worstNarrow);
}
