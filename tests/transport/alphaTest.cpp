/** @file
 * Alpha: surfaces cut out by textures against the same holes as geometry, transmitted light against closed
 * forms, for camera rays, shadow rays and photons.
 */
#include "transport/rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Screen of four cells, two opposite ones of which are opaque. */
const char* const TEXTURED = R"(Texture "holes" "float" "checkerboard" "float uscale" 2 "float vscale" 2
Shape "bilinearmesh" "point3 P" [-1 -1 1  1 -1 1  -1 1 1  1 1 1] "texture alpha" "holes"
)";
const char* const TEXTURED_TRIANGLES =
    R"(Texture "holes" "float" "checkerboard" "float uscale" 2 "float vscale" 2
Shape "trianglemesh" "point3 P" [-1 -1 1  1 -1 1  -1 1 1  1 1 1] "integer indices" [0 1 3 0 3 2]
  "point2 uv" [0 0 1 0 0 1 1 1] "texture alpha" "holes"
)";
const char* const TEXTURED_INSTANCE = R"(Texture "holes" "float" "checkerboard" "string mapping" "planar"
ObjectBegin "screen"
  Scale 2 2 2
  Shape "trianglemesh" "point3 P" [-.5 -.5 0  .5 -.5 0  -.5 .5 0  .5 .5 0] "integer indices" [0 1 3 0 3 2]
    "texture alpha" "holes"
ObjectEnd
AttributeBegin Translate 0 0 1 ObjectInstance "screen" AttributeEnd
)";
const char* const GEOMETRY = R"(Shape "bilinearmesh" "point3 P" [-1 -1 1  0 -1 1  -1 0 1  0 0 1]
Shape "bilinearmesh" "point3 P" [0 0 1  1 0 1  0 1 1  1 1 1]
)";

/** A lamp above a screen above a floor; the screen casts a shadow and reflects light. */
std::string screenScene(const std::string& screen) {
  return view(24, "0 -3 4  0 0 .3  0 0 1", 50) + R"(
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [8 8 8]
  Material "diffuse" "rgb reflectance" [0 0 0]
  Shape "bilinearmesh" "point3 P" [-.5 -.5 4  -.5 .5 4  .5 -.5 4  .5 .5 4]
AttributeEnd
Material "diffuse" "rgb reflectance" [.7 .6 .5]
Shape "bilinearmesh" "point3 P" [-3 -3 0  3 -3 0  -3 3 0  3 3 0]
)" + screen;
}

void expectSamePicture(const Rendered& a, const Rendered& b, double sigmas) {
  ASSERT_EQ(a.pixels(), b.pixels());
  EXPECT_NEAR(a.mean(), b.mean(), 4 * std::hypot(a.standardError(), b.standardError()) + 1e-6);
  for (size_t i = 0; i < a.pixels(); ++i) {
    const double error = std::sqrt(a.film.variance(i) / double(a.film.samples(i)) +
                                   b.film.variance(i) / double(b.film.samples(i)));
    EXPECT_NEAR(double(luminance(a.value(i))), double(luminance(b.value(i))), sigmas * error + .02)
        << "pixel " << i;
  }
}

} // namespace

TEST(Alpha, TexturedHolesAreHoles) {
  const Rendered truth = renderText(screenScene(GEOMETRY), "path", "\"integer maxdepth\" 3", samples(64));
  for (const char* screen : {TEXTURED, TEXTURED_TRIANGLES, TEXTURED_INSTANCE}) {
    SCOPED_TRACE(screen);
    expectSamePicture(renderText(screenScene(screen), "path", "\"integer maxdepth\" 3", samples(64), 2),
                      truth, 6);
  }
}

