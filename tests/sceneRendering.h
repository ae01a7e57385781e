/** @file
 * Small renders for tests and hard cases from the text of a scene, with means and errors. Failures are
 * exceptions.
 */
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "recurse/core/threads/parallel.h"
#include "recurse/render/render.h"
#include "recurse/scene/directives/loader.h"
#include "sanitized.h"

namespace recurse::testing {

/** Scene of the text; throws Error with the diagnostics if it is refused. */
inline std::unique_ptr<Scene> sceneFrom(const std::string& text, const std::string& directory = ".") {
  Diagnostics diagnostics;
  const SceneDescription description = parseScene(text, "test.pbrt", directory, diagnostics);
  diagnostics.throwIfErrors();
  auto scene = buildScene(description, {}, diagnostics);
  diagnostics.throwIfErrors();
  if (!scene) throw Error("no scene was made, and no error reported");
  return scene;
}

inline std::unique_ptr<Integrator> integratorFrom(const std::string& name, const std::string& parameters) {
  Diagnostics diagnostics;
  auto made = plugIns().integrators.make(parseParameterText(name, parameters), {}, diagnostics);
  diagnostics.throwIfErrors();
  return made;
}

struct Rendered {
  Film film;
  RenderStatistics statistics;

  size_t pixels() const { return film.bounds().area(); }
  Rgb value(size_t pixel, size_t layer = 0) const { return film.value(pixel, layer); }
  double luminanceAt(size_t pixel, size_t layer = 0) const { return double(luminance(value(pixel, layer))); }
  double mean(size_t layer = 0) const {
    double sum = 0;
    for (size_t i = 0; i < pixels(); ++i) sum += luminanceAt(i, layer);
    return sum / double(pixels());
  }
  /** Mean over the picture of each layer: three numbers for each layer, red, green and blue. */
  std::vector<double> layerMeans() const {
    std::vector<double> out(3 * film.layerCount());
    for (size_t layer = 0; layer < film.layerCount(); ++layer)
      for (size_t p = 0; p < pixels(); ++p)
        for (int c = 0; c < 3; ++c)
          out[3 * layer + size_t(c)] += double(value(p, layer)[c]) / double(pixels());
    return out;
  }
  /** Standard error of mean(), from the variance within pixels: an upper estimate. */
  double standardError() const {
    double sum = 0;
    for (size_t i = 0; i < pixels(); ++i)
      sum += film.variance(i) / double(std::max<uint64_t>(1, film.samples(i)));
    return std::sqrt(sum) / double(pixels());
  }
  /** Description of an error: samples or photons that are not finite, pixels that are negative or not finite.
   * Empty: none. */
  std::string unsound() const {
    if (statistics.counts.nonFinite > 0)
      return std::to_string(statistics.counts.nonFinite) + " contributions were not finite";
    if (statistics.photonsRefused > 0)
      return std::to_string(statistics.photonsRefused) + " photons were not finite";
    for (size_t i = 0; i < pixels(); ++i) {
      const Rgb v = value(i);
      if (!isFinite(v) || v.r < 0 || v.g < 0 || v.b < 0) return "a pixel is negative or not finite";
    }
    return {};
  }
};

inline Rendered renderScene(const Scene& scene, Integrator& integrator, const PathClasses& classes,
                            int samplesPerPixel, uint64_t seed, int threads = 0) {
  const ThreadPool pool(threads);
  Rendered out{Film(scene.film().crop, classes.layerCount()), {}};
  RenderSettings settings;
  settings.samplesPerPixel = samplesPerPixel;
  settings.seed = seed;
  const std::atomic<bool> stop{false};
  out.statistics = render(scene, integrator, classes, settings, out.film, stop, nullptr, nullptr);
  return out;
}

inline std::string shown(const char* format, double x) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, format, x);
  return buffer;
}
/** A number for a scene file, with every digit. */
inline std::string number(double x) { return shown("%.17g", x); }
inline std::string perspective(double fov) { return "Camera \"perspective\" \"float fov\" " + number(fov); }

/** Film, box filter and a camera; `camera` is the Camera directive with its arguments. */
inline std::string view(int width, int height, const std::string& lookAt, const std::string& camera) {
  return "Film \"rgb\" \"integer xresolution\" " + std::to_string(width) + " \"integer yresolution\" " +
         std::to_string(height) + "\nPixelFilter \"box\"\nLookAt " + lookAt + "\n" + camera +
         "\nWorldBegin\n";
}

/** A box with a mirror sphere, a glass sphere and a lamp, `lampSize` wide; all is scaled and moved. */
inline std::string glassAndMirrorBox(int size, double lampSize = 0.3, double scale = 1, double move = 0) {
  const auto place = [&](double x, double y, double z) {
    return number(x * scale + move) + " " + number(y * scale + move) + " " + number(z * scale + move) + "  ";
  };
  const std::string m = number(move), s = number(scale), l = number(lampSize / 2);
  return view(size, size, place(0, 0, 3.9) + place(0, 0, 0) + "0 1 0", perspective(39.3)) + "Translate " + m +
         " " + m + " " + m + "\nScale " + s + " " + s + " " + s + R"(
Material "diffuse" "rgb reflectance" [ .7 .7 .7 ]
Shape "bilinearmesh" "point3 P" [ -1 -1 -1  -1 -1 1  1 -1 -1  1 -1 1 ]
Shape "bilinearmesh" "point3 P" [ -1 1 -1  1 1 -1  -1 1 1  1 1 1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  -1 1 -1  1 1 -1  1 -1 -1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -1 -1 -1  -1 -1 1  -1 1 1  -1 1 -1 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ 1 -1 -1  1 1 -1  1 1 1  1 -1 1 ]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 25 25 25 ]
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -)" +
         l + " 0.995 -" + l + "  " + l + " 0.995 -" + l + "  " + l + " 0.995 " + l + "  -" + l + " 0.995 " +
         l + R"( ]
AttributeEnd
AttributeBegin
Material "conductor" "rgb reflectance" [ .9 .9 .9 ]
Translate -0.42 -0.6 -0.35
Shape "sphere" "float radius" 0.4
AttributeEnd
AttributeBegin
Material "dielectric" "float eta" 1.5
Translate 0.42 -0.6 0.25
Shape "sphere" "float radius" 0.4
AttributeEnd
)";
}

} // namespace recurse::testing
