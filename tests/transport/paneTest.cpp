/** @file
 * Shadow rays that cross thin panes: direct light agrees with all other estimators and with Fresnel's
 * formulas.
 */
#include "classRendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

constexpr double COSINE = 0.8; ///< cosine between the sun's direction and the normals of floor and panes

/** Transmittance of a pane of index 1.5 for unpolarised light, including all internal reflections. */
double transmitted(double cosine) {
  const double eta = 1.5, inside = std::sqrt(1 - (1 - cosine * cosine) / (eta * eta));
  const double s = (cosine - eta * inside) / (cosine + eta * inside),
               p = (eta * cosine - inside) / (eta * cosine + inside);
  const double r = (s * s + p * p) / 2;
  return 1 - 2 * r / (1 + r);
}

/** A floor of reflectance 1/2 below `panes` panes, in the sun of irradiance π perpendicular to its direction;
 * the camera is below the panes. */
std::string sunnyFloor(int panes) {
  std::string text = R"(
Film "rgb" "integer xresolution" 6 "integer yresolution" 6
PixelFilter "box"
LookAt 0 1 0  0 0 0  0 0 1
Camera "perspective" "float fov" 40
WorldBegin
LightSource "distant" "point3 from" [ .6 .8 0 ] "point3 to" [ 0 0 0 ] "rgb L" [ 3.14159265 3.14159265 3.14159265 ]
Material "diffuse" "rgb reflectance" [ .5 .5 .5 ]
Shape "bilinearmesh" "point3 P" [ -2 0 -2  2 0 -2  -2 0 2  2 0 2 ]
Material "thindielectric" "float eta" 1.5
)";
  for (int i = 0; i < panes; ++i) {
    const std::string y = " " + std::to_string(2 + i) + " ";
    text +=
        "Shape \"bilinearmesh\" \"point3 P\" [ -9" + y + "-9  9" + y + "-9  -9" + y + "9  9" + y + "9 ]\n";
  }
  return text;
}

/** A white ball in a dome of thin glass, in light of radiance 1 from all directions: without absorption the
 * radiance is 1 everywhere. */
std::string furnaceUnderGlass(const std::string& light) {
  return R"(
Film "rgb" "integer xresolution" 8 "integer yresolution" 8
PixelFilter "box"
LookAt 0 0 -2  0 0 0  0 1 0
Camera "perspective" "float fov" 60
WorldBegin
)" + light +
         R"(
Material "thindielectric" "float eta" 1.5
Shape "sphere" "float radius" 3
Material "diffuse" "rgb reflectance" [ 1 1 1 ]
Shape "sphere" "float radius" .7
)";
}

/** All ways that estimate direct light by shadow rays, and some with more shadow rays. */
std::vector<Way> waysWithShadowRays() {
  std::vector<Way> ways = allWays("80000");
  std::erase_if(ways, [](const Way& w) { return w.parameters.find("direct") != std::string::npos; });
  ways.insert(ways.end(),
              {{"path", "\"integer lightsamples\" 3"},
               {"photonmap", "\"integer photons\" 80000 \"integer passes\" 1 \"integer lightsamples\" 2"}});
  return ways;
}

bool splats(const Way& way) { return integratorFrom(way.integrator, way.parameters)->splats(); }

/** Relative tolerance for the light of the sun; splats of light paths have noise. */
double tolerance(const Way& way) { return splats(way) ? 5e-3 : 1e-3; }

} // namespace

TEST(Panes, SunThroughThemIsAsFresnelSays) {
  for (const int panes : {0, 1, 2}) {
    const auto scene = sceneFrom(sunnyFloor(panes));
    ASSERT_TRUE(scene);
    const double expected = 0.5 * COSINE * std::pow(transmitted(COSINE), panes);
    // Depth limit equal to the number of events of direct light: no other light is in the picture.
    const std::string depth = " \"integer maxdepth\" " + std::to_string(panes + 1);
    for (const Way& way : dealt(waysWithShadowRays(), size_t(panes))) {
      const auto& [name, parameters] = way;
      const Rendered r = renderScene(*scene, name, parameters + depth, splats(way) ? 64 : samples(64));
      EXPECT_NEAR(r.mean(), expected, tolerance(way) * expected)
          << panes << " panes, " << name << " " << parameters;
      if (panes == 0) continue;
      const std::string less = " \"integer maxdepth\" " + std::to_string(panes);
      EXPECT_EQ(renderScene(*scene, name, parameters + less, 4).mean(), 0) << panes << " panes, " << name;
    }
  }
}

