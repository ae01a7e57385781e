/** @file
 * The numbers of media, and measured ones.
 */
#include "recurse/model/mediumParameters.h"

namespace recurse {

namespace {

/** Reduced scattering and absorption [1/mm] of table 1 in Jensen, Marschner, Levoy and Hanrahan 2001, "A
 * Practical Model for Subsurface Light Transport". */
struct Preset {
  const char* name;
  Rgbd scattering, absorption;
};
const std::vector<Preset> PRESETS = {
    {"Apple", {2.29, 2.39, 1.97}, {0.0030, 0.0034, 0.046}},
    {"Chicken1", {0.15, 0.21, 0.38}, {0.015, 0.077, 0.19}},
    {"Chicken2", {0.19, 0.25, 0.32}, {0.018, 0.088, 0.20}},
    {"Cream", {7.38, 5.47, 3.15}, {0.0002, 0.0028, 0.0163}},
    {"Ketchup", {0.18, 0.07, 0.03}, {0.061, 0.97, 1.45}},
    {"Marble", {2.19, 2.62, 3.00}, {0.0021, 0.0041, 0.0071}},
    {"Potato", {0.68, 0.70, 0.55}, {0.0024, 0.0090, 0.12}},
    {"Skimmilk", {0.70, 1.22, 1.90}, {0.0014, 0.0025, 0.0142}},
    {"Skin1", {0.74, 0.88, 1.01}, {0.032, 0.17, 0.48}},
    {"Skin2", {1.09, 1.59, 1.79}, {0.013, 0.070, 0.145}},
    {"Spectralon", {11.6, 20.4, 14.9}, {0.00, 0.00, 0.00}},
    {"Wholemilk", {2.55, 3.21, 3.77}, {0.0011, 0.0024, 0.014}},
};

} // namespace

std::vector<std::string> mediumPresetNames() {
  std::vector<std::string> names;
  for (const Preset& p : PRESETS) names.emplace_back(p.name);
  return names;
}

std::vector<ParameterSpec> mediumParameters(const std::string& absorption, const std::string& scattering) {
  return {spectrumParameter("sigma_a", absorption, SpectrumKind::UNBOUNDED, "absorption [1/length]"),
          spectrumParameter("sigma_s", scattering, SpectrumKind::UNBOUNDED, "scattering [1/length]"),
          realParameter("scale", "1", "of sigma_a and sigma_s").range(0, 1e30),
          spectrumParameter("Le", "0", SpectrumKind::ILLUMINANT,
                            "emitted radiance; a unit of length adds sigma_a times that"),
          realParameter("Lescale", "1", "of Le").range(0, 1e30)};
}

MediumPoint readMediumPoint(const Parameters& p) {
  Rgbd absorption = p.spectrum("sigma_a"), scattering = p.spectrum("sigma_s");
  const std::vector<std::string> names = mediumPresetNames();
  if (!p.has("sigma_a") && !p.has("sigma_s") && p.plugInName() == "homogeneous" && p.hasValue("preset")) {
    const std::string preset = p.string("preset");
    for (const Preset& known : PRESETS)
      if (preset == known.name) {
        absorption = known.absorption;
        scattering = known.scattering;
      }
  }
  const double scale = p.real("scale");
  MediumPoint m;
  m.absorption = Rgb(absorption * scale);
  m.scattering = Rgb(scattering * scale);
  m.emission = m.absorption * Rgb(p.spectrum("Le") * p.real("Lescale"));
  const auto usable = [](const Rgb& c) { return maxComponent(c) <= 1e18f; }; // squares fit, false for NaN
  if (!usable(m.absorption) || !usable(m.scattering) || !usable(m.emission))
    p.fail(p.has("scale") ? "scale" : "sigma_s", "the medium is too dense for single precision",
           "coefficients below 1e18");
  return m;
}

} // namespace recurse
