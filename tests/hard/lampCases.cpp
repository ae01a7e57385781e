/** @file
 * 5. Tiny lamps with the power of large ones, a light just above a surface, a hundred thousand lights, a
 * single relevant light among ten thousand.
 */
#include "hardCase.h"

#include <random>

namespace recurse::hard {

namespace {

std::string floor(double half) {
  const std::string h = number(half);
  return diffuse(0.5) + "Shape \"bilinearmesh\" \"point3 P\" [ -" + h + " -" + h + " 0  " + h + " -" + h +
         " 0  -" + h + " " + h + " 0  " + h + " " + h + " 0 ]\n";
}

/** Every lamp of power 10 W at a height of 1 has this irradiance below it, if its radiant intensity is
 * uniform. */
constexpr double POWER = 10;

void tiny(const Report& report) {
  const std::string head = view(8, 8, "0 0 .8  0 0 0  0 1 0", perspective(3)) + floor(0.6) + diffuse(0);
  Budget budget;
  budget.tolerance = 2e-3;
  budget.photons = 4e5;
  // The search disc covers 1/400 of the sphere of directions from the lamp.
  budget.photonTolerance = 0.01 + photonNoise(1000);
  budget.photonParameters = "\"float radius\" .1";
  const double point = 0.5 / M_PI * POWER / (4 * M_PI);
  checkMean(report, "point light",
            head + "LightSource \"point\" \"point3 from\" [ 0 0 1 ] \"float power\" 10\n", point, budget);
  for (const double size : {0.1, 1e-5}) {
    const std::string name = " of size " + shown("%g", size);
    // A Lambertian sphere has the irradiance of a point light of the same power, at any distance.
    checkMean(report, "sphere" + name,
              head +
                  "AreaLightSource \"diffuse\" \"float power\" 10\nTranslate 0 0 1\nShape \"sphere\" \"float "
                  "radius\" " +
                  number(size / 2) + "\n",
              point, budget);
    // A disc: E = Φ / (π (r² + h²)).
    checkMean(report, "disc" + name,
              head +
                  "AreaLightSource \"diffuse\" \"float power\" 10\nTranslate 0 0 1\nReverseOrientation\n"
                  "Shape \"disk\" \"float radius\" " +
                  number(size / 2) + "\n",
              0.5 / M_PI * POWER / M_PI / (1 + size * size / 4), budget);
  }
}

/** Mean of I h / (h² + x² + y²)^1.5 over the square of half width s: 4 I / (2s)² atan(s² / (h sqrt(h² + 2
 * s²))). */
double meanIrradiance(double intensity, double h, double s) {
  return intensity / (s * s) * std::atan(s * s / (h * std::sqrt(h * h + 2 * s * s)));
}

void near(const Report& report) {
  for (const double height : {1e-2, 1e-4, 1e-6}) {
    const double half = 2 * height;
    Budget budget;
    budget.tolerance = 5e-3;
    budget.photonTolerance = 0.05; // the picture is many search discs wide
    budget.photons = 4e5;
    checkMean(report, "point light " + shown("%g", height) + " above a floor",
              view(16, 16, "0 0 1  0 0 0  0 1 0", orthographic(half)) + floor(1) +
                  "LightSource \"point\" \"rgb I\" [ 1 1 1 ] \"point3 from\" [ 0 0 " + number(height) +
                  " ]\n",
              0.5 / M_PI * meanIrradiance(1, height, half), budget);
  }
}

/** Lights uniformly distributed at a height of 1 over a floor, whose centre is in the view. */
void many(const Report& report, int count, const std::string& kind) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> place(-4, 4);
  std::string lights;
  double irradiance = 0;
  for (int i = 0; i < count; ++i) {
    const double x = place(random), y = place(random);
    irradiance += 1.0 / count / std::pow(1 + x * x + y * y, 1.5);
    const std::string where = number(x) + " " + number(y) + " 1";
    if (kind == "point")
      lights += "LightSource \"point\" \"float power\" " + number(4 * M_PI / count) + " \"point3 from\" [ " +
                where + " ]\n";
    else
      lights +=
          "AttributeBegin\nTranslate " + where + "\nShape \"sphere\" \"float radius\" 1e-3\nAttributeEnd\n";
  }
  if (kind != "point")
    lights = diffuse(0) + "AreaLightSource \"diffuse\" \"float power\" " + number(4 * M_PI / count) + "\n" +
             lights;
  Budget budget;
  budget.samples = 256;
  budget.photonSamples = 64;
  budget.photons = 4e5;
  budget.tolerance = 5e-3;
  budget.photonTolerance = 0.05;
  budget.photonParameters = "\"float radius\" .3"; // finds thousands of photons
  checkMean(report, shown("%.0f ", count) + kind + " lights",
            view(8, 8, "0 0 .8  0 0 0  0 1 0", perspective(6)) + floor(5) + lights, 0.5 / M_PI * irradiance,
            budget);
}

/** One relevant light among many: the rest have no power, or the same power behind walls. */
void one(const Report& report, bool walledOff, int samples) {
  constexpr int COUNT = 10000;
  std::string lights;
  for (int i = 0; i < COUNT; ++i) {
    const double x = 3 + 0.01 * (i % 100), y = -0.5 + 0.01 * (i / 100);
    lights += i == 4321 ? std::string("LightSource \"point\" \"rgb I\" [ 2 2 2 ] \"point3 from\" [ 0 0 1 ]\n")
                        : "LightSource \"point\" \"rgb I\" [ 2 2 2 ] \"float scale\" " +
                              std::string(walledOff ? "1" : "1e-9") + " \"point3 from\" [ " + number(x) +
                              " " + number(y) + " .5 ]\n";
  }
  // A black box around all lights but one.
  const std::string box =
      diffuse(0) + "AttributeBegin\nTranslate 3.5 0 .5\nShape \"sphere\" \"float radius\" 2\nAttributeEnd\n";
  Budget budget;
  budget.samples = budget.photonSamples = samples;
  // One photon in 10000 comes from the relevant lamp if all lamps have the same power: more photons, in a
  // wider disc.
  const double radius = walledOff ? 0.35 : 0.1;
  budget.photons = walledOff ? 2e7 : 1e5;
  budget.photonParameters = "\"float radius\" " + number(radius);
  budget.tolerance = 2e-3;
  // The search disc covers r²/4 of the sphere of directions from the lamp; the irradiance decreases by 3/2
  // r², of which the kernel averages a third.
  budget.photonTolerance =
      0.01 + square(radius) / 2 + photonNoise(budget.photons / (walledOff ? COUNT : 1) * square(radius) / 4);
  checkMean(report, walledOff ? "all but one walled off" : "all but one of a billionth of its power",
            view(8, 8, "0 0 .8  0 0 0  0 1 0", perspective(3)) + floor(0.6) + (walledOff ? box : "") + lights,
            0.5 / M_PI * 2, budget);
}

} // namespace

void addLampCases(HardCases& cases) {
  cases.push_back({5, "lamps of the same power", false, tiny});
  cases.push_back({5, "light near a surface", false, near});
  cases.push_back(
      {5, "many lights", false, [](const Report& r) { many(r, SANITIZED ? 10000 : 100000, "point"); }});
  cases.push_back({5, "many lights", true, [](const Report& r) { many(r, 100000, "sphere"); }});
  cases.push_back({5, "one light in 10000 matters", false, [](const Report& r) { one(r, false, 64); }});
  cases.push_back({5, "one light in 10000 matters", true, [](const Report& r) { one(r, true, 65536); }});
}

} // namespace recurse::hard