TEST(Alpha, AMixWithInterfaceIsAScreenWithHoles) {
  const Rendered truth = renderText(screenScene(GEOMETRY), "path", "\"integer maxdepth\" 3", samples(64));
  const char* const SCREEN = R"(Texture "holes" "float" "checkerboard" "float uscale" 2 "float vscale" 2
Texture "sheet" "float" "checkerboard" "float uscale" 2 "float vscale" 2 "float tex1" 0 "float tex2" 1
MakeNamedMaterial "grey" "string type" "diffuse" "rgb reflectance" [.7 .6 .5]
MakeNamedMaterial "black" "string type" "diffuse" "rgb reflectance" [0 0 0]
MakeNamedMaterial "nothing" "string type" "interface"
MakeNamedMaterial "screen" "string type" "mix" "string materials" ["nothing" "grey"] "texture amount" "holes"
MakeNamedMaterial "same" "string type" "mix" "string materials" ["grey" "nothing"] "texture amount" "sheet"
MakeNamedMaterial "unseen" "string type" "mix" "string materials" ["nothing" "black"] "float amount" 0
)";
  for (const char* mix : {R"("string materials" ["nothing" "grey"] "texture amount" "holes")",
                          R"("string materials" ["grey" "nothing"] "texture amount" "sheet")",
                          R"("string materials" ["screen" "same"] "float amount" .3)",
                          R"("string materials" ["screen" "nothing"] "float amount" 0)",
                          R"("string materials" ["unseen" "grey"] "texture amount" "holes")"}) {
    SCOPED_TRACE(mix);
    const std::string screen = std::string(SCREEN) + "Material \"mix\" " + mix +
                               "\nShape \"bilinearmesh\" \"point3 P\" [-1 -1 1  1 -1 1  -1 1 1  1 1 1]\n";
    expectSamePicture(renderText(screenScene(screen), "path", "\"integer maxdepth\" 3", samples(64), 2),
                      truth, 6);
  }
}

TEST(Alpha, PhotonsMeetTheSameHoles) {
  const std::string parameters = "\"integer passes\" 1 \"integer photons\" 60000 \"string direct\" "
                                 "\"photons\" \"float radius\" .15 \"integer maxdepth\" 3";
  const Rendered truth = renderText(screenScene(GEOMETRY), "photonmap", parameters, 4);
  const Rendered cut = renderText(screenScene(TEXTURED), "photonmap", parameters, 4, 2);
  EXPECT_NEAR(cut.mean(), truth.mean(), .02 * truth.mean());
  const Rendered shadowRays =
      renderText(screenScene(TEXTURED_TRIANGLES), "photonmap",
                 "\"integer passes\" 1 \"integer photons\" 60000 \"integer maxdepth\" 3", 16, 3);
  const Rendered path = renderText(screenScene(GEOMETRY), "path", "\"integer maxdepth\" 3", samples(64));
  EXPECT_NEAR(shadowRays.mean(), path.mean(), .02 * path.mean());
}

TEST(Alpha, LayersTransmitIndependently) {
  // A camera sees a lamp through two sheets and a ball of opacity 0.4 each: each of the four surfaces
  // transmits 0.6. They do not reflect.
  const std::string scene = view(16, "0 0 0  0 0 1  0 1 0", 20) + R"(
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [1 1 1] "bool twosided" true
  Material "diffuse" "rgb reflectance" [0 0 0]
  Shape "bilinearmesh" "point3 P" [-5 -5 9  5 -5 9  -5 5 9  5 5 9]
AttributeEnd
Material "diffuse" "rgb reflectance" [0 0 0]
Shape "bilinearmesh" "point3 P" [-5 -5 2  5 -5 2  -5 5 2  5 5 2] "float alpha" .4
Shape "trianglemesh" "point3 P" [-5 -5 3  5 -5 3  -5 5 3  5 5 3] "integer indices" [0 1 3 0 3 2] "float alpha" .4
AttributeBegin Translate 0 0 6 Shape "sphere" "float radius" 2 "float alpha" .4 AttributeEnd
)";
  const Rendered r = renderText(scene, "path", "", samples(256));
  EXPECT_NEAR(r.mean(), std::pow(.6, 4), 5 * r.standardError());
}

