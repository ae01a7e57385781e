/** @file
 * Conversion of spectra to RGB.
 */
#include "recurse/scene/parameters/spectrum.h"
#include "sceneTesting.h"

using namespace recurse;

namespace {

double luminanceOf(const Rgbd& c) { return 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b; }

/** Chromaticity of an RGB colour, by the matrix of the standard. */
Vec2d chromaticity(const Rgbd& c) {
  const double x = 0.412391 * c.r + 0.357584 * c.g + 0.180481 * c.b;
  const double y = 0.212639 * c.r + 0.715169 * c.g + 0.072192 * c.b;
  const double z = 0.019331 * c.r + 0.119195 * c.g + 0.950532 * c.b;
  return Vec2d(x, y) / (x + y + z);
}

} // namespace

TEST(Spectrum, WhiteOfXyz) {
  const Rgbd white = rgbOfXyz({0.95046, 1, 1.08906});
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(white[i], 1, 2e-4);
}

TEST(Spectrum, ColorSpaces) {
  // ITU-R BT.2087-0, the inverse of its matrix M2, on a colour within both gamuts.
  const Rgbd wide = rgbInColorSpace("rec2020", {0.5, 0.4, 0.3}, SpectrumKind::ILLUMINANT);
  const Rgbd narrow{0.57337, 0.38837, 0.28627};
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(wide[i], narrow[i], 2e-4);
  for (const std::string& name : namedColorSpaces()) {
    for (const SpectrumKind kind : {SpectrumKind::ALBEDO, SpectrumKind::UNBOUNDED}) {
      const Rgbd grey = rgbInColorSpace(name, Rgbd(0.5), kind);
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(grey[i], 0.5, 1e-12) << name;
    }
    for (const Rgbd& pure : {Rgbd(1, 0, 0), Rgbd(0, 1, 0), Rgbd(0, 0, 1)}) {
      const Rgbd c = rgbInColorSpace(name, pure, SpectrumKind::ALBEDO);
      EXPECT_GE(std::min({c.r, c.g, c.b}), 0) << name;
      EXPECT_LE(std::max({c.r, c.g, c.b}), 1) << name;
    }
  }
  // Emission keeps its colour: white of ACES.
  const Vec2d white = chromaticity(rgbInColorSpace("aces2065-1", Rgbd(1), SpectrumKind::ILLUMINANT));
  EXPECT_NEAR(white.x, 0.32168, 2e-4);
  EXPECT_NEAR(white.y, 0.33767, 2e-4);
}

TEST(Spectrum, UnknownColorSpacesAreErrors) {
  for (const char* name : {"adobergb", "Rec2020", "aces"})
    EXPECT_THROW(rgbInColorSpace(name, Rgbd(0.5), SpectrumKind::ALBEDO), Error) << name;
}

TEST(Spectrum, ConstantsStayExact) {
  for (double c : {0.0, 0.18, 1.0}) {
    EXPECT_EQ(rgbOfSpectrum({{400, 700}, {c, c}}, SpectrumKind::ALBEDO), Rgbd(c));
    EXPECT_EQ(rgbOfSpectrum({{550}, {c}}, SpectrumKind::UNBOUNDED), Rgbd(c));
  }
  // Nearly constant: uses the integrals.
  const Rgbd c = rgbOfSpectrum({{300, 400, 900}, {0.5, 0.5, 0.5 + 1e-12}}, SpectrumKind::ALBEDO);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(c[i], 0.5, 1e-11);
}

TEST(Spectrum, ReflectancesStayInGamut) {
  for (double at = 400; at < 700; at += 10) {
    const Rgbd c = rgbOfSpectrum({{at - 1, at, at + 20, at + 21}, {0, 1, 1, 0}}, SpectrumKind::ALBEDO);
    for (int i = 0; i < 3; ++i) {
      EXPECT_GE(c[i], 0) << at;
      EXPECT_LE(c[i], 1) << at;
    }
  }
  for (double at = 410; at < 700; at += 10)
    for (const bool rises : {false, true}) {
      const Rgbd c =
          rgbOfSpectrum({{at - 1, at}, {rises ? 0.0 : 1.0, rises ? 1.0 : 0.0}}, SpectrumKind::ALBEDO);
      EXPECT_LE(std::max({c.r, c.g, c.b}), 1) << at;
    }
  const Rgbd red = rgbOfSpectrum({{599, 601}, {0, 1}}, SpectrumKind::ALBEDO);
  EXPECT_GT(red.r, 2 * red.g);
}

