/** @file
 * Media against closed forms: phase functions over the registry, transmittance, single scattering, furnaces,
 * boundaries, path classes.
 */
#include "classRendering.h"
#include "transport/forward/shoot.h"
#include "transport/paths/walk.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** A box whose surface is only a boundary of the medium, z from 0 to 1. */
const std::string MEDIUM_BOX =
    "Material \"interface\"\nShape \"box\" \"point3 p1\" [-2 -2 0] \"point3 p2\" [2 2 1]\n";

/** View along the z axis from outside of the box, with a tiny field of view. */
std::string throughTheBox(const std::string& medium, const std::string& rest) {
  return view(2, "0 0 -1  0 0 1  0 1 0", 0.1) + "MakeNamedMedium \"m\" " + medium +
         "\nAttributeBegin\nMediumInterface \"m\" \"\"\n" + MEDIUM_BOX + "AttributeEnd\n" + rest;
}

const std::string EVEN_SKY = "LightSource \"infinite\" \"rgb L\" [1 1 1]\n";

Rgb meanOfMedium(const Rendered& r) {
  Rgb sum(0);
  for (size_t i = 0; i < r.pixels(); ++i) sum += r.value(i) / static_cast<float>(r.pixels());
  return sum;
}

void expectColour(const Rgb& value, const Rgbd& expected, double tolerance, const std::string& what) {
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(double(value[c]), expected[c], tolerance) << what << " channel " << c;
}

} // namespace

TEST(PhaseFunctions, AreDensitiesThatTheySample) {
  for (const auto& entry : plugIns().phaseFunctions.entries())
    for (const std::string& example : entry.examples) {
      Diagnostics diagnostics;
      const auto phase = entry.make(
          bindParameters(parseParameterText(entry.name, example), entry.parameters, diagnostics, false), {});
      const std::string name = entry.name + " " + example;
      // The cumulative distribution at sampled cosines must be uniform: compares its moments and its
      // correlation with u.
      constexpr int N = 200000;
      double integral = 0, mean = 0;
      for (int i = 0; i < N; ++i) { // in the angle, where peaks are wide
        const double angle = (i + 0.5) / N * M_PI, z = std::cos(angle);
        const double part = double(phase->value(float(z))) * 2 * M_PI * std::sin(angle) * M_PI / N;
        integral += part;
        mean += part * z;
      }
      EXPECT_NEAR(integral, 1, 2e-4) << name;
      EXPECT_NEAR(mean, double(phase->meanCosine()), 2e-4) << name;
      double sampled = 0, squared = 0, expectedSquare = 0;
      constexpr int SAMPLES = 20000;
      for (int i = 0; i < SAMPLES; ++i) {
        const double z = double(phase->sampleCosine(float((i + 0.5) / SAMPLES)));
        ASSERT_LE(std::abs(z), 1 + 1e-5) << name;
        sampled += z / SAMPLES;
        squared += z * z / SAMPLES;
      }
      for (int i = 0; i < N; ++i) {
        const double angle = (i + 0.5) / N * M_PI, z = std::cos(angle);
        expectedSquare += z * z * double(phase->value(float(z))) * 2 * M_PI * std::sin(angle) * M_PI / N;
      }
      EXPECT_NEAR(sampled, double(phase->meanCosine()), 2e-3) << name;
      EXPECT_NEAR(squared, expectedSquare, 2e-3) << name;
    }
}

TEST(Media, HomogeneousOnesHaveTheCoefficientsOfPbrtByDefault) {
  Diagnostics diagnostics;
  const auto medium =
      plugIns().media.make(parseParameterText("homogeneous", ""), MediumContext(), diagnostics);
  ASSERT_TRUE(medium) << diagnostics.format();
  EXPECT_EQ(medium->at(Vec3f(0)).absorption, Rgb(1));
  EXPECT_EQ(medium->at(Vec3f(0)).scattering, Rgb(1));
}

TEST(Media, TransmittanceByChannel) {
  const Rgbd sigma(0.3, 1, 3);
  const Rendered homogeneous = renderText(
      throughTheBox("\"string type\" \"homogeneous\" \"rgb sigma_a\" [.3 1 3] \"rgb sigma_s\" [0 0 0]",
                    EVEN_SKY),
      "path", "", samples(16384));
  expectColour(meanOfMedium(homogeneous), exp(-sigma), 0.012, "homogeneous");
  // One cell: along its middle the density rises from a half to 1 and falls again, with the mean 3/4.
  const Rendered grid = renderText(
      throughTheBox(
          "\"string type\" \"uniformgrid\" \"point3 p0\" [-2 -2 0] \"point3 p1\" [2 2 1] \"rgb sigma_a\" "
          "[.15 .5 1.5] \"rgb sigma_s\" [0 0 0] \"float density\" 2",
          EVEN_SKY),
      "path", "", samples(16384));
  expectColour(meanOfMedium(grid), exp(-0.75 * sigma), 0.012, "grid");
}

TEST(Media, AbsorptionAndEmissionAloneHaveNoVariance) {
  const Rgbd sigma(0.3, 1, 3), emitted(0.5, 0.2, 0);
  const std::string scene = throughTheBox("\"string type\" \"homogeneous\" \"rgb sigma_a\" [.3 1 3] \"rgb "
                                          "sigma_s\" [0 0 0] \"rgb Le\" [.5 .2 0]",
                                          EVEN_SKY);
  for (const std::string integrator : {"path", "simplepath"}) {
    const Rendered r = renderText(scene, integrator, "", 1);
    for (size_t i = 0; i < r.pixels(); ++i)
      expectColour(r.value(i), exp(-sigma) + emitted * (1.0 - exp(-sigma)), 1e-5, integrator);
  }
}

TEST(Media, AbsorptionOfAGridIsExpectedAtEachStep) {
  // One cell: along its middle the density rises from a half to 1 and falls again, with the mean 3/4.
  const Rendered r = renderText(
      throughTheBox("\"string type\" \"uniformgrid\" \"point3 p0\" [-2 -2 0] \"point3 p1\" [2 2 1] \"rgb "
                    "sigma_a\" [1 1 1] \"rgb sigma_s\" [0 0 0] \"float density\" 2",
                    EVEN_SKY),
      "path", "", samples(1024));
  const double expected = std::exp(-1.5);
  EXPECT_NEAR(r.mean(), expected, 4.5 * r.standardError());
  // If absorption were a random event, the variance would be expected * (1 - expected).
  const double variance = square(r.standardError()) * double(r.pixels()) * samples(1024);
  EXPECT_LT(variance, 0.75 * expected * (1 - expected));
}

TEST(Media, LampsInGlassAreNoMatterOfChanceBehindFog) {
  // Reflection of a lamp in a pane of reflectance .04, through five units of a medium that only absorbs.
  const Rendered r = renderText(
      "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [.4 .4 .4] \"rgb sigma_s\" [0 0 "
      "0]\nMediumInterface \"\" \"m\"\n" +
          view(4, "0 0 -1  0 0 1  0 1 0", 0.1) +
          "MediumInterface \"m\" \"m\"\nAttributeBegin\nTranslate 0 0 -2\nAreaLightSource \"diffuse\" \"rgb "
          "L\" [1 1 1]\nShape \"disk\" \"float radius\" 9\nAttributeEnd\nTranslate 0 0 1\nMaterial "
          "\"dielectric\" \"float eta\" 1.5\nShape \"disk\" \"float radius\" 9\n",
      "photonmap", "", 2);
  const double image = 0.04 * std::exp(-2.0); // interreflection with the lamp adds a hundredth
  for (size_t i = 0; i < r.pixels(); ++i) EXPECT_NEAR(r.luminanceAt(i), image, 0.05 * image);
}

