/** @file
 * Subsurface materials against explicit scenes of dielectric and medium, and against random walks in a
 * half-space.
 */
#include <random>

#include "bsdfs/microfacet/fresnel.h"
#include "recurse/model/medium/mediumParameters.h"
#include "rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

std::string ball(const std::string& material) {
  return view(12, "0 -4 1.5  0 0 0  0 0 1", 40) + R"(
LightSource "infinite" "rgb L" [.5 .6 .7]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [8 8 8]
AttributeBegin Translate 1 -1 3 Shape "sphere" "float radius" .5 AttributeEnd
AttributeEnd
Material "diffuse" "rgb reflectance" [.5 .4 .3]
Shape "bilinearmesh" "point3 P" [-3 -3 -1  3 -3 -1  -3 3 -1  3 3 -1]
)" + material +
         "\nShape \"sphere\" \"float radius\" 1\n";
}

MediumPoint insideOf(const std::string& parameters) {
  const auto scene = sceneFrom(ball("Material \"subsurface\" " + parameters));
  return scene->medium(1)->at(Vec3f(0));
}

void expectColour(const Rgb& value, const Rgbd& expected, const std::string& what) {
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(double(value[c]) / expected[c], 1, 1e-5) << what << " channel " << c;
}

/** Fraction of diffuse light that leaves a half-space after entering it. */
double partThatComesOut(double albedo, double g, double eta) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto fresnel = [](double cosine, double ratio) {
    return double(dielectricFresnel(float(cosine), float(ratio)).reflectance);
  };
  double entered = 0, out = 0;
  for (int i = 0; i < 4000; ++i) {
    const double outside = std::sqrt(uniform(engine));
    double weight = 1 - fresnel(outside, eta), depth = 0;
    double down = std::sqrt(1 - (1 - outside * outside) / (eta * eta));
    entered += weight;
    while (weight > 1e-3) {
      const double next = depth - down * std::log(1 - uniform(engine));
      if (next <= 0) {
        const double back = fresnel(-down, 1 / eta);
        out += weight * (1 - back);
        weight *= back;
        // Continues from the boundary: free path lengths are memoryless.
        depth = 0;
        down = -down;
        continue;
      }
      depth = next;
      weight *= albedo;
      const double u = 2 * uniform(engine) - 1, q = (1 - g * g) / (1 + g * u);
      const double turn = g == 0 ? u : (1 + g * g - q * q) / (2 * g);
      const double around = 2 * M_PI * uniform(engine);
      down = down * turn + std::sqrt(std::max(0., (1 - down * down) * (1 - turn * turn))) * std::cos(around);
    }
  }
  return out / entered;
}

} // namespace

TEST(Subsurface, IsItsDielectricAndMedium) {
  const std::string boundary = " \"float eta\" 1.4 \"float roughness\" .1 ",
                    medium = " \"rgb sigma_a\" [.02 .1 .4] \"rgb sigma_s\" [2 3 5] \"float g\" .3 ";
  const Rendered material =
      renderText(ball("Material \"subsurface\"" + boundary + medium + "\"float scale\" 2"), "path", "", 4);
  const Rendered byHand =
      renderText(ball("MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"float scale\" 2" + medium +
                      "\nMediumInterface \"m\" \"\"\nMaterial \"dielectric\"" + boundary),
                 "path", "", 4);
  ASSERT_GT(material.mean(), .1);
  for (size_t i = 0; i < material.pixels(); ++i) EXPECT_EQ(material.value(i), byHand.value(i)) << i;
}

TEST(Subsurface, TakesThePlaceOfTheInnerMediumOnly) {
  const auto scene =
      sceneFrom(ball("MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [0 0 0] "
                     "\"rgb sigma_s\" [.1 .1 .1]\nMediumInterface \"\" \"fog\"\n"
                     "Material \"subsurface\""));
  EXPECT_EQ(scene->contents().media, 2u);
}