TEST(Panes, AreEventsOfThePathsClass) {
  const auto scene = sceneFrom(sunnyFloor(2));
  ASSERT_TRUE(scene);
  const PathClasses classes({{"none", "LDE"}, {"one", "LSDE"}, {"two", "LSSDE"}});
  const double expected = 0.5 * COSINE * square(transmitted(COSINE));
  for (const Way& way : dealt(waysWithShadowRays(), 0)) {
    const Rendered r =
        renderClasses(*scene, {way.integrator, way.parameters + " \"integer maxdepth\" 3"}, classes, 16, 1);
    for (size_t layer = 0; layer < 3; ++layer)
      EXPECT_NEAR(r.mean(layer), layer == 2 ? expected : 0,
                  layer == 2 ? std::max(1e-3, tolerance(way) * expected) : 0)
          << way.integrator << " " << way.parameters;
  }
  const Rendered alone =
      renderClasses(*scene, {"path", ""}, PathClasses(std::vector<PathClass>{{"two", "LSSDE"}}), 16, 1);
  EXPECT_NEAR(alone.layerMeans()[0], expected, 1e-3);
}

/** A small lamp outside of the view, floor and wall behind one pane, and a second pane in front of the
 * camera. Without shadow rays through panes only rare hits of the lamp find light of LSDSE. */
TEST(Panes, ASmallLampBehindThemMakesNoBrightPixels) {
  const auto scene = sceneFrom(view(16, "0 1.2 -3.5  0 .4 0  0 1 0", 40) + R"(
AttributeBegin
Translate 0 2.6 1
AreaLightSource "diffuse" "rgb L" [ 4000 4000 4000 ]
Shape "sphere" "float radius" .01
AttributeEnd
Material "thindielectric"
Shape "bilinearmesh" "point3 P" [ -2 0 -2.5  2 0 -2.5  -2 2 -2.5  2 2 -2.5 ]
Shape "bilinearmesh" "point3 P" [ -2 2 -3  2 2 -3  -2 2 2  2 2 2 ]
Material "diffuse" "rgb reflectance" [ .6 .5 .4 ]
Shape "bilinearmesh" "point3 P" [ -2 0 -3  2 0 -3  -2 0 2  2 0 2 ]
Shape "bilinearmesh" "point3 P" [ -2 0 2  2 0 2  -2 3 2  2 3 2 ]
)");
  const PathClasses classes({{"direct", "LSDSE"}, {"two", "LSDDSE"}});
  const Rendered seen = renderClasses(*scene, {"path", ""}, classes, samples(128), 1);
  const BatchMeans truth = classMeans(*scene, {"path", ""}, classes, samples(64), 6);
  for (const char* name : {"bdpt", "vcm"}) {
    const Rendered r = renderClasses(*scene, {name, ""}, classes, samples(64), 1);
    const BatchMeans means = classMeans(*scene, {name, ""}, classes, samples(64), 6);
    for (size_t layer = 0; layer < classes.layerCount(); ++layer) {
      const size_t i = 3 * layer;
      const double error = std::hypot(means.standardError(i), truth.standardError(i));
      EXPECT_NEAR(means.mean(i), truth.mean(i), 4.5 * error) << name << " " << layer;
      EXPECT_LT(error, (SANITIZED ? 0.05 : 0.02) * truth.mean(i)) << name << " " << layer;
      double brightest = 0, most = 0;
      for (size_t p = 0; p < r.pixels(); ++p) {
        brightest = std::max(brightest, r.luminanceAt(p, layer));
        most = std::max(most, seen.luminanceAt(p, layer));
      }
      EXPECT_LT(brightest, 2 * most) << name << " " << layer;
    }
  }
}