TEST(Media, ChannelsMayOnlyAbsorbBesideOthersThatScatter) {
  // Medium and walls have one temperature: 1 everywhere, and black in the channel without transmission.
  const auto inside = [](const std::string& medium, const std::string& wall) {
    return "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" " + medium +
           "\nMediumInterface \"\" \"m\"\n" + view(4, "0 0 0  0 0 1  0 1 0", 90) +
           "MediumInterface \"m\" \"m\"\nReverseOrientation\nMaterial \"diffuse\" \"rgb reflectance\" [.4 "
           ".4 .4]\nAreaLightSource \"diffuse\" \"rgb L\" [" +
           wall + "]\nShape \"sphere\" \"float radius\" 1\n";
  };
  const Rendered hot =
      renderText(inside("\"rgb sigma_a\" [1 .5 0] \"rgb sigma_s\" [0 .5 2] \"rgb Le\" [1 1 1]", ".6 .6 .6"),
                 "path", "", samples(1024));
  expectColour(meanOfMedium(hot), Rgbd(1), SANITIZED ? 0.06 : 0.02, "hot");
  const Rendered dark = renderText(inside("\"rgb sigma_a\" [1e6 0 0] \"rgb sigma_s\" [0 .5 2]", ".6 .6 .6"),
                                   "path", "", samples(1024));
  expectColour(meanOfMedium(dark), {0, 1, 1}, SANITIZED ? 0.06 : 0.02, "dark in red");
}

TEST(Media, SingleScatteringOfParallelLight) {
  // Along the ray through the middle, at depth h below the lit side.
  const double h = 2, e = 3;
  const Rgbd absorption(0.1, 0.2, 0.6), scattering(0.4, 0.3, 0.2), extinction = absorption + scattering;
  const Rgbd expected =
      scattering / (4 * M_PI) * e * exp(-extinction * h) * (1.0 - exp(-extinction)) / extinction;
  const std::string light =
      "LightSource \"distant\" \"point3 from\" [0 1 0] \"point3 to\" [0 0 0] \"rgb L\" [3 3 3]\n";
  for (const std::string medium :
       {"\"string type\" \"homogeneous\"", "\"string type\" \"uniformgrid\" \"integer nx\" 1 \"point3 p0\" "
                                           "[-900 -900 -900] \"point3 p1\" [900 900 900] "
                                           "\"float density\" 1"}) {
    const Rendered r =
        renderText(throughTheBox(medium + " \"rgb sigma_a\" [.1 .2 .6] \"rgb sigma_s\" [.4 .3 .2]", light),
                   "simplepath", "\"integer maxdepth\" 1", samples(16384));
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(double(meanOfMedium(r)[c]) / expected[c], 1, SANITIZED ? 0.15 : 0.03)
          << medium << " channel " << c;
  }
}

TEST(Media, WhiteFurnace) {
  // In a sky of 1, a medium without absorption has the radiance 1 everywhere, whatever its scattering.
  const std::string grid =
      "\"string type\" \"uniformgrid\" \"integer nx\" 2 \"integer ny\" 2 \"integer nz\" 2 "
      "\"point3 p0\" [-2 -2 0] \"point3 p1\" [2 2 1] \"float density\" [0 5 1 0 3 0 0 2] ";
  const std::string rgb =
      "\"string type\" \"rgbgrid\" \"integer nx\" 2 \"point3 p0\" [-2 -2 0] \"point3 p1\" [2 2 1] "
      "\"rgb sigma_s\" [ 1 5 0  2 0 3 ] ";
  const std::string white = "\"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [.5 2 4] ";
  for (const std::string& medium : {"\"string type\" \"homogeneous\" " + white + "\"float g\" .7",
                                    grid + white + "\"string phase\" \"rayleigh\"", rgb,
                                    grid + white + "\"string phase\" \"schlick\" \"float k\" -.8"}) {
    const Rendered r = renderText(throughTheBox(medium, EVEN_SKY), "path", "", samples(4096));
    expectColour(meanOfMedium(r), Rgbd(1), SANITIZED ? 0.1 : 0.03, medium);
  }
}

TEST(Media, MatterTooDenseForPositionsLooksLikeOtherDenseMatter) {
  // In one channel light that enters the medium could not leave it in single precision. With a limited number
  // of events, the reflectance does not depend on the density if the medium is deep; with unlimited events
  // all light would return, by ever rarer and longer walks.
  const auto seen = [](const std::string& density) {
    const std::string medium =
        "\"string type\" \"homogeneous\" \"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [" + density + " 1 1]";
    const Rendered r =
        renderText(throughTheBox(medium, EVEN_SKY), "path", "\"integer maxdepth\" 256", samples(4096));
    return std::pair(r.mean(), r.standardError());
  };
  const auto [resolved, error] = seen("1e4");
  const auto [dense, denseError] = seen("1e18");
  EXPECT_NEAR(dense, resolved, 4 * std::hypot(error, denseError));
  EXPECT_LT(error, SANITIZED ? 0.02 : 0.007);
}

TEST(Media, IsothermalEnclosure) {
  // Walls that emit (1 - albedo) and a medium that emits by its absorption: 1 everywhere.
  const std::string scene =
      view(4, "0 0 0  0 0 1  0 1 0", 90) +
      "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [.3 .5 1] \"rgb sigma_s\" [1 .5 "
      ".2] "
      "\"rgb Le\" [1 1 1]\nMediumInterface \"m\" \"m\"\nReverseOrientation\nMaterial \"diffuse\" \"rgb "
      "reflectance\" "
      "[.4 .4 .4]\nAreaLightSource \"diffuse\" \"rgb L\" [.6 .6 .6]\nShape \"sphere\" \"float radius\" 1\n";
  const std::string inside = "MediumInterface \"\" \"m\"\nCamera";
  std::string text = scene;
  text.replace(text.find("Camera"), 6, inside);
  const Rendered r = renderText(text, "path", "", samples(1024));
  expectColour(meanOfMedium(r), Rgbd(1), SANITIZED ? 0.06 : 0.02, "");
}

