/** @file
 * Coated materials against geometry with the same two surfaces: a rough dielectric disc close above its base.
 * The coat's random walk and the scene's paths share only the microfacet model.
 */
#include "rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

struct CoatCase {
  const char* name;
  const char* coated;    ///< the coated material, without absorption and without a limit of the walk
  const char* interface; ///< the coat alone
  const char* base;
  const char* lamp; ///< position of the lamp's centre
};

void PrintTo(const CoatCase& c, std::ostream* out) { *out << c.name; }

Rendered seenFromAside(const CoatCase& c, const std::string& surfaces, int samplesPerPixel, uint64_t seed) {
  const std::string text = std::string(R"(
LookAt 0 -4 4  0 0 0  0 0 1
Camera "orthographic" "float screenwindow" [ -.5 .5 -.5 .5 ]
Film "rgb" "integer xresolution" 16 "integer yresolution" 16
WorldBegin
AttributeBegin
Translate )") + c.lamp + R"(
AreaLightSource "diffuse"
ReverseOrientation
Shape "disk" "float radius" 10
AttributeEnd
)" + surfaces;
  return renderText(text, "path", "", samples(samplesPerPixel), seed);
}

class Coats : public ::testing::TestWithParam<CoatCase> {};

} // namespace

TEST_P(Coats, AreWhatTheirTwoSurfacesAre) {
  const CoatCase& c = GetParam();
  const std::string disk = "\nShape \"disk\" \"float radius\" 100\n";
  const Rendered one = seenFromAside(
      c, std::string(c.coated) + "\"float thickness\" 0 \"integer maxdepth\" 1000" + disk, 1200, 1);
  const Rendered two = seenFromAside(c, c.base + disk + "Translate 0 0 .001\n" + c.interface + disk, 2400, 2);
  const double error = std::hypot(one.standardError(), two.standardError());
  EXPECT_LT(error, 0.003 * two.mean() * (SANITIZED ? 3 : 1)) << "tells nothing";
  EXPECT_NEAR(one.mean(), two.mean(), 4 * error);
}

INSTANTIATE_TEST_SUITE_P(
    , Coats,
    ::testing::Values(
        CoatCase{"Diffuse",
                 "Material \"coateddiffuse\" \"float roughness\" .2 \"bool remaproughness\" false ",
                 "Material \"dielectric\" \"float roughness\" .2 \"bool remaproughness\" false",
                 "Material \"diffuse\"", "0 8 8"},
        CoatCase{
            "BrightDiffuseUnderABentCoat",
            "Material \"coateddiffuse\" \"rgb reflectance\" [ .9 .9 .9 ] \"float uroughness\" .1 \"float "
            "vroughness\" .3 \"float eta\" 1.8 \"bool remaproughness\" false ",
            "Material \"dielectric\" \"float uroughness\" .1 \"float vroughness\" .3 \"float eta\" 1.8 "
            "\"bool remaproughness\" false",
            "Material \"diffuse\" \"rgb reflectance\" [ .9 .9 .9 ]", "0 8 8"},
        CoatCase{
            "Metal",
            "Material \"coatedconductor\" \"rgb conductor.eta\" [ .9 .9 .9 ] \"rgb conductor.k\" [ 6 6 6 ] "
            "\"float interface.roughness\" .1 "
            "\"float conductor.roughness\" .3 \"bool remaproughness\" false ",
            "Material \"dielectric\" \"float roughness\" .1 \"bool remaproughness\" false",
            "Material \"conductor\" \"rgb eta\" [ .6 .6 .6 ] \"rgb k\" [ 4 4 4 ] \"float roughness\" .3 "
            "\"bool remaproughness\" false", // as it is inside a medium of index 1.5
            "0 8 8"}),
    [](const auto& test) { return std::string(test.param.name); });
