/** @file
 * Named spectra of pbrt as RGB: glasses and metals, and the standard illuminants.
 *
 * Refractive indices are taken at one wavelength for each component, because an index is no colour: 611, 549
 * and 464 nm, near the Rec. 709 primaries. Illuminants have luminance 1.
 */
#include <array>
#include <cmath>
#include <map>

#include "recurse/scene/parameters/spectrum.h"

namespace recurse {

namespace {

constexpr std::array<double, 3> RGB_WAVELENGTHS = {0.611, 0.549, 0.464}; // micrometres

template <class F> Rgbd atPrimaries(F&& index) {
  return {index(RGB_WAVELENGTHS[0]), index(RGB_WAVELENGTHS[1]), index(RGB_WAVELENGTHS[2])};
}

/** Glass by Sellmeier's equation: n² = 1 + sum of b λ² / (λ² - c). */
struct Glass {
  const char* name;
  std::vector<double> b, c; ///< c in square micrometres
  /** Refractive index at wavelength `w` [µm]. */
  double index(double w) const {
    double n2 = 1;
    for (size_t i = 0; i < b.size(); ++i) n2 += b[i] * w * w / (w * w - c[i]);
    return std::sqrt(n2);
  }
};

/** Coefficients of the Schott optical glass data sheets, unless a source is named. pbrt's F5, F10 and F11 are
 * the heavy flints SF5...SF11. */
const std::vector<Glass>& glasses() {
  static const std::vector<Glass> GLASSES = [] {
    std::vector<Glass> g = {
        {"glass-BK7", {1.03961212, 0.231792344, 1.01046945}, {0.00600069867, 0.0200179144, 103.560653}},
        {"glass-BAF10", {1.5851495, 0.143559385, 1.08521269}, {0.00926681282, 0.0424489805, 105.613573}},
        {"glass-FK51A", {0.971247817, 0.216901417, 0.904651666}, {0.00472301995, 0.0153575612, 168.68133}},
        {"glass-LASF9", {2.00029547, 0.298926886, 1.80691843}, {0.0121426017, 0.0538736236, 156.530829}},
        {"glass-SF5", {1.52481889, 0.187085527, 1.42729015}, {0.011254756, 0.0588995392, 129.141675}},
        {"glass-SF10", {1.62153902, 0.256287842, 1.64447552}, {0.0122241457, 0.0595736775, 147.468793}},
        {"glass-SF11", {1.73759695, 0.313747346, 1.89878101}, {0.013188707, 0.0623068142, 155.23629}},
        // Daimon and Masumura 2007, at 20 °C.
        {"water",
         {0.5684027565, 0.1726177391, 0.02086189578, 0.1130748688},
         {0.005101829712, 0.01821153936, 0.02620722293, 10.69792721}},
        // Peter 1923.
        {"diamond", {0.3306, 4.3356}, {0.175 * 0.175, 0.106 * 0.106}},
        // Malitson 1965.
        {"glass-fusedsilica",
         {0.6961663, 0.4079426, 0.8974794},
         {0.0684043 * 0.0684043, 0.1162414 * 0.1162414, 9.896161 * 9.896161}}};
    for (const char* number : {"5", "10", "11"})
      for (size_t i = 0; i < 7; ++i)
        if (g[i].name == std::string("glass-SF") + number) {
          Glass other = g[i];
          other.name = number[0] == '5' ? "glass-F5" : number[1] == '0' ? "glass-F10" : "glass-F11";
          g.push_back(other);
        }
    return g;
  }();
  return GLASSES;
}

/** Emission of a chromaticity, with luminance 1. */
Rgbd fromChromaticity(double x, double y) { return rgbOfXyz({x / y, 1, (1 - x - y) / y}); }

std::map<std::string, Rgbd> makeTable() {
  std::map<std::string, Rgbd> t;

  for (const Glass& glass : glasses()) t[glass.name] = atPrimaries([&](double w) { return glass.index(w); });

  // P. B. Johnson and R. W. Christy, "Optical Constants of the Noble Metals", Phys. Rev. B 6, 1972.
  t["metal-Ag-eta"] = {0.155, 0.117, 0.138};
  t["metal-Ag-k"] = {4.828, 3.122, 2.147};
  t["metal-Au-eta"] = {0.143, 0.375, 1.442};
  t["metal-Au-k"] = {3.983, 2.386, 1.603};
  t["metal-Cu-eta"] = {0.2004, 0.9240, 1.1022};
  t["metal-Cu-k"] = {3.9129, 2.4528, 2.1421};
  // A. D. Rakic, "Algorithm for the determination of intrinsic optical constants of metal films", 1995.
  t["metal-Al-eta"] = {1.657, 0.880, 0.521};
  t["metal-Al-k"] = {9.224, 6.270, 4.837};
  // Brass with 70% copper, as measured for the CRC Handbook of Chemistry and Physics.
  t["metal-CuZn-eta"] = {0.444, 0.527, 1.094};
  t["metal-CuZn-k"] = {3.695, 2.765, 1.829};
  // Two oxides among the metals, without visible absorption. R. E. Stephens and I. H. Malitson, "Index of
  // Refraction of Magnesium Oxide", 1952; J. R. DeVore, "Refractive Indices of Rutile and Sphalerite", 1951
  // (ordinary ray).
  t["metal-MgO-eta"] = atPrimaries([](double w) {
    const double w2 = w * w;
    return std::sqrt(2.956362 - 0.01062387 * w2 - 0.0000204968 * w2 * w2 + 0.02195770 / (w2 - 0.01428322));
  });
  t["metal-MgO-k"] = Rgbd(0);
  t["metal-TiO2-eta"] = atPrimaries([](double w) { return std::sqrt(5.913 + 0.2441 / (w * w - 0.0803)); });
  t["metal-TiO2-k"] = Rgbd(0);

  // CIE 15:2004, tables T.3 (A, D) and T.8.1 (fluorescent lamps), 2° observer; ACES white of SMPTE ST 2065-1.
  t["stdillum-A"] = fromChromaticity(0.44758, 0.40745);
  t["stdillum-D50"] = fromChromaticity(0.34567, 0.35851);
  t["stdillum-D65"] = Rgbd(1);
  constexpr double FLUORESCENT[][2] = {{.3131, .3371}, {.3721, .3751}, {.4091, .3941}, {.4402, .4031},
                                       {.3138, .3452}, {.3779, .3882}, {.3129, .3292}, {.3458, .3586},
                                       {.3741, .3727}, {.3458, .3588}, {.3805, .3769}, {.4370, .4042}};
  int number = 0;
  for (const auto& xy : FLUORESCENT)
    t["stdillum-F" + std::to_string(++number)] = fromChromaticity(xy[0], xy[1]);
  t["illum-acesD60"] = fromChromaticity(0.32168, 0.33767);
  return t;
}

const std::map<std::string, Rgbd>& table() {
  static const std::map<std::string, Rgbd> TABLE = makeTable();
  return TABLE;
}

} // namespace

std::optional<Rgbd> rgbOfNamedSpectrum(const std::string& name) {
  const auto found = table().find(name);
  if (found == table().end()) return {};
  return found->second;
}

std::optional<SampledSpectrum> indexOfNamedGlass(const std::string& name) {
  for (const Glass& glass : glasses()) {
    if (glass.name != name) continue;
    constexpr double STEP = 5; // [nm] the index is linear between samples to six digits
    SampledSpectrum spectrum;
    for (double w = SHORTEST_WAVELENGTH; w <= LONGEST_WAVELENGTH; w += STEP) {
      spectrum.wavelengths.push_back(w);
      spectrum.values.push_back(glass.index(w / 1000));
    }
    return spectrum;
  }
  return {};
}

const std::vector<std::string>& namedSpectra() {
  static const std::vector<std::string> NAMES = [] {
    std::vector<std::string> names;
    for (const auto& entry : table()) names.push_back(entry.first);
    return names;
  }();
  return NAMES;
}

} // namespace recurse