TEST(Media, MirrorsTurnQuadricsInsideOutAsInPbrt) {
  // The medium outside has no boundary, so no light of the sky passes.
  const std::string ball = "Shape \"sphere\"", drum =
                                                   "Shape \"cylinder\" \"float radius\" 2\n"
                                                   "Shape \"disk\" \"float radius\" 2 \"float height\" 1\n"
                                                   "ReverseOrientation\n"
                                                   "Shape \"disk\" \"float radius\" 2 \"float height\" -1\n";
  const std::string mirror = "Scale 1 1 -1\n", turn = "ReverseOrientation\n";
  for (const std::string& shape : {ball, drum}) {
    const auto seen = [&](const std::string& before) {
      return renderText(view(2, "0 0 -3  0 0 1  0 1 0", 0.01) + EVEN_SKY +
                            "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [1 1 1] "
                            "\"rgb sigma_s\" [0 0 0]\nMaterial \"interface\"\nMediumInterface \"m\" \"\"\n" +
                            before + shape,
                        "path", "", 1)
          .mean();
    };
    EXPECT_NEAR(seen(""), std::exp(-2.0), 1e-5) << shape;
    EXPECT_EQ(seen(turn), 0) << shape;
    EXPECT_EQ(seen(mirror), 0) << shape;
    EXPECT_NEAR(seen(mirror + turn), std::exp(-2.0), 1e-5) << shape;
  }
  // The emitting side of lamps stays the same.
  const Rendered lamp = renderText(view(2, "0 0 -3  0 0 1  0 1 0", 0.01) +
                                       "AreaLightSource \"diffuse\" \"rgb L\" [2 2 2]\n" + mirror + ball,
                                   "path", "", 1);
  EXPECT_NEAR(lamp.mean(), 2, 1e-5);
}

TEST(Media, AreKeptInNestedDielectrics) {
  // A ball of priority 1 with a medium; a clear solid of higher priority covers half of it. Neither refracts.
  const std::string text = view(2, "0 0 -3  0 0 1  0 1 0", 0.1) +
                           "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [1 1 1] "
                           "\"rgb sigma_s\" [0 0 0]\n" +
                           EVEN_SKY +
                           "AttributeBegin\nMediumInterface \"m\" \"\"\nMaterial \"dielectric\" \"float "
                           "eta\" 1 \"integer priority\" 1\n"
                           "Shape \"sphere\" \"float radius\" 1\nAttributeEnd\n"
                           "AttributeBegin\nMaterial \"dielectric\" \"float eta\" 1 \"integer priority\" 2\n"
                           "Shape \"box\" \"point3 p1\" [-2 -2 0] \"point3 p2\" [2 2 2]\nAttributeEnd\n";
  // The clear solid does not name a medium, so it contains the outer medium: none.
  EXPECT_NEAR(renderText(text, "simplepath", "", samples(8192)).mean(), std::exp(-1.0), 0.02);
}

TEST(Media, BoundariesDoNotDrawTheAlphaBehindThemAgain) {
  const std::string sheet =
      view(16, "0 -5 3  0 0 0  0 0 1", 30) +
      "MakeNamedMedium \"thin\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ 1e-6 1e-6 1e-6 ] \"rgb "
      "sigma_s\" [ 0 0 0 ]\n"
      "LightSource \"point\" \"rgb I\" [ 10 10 10 ] \"point3 from\" [ 0 0 4 ]\n"
      "Material \"diffuse\" \"rgb reflectance\" [ .5 .5 .5 ]\nShape \"disk\" \"float radius\" 5\n"
      "Material \"diffuse\" \"rgb reflectance\" [ 0 0 0 ]\n"
      "Shape \"disk\" \"float radius\" 2 \"float height\" 3.5 \"float alpha\" .5\n";
  const std::string boundary = "MediumInterface \"thin\" \"\"\nMaterial \"interface\"\n"
                               "Shape \"box\" \"point3 p1\" [ -4 -4 .5 ] \"point3 p2\" [ 4 4 1 ]\n";
  for (const char* integrator : {"path", "simplepath"}) {
    const Rendered without = renderText(sheet, integrator, "", samples(256)),
                   with = renderText(sheet + boundary, integrator, "", samples(256));
    ASSERT_GT(without.mean(), 0);
    EXPECT_NEAR(with.mean() / without.mean(), 1, SANITIZED ? .2 : .02) << integrator;
  }
}

TEST(Media, RaysGetPastEdges) {
  // A light whose rays hit exactly the edges of a box.
  const Rendered r =
      renderText(view(16, "0 0 -5  0 0 0  0 1 0", 40) +
                     "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [1 1 1] \"rgb "
                     "sigma_s\" [1 1 1]\n"
                     "LightSource \"point\" \"point3 from\" [-2 1.5 -2] \"rgb I\" [9 9 9]\n"
                     "AttributeBegin\nMediumInterface \"m\" \"\"\nMaterial \"interface\"\nShape "
                     "\"trianglemesh\" \"integer indices\" "
                     "[0 2 3 0 3 1 4 5 7 4 7 6 0 1 5 0 5 4 2 6 7 2 7 3 0 4 6 0 6 2 1 3 7 1 7 5] \"point3 P\" "
                     "[-.7 -.7 -.7 .7 -.7 "
                     "-.7 -.7 .7 -.7 .7 .7 -.7 -.7 -.7 .7 .7 -.7 .7 -.7 .7 .7 .7 .7 .7]\nAttributeEnd\n"
                     "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-3 -3 3 3 -3 3 "
                     "3 3 3 -3 3 3]\n",
                 "path", "", samples(64));
  EXPECT_GT(r.mean(), 0);
}

TEST(Media, PathClassesTellMediaFromSurfaces) {
  const auto scene = sceneFrom(
      throughTheBox("\"string type\" \"homogeneous\" \"rgb sigma_a\" [.2 .2 .2] \"rgb sigma_s\" [.8 .8 .8]",
                    EVEN_SKY + "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-3 -3 "
                               "2 3 -3 2 3 3 2 -3 3 2]\n"));
  const PathClasses classes(
      {{"all", "all"}, {"surface", "surface"}, {"medium", "medium"}, {"VE", "LVE"}, {"DVE", "LDVE"}});
  const Rendered r = renderScene(*scene, *integratorFrom("path", ""), classes, samples(1024), 0);
  double sums[5];
  for (size_t layer = 0; layer < 5; ++layer) sums[layer] = r.mean(layer);
  EXPECT_NEAR(sums[1] + sums[2], sums[0], 1e-4 * sums[0]);
  for (const double s : sums) EXPECT_GT(s, 0);
  EXPECT_LT(sums[3] + sums[4], sums[2]);
}

TEST(Media, AreRefusedByIntegratorsThatKnowNothingOfThem) {
  const auto scene = sceneFrom(throughTheBox("\"string type\" \"homogeneous\"", EVEN_SKY));
  for (const char* name : {"bdpt", "vcm", "lightpath"})
    EXPECT_THROW(renderScene(*scene, name, "", 1), Error) << name;
}