TEST(Spectrum, EmissionHasLuminanceOne) {
  for (double kelvin : {500.0, 1500.0, 2856.0, 6500.0, 20000.0, 1e7}) {
    const Rgbd c = rgbOfBlackbody(kelvin, SpectrumKind::ILLUMINANT);
    EXPECT_NEAR(luminanceOf(c), 1, 1e-12) << kelvin;
    EXPECT_GE(std::min({c.r, c.g, c.b}), 0) << kelvin;
  }
  EXPECT_NEAR(luminanceOf(rgbOfSpectrum({{400, 700}, {7, 7}}, SpectrumKind::ILLUMINANT)), 1, 1e-12);
  EXPECT_EQ(rgbOfSpectrum({{400, 700}, {0, 0}}, SpectrumKind::ILLUMINANT), Rgbd(0));
  EXPECT_EQ(rgbOfBlackbody(1e-3, SpectrumKind::ILLUMINANT), Rgbd(0));
}

TEST(Spectrum, BlackbodyChromaticities) {
  // Points of the Planckian locus, from tables (2° observer).
  const double table[][3] = {
      {2856, 0.4476, 0.4074}, {4000, 0.3805, 0.3768}, {6500, 0.3135, 0.3237}, {10000, 0.2807, 0.2884}};
  for (const auto& [kelvin, x, y] : table) {
    const Vec2d c = chromaticity(rgbOfBlackbody(kelvin, SpectrumKind::ILLUMINANT));
    EXPECT_NEAR(c.x, x, 0.004) << kelvin;
    EXPECT_NEAR(c.y, y, 0.004) << kelvin;
  }
}

TEST(Spectrum, NamedOnes) {
  EXPECT_FALSE(rgbOfNamedSpectrum("metal-Xx-eta"));
  for (const std::string& name : namedSpectra()) {
    const Rgbd c = rgbOfNamedSpectrum(name).value();
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(std::isfinite(c[i]) && c[i] >= 0) << name;
    if (name.find("illum") != std::string::npos) {
      EXPECT_NEAR(luminanceOf(c), 1, 2e-4) << name;
    }
    if (name.rfind("glass-", 0) == 0) {
      EXPECT_TRUE(c.r > 1.4 && c.r < c.g && c.g < c.b && c.b < 2) << name;
    }
  }
  // The index nd of the catalogue is between the values at 611 and 549 nm.
  const std::pair<const char*, double> glasses[] = {
      {"glass-BK7", 1.5168},  {"glass-BAF10", 1.67003}, {"glass-FK51A", 1.48656}, {"glass-LASF9", 1.85025},
      {"glass-SF5", 1.67271}, {"glass-SF10", 1.72828},  {"glass-SF11", 1.78472}};
  for (const auto& [name, nd] : glasses) {
    const Rgbd c = rgbOfNamedSpectrum(name).value();
    EXPECT_TRUE(c.r < nd && nd < c.g) << name;
  }
  const Rgbd a = rgbOfNamedSpectrum("stdillum-A").value();
  EXPECT_NEAR(chromaticity(a).x, 0.4476, 1e-3);
  EXPECT_NEAR(rgbOfNamedSpectrum("metal-TiO2-eta")->g, 2.65, 0.05);
  EXPECT_NEAR(rgbOfNamedSpectrum("metal-MgO-eta")->g, 1.739, 0.005);
}

TEST(Spectrum, Interpolation) {
  const SampledSpectrum s{{400, 500}, {1, 3}};
  EXPECT_EQ(s.at(300), 1);
  EXPECT_EQ(s.at(450), 2);
  EXPECT_EQ(s.at(500), 3);
  EXPECT_EQ(s.at(600), 3);
  EXPECT_THROW(spectrumFromPairs({}), Error);
  EXPECT_THROW(spectrumFromPairs({1}), Error);
  EXPECT_THROW(spectrumFromPairs({-1, 1}), Error);
}
