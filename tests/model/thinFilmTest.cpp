/** @file
 * Thin films: reflectance against Airy's sum at each wavelength, limits without a film, energy, and the same
 * fraction of light in both directions.
 */
#include <cmath>
#include <complex>
#include <gtest/gtest.h>

#include "bsdfs/microfacet/fresnel.h"
#include "bsdfs/microfacet/thinFilm.h"
#include "model/bsdfTesting.h"
#include "recurse/scene/parameters/spectrum.h"
#include "sceneRendering.h"

using namespace recurse;

namespace {

/** Sum of the waves that a film reflects, at one wavelength [nm] (Born, Wolf, "Principles of Optics", 1.6.4).
 */
double airyReflectance(double cosine, double film, std::complex<double> base, double thickness,
                       double wavelength) {
  const double sin2 = 1 - square(cosine);
  const double inFilm = std::sqrt(square(film) - sin2);
  const std::complex<double> inBase = std::sqrt(base * base - sin2);
  const std::complex<double> turn = std::polar(1.0, 4 * M_PI * thickness * inFilm / wavelength);
  double sum = 0;
  for (const bool parallel : {false, true}) {
    // Admittances of the three media for this polarisation.
    const double a = parallel ? 1 / cosine : cosine;
    const double b = parallel ? square(film) / inFilm : inFilm;
    const std::complex<double> c = parallel ? base * base / inBase : inBase;
    const double outer = (a - b) / (a + b);
    const std::complex<double> inner = (b - c) / (b + c);
    sum += std::norm((outer + inner * turn) / (1.0 + outer * inner * turn)) / 2;
  }
  return sum;
}

/** Colour of daylight after multiplication by a function of the wavelength [nm]. */
template <class F> Rgbd daylightMean(const F& factor) {
  Rgbd sum(0), white(0);
  for (double w = SHORTEST_WAVELENGTH + 0.125; w < LONGEST_WAVELENGTH; w += 0.25) {
    white += daylightColour(w);
    sum += daylightColour(w) * factor(w);
  }
  return sum / white;
}

constexpr double COSINES[] = {1, 0.8, 0.5, 0.2, 0.03};

/** Reflectance and transmittance of a material's delta lobes. */
std::pair<Rgb, Rgb> lobesOf(const Material& material, const Vec3f& wi, Vec3f* refracted = nullptr) {
  BsdfArena arena;
  DeltaScatters out;
  material.bsdfAt(SurfacePoint{}, arena)->deltas(wi, out);
  std::pair<Rgb, Rgb> sum{0, 0};
  for (const DeltaScatter& s : out) {
    (s.lobe == MIRROR ? sum.first : sum.second) += s.weight;
    if (s.lobe == REFRACTION && refracted) *refracted = s.wo;
  }
  return sum;
}

std::unique_ptr<Material> materialOf(const std::string& name, const std::string& parameters,
                                     std::string* messages = nullptr) {
  const NamedMaterials named;
  Diagnostics diagnostics;
  auto made = plugIns().materials.make(parseParameterText(name, parameters), named.context(), diagnostics);
  if (messages) *messages = diagnostics.format();
  return made;
}

} // namespace

TEST(ThinFilm, ReflectsAsAirysSumOverAllWavelengths) {
  for (const auto& base : {std::complex<double>(1), {1.5, 0}, {0.75, 0}, {2.5, 0}, {0.2, 3.9}, {2.9, 3.1}})
    for (const double film : {1.0, 1.33, 1.6, 2.4})
      for (const double thickness : {1.0, 30.0, 110.0, 400.0, 1000.0, 3000.0})
        for (const double cosine : COSINES) {
          const Rgbd expected =
              daylightMean([&](double w) { return airyReflectance(cosine, film, base, thickness, w); });
          const Rgb found = ThinFilm{float(thickness), float(film)}.reflectance(
              float(cosine), Rgb(float(base.real())), Rgb(float(base.imag())));
          for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(double(found[c]), std::clamp(expected[c], 0.0, 1.0), 5e-4)
                << base << " film " << film << ", " << thickness << " nm, cosine " << cosine;
        }
}