TEST(Media, WrongOnesAreTold) {
  const auto messageOf = [](const std::string& medium) {
    Diagnostics diagnostics;
    const SceneDescription d = parseScene(throughTheBox(medium, EVEN_SKY), "test.pbrt", ".", diagnostics);
    EXPECT_FALSE(buildScene(d, {}, diagnostics)) << medium;
    return diagnostics.format();
  };
  const auto tells = [&](const std::string& medium, const std::string& part) {
    const std::string message = messageOf(medium);
    EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_NE(message.find("test.pbrt:"), std::string::npos) << message;
  };
  tells("\"string type\" \"homogenous\"", "homogeneous");
  tells("\"string type\" \"homogeneous\" \"string phase\" \"mie\"", "mie");
  tells("\"string type\" \"homogeneous\" \"float g\" 1.5", "g");
  tells("\"string type\" \"homogeneous\" \"rgb sigma_a\" [-1 0 0]", "sigma_a");
  tells("\"string type\" \"homogeneous\" \"float scale\" 1e30", "single precision");
  tells("\"string type\" \"uniformgrid\" \"float density\" [1 2]", "2 values for 1 x 1 x 1");
  tells("\"string type\" \"uniformgrid\" \"float density\" -1", "density");
  tells("\"string type\" \"uniformgrid\" \"float density\" 1e20", "density");
  tells("\"string type\" \"uniformgrid\" \"float density\" 1 \"point3 p1\" [0 1 1]", "flat");
  tells("\"string type\" \"uniformgrid\" \"float density\" 1 \"point3 p1\" [1e-40 1 1]",
        "too small or too large");
  tells("\"string type\" \"rgbgrid\"", "neither");
  tells("\"string type\" \"rgbgrid\" \"rgb sigma_a\" [1e18 0 0]", "steps through the grid");
  tells("\"string type\" \"rgbgrid\" \"rgb sigma_a\" [1 1 1] \"rgb Le\" [1e20 1 1] \"float Lescale\" 1e20",
        "too high for single precision");
  tells("\"string type\" \"uniformgrid\" \"integer nx\" 2 \"float density\" [1 1] \"rgb Le\" [1e10 1 1] "
        "\"float Lescale\" [0 1e10]",
        "the emission is too high for single precision");
  tells("\"string type\" \"uniformgrid\" \"float density\" 1 \"rgb sigma_s\" [1e18 0 0]",
        "steps through the grid");
  tells("\"string type\" \"uniformgrid\" \"integer nx\" 3 \"float density\" [0 0 1e18]",
        "steps through the grid");
  tells("\"string type\" \"cloud\" \"float scale\" 1e12", "steps through the grid");
  tells("\"string type\" \"homogeneous\" \"string preset\" \"Wholemilks\"", "Wholemilk");
}

TEST(Media, TooMuchEmissionIsReportedAtItsParameter) {
  const auto parameterAtFault = [](const std::string& parameters) {
    const std::string scene = throughTheBox("\"string type\" \"homogeneous\" " + parameters, EVEN_SKY);
    Diagnostics diagnostics;
    EXPECT_FALSE(buildScene(parseScene(scene, "test.pbrt", ".", diagnostics), {}, diagnostics));
    if (diagnostics.all().size() != 1) return diagnostics.format();
    const SourceLocation& where = diagnostics.all()[0].location;
    const std::string before = where.lineText().substr(0, size_t(where.column) - 1);
    const size_t end = before.rfind('"');
    return before.substr(before.rfind('"', end - 1), end + 1 - before.rfind('"', end - 1));
  };
  const std::string scale = "\"float scale\" 2 ";
  EXPECT_EQ(parameterAtFault(scale + "\"rgb Le\" [1e19 0 0]"), "\"rgb Le\"");
  EXPECT_EQ(parameterAtFault(scale + "\"rgb Le\" [1 1 1] \"float Lescale\" 1e19"), "\"float Lescale\"");
  EXPECT_EQ(parameterAtFault(scale + "\"rgb Le\" [1e19 0 0] \"float Lescale\" 1"), "\"rgb Le\"");
  EXPECT_EQ(parameterAtFault("\"rgb Le\" [1 1 1] \"float scale\" 1e19"), "\"float scale\"");
}

namespace {

/** Strong absorption that differs by colour. */
const std::string FOG =
    "\"homogeneous\" \"rgb sigma_a\" [.3 .2 .1] \"rgb sigma_s\" [.2 .25 .3] \"float g\" .4";
/** Wisps of the same medium, some of which are clear in a colour. */
const std::string WISPS =
    "\"rgbgrid\" \"integer nx\" 2 \"integer ny\" 2 \"point3 p0\" [-1 -1 -1] \"point3 p1\" [1 1 1] "
    "\"rgb sigma_a\" [0 .2 .1  .6 0 .1  .4 .4 0  .2 .2 .3] "
    "\"rgb sigma_s\" [0 .2 .9  .6 .1 .2  .1 .2 0  .4 .9 .3] \"float g\" .4";

/** A room of fog with a glass ball under a wide lamp. */
std::string foggyRoom(int size) {
  return "MakeNamedMedium \"fog\" \"string type\" " + FOG + "\nMediumInterface \"\" \"fog\"\n" +
         view(size, "0 0 -.95  0 0 1  0 1 0", 80) + R"(
MediumInterface "fog" "fog"
Material "diffuse" "rgb reflectance" [ .5 .5 .5 ]
ReverseOrientation
Shape "box" "point3 p1" [-1 -1 -1] "point3 p2" [1 1 1]
ReverseOrientation
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 6 6 6 ]
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-.5 .99 -.2 .5 .99 -.2 .5 .99 .8 -.5 .99 .8]
AttributeEnd
AttributeBegin
MediumInterface "" "fog"
Material "dielectric" "float eta" 1.5
Translate 0 .2 .3
Shape "sphere" "float radius" .4
AttributeEnd
)";
}

/** Scene of a floor and the medium "mist". */
std::string floorWith(const std::string& shapes) {
  return view(16, "0 1.4 -4.5  0 .8 0  0 1 0", 44) + R"(
MakeNamedMedium "mist" "string type" "homogeneous" "rgb sigma_a" [ .4 .3 .2 ] "rgb sigma_s" [ .3 .4 .5 ]
Material "diffuse" "rgb reflectance" [ .6 .5 .4 ]
Shape "bilinearmesh" "point3 P" [ -3 0 -3  3 0 -3  -3 0 3  3 0 3 ])" +
         shapes;
}

Film renderMediaClasses(const Scene& scene, const std::string& integrator, const std::string& parameters,
                        const PathClasses& classes, int count, int threads = 0) {
  return renderScene(scene, *integratorFrom(integrator, parameters), classes, count, 0, threads).film;
}

/** Expects the same means over the pixels for each class. */
void expectSameByClass(const Film& film, const Film& truth, const PathClasses& classes,
                       const std::string& what) {
  // The few samples of sanitizers do not resolve a caustic alone.
  for (size_t layer = 0; layer < (SANITIZED ? 1 : classes.layerCount()); ++layer) {
    Rgb a(0), b(0);
    for (size_t i = 0; i < film.bounds().area(); ++i) {
      a += film.value(i, layer);
      b += truth.value(i, layer);
    }
    const std::string& name = classes.classes()[layer].name;
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(double(a[c] / b[c]), 1,
                  SANITIZED       ? 0.2
                  : name == "all" ? 0.015
                                  : 0.04)
          << what << " " << name << " channel " << c;
  }
}

void expectWhatPathFinds(const std::string& text, const std::vector<PathClass>& asked, int photonSamples = 64,
                         int pathSamples = 16384) {
  const auto scene = sceneFrom(text);
  const PathClasses classes(asked);
  const Film truth = renderMediaClasses(*scene, "path", "", classes, SANITIZED ? 512 : pathSamples);
  for (const std::string parameters : {"\"integer lightsamples\" 8", "\"string direct\" \"photons\""}) {
    const Film film =
        renderMediaClasses(*scene, "photonmap", parameters, classes, SANITIZED ? 4 : photonSamples);
    expectSameByClass(film, truth, classes, parameters);
  }
}

} // namespace