TEST(Alpha, ShadowsAreAsThickAsTheSurface) {
  // Vertical light through a sheet of opacity 0.3 that reflects nothing.
  const std::string scene = view(8, "0 0 1  0 0 0  0 1 0", 20) + R"(
LightSource "distant" "point3 from" [0 0 1] "point3 to" [0 0 0] "rgb L" [2 2 2]
Material "diffuse" "rgb reflectance" [.5 .5 .5]
Shape "bilinearmesh" "point3 P" [-5 -5 0  5 -5 0  -5 5 0  5 5 0]
Material "diffuse" "rgb reflectance" [0 0 0]
Shape "disk" "float radius" 9 "float height" 3 "float alpha" .3
)";
  for (const Way& way :
       {Way{"path", ""}, Way{"photonmap", "\"integer passes\" 1 \"integer photons\" 1000"}}) {
    const Rendered r = renderText(scene, way.integrator, way.parameters, samples(512));
    EXPECT_NEAR(r.mean(), .7 * 2 * .5 / M_PI, 5 * r.standardError()) << way.integrator;
  }
}

TEST(Alpha, PartsThatAreCutOutDoNotShine) {
  // Half of the lamp cut out by alpha is equal to a lamp of half the size: visible, sampled, and as photons.
  const auto scene = [](const std::string& lamp) {
    return view(12, "0 -3 2  0 0 .5  0 0 1", 60) +
           "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [3 2 1]\n" +
           "Material \"diffuse\" \"rgb reflectance\" [.3 .3 .3]\n" + lamp + "AttributeEnd\n" +
           "Material \"diffuse\" \"rgb reflectance\" [.7 .6 .5]\n"
           "Shape \"bilinearmesh\" \"point3 P\" [-3 -3 0  3 -3 0  -3 3 0  3 3 0]\n";
  };
  const std::string half =
      scene("Shape \"bilinearmesh\" \"point3 P\" [-.5 -.5 2  -.5 .5 2  0 -.5 2  0 .5 2]\n");
  const std::string cut = scene(R"(Texture "half" "float" "checkerboard" "float vscale" 2
Shape "bilinearmesh" "point3 P" [-.5 -.5 2  -.5 .5 2  .5 -.5 2  .5 .5 2] "texture alpha" "half"
)");
  for (const Way& way : dealt(quickWays("100000"), 0)) {
    const Rendered a = renderText(half, way.integrator, way.parameters, samples(64)),
                   b = renderText(cut, way.integrator, way.parameters, samples(64), 2);
    EXPECT_NEAR(a.mean(), b.mean(), .02 * a.mean()) << way.integrator << way.parameters;
  }
}

TEST(Alpha, LightsOfAlphaZeroShineUnseen) {
  const auto scene = [](const std::string& alpha) {
    return view(12, "0 -3 1  0 0 0  0 0 1", 30) + R"(
AttributeBegin AreaLightSource "diffuse" "rgb L" [3 2 1]
Material "interface"
Shape "bilinearmesh" "point3 P" [-.5 -.5 3  -.5 .5 3  .5 -.5 3  .5 .5 3] )" +
           alpha + R"(
AttributeEnd
Material "diffuse" "rgb reflectance" [.7 .6 .5]
Shape "bilinearmesh" "point3 P" [-3 -3 0  3 -3 0  -3 3 0  3 3 0]
)";
  };
  // The view is a hundredth of the plate; this number of photons makes the density in it uniform to within a
  // hundredth.
  for (const Way& way : dealt(quickWays(SANITIZED ? "200000" : "400000"), 1)) {
    const Rendered seen = renderText(scene(""), way.integrator, way.parameters, samples(64)),
                   unseen =
                       renderText(scene("\"float alpha\" 0"), way.integrator, way.parameters, samples(64), 2);
    EXPECT_NEAR(unseen.mean(), seen.mean(), .02 * seen.mean()) << way.integrator << way.parameters;
  }
  // At the lamp itself nothing is visible.
  const std::string at =
      view(8, "0 0 0  0 0 1  0 1 0", 10) + R"(AreaLightSource "diffuse" "rgb L" [3 2 1] "bool twosided" true