/** At normal incidence and a single wavelength the closed form has one cosine, and so has the sum above. */
TEST(ThinFilm, AirysSumHasItsClosedForms) {
  const double outer = (1 - 1.38) / (1 + 1.38), inner = (1.38 - 1.52) / (1.38 + 1.52);
  for (const double thickness : {0.0, 50.0, 99.6, 200.0}) {
    const double phase = 4 * M_PI * 1.38 * thickness / 550;
    const double top = square(outer) + square(inner) + 2 * outer * inner * std::cos(phase);
    EXPECT_NEAR(airyReflectance(1, 1.38, 1.52, thickness, 550),
                top / (1 + square(outer * inner) + 2 * outer * inner * std::cos(phase)), 1e-12);
  }
  // A quarter-wave film with the geometric mean of both indices reflects nothing.
  EXPECT_NEAR(airyReflectance(1, std::sqrt(1.52), 1.52, 550 / (4 * std::sqrt(1.52)), 550), 0, 1e-12);
  const Rgb coated =
      ThinFilm{float(550 / (4 * std::sqrt(1.52))), std::sqrt(1.52f)}.reflectance(1, Rgb(1.52f));
  EXPECT_LT(coated.g, 0.05f * dielectricFresnel(1, 1.52f).reflectance);
}

TEST(ThinFilm, IsNoneIfThinOrOfTheIndexOfEitherSide) {
  for (const double c : COSINES) {
    const auto cosine = float(c);
    const auto expectBare = [&](const ThinFilm& film, float eta, float k) {
      const Rgb found = film.reflectance(cosine, Rgb(eta), Rgb(k));
      const float bare =
          k > 0 ? conductorFresnel(cosine, eta, k) : dielectricFresnel(cosine, eta).reflectance;
      for (int channel = 0; channel < 3; ++channel)
        EXPECT_NEAR(found[channel], bare, 3e-5f) << eta << " " << k << " cosine " << cosine;
    };
    for (const float eta : {0.65f, 1.0f, 1.5f, 2.4f}) {
      expectBare({1e-4f, 1.33f}, eta, 0);
      expectBare({400, 1}, eta, 0);
      if (eta >= 1) expectBare({400, eta}, eta, 0);
      expectBare({1e-4f, 1.8f}, eta, 3);
      expectBare({250, 1}, eta, 3);
    }
  }
}

TEST(ThinFilm, ReflectsAllLightAlongIt) {
  EXPECT_EQ(ThinFilm({400, 1}).reflectance(0, Rgb(1.5f)), Rgb(1));
  EXPECT_EQ(ThinFilm({400, 1.33f}).reflectance(0, Rgb(1)), Rgb(1));
}

TEST(ThinFilm, ReflectsAllLightWhereTheIndexOfTheBaseIsZero) {
  const Rgb found = ThinFilm{300, 1.33f}.reflectance(1, Rgb(0, 1, 1), Rgb(0, 2, 2));
  EXPECT_EQ(found.r, 1);
  EXPECT_GT(found.g, 0);
  EXPECT_LT(found.g, 1);
}

TEST(ThinFilm, LosesNoLightAndPassesTheSameBothWays) {
  for (const std::string parameters :
       {"\"float eta\" 1.5 \"float thinfilm.thickness\" 300",
        "\"float eta\" 1 \"float thinfilm.thickness\" 500",
        "\"float eta\" .7 \"float thinfilm.thickness\" 200 \"float thinfilm.eta\" 2"}) {
    const auto glass = materialOf("dielectric", parameters), pane = materialOf("thindielectric", parameters);
    ASSERT_TRUE(glass && pane);
    for (const double c : COSINES) {
      const auto cosine = float(c);
      const Vec3f wi(std::sqrt(1 - square(cosine)), 0, cosine);
      for (const Material* material : {glass.get(), pane.get()}) {
        Vec3f beyond(0);
        const auto [mirrored, through] = lobesOf(*material, wi, &beyond);
        EXPECT_LT(maxComponent(abs(mirrored + through - 1.0f)), 1e-6f) << parameters;
        if (isBlack(through)) continue;
        const auto [back, out] = lobesOf(*material, glm::normalize(beyond));
        EXPECT_LT(maxComponent(abs(back - mirrored)), 1e-4f) << parameters << " cosine " << cosine;
      }
    }
  }
}

TEST(ThinFilm, OnAPaneOfAirIsABubble) {
  const auto bubble = materialOf("thindielectric", "\"float eta\" 1 \"float thinfilm.thickness\" 400");
  const Rgb film = ThinFilm{400, 1.33f}.reflectance(0.6f, Rgb(1));
  EXPECT_LT(maxComponent(abs(lobesOf(*bubble, {0.8f, 0, 0.6f}).first - film)), 1e-6f);
  EXPECT_GT(maxComponent(film), 0.02f);
}