TEST(MediaPhotons, DenseMatterIsNoDarkerThanByPaths) {
  // The mean free path is far below the radius of kernels; the surface is seen at a grazing angle.
  const std::string ball =
      view(16, "0 -4 1.5  0 0 .5  0 0 1", 12) + "LightSource \"distant\" \"point3 from\" [ 3 -3 6 ]\n" +
      EVEN_SKY +
      "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ 0 0 0 ] "
      "\"rgb sigma_s\" [ 1000 1000 1000 ]\nTranslate 0 0 .5\nMediumInterface \"m\" \"\"\n"
      "Material \"interface\"\nShape \"sphere\" \"float radius\" .5\n";
  const Rendered paths = renderText(ball, "path", "", SANITIZED ? 4 : 256);
  const Rendered photons = renderText(ball, "photonmap", "", SANITIZED ? 1 : 16);
  if (SANITIZED) return; // too few samples for either mean
  EXPECT_NEAR(photons.mean() / paths.mean(), 1, 0.08);
}

TEST(MediaPhotons, MatterDenseInOneChannelIsNoDarkerInThatThanByPaths) {
  // Few of the sampled distances contribute red light, and selection by luminance alone would rarely choose
  // them.
  const std::string slab = view(16, "0 0 -1  0 0 1  0 1 0", 80) + EVEN_SKY +
                           "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ 0 0 0 ] "
                           "\"rgb sigma_s\" [ 1e4 1 1 ]\nMediumInterface \"m\" \"\"\n" +
                           MEDIUM_BOX;
  const Rgb paths = meanOfMedium(renderText(slab, "path", "\"integer maxdepth\" 2", samples(512)));
  const Rgb photons = meanOfMedium(renderText(slab, "photonmap", "\"integer maxdepth\" 2", samples(32)));
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(double(photons[c] / paths[c]), 1, SANITIZED ? 0.15 : 0.05) << "channel " << c;
}

TEST(MediaPhotons, AShaftOfSunlightIsAsBrightAsByPathsWithLittleVariance) {
  // The sun shines through a slit, perpendicular to the rays of all pixels.
  const auto scene =
      sceneFrom(view(16, "0 0 -1  0 0 1  0 1 0", 0.1) +
                "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [0 0 0] \"rgb "
                "sigma_s\" [2 2 2]\n"
                "AttributeBegin\nMediumInterface \"m\" \"\"\n" +
                MEDIUM_BOX +
                "AttributeEnd\nLightSource \"distant\" \"point3 from\" [1 0 0] \"point3 to\" [0 0 0]\n"
                "Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n"
                "Shape \"box\" \"point3 p1\" [2.1 -2 -2] \"point3 p2\" [2.2 2 .4]\n"
                "Shape \"box\" \"point3 p1\" [2.1 -2 .5] \"point3 p2\" [2.2 2 3]\n");
  const auto found = [&](const std::string& integrator, const std::string& parameters, int samples) {
    const Rendered r = renderScene(*scene, integrator, "\"integer maxdepth\" 1 " + parameters, samples);
    std::vector<double> values(r.pixels());
    for (size_t i = 0; i < values.size(); ++i) values[i] = double(r.value(i).g);
    return Mean(values);
  };
  const Mean paths = found("path", "", 256), photons = found("photonmap", "\"integer photons\" 100", 1);
  EXPECT_NEAR(photons.value, paths.value, 4.5 * std::hypot(photons.error, paths.error));
  // The sun lights the fraction .09 of the ray: a single shadow ray would have a relative variance of 9.7,
  // four stratified ones 1.7.
  EXPECT_LT(square(photons.error / photons.value) * 256, 4);
}

TEST(MediaPhotons, BesideASmallLampNoPixelIsBrighterThanByPaths) {
  // A disc seen edge-on, beside a glass ball: the irradiance near the disc is unbounded, and glass causes
  // caustics.
  const std::string text =
      "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [.02 .02 .02] "
      "\"rgb sigma_s\" [.15 .15 .15]\nMediumInterface \"\" \"fog\"\n" +
      view(32, "0 0 -4  0 0 0  0 1 0", 40) +
      "MediumInterface \"fog\" \"fog\"\nAttributeBegin\nReverseOrientation\nMaterial "
      "\"diffuse\"\nShape \"sphere\" \"float radius\" 6\nAttributeEnd\nAttributeBegin\n"
      "Translate .8 .6 0\nRotate 90 0 1 0\nAreaLightSource \"diffuse\" \"rgb L\" [1280 1280 "
      "1280]\nShape \"disk\" \"float radius\" .05\nAttributeEnd\nMediumInterface \"\" "
      "\"fog\"\nMaterial \"dielectric\"\nTranslate -.3 -.2 0\nShape \"sphere\" \"float "
      "radius\" .5\n";
  const auto scene = sceneFrom(text);
  const auto brightest = [](const Rendered& r) {
    double most = 0;
    for (size_t i = 0; i < r.pixels(); ++i) most = std::max(most, r.luminanceAt(i));
    return most;
  };
  const Rendered paths = renderScene(*scene, "path", "", samples(512));
  for (uint64_t seed = 1; seed <= (SANITIZED ? 1 : 3); ++seed) {
    const Rendered r =
        renderScene(*scene, "photonmap", "\"integer photons\" 20000 \"integer passes\" 1", samples(32), seed);
    EXPECT_NEAR(r.mean() / paths.mean(), 1, 0.02 + 4.5 * paths.standardError() / paths.mean()) << seed;
    EXPECT_LT(brightest(r), 3 * brightest(paths)) << seed;
    if (!SANITIZED) { // the few paths of sanitizers have bright pixels of their own
      EXPECT_GT(brightest(r), brightest(paths) / 3) << seed;
    }
  }
}

TEST(MediaPhotons, FindWhatPathFindsClassByClass) {
  expectWhatPathFinds(foggyRoom(16), {{"all", "all"},
                                      {"single", "LVE"},
                                      {"caustic", "LS+VE"},
                                      {"through", "LVS+E"},
                                      {"lit", "LD+VE"},
                                      {"multiple", "LV+VE"},
                                      {"fogOnWalls", "L(V|S)*VDE"},
                                      {"walls", "LD+E"},
                                      {"secondary", "LD*VDV*DE"}});
}

TEST(MediaPhotons, OfALampAcrossABoundaryStartOnItsTwoSides) {
  expectWhatPathFinds(floorWith(R"(
AttributeBegin
MediumInterface "mist" ""
Material "interface"
Shape "box" "point3 p1" [ -2.5 -.1 -2.5 ] "point3 p2" [ 2.5 1.2 1.9 ]
AttributeEnd
AreaLightSource "diffuse" "rgb L" [ 8 8 8 ]
Translate .3 1.2 .3
Rotate 90 1 0 0
Shape "cylinder" "float radius" .12 "float zmin" -1 "float zmax" 1)"),
                      {{"reflected", "all - LE"}, {"scattered", "L.*V.*E"}, {"floor", "LD+E"}}, 16, 4096);
}

