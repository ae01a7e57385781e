/** @file
 * Small renders for tests: a scene as text in, means and errors out.
 */
#pragma once

#include <gtest/gtest.h>

#include "recurse/core/parallel.h"
#include "recurse/scene/loader.h"
#include "recurse/transport/render.h"
#include "sanitized.h"

namespace recurse::testing {

inline std::unique_ptr<Scene> sceneFrom(const std::string& text) {
  Diagnostics diagnostics;
  const SceneDescription description = parseScene(text, "test.pbrt", ".", diagnostics);
  std::unique_ptr<Scene> scene;
  if (!diagnostics.hasErrors()) scene = buildScene(description, {}, diagnostics);
  EXPECT_FALSE(diagnostics.hasErrors()) << diagnostics.format();
  return scene;
}

inline std::unique_ptr<Integrator> integratorFrom(const std::string& name, const std::string& parameters) {
  Diagnostics diagnostics;
  auto made = plugIns().integrators.make(parseParameterText(name, parameters), {}, diagnostics);
  EXPECT_FALSE(diagnostics.hasErrors()) << diagnostics.format();
  return made;
}

struct Rendered {
  Film film;
  RenderStatistics statistics;

  size_t pixels() const { return film.bounds().area(); }
  Rgb value(size_t pixel) const { return film.value(pixel, 0); }
  double mean() const {
    double sum = 0;
    for (size_t i = 0; i < pixels(); ++i) sum += double(luminance(value(i)));
    return sum / double(pixels());
  }
  /** Standard error of mean(), from the variance within pixels: too large rather than too small. */
  double standardError() const {
    double sum = 0;
    for (size_t i = 0; i < pixels(); ++i)
      sum += film.variance(i) / double(std::max<uint64_t>(1, film.samples(i)));
    return std::sqrt(sum) / double(pixels());
  }
};

inline Rendered renderScene(const Scene& scene, const std::string& integrator, const std::string& parameters,
                            int samplesPerPixel, uint64_t seed = 1, int threads = 0) {
  const ThreadPool pool(threads);
  const auto made = integratorFrom(integrator, parameters);
  const PathClasses classes;
  Rendered out{Film(scene.film().crop, 1), {}};
  RenderSettings settings;
  settings.samplesPerPixel = samplesPerPixel;
  settings.seed = seed;
  const std::atomic<bool> stop{false};
  out.statistics = render(scene, *made, classes, settings, out.film, stop, nullptr, nullptr);
  EXPECT_EQ(out.statistics.counts.nonFinite, 0u);
  return out;
}

inline Rendered renderText(const std::string& text, const std::string& integrator,
                           const std::string& parameters, int samplesPerPixel, uint64_t seed = 1,
                           int threads = 0) {
  const auto scene = sceneFrom(text);
  if (!scene) throw std::runtime_error("no scene");
  return renderScene(*scene, integrator, parameters, samplesPerPixel, seed, threads);
}

/** Film, filter and camera of `size` x `size` pixels. */
inline std::string view(int size, const std::string& lookAt, double fov) {
  const std::string n = std::to_string(size);
  return "Film \"rgb\" \"integer xresolution\" " + n + " \"integer yresolution\" " + n +
         "\nPixelFilter \"box\"\nLookAt " + lookAt + "\nCamera \"perspective\" \"float fov\" " +
         std::to_string(fov) + "\nWorldBegin\n";
}

/** A floor, a wall and a small lamp in front of them. */
inline std::string litCorner(int size) {
  return view(size, "0 -3 2  0 0 .2  0 0 1", 40) + R"(
Material "diffuse" "rgb reflectance" [ .7 .6 .5 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 -2 0  2 -2 0  2 2 0  -2 2 0 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 .5 0  2 .5 0  2 .5 2  -2 .5 2 ]
AreaLightSource "diffuse" "rgb L" [ 20 20 20 ]
Shape "sphere" "float radius" .2
)";
}

/** The mean of many independent values, with its standard error. */
struct Mean {
  explicit Mean(const std::vector<double>& values) {
    const auto n = double(values.size());
    for (const double v : values) value += v / n;
    double squares = 0;
    for (const double v : values) squares += square(v - value);
    error = std::sqrt(squares) / n;
  }
  double value = 0, error = 0;
};

/** The ways of estimating the whole of light transport: integrator and parameters. */
struct Way {
  std::string integrator, parameters;
};
inline std::vector<Way> allWays(const std::string& photons) {
  const std::string p = "\"integer passes\" 1 \"integer photons\" " + photons;
  return {{"path", ""},
          {"photonmap", p},
          {"photonmap", p + " \"string direct\" \"photons\""},
          {"photonmap", p + " \"integer finalgather\" 2"},
          {"photonmap", p + " \"integer finalgather\" 1 \"string direct\" \"photons\""},
          {"photonmap", p + " \"bool causticsonly\" true"}};
}

} // namespace recurse::testing