Shape "disk" "float height" 3 "float radius" 9 "float alpha" 0)";
  EXPECT_EQ(renderText(at, "path", "", 4).mean(), 0);
}

TEST(Alpha, SameBitsForAnyNumberOfThreads) {
  const std::string scene = screenScene(R"(Texture "holes" "float" "fbm"
Shape "sphere" "texture alpha" "holes"
)");
  for (const Way& way : dealt(allWays("5000"), 2)) {
    const Rendered one = renderText(scene, way.integrator, way.parameters, 4, 1, 1),
                   four = renderText(scene, way.integrator, way.parameters, 4, 1, 4);
    for (size_t i = 0; i < one.pixels(); ++i) ASSERT_EQ(one.value(i), four.value(i)) << way.integrator;
  }
}

TEST(TexturedScenes, IntegratorsAgree) {
  // Colours and bumps on both sides of an interreflection, also visible in a mirror.
  const std::string scene = view(16, "0 -4 3  0 0 .6  0 0 1", 45) + R"(
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [9 9 9]
  Translate 0 0 4 ReverseOrientation
  Shape "disk" "float radius" .7
AttributeEnd
Texture "squares" "spectrum" "checkerboard" "float uscale" 6 "float vscale" 6 "rgb tex1" [.8 .2 .1] "rgb tex2" [.2 .3 .8]
Texture "hills" "float" "fbm" "integer octaves" 3
Texture "low" "float" "scale" "texture tex" "hills" "float scale" .2
Material "diffuse" "texture reflectance" "squares"
Shape "bilinearmesh" "point3 P" [-3 -3 0  3 -3 0  -3 3 0  3 3 0]
Material "diffuse" "texture reflectance" "squares" "texture displacement" "low"
AttributeBegin Translate -.7 0 .8 Shape "sphere" "float radius" .8 AttributeEnd
Material "conductor"
AttributeBegin Translate 1 0 .6 Shape "sphere" "float radius" .6 AttributeEnd
)";
  const Rendered path = renderText(scene, "path", "", samples(256));
  for (const Way& way :
       {Way{"photonmap", "\"integer passes\" 1 \"integer photons\" 100000"},
        Way{"photonmap", "\"integer passes\" 1 \"integer photons\" 100000 \"string direct\" \"photons\""}}) {
    const Rendered r = renderText(scene, way.integrator, way.parameters, samples(32), 2);
    EXPECT_NEAR(r.mean(), path.mean(), .02 * path.mean() + 4 * path.standardError()) << way.parameters;
  }
}

// Photons hit a sheet of partial alpha at random, and so do the camera rays that ask the photon map.
TEST(Alpha, PhotonsOnASheetAreAsBrightAsShadowRays) {
  const auto meanOf = [](const std::string& alpha, const char* integrator, const std::string& parameters) {
    return renderText(view(16, "0 0 5  0 0 0  0 1 0", 30) +
                          "LightSource \"point\" \"rgb I\" [ 10 10 10 ] \"point3 from\" [ 0 0 3 ]\n"
                          "Material \"diffuse\" \"rgb reflectance\" [ .5 .5 .5 ]\n"
                          "Shape \"trianglemesh\" \"integer indices\" [ 0 1 2 0 2 3 ] \"point3 P\" [ -4 -4 0 "
                          "4 -4 0 4 "
                          "4 0 -4 4 0 ] \"float alpha\" " +
                          alpha,
                      integrator, parameters, SANITIZED ? 4 : 32)
        .mean();
  };
  const double opaque = meanOf("1", "path", "");
  for (const auto& [integrator, parameters] :
       {std::pair("path", ""),
        {"photonmap", "\"string direct\" \"photons\""},
        {"photonmap", "\"string direct\" \"photons\" \"bool edges\" false"},
        {"simplephotonmap", ""},
        {"vcm", ""}})
    for (const char* alpha : {".1", ".6"})
      EXPECT_NEAR(meanOf(alpha, integrator, parameters) / opaque, std::stod(alpha), SANITIZED ? .1 : .012)
          << integrator << " " << parameters << " " << alpha;
}