TEST(Panes, ShadowRaysAndOtherRaysShareTheLightBehindThem) {
  const std::string sky = "LightSource \"infinite\" \"rgb L\" [ 1 1 1 ]\n",
                    lamp = "AttributeBegin\nMaterial \"interface\"\nReverseOrientation\n"
                           "AreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ]\n"
                           "Shape \"sphere\" \"float radius\" 4\nAttributeEnd\n";
  // Rays to the outer lamp pass the inner one, whose material has a name.
  const auto shell = [](const std::string& material, const std::string& radius, const std::string& radiance) {
    return "AttributeBegin\n" + material + "\nReverseOrientation\nAreaLightSource \"diffuse\" \"rgb L\" [ " +
           radiance + " " + radiance + " " + radiance + " ]\nShape \"sphere\" \"float radius\" " + radius +
           "\nAttributeEnd\n";
  };
  const std::string lamps = "MakeNamedMaterial \"air\" \"string type\" \"interface\"\n" +
                            shell("NamedMaterial \"air\"", "4", ".25") +
                            shell("Material \"interface\"", "5", ".75");
  size_t scenes = 0;
  for (const std::string& light : {sky, lamp, lamps}) {
    const auto scene = sceneFrom(furnaceUnderGlass(light));
    ASSERT_TRUE(scene);
    for (const auto& [name, parameters] : dealt(waysWithShadowRays(), scenes++)) {
      const Rendered r = renderScene(*scene, name, parameters, samples(256));
      EXPECT_NEAR(r.mean(), 1, 5 * std::min(r.standardError(), 4e-3)) << name << " " << parameters << "\n"
                                                                      << light;
    }
  }
}

/** Without shadow rays photons carry the same light through the pane. */
TEST(Panes, PhotonsBringTheSameLight) {
  const auto scene = sceneFrom(sunnyFloor(1));
  ASSERT_TRUE(scene);
  const PathClasses classes(std::vector<PathClass>{{"straight", "LSDE"}});
  const auto mean = [&](const char* name, const char* parameters) {
    return renderClasses(*scene, {name, parameters}, classes, 16, 1).layerMeans()[0];
  };
  const double shadowRays = mean("path", ""),
               photons =
                   mean("photonmap",
                        "\"integer photons\" 200000 \"integer passes\" 1 \"string direct\" \"photons\"");
  EXPECT_NEAR(photons, shadowRays, 0.05 * shadowRays);
}

/** A point lamp above a pane in fog: every path through the pane, on the floor and in the fog. */
TEST(Panes, LightComesThroughThemIntoFog) {
  const auto scene = sceneFrom(R"(
Film "rgb" "integer xresolution" 8 "integer yresolution" 8
PixelFilter "box"
LookAt 0 .3 -2  0 .2 0  0 1 0
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_s" [ .3 .2 .1 ] "rgb sigma_a" [ .05 .05 .05 ]
MediumInterface "" "fog"
Camera "perspective" "float fov" 60
WorldBegin
MediumInterface "fog" "fog"
LightSource "point" "point3 from" [ 0 3 0 ] "rgb I" [ 10 10 10 ]
Material "thindielectric" "float eta" 1.5
Shape "bilinearmesh" "point3 P" [ -9 1 -9  9 1 -9  -9 1 9  9 1 9 ]
Material "diffuse" "rgb reflectance" [ .5 .5 .5 ]
Shape "bilinearmesh" "point3 P" [ -9 0 -9  9 0 -9  -9 0 9  9 0 9 ]
)");
  ASSERT_TRUE(scene);
  const PathClasses classes({{"fog", "LSVE"}, {"floor", "LSDE"}, {"further", "LS(D|V)(D|V)E"}});
  const std::vector<double> truth =
      renderClasses(*scene, {"path", "\"integer maxdepth\" 4"}, classes, samples(2048), 1).layerMeans();
  const std::vector<double> photons =
      renderClasses(*scene,
                    {"photonmap", "\"integer passes\" 0 \"integer photons\" 10000 \"integer maxdepth\" 4"},
                    classes, samples(512), 2)
          .layerMeans();
  for (const size_t i : {0u, 3u, 6u}) EXPECT_NEAR(photons[i], truth[i], 0.03 * truth[i]) << i / 3;
}

