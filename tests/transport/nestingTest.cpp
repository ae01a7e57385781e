/** @file
 * Overlapping dielectrics: the picture is equal to the picture of the same solids with their true surfaces.
 */
#include <random>

#include "rendering.h"

#include "transport/emission/cameraProbe.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** Solids between four lamps of different colours, behind and in front of them. */
std::string between(const std::string& solids) {
  std::string text = R"(
Film "rgb" "integer xresolution" 12 "integer yresolution" 12
PixelFilter "box"
LookAt .3 .2 -6  0 0 0  0 1 0
Camera "perspective" "float fov" 24
WorldBegin
)";
  const struct {
    const char* radiance;
    double x, y, z;
  } quads[] = {
      {"3 1 .2", -2, -2, 5}, {".2 2 .3", 1.9, -1.8, 5}, {".1 .4 3", -.3, 2, 5}, {"1 1 1", .2, .1, -9}};
  for (const auto& q : quads) {
    const auto corner = [&](double dx, double dy) {
      return std::to_string(q.x + dx) + " " + std::to_string(q.y + dy) + " " + std::to_string(q.z) + "  ";
    };
    text += std::string("AttributeBegin\nAreaLightSource \"diffuse\" \"bool twosided\" true \"rgb L\" [ ") +
            q.radiance + " ]\nMaterial \"interface\"\nShape \"bilinearmesh\" \"point3 P\" [ " +
            corner(-1.5, -1.5) + corner(1.5, -1.5) + corner(-1.5, 1.5) + corner(1.5, 1.5) +
            "]\nAttributeEnd\n";
  }
  return text + solids;
}

std::string sphere(double radius, const std::string& material, bool inwards = false) {
  return "AttributeBegin\nMaterial \"dielectric\" " + material + "\n" +
         (inwards ? "ReverseOrientation\n" : "") + "Shape \"sphere\" \"float radius\" " +
         std::to_string(radius) + "\nAttributeEnd\n";
}

/** Parameters for one pass of photons for each sample of a few pixels. */
const char* fewPhotons(const std::string& integrator) {
  return integrator == "photonmap" ? "\"integer passes\" 0 \"integer photons\" 8192" : "";
}

void expectSamePicture(const std::string& a, const std::string& b, const std::string& integrator) {
  const auto one = sceneFrom(between(a)), other = sceneFrom(between(b));
  ASSERT_TRUE(one && other);
  const Rendered x = renderScene(*one, integrator, fewPhotons(integrator), samples(512), 1);
  const Rendered y = renderScene(*other, integrator, fewPhotons(integrator), samples(512), 2);
  double most = 0;
  for (size_t p = 0; p < x.pixels(); ++p) {
    const double error = std::sqrt(x.film.variance(p) / double(x.film.samples(p)) +
                                   y.film.variance(p) / double(y.film.samples(p)));
    const double l = double(luminance(x.value(p)));
    EXPECT_NEAR(l, double(luminance(y.value(p))), 5 * error + 1e-3) << integrator << " pixel " << p;
    most = std::max(most, l);
  }
  EXPECT_GT(most, 0.5);
}

} // namespace

TEST(Nesting, WaterThatReachesIntoItsGlassTouchesIt) {
  // Inside of the glass, at a radius of .8, the relative index is that of glass to water.
  const std::string touching = sphere(1, R"("float eta" 1.5)") + sphere(0.8, R"("float eta" .8866667)");
  const std::string overlapping = sphere(1, R"("float eta" 1.5 "integer priority" 2)") +
                                  sphere(0.8, R"("float eta" 1.5 "integer priority" 2)", true) +
                                  sphere(0.9, R"("float eta" 1.33 "integer priority" 1)");
  for (const char* integrator : {"path", "photonmap"}) expectSamePicture(touching, overlapping, integrator);
}

