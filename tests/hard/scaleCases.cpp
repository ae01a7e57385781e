/** @file
 * 1. The whole scene scaled by 1e-6 to 1e6, and translated by 1e7 times its size: the picture is the same.
 */
#include "hardCase.h"

namespace recurse::hard {

namespace {

/** A floor of albedo 1/2 under the middle of a disc lamp: L = ρ L_e r² / (r² + h²) there. */
std::string floorUnderDisc(double scale, double move) {
  const auto place = [&](double x, double y, double z) {
    return number(x * scale + move) + " " + number(y * scale + move) + " " + number(z * scale + move) + "  ";
  };
  return view(8, 8, place(0, 0, 1) + place(0, 0, 0) + "0 1 0", perspective(6)) + "Translate " + number(move) +
         " " + number(move) + " " + number(move) + "\nScale " + number(scale) + " " + number(scale) + " " +
         number(scale) + "\n" + diffuse(0.5) +
         "Shape \"bilinearmesh\" \"point3 P\" [ -.6 -.6 0  .6 -.6 0  -.6 .6 0  .6 .6 0 ]\n" + diffuse(0) +
         "AreaLightSource \"diffuse\" \"rgb L\" [ 5 5 5 ]\nTranslate 0 0 1.5\nReverseOrientation\n"
         "Shape \"disk\" \"float radius\" .3\n";
}

void scaled(const Report& report, double scale, double move) {
  Budget budget;
  budget.samples = 256;
  budget.tolerance = 2e-3;
  budget.photonTolerance = 0.03;
  checkMean(report, "floor under a disc lamp", floorUnderDisc(scale, move), 0.5 * 5 * 0.09 / (0.09 + 2.25),
            budget);

  budget.photonSamples = 16;
  const auto plain = sceneFrom(testing::glassAndMirrorBox(24, 0.6)),
             other = sceneFrom(testing::glassAndMirrorBox(24, 0.6, scale, move));
  for (const Way& way : allWays(budget.photons)) {
    const Rendered a = renderScene(*plain, way, budget), b = renderScene(*other, way, budget);
    report.atMost(
        "glass and mirror in a box", way.label, "mean differs by", std::abs(b.mean() / a.mean() - 1),
        1e-3 + (way.usesPhotons ? 0.01 : 0) + 4 * std::hypot(a.standardError(), b.standardError()) / a.mean(),
        b.unsound());
    // Pictures with equal samples are equal, except for paths that rounding changes.
    size_t unlike = 0;
    for (size_t i = 0; i < a.pixels(); ++i)
      unlike += !(std::abs(a.luminanceAt(i) - b.luminanceAt(i)) <= 0.1 * a.luminanceAt(i));
    report.atMost("glass and mirror in a box", way.label, "pixels off by 10%",
                  double(unlike) / double(a.pixels()), 0.2);
  }
}

} // namespace

void addScaleCases(HardCases& cases) {
  for (const double scale : {1e-6, 1e-3, 1e3, 1e6})
    cases.push_back(
        {1, "scaled by " + shown("%g", scale), false, [scale](const Report& r) { scaled(r, scale, 0); }});
  for (const double scale : {1e-6, 1.0, 1e6})
    cases.push_back({1, "scaled by " + shown("%g", scale) + ", moved by 1e7 times its size", false,
                     [scale](const Report& r) { scaled(r, scale, 2e7 * scale); }});
}

} // namespace recurse::hard