TEST(MediaPhotons, OfALampThatIsABoundaryStartOnItsTwoSides) {
  expectWhatPathFinds(floorWith(R"(
AttributeBegin
MediumInterface "mist" "mist"
Material "diffuse"
Translate 0 .8 0
Shape "sphere" "float radius" .3
AttributeEnd
MediumInterface "mist" ""
Material "interface"
AreaLightSource "diffuse" "rgb L" [ 4 4 4 ] "bool twosided" true
Shape "box" "point3 p1" [ -.4 .4 -.4 ] "point3 p2" [ .4 1.2 .4 ])"),
                      {{"reflected", "all - LE"}, {"scattered", "L.*V.*E"}, {"floor", "LD+E"}}, 16, 4096);
}

TEST(PhotonBeams, FindWhatPointsFindClassByClass) {
  const auto scene = sceneFrom(foggyRoom(16));
  const PathClasses classes({{"all", "all"},
                             {"caustic", "LS+VE"},
                             {"through", "LVS+E"},
                             {"lit", "LD+VE"},
                             {"multiple", "LV+VE"},
                             {"secondary", "LD*VDV*DE"}});
  const auto found = [&](const std::string& kept) {
    return renderMediaClasses(*scene, "photonmap",
                              "\"integer lightsamples\" 8 \"string volumephotons\" \"" + kept + "\"", classes,
                              SANITIZED ? 4 : 96);
  };
  expectSameByClass(found("beams"), found("points"), classes, "beams");
}

TEST(GridPhotons, FindWhatPathFindsClassByClass) {
  // Wisps over a floor under a uniform sky, whose light paths find easily.
  expectWhatPathFinds(
      view(6, "0 -3 1  0 0 -.4  0 0 1", 50) + "MakeNamedMedium \"wisps\" \"string type\" " + WISPS + "\n" +
          EVEN_SKY +
          "Material \"diffuse\" \"rgb reflectance\" [ .5 .5 .5 ]\nShape \"trianglemesh\" \"integer "
          "indices\" [0 1 2 0 2 3] \"point3 P\" [-2 -2 -1.1 2 -2 -1.1 2 2 -1.1 -2 2 -1.1]\n"
          "MediumInterface \"wisps\" \"\"\nMaterial \"interface\"\nShape \"box\" \"point3 p1\" [-1 -1 -1] "
          "\"point3 p2\" [1 1 1]\n",
      {{"all", "all"}, {"multiple", "L(D|V)+VE"}, {"onFloor", "LV+DE"}, {"floor", "LD+E"}}, 256);
}

TEST(GlowPhotons, FindWhatPathFindsClassByClass) {
  // The only light: emissive wisps over a floor.
  const std::string glow =
      WISPS.substr(0, WISPS.find("\"float g\"")) + "\"rgb Le\" [4 3 2  6 4 2  1 2 5  3 3 3] \"float g\" .4";
  expectWhatPathFinds(
      view(6, "0 -3 1  0 0 -.4  0 0 1", 50) + "MakeNamedMedium \"wisps\" \"string type\" " + glow +
          "\nMaterial \"diffuse\" \"rgb reflectance\" [ .5 .5 .5 ]\nShape \"trianglemesh\" \"integer "
          "indices\" [0 1 2 0 2 3] \"point3 P\" [-2 -2 -1.1 2 -2 -1.1 2 2 -1.1 -2 2 -1.1]\n"
          "MediumInterface \"wisps\" \"\"\nMaterial \"interface\"\nShape \"box\" \"point3 p1\" [-1 -1 -1] "
          "\"point3 p2\" [1 1 1]\n",
      {{"all", "all"},
       {"seen", "LE"},
       {"floor", "LDE"},
       {"single", "LVE"},
       {"multiple", "L(D|V)+VE"},
       {"onFloor", "LV+DE"}},
      256);
}

TEST(GlowPhotons, IsothermalEnclosure) {
  // Walls that emit (1 - albedo) and a medium that emits by its absorption: 1 everywhere.
  const auto scene = sceneFrom(
      "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [.3 .5 1] \"rgb sigma_s\" [1 .5 "
      ".2] \"rgb Le\" [1 1 1]\nMediumInterface \"\" \"m\"\n" +
      view(8, "0 0 0  0 0 1  0 1 0", 90) +
      "MediumInterface \"\" \"m\"\nReverseOrientation\nMaterial \"diffuse\" \"rgb reflectance\" [.4 .4 .4]\n"
      "AreaLightSource \"diffuse\" \"rgb L\" [.6 .6 .6]\nShape \"sphere\" \"float radius\" 1\n");
  for (const char* direct : {"shadowrays", "photons"})
    expectColour(
        meanOfMedium(renderScene(*scene, "photonmap", "\"string direct\" \"" + std::string(direct) + "\"",
                                 SANITIZED ? 2 : 16)),
        Rgbd(1), SANITIZED ? 0.05 : 0.015, direct);
}

TEST(GlowPhotons, AMediumWithoutEndIsForPaths) {
  const std::string glowing = "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb Le\" [1 1 1]\n";
  const std::string ball = "Material \"interface\"\nShape \"sphere\" \"float radius\" 1\n";
  const auto photonmap = integratorFrom("photonmap", "");
  EXPECT_FALSE(photonmap->supportsMedia(*sceneFrom(glowing + "MediumInterface \"\" \"m\"\n" +
                                                   view(2, "0 0 -3  0 0 1  0 1 0", 40) +
                                                   "MediumInterface \"\" \"m\"\n" + ball)));
  EXPECT_TRUE(photonmap->supportsMedia(
      *sceneFrom(glowing + view(2, "0 0 -3  0 0 1  0 1 0", 40) + "MediumInterface \"m\" \"\"\n" + ball)));
}

TEST(GlowPhotons, CausticsAloneLeaveMediaThatGlowOrScatterToPaths) {
  const auto photonmap = integratorFrom("photonmap", "\"bool causticsonly\" true");
  const auto supports = [&](const std::string& properties) {
    return photonmap->supportsMedia(*sceneFrom(
        "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" " + properties + "\n" +
        view(2, "0 0 -3  0 0 1  0 1 0", 40) +
        "MediumInterface \"m\" \"\"\nMaterial \"interface\"\nShape \"sphere\" \"float radius\" 1\n"));
  };
  const std::string noScattering = "\"rgb sigma_a\" [1 2 3] \"rgb sigma_s\" [0 0 0]";
  EXPECT_TRUE(supports(noScattering));
  EXPECT_FALSE(supports(noScattering + " \"rgb Le\" [1 1 1]"));
  EXPECT_FALSE(supports("\"rgb sigma_a\" [1 2 3] \"rgb sigma_s\" [0 0 .1]"));
}

TEST(GlowPhotons, FindAFlameInALargeScene) {
  // The flame is above a ground a thousand times as wide, as a shape and as a part of an object in a smaller
  // scene.
  const double radius = 0.05, power = 4 * M_PI * 2 * 4 / 3 * M_PI * radius * radius * radius;
  const std::string medium = "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [1 1 1] "
                             "\"rgb sigma_s\" [0 0 0] \"rgb Le\" [2 2 2]\n";
  const std::string flame = "MediumInterface \"m\" \"\"\nMaterial \"interface\"\nShape \"sphere\" \"float "
                            "radius\" .05\n";
  const auto ground = [](const std::string& half) {
    return "Shape \"bilinearmesh\" \"point3 P\" [-" + half + " -1 -" + half + " " + half + " -1 -" + half +
           " -" + half + " -1 " + half + " " + half + " -1 " + half + "]\n";
  };
  const std::string start = medium + view(2, "0 0 -3  0 0 1  0 1 0", 40);
  for (const std::string& text :
       {start + ground("50") + flame, start + ground("2") + "ObjectBegin \"candle\"\n" + flame +
                                          "ObjectEnd\nObjectInstance \"candle\"\n"}) {
    EmissiveMedia glowing;
    TransportCounts counts;
    EXPECT_TRUE(glowing.learn(*sceneFrom(text), 0, 1, 0, counts));
    EXPECT_NEAR(glowing.power() / power, 1, 0.1) << text;
  }
}