TEST(Nesting, TheStrongerIsThereInWhateverOrder) {
  const std::string hidden = sphere(1, R"("float eta" 1.7 "integer priority" 3)");
  const std::string within = sphere(0.6, R"("float eta" 1.2 "integer priority" 2)");
  expectSamePicture(sphere(1, R"("float eta" 1.7)"), hidden + within, "path");
  expectSamePicture(sphere(1, R"("float eta" 1.7)"), within + hidden, "path");
  // In the reverse order the weaker solid is outside of the stronger one, as with relative indices.
  expectSamePicture(sphere(1, R"("float eta" 1.7)") + sphere(0.6, R"("float eta" .7058824)"),
                    sphere(1, R"("float eta" 1.7 "integer priority" 1)") +
                        sphere(0.6, R"("float eta" 1.2 "integer priority" 2)"),
                    "path");
}

TEST(Nesting, OneSolidOfManyShapesHasNoWallsInside) {
  const std::string material =
      "MakeNamedMaterial \"g\" \"string type\" \"dielectric\" \"integer priority\" 1\n"
      "NamedMaterial \"g\"\n";
  const std::string two =
      material + "Shape \"sphere\" \"float radius\" 1\nShape \"sphere\" \"float radius\" .5\n";
  expectSamePicture(sphere(1, ""), two, "path");
}

TEST(Nesting, NothingIsLostInAFurnace) {
  const auto scene =
      sceneFrom(R"(
Film "rgb" "integer xresolution" 8 "integer yresolution" 8
LookAt .3 .2 -6  0 0 0  0 1 0
Camera "perspective" "float fov" 24
WorldBegin
LightSource "infinite" "rgb L" [ 1 1 1 ]
)" + sphere(1, R"("float eta" 1.5 "integer priority" 2)") +
                "Translate .7 0 0\n" + sphere(0.8, R"("float eta" 1.33 "integer priority" 1)"));
  ASSERT_TRUE(scene);
  const Rendered r = renderScene(*scene, "path", "", samples(256));
  EXPECT_NEAR(r.mean(), 1, 0.005 + 3 * r.standardError());
}

TEST(Nesting, HiddenSurfacesThrowNoShadows) {
  // A lamp and a floor inside of glass, with the surface of a weaker solid between them.
  for (const char* lamp :
       {"LightSource \"point\" \"rgb I\" [ 2 2 2 ] \"point3 from\" [ .1 .8 -.2 ]\n",
        "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [ 40 40 40 ]\nMaterial \"interface\"\n"
        "Translate .1 .8 -.2\nShape \"sphere\" \"float radius\" .1\nAttributeEnd\n"}) {
    const std::string inside = std::string(lamp) +
                               "AttributeBegin\nMaterial \"diffuse\"\nRotate -90 1 0 0\nShape \"disk\" "
                               "\"float radius\" .5\nAttributeEnd\n";
    const std::string glass = sphere(1, R"("float eta" 1.5 "integer priority" 2)");
    const std::string weaker = sphere(0.6, R"("float eta" 1.2 "integer priority" 1)");
    const auto one = sceneFrom(between(glass + inside)), other = sceneFrom(between(glass + weaker + inside));
    ASSERT_TRUE(one && other);
    const std::string photons = "\"integer passes\" 1 \"integer photons\" " + std::to_string(samples(20000));
    for (const Way& way : {Way{"path", ""}, Way{"photonmap", photons}}) {
      const Rendered x = renderScene(*one, way.integrator, way.parameters, samples(64), 1);
      const Rendered y = renderScene(*other, way.integrator, way.parameters, samples(64), 2);
      EXPECT_NEAR(x.mean(), y.mean(), 4 * std::hypot(x.standardError(), y.standardError()) + 0.02 * x.mean())
          << way.integrator << " " << lamp;
    }
  }
}