TEST(ThinFilm, ColoursMetalsRoughOrSmooth) {
  // Straw to blue: colours of steel with a growing oxide film.
  const std::string steel =
      "\"rgb eta\" [ 2.9 2.9 2.7 ] \"rgb k\" [ 3.1 2.9 2.8 ] \"float thinfilm.eta\" 2.4 "
      "\"float thinfilm.thickness\" ";
  const Rgb straw = lobesOf(*materialOf("conductor", steel + "25"), {0, 0, 1}).first;
  const Rgb blue = lobesOf(*materialOf("conductor", steel + "55"), {0, 0, 1}).first;
  EXPECT_GT(straw.r, 1.3f * straw.b);
  EXPECT_GT(blue.b, 1.3f * blue.r);
  BsdfArena arena;
  const auto rough = materialOf("conductor", steel + "55 \"float roughness\" .1");
  const Rgb value = rough->bsdfAt(SurfacePoint{}, arena)->value({0, 0, 1}, {0, 0, 1});
  EXPECT_NEAR(value.b / value.r, blue.b / blue.r, 1e-3f);
}

TEST(ThinFilm, ThicknessAndIndexHaveTextures) {
  const std::string film = "\"texture thinfilm.thickness\" \"thickness\" \"texture thinfilm.eta\" \"index\"";
  for (const std::string material : {"conductor", "dielectric", "thindielectric"}) {
    SCOPED_TRACE(material);
    const auto scene = recurse::testing::sceneFrom(
        recurse::testing::view(4, 4, "0 0 5  0 0 0  0 1 0", recurse::testing::perspective(40)) +
        "Texture \"thickness\" \"float\" \"bilerp\" \"float v00\" 200 \"float v01\" 200 \"float v10\" 400 "
        "\"float v11\" 400\nTexture \"index\" \"float\" \"bilerp\" \"float v00\" 0 \"float v01\" 1.8 "
        "\"float v10\" 0 \"float v11\" 1.8\nMaterial \"" +
        material + "\" " + film +
        "\nShape \"bilinearmesh\" \"point3 P\" [ -2 -2 0  2 -2 0  -2 2 0  2 2 0 ]\n");
    for (const Vec2f uv : {Vec2f(0.25f, 0.9f), Vec2f(0.75f, 0.9f), Vec2f(0.75f, 0.6f), Vec2f(0.5f, 0.2f)}) {
      SurfacePoint point{};
      point.uv = uv;
      const float index = std::max(1.0f, 1.8f * uv.y),
                  thickness = 200 + 200 * uv.x; // an index below 1 is clamped
      BsdfArena arena;
      DeltaScatters textured;
      scene->shapes()[0].material->bsdfAt(point, arena)->deltas({0.6f, 0, 0.8f}, textured);
      const auto same = materialOf(material, "\"float thinfilm.thickness\" " + std::to_string(thickness) +
                                                 " \"float thinfilm.eta\" " + std::to_string(index));
      const Rgb expected = lobesOf(*same, {0.6f, 0, 0.8f}).first;
      EXPECT_LT(maxComponent(abs(textured.begin()->weight - expected)), 1e-5f) << uv.x << " " << uv.y;
      const auto other = materialOf(material, "\"float thinfilm.thickness\" " + std::to_string(thickness));
      EXPECT_GT(maxComponent(abs(textured.begin()->weight - lobesOf(*other, {0.6f, 0, 0.8f}).first)), 1e-3f);
    }
  }
}

TEST(ThinFilm, WhatIsWrongIsSaid) {
  const auto messages = [](const std::string& material, const std::string& parameters) {
    std::string out;
    materialOf(material, parameters, &out);
    return out;
  };
  const std::string film = "\"float thinfilm.thickness\" 300 ";
  EXPECT_NE(
      messages("dielectric", film + "\"float roughness\" .3 \"bool multiscatter\" true").find("multiscatter"),
      std::string::npos);
  EXPECT_NE(messages("dielectric", film + "\"integer priority\" 1").find("priority"), std::string::npos);
  EXPECT_NE(messages("dielectric", film + "\"spectrum eta\" \"glass-BK7\"").find("no dispersion"),
            std::string::npos);
  EXPECT_EQ(messages("dielectric", "\"spectrum eta\" \"glass-BK7\""), "");
  EXPECT_NE(messages("conductor", "\"float thinfilm.eta\" 2").find("there is no film"), std::string::npos);
  EXPECT_NE(messages("conductor", film + "\"float thinfilm.eta\" .9").find("thinfilm.eta"),
            std::string::npos);
  EXPECT_NE(messages("thindielectric", "\"float thinfilm.thickness\" -1").find("thickness"),
            std::string::npos);
  EXPECT_EQ(messages("thindielectric", film), "");
}