TEST(MediaPhotons, StartInWhatIsAroundTheScene) {
  // A room of fog with openings to the sky; the medium that the file gives to the sky is not the medium of
  // its rays.
  const std::string fog = "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [.1 .1 .1] "
                          "\"rgb sigma_s\" [.3 .3 .3]\nMediumInterface \"\" \"m\"\n" +
                          view(8, "0 0 0  0 0 1  0 1 0", 60) + EVEN_SKY;
  std::string room = "MediumInterface \"m\" \"m\"\nMaterial \"diffuse\"\n";
  for (const char* wall : {"[-1 -1 1] \"point3 p2\" [1 1 1.2]", "[-1 -1 -1] \"point3 p2\" [-.8 1 1]",
                           "[.8 -1 -1] \"point3 p2\" [1 1 1]", "[-1 -1 -1] \"point3 p2\" [1 -.8 1]",
                           "[-1 .8 -1] \"point3 p2\" [1 1 1]"})
    room += "Shape \"box\" \"point3 p1\" " + std::string(wall) + "\n";
  const std::string pane = "MediumInterface \"\" \"m\"\nMaterial \"interface\"\nShape \"bilinearmesh\" "
                           "\"point3 P\" [-1 -1 -.99 1 -1 -.99 -1 1 -.99 1 1 -.99]\n";
  const auto closed = sceneFrom(fog + room + pane), endless = sceneFrom(fog + room);
  TransportCounts counts;
  EXPECT_EQ(mediumOutside(*closed, counts), 0);
  EXPECT_EQ(mediumOutside(*endless, counts), 1);
  const auto mean = [](const Scene& scene, const char* integrator) {
    return double(meanOfMedium(renderScene(scene, integrator, "", SANITIZED ? 8 : 256)).g);
  };
  EXPECT_NEAR(mean(*closed, "photonmap") / mean(*closed, "path"), 1, SANITIZED ? 0.1 : 0.03);
  EXPECT_EQ(mean(*endless, "photonmap"), 0);
  EXPECT_EQ(mean(*endless, "path"), 0);
}

TEST(MediaPhotons, WhiteFurnaceAsFarAsTheEdge) {
  // In a sky of 1, a medium without absorption has the radiance 1 everywhere. At the sides of the box half of
  // a photon's disc is outside.
  const std::string box = "\"point3 p0\" [-1 -1 0] \"point3 p1\" [1 1 1] ";
  for (const std::string& medium :
       {std::string("\"homogeneous\" \"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [1 1 1]"),
        "\"uniformgrid\" \"integer nx\" 2 \"integer ny\" 2 \"integer nz\" 2 " + box +
            "\"float density\" [0 3 1 0 3 0 0 2] \"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [1 1 1] \"float g\" "
            ".5"}) {
    constexpr int SIZE = 16;
    const auto scene = sceneFrom("Film \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 16\n"
                                 "LookAt 0 0 -1  0 0 1  0 1 0\nCamera \"orthographic\"\nWorldBegin\n"
                                 "MakeNamedMedium \"m\" \"string type\" " +
                                 medium +
                                 "\nMediumInterface \"m\" \"\"\nMaterial \"interface\"\n"
                                 "Shape \"box\" \"point3 p1\" [-1 -1 0] \"point3 p2\" [1 1 1]\n" +
                                 EVEN_SKY);
    const Rendered r = renderScene(
        *scene, "photonmap", "\"integer photons\" 50000 \"integer passes\" 0 \"string direct\" \"photons\"",
        SANITIZED ? 4 : 32);
    Rgb rim(0);
    for (int i = 0; i < SIZE; ++i)
      for (const int k : {i, i + SIZE * (SIZE - 1), i * SIZE, i * SIZE + SIZE - 1})
        rim += r.value(static_cast<size_t>(k)) / (4.0f * SIZE);
    expectColour(meanOfMedium(r), Rgbd(1), SANITIZED ? 0.05 : 0.01, medium);
    expectColour(rim, Rgbd(1), SANITIZED ? 0.06 : 0.02, medium);
  }
}

TEST(MediaPhotons, DoNotWanderFarFromTheSceneInAFogThatAbsorbsNothing) {
  const std::string text = R"(
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_s" [ .1 .1 .1 ] "rgb sigma_a" [ 0 0 0 ]
MediumInterface "" "fog"
)" + view(8, "0 1 -6  0 1 0  0 1 0", 60) +
                           R"(
LightSource "point" "rgb I" [ 20 20 20 ] "point3 from" [ 0 4 -2 ]
Material "diffuse" "rgb reflectance" [ .7 .7 .7 ]
Shape "bilinearmesh" "point3 P" [ -9 0 -9  9 0 -9  -9 0 9  9 0 9 ]
)";
  const auto scene = sceneFrom(text);
  const PathClasses classes(std::vector<PathClass>{{"fog", "LVVV*E"}});
  const std::string few = "\"integer passes\" 0 \"integer photons\" ";
  const BatchMeans paths = classMeans(*scene, {"path", ""}, classes, samples(64), 6),
                   photons = classMeans(*scene, {"photonmap", few + "2000"}, classes, samples(8), 6);
  EXPECT_NEAR(photons.mean(0), paths.mean(0),
              4 * std::hypot(photons.standardError(0), paths.standardError(0)) + 0.01 * paths.mean(0));
  // Without roulette each photon has about a thousand events, and two rays at each.
  const Rendered one = renderScene(*scene, "photonmap", few + "20000", 1);
  EXPECT_LT(one.statistics.counts.rays, 1000 * one.statistics.photonsEmitted);
}

TEST(MediaPhotons, AreTheSameForAnyNumberOfThreads) {
  const auto scene = sceneFrom(foggyRoom(8));
  const PathClasses classes;
  for (const char* more : {"", " \"string volumephotons\" \"beams\""}) {
    const std::string parameters = "\"integer passes\" 0 \"integer photons\" 20000" + std::string(more);
    const Film one = renderMediaClasses(*scene, "photonmap", parameters, classes, 2, 1),
               four = renderMediaClasses(*scene, "photonmap", parameters, classes, 2, 4);
    for (size_t i = 0; i < one.bounds().area(); ++i) EXPECT_EQ(one.value(i, 0), four.value(i, 0)) << i;
  }
}