TEST(Nesting, TheEyeMayBeInside) {
  // Seen from inside of the glass, the weaker solid around its far side is still hidden, and objects beyond
  // are visible.
  const std::string eye = R"(
Film "rgb" "integer xresolution" 8 "integer yresolution" 8
PixelFilter "box"
LookAt 0 0 -.5  .1 .2 1  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "infinite" "rgb L" [ .2 .2 .2 ]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 3 3 3 ]
Translate .3 0 6
Shape "sphere" "float radius" 1.5
AttributeEnd
)";
  const auto one = sceneFrom(eye + sphere(1, R"("float eta" 1.5)"));
  const auto other = sceneFrom(eye + sphere(1, R"("float eta" 1.5 "integer priority" 2)") +
                               sphere(0.8, R"("float eta" 1.2 "integer priority" 1)"));
  ASSERT_TRUE(one && other);
  for (const char* integrator : {"path", "photonmap"}) {
    const Rendered x = renderScene(*one, integrator, fewPhotons(integrator), samples(512), 1);
    const Rendered y = renderScene(*other, integrator, fewPhotons(integrator), samples(512), 2);
    EXPECT_NEAR(x.mean(), y.mean(), 4 * std::hypot(x.standardError(), y.standardError()) + 1e-3 * x.mean())
        << integrator;
  }
}

TEST(Nesting, TooManyAreRefusedAtTheirPlace) {
  std::string solids;
  for (size_t i = 0; i <= Scene::MAX_NESTED; ++i) {
    solids += sphere(1, "\"float eta\" 1.5 \"integer priority\" 1"); // all of one medium
    if (i > 0) solids += sphere(1, "\"integer priority\" " + std::to_string(1 + i));
  }
  Diagnostics diagnostics;
  const SceneDescription description = parseScene(between(solids), "test.pbrt", ".", diagnostics);
  EXPECT_FALSE(buildScene(description, {}, diagnostics));
  EXPECT_NE(diagnostics.format().find("more than 32 different dielectrics with a priority"),
            std::string::npos);
}

/** Probes pass surfaces that a stronger solid around them hides. */
TEST(Nesting, ProbesOfTheCameraPassHiddenSurfaces) {
  const std::string glass = sphere(1, "\"float eta\" 1.5 \"integer priority\" 2"),
                    hidden = sphere(0.6, "\"float eta\" 3 \"integer priority\" 1");
  const std::string wall =
      "Material \"diffuse\"\nShape \"bilinearmesh\" \"point3 P\" [ -9 -9 4  9 -9 4  -9 9 4 "
      " 9 9 4 ]\n";
  const auto plain = sceneFrom(between(glass + wall)), nested = sceneFrom(between(glass + hidden + wall));
  ASSERT_TRUE(plain && nested);
  TransportCounts counts;
  const GatherWeighting none = GatherWeighting::belowRoughness(0);
  const auto a = probeCamera(*plain, 12, 0, none, counts), b = probeCamera(*nested, 12, 0, none, counts);
  ASSERT_EQ(a.size(), b.size());
  ASSERT_GT(a.size(), 100u);
  for (size_t i = 0; i < a.size(); ++i)
    EXPECT_LT(glm::distance(a[i].point.position, b[i].point.position), 1e-3f) << i;
}

/** Displaced from the floor only, a ray to the edge would hit wall and floor in turn, without end. */
TEST(Nesting, RaysGoOnBehindEdges) {
  const auto scene = sceneFrom(R"(
WorldBegin
Shape "trianglemesh" "point3 P" [ -4 -8 0  4 -8 0  4 4 0  -4 4 0 ] "integer indices" [ 0 1 2 0 2 3 ]
Shape "trianglemesh" "point3 P" [ -4 4 0  4 4 0  4 4 6  -4 4 6 ] "integer indices" [ 0 1 2 0 2 3 ]
)");
  ASSERT_TRUE(scene);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(-1, 1);
  for (int i = 0; i < 200000; ++i) {
    const Vec3f from(0, -6, 2), to(4 * unit(random), 4, 2e-7f * unit(random));
    Ray ray{from, glm::normalize(to - from), INFINITE, 0};
    int count = 0;
    for (Hit hit; count < 8 && scene->intersectPosition(ray, hit); ++count) ray = rayBehind(ray, hit);
    ASSERT_LE(count, 3) << i; // one of them may be hit twice, by rounding
  }
}