TEST(Subsurface, CoefficientsAreThoseThatAreAskedFor) {
  expectColour(insideOf("").absorption, {.0011, .0024, .014}, "default");
  expectColour(insideOf("").scattering, {2.55, 3.21, 3.77}, "default");
  expectColour(insideOf("\"string name\" \"Marble\" \"float scale\" 3").scattering, {6.57, 7.86, 9},
               "Marble");
  expectColour(insideOf("\"string name\" \"White Grapefruit Juice\"").absorption, {.0138, .018831, .056781},
               "juice");
  for (const std::string& name : mediumPresetNames()) insideOf("\"string name\" \"" + name + "\"");
  // For a reflectance and a mean free path, the extinction is the inverse of the path, which `scale`
  // multiplies.
  const std::string path = "\"rgb reflectance\" [.2 .5 .9] \"rgb mfp\" [.1 .2 .4] ";
  expectColour(insideOf(path).extinction(), {10, 5, 2.5}, "mfp");
  expectColour(insideOf(path + "\"float scale\" 2").extinction(), {5, 2.5, 1.25}, "scaled");
  // The reflectance 0 means only absorption, 1 only scattering.
  const MediumPoint ends = insideOf("\"rgb reflectance\" [0 1 .5]");
  EXPECT_NEAR(ends.scattering.r, 0, 1e-6);
  EXPECT_NEAR(ends.absorption.g, 0, 1e-6);
}

TEST(Subsurface, ReflectanceComesOutOfAHalfSpace) {
  for (const double eta : {1., 1.4})
    for (const double g : {0., .6}) {
      const std::string numbers =
          "\"float eta\" " + std::to_string(eta) + " \"float g\" " + std::to_string(g);
      const MediumPoint inside = insideOf("\"rgb reflectance\" [.3 .6 .9] " + numbers);
      const Rgbd wanted(.3, .6, .9);
      for (int c = 0; c < 3; ++c) {
        const double albedo = double(inside.scattering[c] / inside.extinction()[c]);
        // Refracted light goes deeper than diffuse light, for which the formulas are derived.
        EXPECT_NEAR(partThatComesOut(albedo, g, eta), wanted[c], .045) << numbers << " channel " << c;
      }
    }
}

TEST(Subsurface, OfATextureTheMeanCounts) {
  const std::string texture = "Texture \"t\" \"spectrum\" \"checkerboard\" \"float uscale\" 4 \"float "
                              "vscale\" 4 \"rgb tex1\" [.2 .2 .2] \"rgb tex2\" [.6 .4 .2]\n";
  const auto inside = [&](const std::string& parameters) {
    return sceneFrom(ball(texture + "Material \"subsurface\" " + parameters))->medium(1)->at(Vec3f(0));
  };
  expectColour(inside("\"texture sigma_s\" \"t\" \"rgb sigma_a\" [1 1 1]").scattering, {.4, .3, .2}, "mean");
}

TEST(Subsurface, PhotonsAndPathsAgree) {
  const std::string scene = ball("Material \"subsurface\" \"rgb reflectance\" [.8 .6 .4] \"float mfp\" .05");
  const Rendered path = renderText(scene, "path", "", samples(64));
  const Rendered photons = renderText(scene, "photonmap", "\"integer photons\" 10000", samples(12));
  EXPECT_NEAR(photons.mean(), path.mean(),
              .02 * path.mean() + 4 * (path.standardError() + photons.standardError()));
}

TEST(Subsurface, BadUsesAreExplained) {
  const auto complaint = [](const std::string& text) {
    Diagnostics diagnostics;
    const SceneDescription description = parseScene(ball(text), "test.pbrt", ".", diagnostics);
    const auto scene = buildScene(description, {}, diagnostics);
    EXPECT_FALSE(scene) << text;
    return diagnostics.format();
  };
  const auto expect = [&](const std::string& text, const std::string& words) {
    const std::string said = complaint(text);
    EXPECT_NE(said.find(words), std::string::npos) << text << "\n" << said;
  };
  expect("Material \"subsurface\" \"string name\" \"Marbel\"", "did you mean \"Marble\"");
  expect("Material \"subsurface\" \"rgb sigma_a\" [1 1 1]", "only one of sigma_a and sigma_s");
  expect("Material \"subsurface\" \"rgb reflectance\" [.5 .5 .5] \"rgb mfp\" [1 0 1]", "mean free path is 0");
  expect("Material \"subsurface\" \"rgb reflectance\" [.5 1.5 .5]", "out of range");
  expect("Material \"subsurface\" \"float g\" 1", "out of range");
  expect("Material \"subsurface\" \"float scale\" 1e20", "too dense");
  expect("MakeNamedMaterial \"s\" \"string type\" \"subsurface\"\nMakeNamedMaterial \"d\" \"string type\" "
         "\"diffuse\"\nMaterial \"mix\" \"string materials\" [\"s\" \"d\"]",
         "contains a medium");
}
