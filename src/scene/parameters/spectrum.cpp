/** @file
 * Integration of spectra to colours.
 */
#include "recurse/scene/parameters/spectrum.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "recurse/core/io/error.h"
#include "recurse/scene/parameters/reflectanceWeights.h"
#include "scene/text/lexer.h"
#include "scene/text/sourceFiles.h"

namespace recurse {

namespace {

/** Range of the integrals [nm], in steps of 1 nm; the eye is nearly insensitive outside of it. */
constexpr int FIRST_WAVELENGTH = 360, LAST_WAVELENGTH = 780;

/** Gaussian lobe with a separate inverse width on each side. */
double lobe(double wavelength, double centre, double below, double above) {
  const double t = (wavelength - centre) * (wavelength < centre ? below : above);
  return std::exp(-0.5 * t * t);
}

/**
 * CIE 1931 matching functions, in the multi-lobe fit of C. Wyman, P.-P. Sloan and P. Shirley, "Simple
 * Analytic Approximations to the CIE XYZ Color Matching Functions", JCGT 2(2), 2013.
 */
Vec3d matchingFunctions(double w) {
  return {0.362 * lobe(w, 442.0, 0.0624, 0.0374) + 1.056 * lobe(w, 599.8, 0.0264, 0.0323) -
              0.065 * lobe(w, 501.1, 0.0490, 0.0382),
          0.821 * lobe(w, 568.8, 0.0213, 0.0247) + 0.286 * lobe(w, 530.9, 0.0613, 0.0322),
          1.217 * lobe(w, 437.0, 0.0845, 0.0278) + 0.681 * lobe(w, 459.0, 0.0385, 0.0725)};
}

/** CIE standard illuminant D65 (ISO 11664-2), every 10 nm from 360 nm. */
constexpr double D65[] = {46.6383, 52.0891, 49.9755, 54.6482, 82.7549, 91.4860, 93.4318, 86.6823, 104.865,
                          117.008, 117.812, 114.861, 115.923, 108.811, 109.354, 107.802, 104.790, 107.689,
                          104.405, 104.046, 100.000, 96.3342, 95.7880, 88.6856, 90.0062, 89.5991, 87.6987,
                          83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091, 74.3490,
                          61.6040, 69.8856, 75.0870, 63.5927, 46.4182, 66.8054, 63.3828};

double daylight(int wavelength) {
  const int i = (wavelength - FIRST_WAVELENGTH) / 10;
  const double t = (wavelength - FIRST_WAVELENGTH - 10 * i) / 10.0;
  return t == 0 ? D65[i] : D65[i] * (1 - t) + D65[i + 1] * t;
}

/** Planck's law up to a constant factor. */
double planck(double nanometres, double kelvin) {
  constexpr double SECOND_RADIATION_CONSTANT = 1.438776877e7; // nm K, CODATA 2018
  const double exponent = SECOND_RADIATION_CONSTANT / (nanometres * kelvin);
  return 1 / (std::pow(nanometres / 560, 5) * std::expm1(exponent));
}

template <class F> Vec3d integrate(F&& spectrum) {
  static const std::vector<Vec3d> MATCHING = [] {
    std::vector<Vec3d> table;
    for (int w = FIRST_WAVELENGTH; w <= LAST_WAVELENGTH; ++w) table.push_back(matchingFunctions(w));
    return table;
  }();
  Vec3d xyz(0);
  for (int w = FIRST_WAVELENGTH; w <= LAST_WAVELENGTH; ++w)
    xyz += MATCHING[static_cast<size_t>(w - FIRST_WAVELENGTH)] * spectrum(w);
  return xyz;
}

/** Matrix of a colour space, from the chromaticities x, y of its primaries and white. */
Mat3d xyzFromRgb(const std::array<Vec2d, 3>& primaries, const Vec2d& whitePoint) {
  const auto column = [](const Vec2d& c) { return Vec3d(c.x / c.y, 1, (1 - c.x - c.y) / c.y); };
  const Mat3d columns(column(primaries[0]), column(primaries[1]), column(primaries[2]));
  const Vec3d amounts = glm::inverse(columns) * column(whitePoint);
  return {columns[0] * amounts.x, columns[1] * amounts.y, columns[2] * amounts.z};
}

/** Integral of daylight. Results are divided by it, so that the errors of the fitted matching functions
 * cancel for white. */
const Rgbd& white() {
  static const Rgbd WHITE = rgbOfXyz(integrate(daylight));
  return WHITE;
}

template <class F> Rgbd convert(F&& spectrum, SpectrumKind kind) {
  if (kind != SpectrumKind::ILLUMINANT)
    return intoGamut(rgbOfXyz(integrate([&](int w) { return spectrum(w) * daylight(w); })) / white());
  const Rgbd c = intoGamut(rgbOfXyz(integrate(spectrum)) / white());
  const double y = luminance(c);
  return y > 0 ? c / y : Rgbd(0);
}

} // namespace

Rgbd intoGamut(const Rgbd& c) {
  const double lowest = std::min({c.r, c.g, c.b});
  if (lowest >= 0) return c;
  const double grey = luminance(c);
  if (!(grey > 0)) return Rgbd(0);
  const double keep = grey / (grey - lowest);
  return max((c - grey) * keep + grey, 0);
}

Rgbd daylightColour(double wavelength) {
  if (!(wavelength >= FIRST_WAVELENGTH && wavelength <= LAST_WAVELENGTH)) return Rgbd(0);
  const int below = std::min(static_cast<int>(wavelength), LAST_WAVELENGTH - 1);
  const double t = wavelength - below, light = daylight(below) * (1 - t) + daylight(below + 1) * t;
  return rgbOfXyz(matchingFunctions(wavelength) * light) / white();
}

Rgbd rgbOfXyz(const Vec3d& xyz) {
  // Primaries and white of ITU-R BT.709-6, item 1.3 and 1.4.
  static const Mat3d FROM_XYZ =
      glm::inverse(xyzFromRgb({{{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}}}, {0.3127, 0.3290}));
  return Rgbd(FROM_XYZ * xyz);
}

const std::vector<std::string>& namedColorSpaces() {
  static const std::vector<std::string> NAMES = {"srgb", "rec2020", "dci-p3", "aces2065-1"};
  return NAMES;
}

Rgbd rgbInColorSpace(const std::string& name, const Rgbd& value, SpectrumKind kind) {
  if (name.empty() || name == "srgb") return value;
  static const auto TO_REC709 = [](const std::array<Vec2d, 3>& primaries, const Vec2d& whitePoint) {
    const Mat3d toXyz = xyzFromRgb(primaries, whitePoint);
    return Mat3d(Vec3d(rgbOfXyz(toXyz[0])), Vec3d(rgbOfXyz(toXyz[1])), Vec3d(rgbOfXyz(toXyz[2])));
  };
  // ITU-R BT.2020-2; SMPTE RP 431-2 with the white of displays, as pbrt; SMPTE ST 2065-1.
  static const Mat3d REC2020 =
      TO_REC709({{{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}}}, {0.3127, 0.3290});
  static const Mat3d DCI_P3 = TO_REC709({{{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}}}, {0.3127, 0.3290});
  static const Mat3d ACES =
      TO_REC709({{{0.7347, 0.2653}, {0.0, 1.0}, {0.0001, -0.0770}}}, {0.32168, 0.33767});
  const Mat3d* const found = name == "rec2020"      ? &REC2020
                             : name == "dci-p3"     ? &DCI_P3
                             : name == "aces2065-1" ? &ACES
                                                    : nullptr;
  if (!found) throw Error("colour space \"" + name + "\" does not exist");
  const Mat3d& matrix = *found;
  if (kind == SpectrumKind::ILLUMINANT) return intoGamut(matrix * value);
  // A factor that absorbs in its colour space must not amplify in Rec. 709.
  return min(intoGamut(matrix * value / (matrix * Rgbd(1))),
             Rgbd(std::max({1.0, value.r, value.g, value.b})));
}

Vec3d xyzOfRgb(const Rgbd& rgb) {
  static const Mat3d TO_XYZ =
      glm::inverse(Mat3d(Vec3d(rgbOfXyz({1, 0, 0})), Vec3d(rgbOfXyz({0, 1, 0})), Vec3d(rgbOfXyz({0, 0, 1}))));
  return TO_XYZ * Vec3d(rgb);
}

Mat3d whiteBalance(double kelvin) {
  // Chromaticity of daylight by temperature (CIE 15:2004, section 3.1).
  Vec3d source;
  if (kelvin < 4000) {
    source = xyzOfRgb(rgbOfBlackbody(kelvin, SpectrumKind::ILLUMINANT));
  } else {
    const double t = 1 / kelvin, x = kelvin <= 7000
                                         ? ((-4.6070e9 * t + 2.9678e6) * t + 0.09911e3) * t + 0.244063
                                         : ((-2.0064e9 * t + 1.9018e6) * t + 0.24748e3) * t + 0.237040;
    const double y = (-3 * x + 2.870) * x - 0.275;
    source = Vec3d(x / y, 1, (1 - x - y) / y);
  }
  // Rows of Bradford's matrix (Lam 1985), from XYZ to cones.
  const Mat3d cones = glm::transpose(
      Mat3d(Vec3d(0.8951, 0.2664, -0.1614), Vec3d(-0.7502, 1.7135, 0.0367), Vec3d(0.0389, -0.0685, 1.0296)));
  const Vec3d from = cones * (source / source.y), to = cones * xyzOfRgb(Rgbd(1));
  Mat3d scale(1);
  for (int i = 0; i < 3; ++i) scale[i][i] = to[i] / from[i];
  const Mat3d adapt = glm::inverse(cones) * scale * cones;
  const auto column = [&](const Rgbd& c) { return Vec3d(rgbOfXyz(adapt * xyzOfRgb(c))); };
  return {column({1, 0, 0}), column({0, 1, 0}), column({0, 0, 1})};
}

double SampledSpectrum::at(double wavelength) const {
  if (wavelengths.empty()) return 0;
  const auto above = std::upper_bound(wavelengths.begin(), wavelengths.end(), wavelength);
  if (above == wavelengths.begin()) return values.front();
  if (above == wavelengths.end()) return values.back();
  const auto i = static_cast<size_t>(above - wavelengths.begin());
  const double t = (wavelength - wavelengths[i - 1]) / (wavelengths[i] - wavelengths[i - 1]);
  return values[i - 1] * (1 - t) + values[i] * t;
}

Rgbd rgbOfSpectrum(const SampledSpectrum& spectrum, SpectrumKind kind) {
  const auto& v = spectrum.values;
  // Exact for a constant, without rounding errors.
  if (kind != SpectrumKind::ILLUMINANT && !v.empty() &&
      std::all_of(v.begin(), v.end(), [&](double x) { return x == v[0]; }))
    return Rgbd(v[0]);
  const Rgbd colour = convert([&](int w) { return spectrum.at(w); }, kind);
  if (kind != SpectrumKind::ALBEDO || v.empty()) return colour;
  // A saturated reflectance that absorbs at all wavelengths must not amplify a channel.
  return min(colour, Rgbd(std::max(1.0, *std::max_element(v.begin(), v.end()))));
}

std::vector<Rgbd> reflectanceWeights(const std::vector<double>& wavelengths) {
  std::vector<Rgbd> colours(wavelengths.size(), Rgbd(0));
  for (int w = FIRST_WAVELENGTH; w <= LAST_WAVELENGTH; ++w) {
    const Rgbd colour = daylightColour(w);
    const auto above = static_cast<size_t>(std::upper_bound(wavelengths.begin(), wavelengths.end(), w) -
                                           wavelengths.begin());
    if (above == 0 || above == wavelengths.size()) {
      colours[above == 0 ? 0 : above - 1] += colour;
      continue;
    }
    const double t = (w - wavelengths[above - 1]) / (wavelengths[above] - wavelengths[above - 1]);
    colours[above - 1] += colour * (1 - t);
    colours[above] += colour * t;
  }
  return colours;
}

Rgbd rgbOfBlackbody(double kelvin, SpectrumKind kind) {
  if (!(kelvin > 0)) return Rgbd(0);
  // Relative to the peak, given by Wien's law, so that no temperature causes over- or
  // underflow.
  const double peak = 2.897771955e6 / kelvin; // nm
  double largest = planck(peak, kelvin);
  if (kind == SpectrumKind::ILLUMINANT)
    largest = std::max(planck(FIRST_WAVELENGTH, kelvin), planck(LAST_WAVELENGTH, kelvin));
  if (!(largest > 0) || !std::isfinite(largest)) return Rgbd(0);
  return convert([&](int w) { return planck(w, kelvin) / largest; }, kind);
}

SampledSpectrum spectrumFromPairs(const std::vector<double>& pairs) {
  if (pairs.empty()) throw Error("a spectrum needs at least one pair of wavelength and value");
  if (pairs.size() % 2) throw Error("a spectrum needs pairs of wavelength and value; a value is missing");
  SampledSpectrum spectrum;
  for (size_t i = 0; i < pairs.size(); i += 2) {
    if (i > 0 && pairs[i] <= pairs[i - 2]) throw Error("the wavelengths of a spectrum must increase");
    if (!(pairs[i] > 0)) throw Error("the wavelengths of a spectrum must be positive");
    spectrum.wavelengths.push_back(pairs[i]);
    spectrum.values.push_back(pairs[i + 1]);
  }
  return spectrum;
}

SampledSpectrum readSpectrumFile(const std::string& path) {
  using namespace sceneFile;
  SourceFiles files;
  std::vector<double> numbers;
  try {
    Lexer lexer(files.open(path));
    lexer.appendNumbers(numbers);
    const Token rest = lexer.next();
    if (rest.kind != TokenKind::END) numberValue(rest);
  } catch (const SceneError& e) {
    if (e.diagnostics().empty()) throw;
    const Diagnostic& d = e.diagnostics()[0];
    throw Error("spectrum file " + path + ", line " + std::to_string(d.location.line) + ": " + d.message);
  }
  try {
    return spectrumFromPairs(numbers);
  } catch (const Error& e) {
    throw Error("spectrum file " + path + ": " + e.what());
  }
}

} // namespace recurse
