/** @file
 * Small renders for the tests of transport: what is not finite fails the test.
 */
#pragma once

#include <gtest/gtest.h>

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
