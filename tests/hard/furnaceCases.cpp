/** @file
 * 6. Furnaces of high albedo: inside a closed surface that emits 1 - ρ and reflects ρ the radiance is 1.
 * Walks have about 1 / (1 - ρ) events, and a limit on them would lose light.
 */
#include "hardCase.h"

namespace recurse::hard {

namespace {

void furnace(const Report& report, double albedo, const std::string& name, const std::string& material,
             int samples, double photons) {
  const std::string e = number(1 - albedo);
  const auto scene = sceneFrom(view(8, 8, ".3 .2 -.5  0 0 0  0 1 0", perspective(60)) + material +
                               "ReverseOrientation\nAreaLightSource \"diffuse\" \"rgb L\" [ " + e + " " + e +
                               " " + e + " ]\nShape \"sphere\"\n");
  for (const Way& way : allWays(photons)) {
    const bool diffuseLight = name == "diffuse";
    Budget budget;
    budget.samples = budget.photonSamples = std::max(1, samples / (way.usesPhotons && diffuseLight ? 4 : 1));
    const Rendered r = renderScene(*scene, way, budget);
    // Camera walks: measured. Photons: one relative standard deviation for each photon's own walk.
    const double noise = way.usesPhotons && diffuseLight ? 1 / std::sqrt(photons) : 0;
    report.atMost(name + ", albedo " + shown("%g", albedo), way.label, "relative error",
                  std::abs(r.mean() - 1),
                  2e-3 + (noise > 0 ? 0.01 : 0) + 4 * std::hypot(noise, r.standardError()), r.unsound());
  }
}

std::string mirror(double reflectance) {
  const std::string r = number(reflectance);
  return "Material \"conductor\" \"rgb reflectance\" [ " + r + " " + r + " " + r + " ]\n";
}

} // namespace

void addFurnaceCases(HardCases& cases) {
  const auto add = [&](double albedo, int samples, double photons, bool heavy) {
    cases.push_back({6, "furnace of albedo " + shown("%g", albedo), heavy, [=](const Report& report) {
                       furnace(report, albedo, "diffuse", diffuse(albedo), samples, photons);
                     }});
  };
  add(0.99, 64, 20000, false);
  add(0.999, 64, 4000, false);
  add(0.9999, 16, 200, false);
  add(0.9999, 64, 2000, true);
  for (const double r : {0.99, 0.999, 0.9999})
    // From the centre every reflection is at normal incidence, where the reflectance is the parameter.
    cases.push_back({6, "furnace of mirrors of " + shown("%g", r), false, [r](const Report& report) {
                       const std::string e = number(1 - r);
                       Budget budget;
                       budget.samples = budget.photonSamples = r > 0.999 ? 12 : 32;
                       budget.photons = 100;
                       budget.tolerance = budget.photonTolerance = 2e-3;
                       checkMean(report, "",
                                 view(4, 4, "0 0 0  0 0 1  0 1 0", perspective(60)) + mirror(r) +
                                     "ReverseOrientation\nAreaLightSource \"diffuse\" \"rgb L\" [ " + e +
                                     " " + e + " " + e + " ]\nShape \"sphere\"\n",
                                 1, budget);
                     }});
}

} // namespace recurse::hard
