/** @file
 * Small renders for the tests of transport: values that are not finite fail the test.
 */
#pragma once

#include <gtest/gtest.h>
#include <set>
#include <typeindex>

#include "sceneRendering.h"

namespace recurse::testing {

inline Rendered renderScene(const Scene& scene, const std::string& integrator, const std::string& parameters,
                            int samplesPerPixel, uint64_t seed = 1, int threads = 0) {
  Rendered out = renderScene(scene, *integratorFrom(integrator, parameters), PathClasses(), samplesPerPixel,
                             seed, threads);
  EXPECT_EQ(out.statistics.counts.nonFinite, 0u);
  return out;
}

inline Rendered renderText(const std::string& text, const std::string& integrator,
                           const std::string& parameters, int samplesPerPixel, uint64_t seed = 1,
                           int threads = 0) {
  return renderScene(*sceneFrom(text), integrator, parameters, samplesPerPixel, seed, threads);
}

/** Film, filter and camera of `size` x `size` pixels. */
inline std::string view(int size, const std::string& lookAt, double fov) {
  return view(size, size, lookAt, perspective(fov));
}

/** A floor and a wall with a small lamp in front of them. */
inline std::string litCorner(int size) {
  return view(size, "0 -3 2  0 0 .2  0 0 1", 40) + R"(
Material "diffuse" "rgb reflectance" [ .7 .6 .5 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 -2 0  2 -2 0  2 2 0  -2 2 0 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 .5 0  2 .5 0  2 .5 2  -2 .5 2 ]
AreaLightSource "diffuse" "rgb L" [ 20 20 20 ]
Shape "sphere" "float radius" .2
)";
}

/** Mean of independent values, with its standard error. */
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

/** Integrator with its parameters. */
struct Way {
  std::string integrator, parameters;
};

/** Whether the integrator takes the parameter. */
inline bool hasParameter(const std::string& integrator, const std::string& name) {
  for (const ParameterSpec& p : plugIns().integrators.find(integrator)->parameters)
    if (p.name == name && !p.ignored) return true;
  return false;
}

/** Ways to estimate all light transport: the integrators of the registry that claim all paths without
 * assumptions, with default parameters and without aliases, and photonmap with one map of the given number of
 * photons. Progressive integrators emit the same number in 16 passes. */
inline std::vector<Way> allWays(const std::string& photons) {
  std::vector<Way> ways;
  const std::string progressive =
      "\"integer passes\" 0 \"integer photons\" " + std::to_string(std::max(1, std::stoi(photons) / 16));
  std::set<std::type_index> known;
  for (const auto& entry : plugIns().integrators.entries()) {
    const auto made = integratorFrom(entry.name, "");
    const Integrator& integrator = *made;
    const bool isTextbook = entry.name == "simplephotonmap"; // a single wide search, whose blur is visible
    if (integrator.claims().empty() && integrator.suppositions().empty() && !isTextbook &&
        known.insert(typeid(integrator)).second)
      ways.push_back({entry.name, hasParameter(entry.name, "photons") && hasParameter(entry.name, "passes")
                                      ? progressive
                                      : ""});
  }
  const std::string p = "\"integer passes\" 1 \"integer photons\" " + photons;
  for (const char* more :
       {"", " \"string direct\" \"photons\"", " \"integer finalgather\" 2",
        " \"integer finalgather\" 1 \"string direct\" \"photons\"", " \"bool causticsonly\" true"})
    ways.push_back({"photonmap", p + more});
  return ways;
}

/** Ways of allWays() whose light paths do not depend on the number of samples: the rest take long for many
 * samples. */
inline std::vector<Way> quickWays(const std::string& photons) {
  std::vector<Way> ways = allWays(photons);
  std::erase_if(ways, [](const Way& way) {
    return integratorFrom(way.integrator, way.parameters)->passes(1).schedule() == PassSchedule::PER_SAMPLE;
  });
  return ways;
}

/** All ways; under sanitizers every third way, with an offset that depends on the scene, because the executed
 * code depends on the way much more than on the scene. */
inline std::vector<Way> dealt(const std::vector<Way>& ways, size_t scene) {
  if (!SANITIZED) return ways;
  constexpr size_t STRIDE = 3;
  std::vector<Way> some;
  for (size_t i = scene % STRIDE; i < ways.size(); i += STRIDE) some.push_back(ways[i]);
  return some;
}

/** Whether the way reads photon maps and has their blur. */
inline bool readsPhotons(const Way& way) {
  return hasParameter(way.integrator, "gatherphotons") &&
         way.parameters.find("causticsonly") == std::string::npos;
}

} // namespace recurse::testing