TEST(MediaPhotons, KeepTheirPowerWhateverTheChannels) {
  // Without absorption Russian roulette ends no photon. In the end all flux of a photon may be in one
  // channel, with three times its value, and no more after hundreds of events.
  const auto scene = sceneFrom(
      view(4, "0 0 -5  0 0 0  0 1 0", 40) +
      "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [20 26 "
      "30]\n"
      "LightSource \"point\" \"rgb I\" [1 1 1]\nMediumInterface \"m\" \"\"\nMaterial \"interface\"\n"
      "Shape \"box\" \"point3 p1\" [-1 -1 -1] \"point3 p2\" [1 1 1]\n");
  ShootSettings settings;
  settings.photons = SANITIZED ? 200 : 2000;
  settings.maxDepth = LOSSLESS_ROULETTE_DEPTH;
  const ShotPhotons shot = shootPhotons(*scene, PathClasses(), Pass(), settings, ForwardControl());
  ASSERT_GT(shot.inMedia.size(), 100 * settings.photons);
  const float each = 4 * PI / static_cast<float>(settings.photons);
  float strongest = 0;
  for (const VolumePhoton& p : shot.inMedia) strongest = std::max(strongest, maxComponent(p.power) / each);
  EXPECT_GT(strongest, 2);
  EXPECT_LT(strongest, 3.01f);
}

TEST(MediaPhotons, ABeamIsFoundWithinItsDiscs) {
  // Photons along a line, perpendicular to rays: each ray gets the power of the photons whose discs it
  // crosses.
  std::vector<VolumePhoton> photons;
  for (int i = 0; i < 5000; ++i)
    photons.push_back({Vec3f(float(i) / 5000, 0.001f * float(i % 7), 0.002f * float(i % 5)),
                       packDirection({1, 0, 0}), Rgb(1)});
  VolumePhotonMap map;
  map.build(photons, 1, 10);
  // Integrated over a wide plane of parallel rays, the contribution of each photon is 1.
  double sum = 0;
  constexpr int N = 400;
  for (int y = 0; y < N; ++y)
    for (int x = 0; x < N; ++x) {
      const Vec3f origin(-.1f + 1.2f * (float(x) + 0.5f) / N, -.1f + .2f * (float(y) + 0.5f) / N, -3);
      map.visitAlong({origin, {0, 0, 1}}, 10, [&](const VolumePhoton& p, float t, float kernel) {
        EXPECT_NEAR(t, 3 + p.position.z, 1e-4);
        sum += double(kernel) * 1.2 * .2 / (double(N) * N);
      });
    }
  EXPECT_NEAR(sum / double(photons.size()), 1, 0.02);
  // Photons beyond the end of the ray are not found.
  map.visitAlong({{.5f, 0, -3}, {0, 0, 1}}, 2.9f, [](const VolumePhoton&, float, float) { FAIL(); });
}

TEST(PhotonBeams, BringInTheMeanWhatLiesAlongThem) {
  // Parallel beams, uniform over a square, and rays that cross them at an angle: the expected number of
  // crossings is one over the sine of the angle for each unit of the perpendicular plane.
  std::vector<PhotonBeam> beams;
  constexpr int N = 40;
  for (int y = 0; y < N; ++y)
    for (int x = 0; x < N; ++x)
      beams.push_back({Vec3f(-2, (float(x) + 0.5f) / N, (float(y) + 0.5f) / N), Vec3f(1, 0, 0), 4, Rgb(1)});
  for (const float scale : {1.0f, 0.5f}) {
    PhotonBeamMap map;
    map.build(beams, scale, 1);
    ASSERT_EQ(map.size(), size_t(N * N));
    for (const float angle : {0.3f, 1.0f, 1.5f}) {
      const Vec3f direction(std::cos(angle), 0, std::sin(angle));
      double sum = 0;
      int passed = 0;
      constexpr int RAYS = 2000;
      for (int i = 0; i < RAYS; ++i) {
        // The ray crosses the middle of the square from side to side.
        const Vec3f origin = Vec3f(0, 0.3f + 0.4f * (float(i) + 0.5f) / RAYS, 0.5f) - direction * 1.9f;
        map.visitAlong({origin, direction}, 3.8f, [&](const PhotonBeam& b, float s, float t, float kernel) {
          EXPECT_LT(std::abs(b.origin.y - origin.y), 0.05f * scale);
          EXPECT_NEAR(b.origin.x + s, origin.x + t * direction.x, 1e-4);
          sum += double(kernel) / RAYS;
          ++passed;
        });
      }
      // N beams for each unit of height, at each of N depths.
      const double expected = double(N) * N / std::sin(double(angle));
      EXPECT_NEAR(sum / expected, 1, 0.02) << angle << " " << scale;
      EXPECT_GT(passed, 0);
    }
    // Beams beyond the end of the ray are not found.
    map.visitAlong({{0, 0.5f, -1}, {0, 0, 1}}, 0.9f, [](const PhotonBeam&, float, float, float) { FAIL(); });
  }
}

TEST(PhotonBeams, SingleScatteringOfParallelLight) {
  // Single scattering as in the test of path, by beams alone: the mean over a square window of width 1.
  const std::string text =
      "Film \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 16\nLookAt 0 0 -1  0 0 1  0 1 0\n"
      "Camera \"orthographic\" \"float screenwindow\" [-.5 .5 -.5 .5]\nWorldBegin\n"
      "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [.1 .2 .6] \"rgb sigma_s\" [.4 "
      ".3 "
      ".2]\nMediumInterface \"m\" \"\"\n" +
      MEDIUM_BOX +
      "LightSource \"distant\" \"point3 from\" [0 1 0] \"point3 to\" [0 0 0] \"rgb L\" [3 3 3]\n";
  const Rgbd scattering(.4, .3, .2), extinction(.5, .5, .8), half = extinction * 0.5;
  const Rgbd meanArrives = exp(-extinction * 2.0) * (exp(half) - exp(-half)) / extinction;
  const Rgbd expected = scattering / (4 * M_PI) * 3.0 * meanArrives * (1.0 - exp(-extinction)) / extinction;
  const Rendered r =
      renderText(text, "photonmap",
                 "\"string direct\" \"photons\" \"string volumephotons\" \"beams\" \"integer maxdepth\" 1 "
                 "\"integer photons\" 20000 \"integer passes\" 0",
                 SANITIZED ? 8 : 64);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(double(meanOfMedium(r)[c]) / expected[c], 1, SANITIZED ? 0.15 : 0.03) << c;
}

// In fog of many scattering events, all photons that are stored are stored with the same probability. Trials
// of a few photons choose it.
TEST(Media, PhotonsStoredForEachEmittedOneDoNotDependOnTheirNumber) {
  const auto scene =
      sceneFrom("MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [0 0 0] "
                "\"rgb sigma_s\" [3 3 3]\nMediumInterface \"\" \"fog\"\n" +
                view(32, "0 0 -.95  0 0 1  0 1 0", 80) + R"(
MediumInterface "fog" "fog"
LightSource "point" "point3 from" [ 0 .9 0 ]
Material "diffuse" "rgb reflectance" [ .5 .5 .5 ]
ReverseOrientation
Shape "box" "point3 p1" [-1 -1 -1] "point3 p2" [1 1 1]
)");
  const auto storedPerEmitted = [&](int photons) {
    const auto s = renderScene(*scene, "photonmap",
                               "\"integer passes\" 0 \"integer photons\" " + std::to_string(photons), 1)
                       .statistics;
    return double(s.photonsStored) / double(s.photonsEmitted);
  };
  EXPECT_NEAR(storedPerEmitted(131072) / storedPerEmitted(4096), 1, .1);
}