/** A small lamp above a floor, with `between` close below the lamp. */
std::string lampOverFloor(const std::string& between) {
  return R"(
Film "rgb" "integer xresolution" 12 "integer yresolution" 9
PixelFilter "box"
LookAt 0 -5 1.5  0 0 .5  0 0 1
Camera "perspective" "float fov" 45
MakeNamedMedium "vacuum" "string type" "homogeneous" "rgb sigma_a" [ 0 0 0 ] "rgb sigma_s" [ 0 0 0 ]
WorldBegin
Material "diffuse" "rgb reflectance" [ .7 .7 .7 ]
Shape "bilinearmesh" "point3 P" [ -4 -4 0  4 -4 0  -4 4 0  4 4 0 ]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 40 36 30 ]
Material "diffuse" "rgb reflectance" [ 0 0 0 ]
Translate 0 0 1.95
Rotate 180 1 0 0
Shape "disk" "float radius" .1
AttributeEnd
)" + between;
}

// The position error of a wide pane is larger than that of a small lamp behind it.
TEST(Panes, DoNotMakeShadowRaysHitTheLamp) {
  const auto meanOf = [](const std::string& between, const char* name) {
    const auto scene = sceneFrom(lampOverFloor(between));
    const bool hasMap = std::string(name) == "photonmap";
    return renderScene(*scene, name, hasMap ? "\"integer passes\" 1 \"integer photons\" 1000" : "", 64)
        .mean();
  };
  const double alone = meanOf("", "path");
  const std::string pane = "Material \"thindielectric\" \"float eta\" 1.0001\nRotate 10 1 0 0\n"
                           "Shape \"trianglemesh\" \"point3 P\" [ -30 -30 1.9  30 -30 1.9  0 30 1.9 ] "
                           "\"integer indices\" [ 0 1 2 ]\n",
                    box = "MediumInterface \"vacuum\" \"\"\nMaterial \"interface\"\n"
                          "Shape \"box\" \"point3 p1\" [ -30 -30 .5 ] \"point3 p2\" [ 30 30 1.9 ]\n";
  for (const char* name : {"path", "simplepath", "photonmap", "bdpt", "vcm"}) {
    EXPECT_NEAR(meanOf(pane, name), alone, .01 * alone) << name;
    if (name[0] != 'b' && name[0] != 'v') {
      EXPECT_NEAR(meanOf(box, name), alone, .01 * alone) << name;
    }
  }
}

// Near a coordinate of zero, the rounding of a distance is larger than the position error of a pane.
TEST(Panes, NearACoordinateOfZeroArePassedOnce) {
  const auto meanAt = [](const std::string& height) {
    return renderText(view(16, "0 -5 -.3  0 0 -1  0 0 1", 30) + R"(
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 10 10 10 ]
Translate 0 0 2
Shape "sphere" "float radius" .4
AttributeEnd
Material "diffuse" "rgb reflectance" [ .5 .5 .5 ]
Shape "bilinearmesh" "point3 P" [ -4 -4 -1  4 -4 -1  -4 4 -1  4 4 -1 ]
Material "thindielectric"
Translate 0 0 )" + height +
                          R"(
Shape "trianglemesh" "point3 P" [ -4 -4 0  4 -4 0  4 4 0  -4 4 0 ] "integer indices" [ 0 1 2 0 2 3 ]
)",
                      "path", "", SANITIZED ? 64 : 256)
        .mean();
  };
  const double further = meanAt(".1");
  for (const char* height : {".0013", "-.0013", "0"})
    EXPECT_NEAR(meanAt(height), further, .005 * further) << height;
}
