/** @file
 * 7. Radiance from 1e-20 to 1e20 in one picture; a film with a million samples per pixel.
 */
#include "hardCase.h"

namespace recurse::hard {

namespace {

void decades(const Report& report) {
  // A row of lamps, one for each pixel; a lamp's light reaches only its own pixel.
  constexpr int COUNT = 41;
  std::string text =
      "Film \"rgb\" \"integer xresolution\" 41 \"integer yresolution\" 1\nPixelFilter \"box\"\n"
      "LookAt 0 0 1  0 0 0  0 1 0\nCamera \"orthographic\" \"float screenwindow\" [ -20.5 20.5 -.5 "
      ".5 ]\nWorldBegin\n" +
      diffuse(0);
  const auto radiance = [](int i) { return std::pow(10.0, i - 20); };
  for (int i = 0; i < COUNT; ++i) {
    // Camera space looks along +z with x to the right: seen from +z the world's x runs to the left.
    const double x = 20 - i;
    text += "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [ " + number(radiance(i)) + " " +
            number(radiance(i)) + " " + number(radiance(i)) + " ]\nShape \"bilinearmesh\" \"point3 P\" [ " +
            number(x - .5) + " -.5 0  " + number(x + .5) + " -.5 0  " + number(x - .5) + " .5 0  " +
            number(x + .5) + " .5 0 ]\nAttributeEnd\n";
  }
  const auto scene = sceneFrom(text);
  for (const Way& way : allWays(1e4)) {
    const Rendered r = renderScene(*scene, way, 16);
    double worst = 0;
    for (int i = 0; i < COUNT; ++i)
      worst = std::max(worst, std::abs(r.luminanceAt(static_cast<size_t>(i)) / radiance(i) - 1));
    report.atMost("lamps of 1e-20 to 1e20, a pixel each", way.label, "worst relative error", worst, 1e-5,
                  r.unsound());
  }
}

/** A pair of rooms, each a floor under its own lamp; the lamp of the second room is 1e40 times as bright. */
void rooms(const Report& report, const std::string& dimLamp, double dimRadiance, const std::string& name) {
  const std::string wall = diffuse(0) + "AttributeBegin\nTranslate 0 0 0\nRotate 90 0 1 0\nShape \"disk\" "
                                        "\"float radius\" 50\nAttributeEnd\n";
  const std::string rest = diffuse(0.5) +
                           "Shape \"bilinearmesh\" \"point3 P\" [ -4 -1 0  -2 -1 0  -4 1 0  -2 1 0 ]\n"
                           "Shape \"bilinearmesh\" \"point3 P\" [ 2 -1 0  4 -1 0  2 1 0  4 1 0 ]\n" +
                           wall +
                           "LightSource \"point\" \"rgb I\" [ 1e20 1e20 1e20 ] \"point3 from\" [ 3 0 1 ]\n";
  Budget budget;
  budget.samples = 256;
  budget.tolerance = 5e-3;
  budget.photonTolerance = 0.05;
  checkMean(report, "floor lit by " + name + " beside 1e20 behind a wall",
            view(8, 8, "-3 0 .7  -3 0 0  0 1 0", perspective(6)) + rest + dimLamp, dimRadiance, budget);
  checkMean(report, "floor lit by 1e20 beside " + name + " behind a wall",
            view(8, 8, "3 0 .7  3 0 0  0 1 0", perspective(6)) + rest + dimLamp, 0.5 / M_PI * 1e20, budget);
}

void film(const Report& report) {
  const uint32_t count = 1000000;
  for (const float value : {0.1f, 1e-20f, 1e20f}) {
    Film film({0, 0, 1, 1}, 1);
    const Rgb colour(value);
    for (uint32_t i = 0; i < count; ++i) film.add(0, i, 1, &colour, colour);
    report.atMost(shown("%.0f equal samples of ", double(count)) + shown("%g", double(value)), "-",
                  "relative drift", std::abs(double(film.value(0, 0).r) / double(value) - 1), 1e-7);
  }
  // Large and small values alternate: the mean is half of their sum.
  Film film({0, 0, 1, 1}, 1);
  const Rgb large(1e5f), small(1e-3f);
  for (uint32_t i = 0; i < count; ++i) film.add(0, i, 1, i % 2 ? &large : &small, i % 2 ? large : small);
  report.atMost("samples of 1e5 and 1e-3 in turn", "-", "relative drift",
                std::abs(double(film.value(0, 0).r) / ((double(1e5f) + double(1e-3f)) / 2) - 1), 1e-7);
}

/** Mean over a pixel of light with a known mean, with so large a number of samples that a sum in floats would
 * stop growing. */
void render(const Report& report, int samples) {
  const auto scene = sceneFrom(view(1, 1, "0 0 1  0 0 0  0 1 0", orthographic(1)) + constantLight(0.1) +
                               glass(1.5) + "Shape \"sphere\" \"float radius\" .5\n");
  for (const Way& way : allWays(100)) {
    const Rendered r = renderScene(*scene, way, SANITIZED ? samples / 16 : samples);
    report.atMost(shown("%.0f samples a pixel", samples), way.label, "relative error",
                  std::abs(r.mean() / double(0.1f) - 1), 1e-5 + 4 * r.standardError() / 0.1, r.unsound());
  }
}

} // namespace

void addRangeCases(HardCases& cases) {
  cases.push_back({7, "radiance from 1e-20 to 1e20", false, decades});
  cases.push_back(
      {7, "two rooms", false, [](const Report& r) {
         rooms(r, "LightSource \"point\" \"rgb I\" [ 1e-20 1e-20 1e-20 ] \"point3 from\" [ -3 0 1 ]\n",
               0.5 / M_PI * 1e-20, "a point light of 1e-20");
         rooms(r,
               "AreaLightSource \"diffuse\" \"rgb L\" [ 1e-20 1e-20 1e-20 ]\nTranslate -3 0 1\n"
               "ReverseOrientation\nShape \"disk\" \"float radius\" .5\n",
               0.5 * 0.25 / 1.25 * 1e-20, "a lamp of 1e-20");
       }});
  cases.push_back({7, "film", false, film});
  cases.push_back({7, "render", false, [](const Report& r) { render(r, 50000); }});
  cases.push_back({7, "render", true, [](const Report& r) { render(r, 1000000); }});
}

} // namespace recurse::hard
