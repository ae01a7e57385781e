/** @file
 * Dispersive glass: prisms and drops by their angles of deviation, and white light whose colours add up to
 * white.
 */
#include "classRendering.h"

#include "recurse/model/bsdf/dispersion.h"
#include "recurse/model/bsdf/scatteringPoint.h"
#include "recurse/scene/parameters/spectrum.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

double degrees(double radians) { return radians * 180 / M_PI; }

/** Angle of deviation of a ray of a wavelength after refraction into a solid, `mirrors` internal reflections,
 * and refraction out of it [degrees]; negative if it misses the solid. */
double deviation(const Scene& scene, Ray ray, float wavelength, int mirrors) {
  const Vec3f before = ray.direction;
  double turned = 0;
  BsdfArena arena;
  for (int i = 0; i < mirrors + 2; ++i) {
    Hit hit;
    if (!scene.intersect(ray, hit)) return -1;
    hit.point.wavelength = wavelength;
    hit.point.isWhite = false;
    arena.reset();
    const ScatteringPoint scattering(*hit.material->bsdfAt(hit.point, arena), hit.point);
    const bool inside = i > 0 && i <= mirrors;
    const auto s = inside ? scattering.specularReflectionBackwardScatter(-ray.direction)
                          : scattering.specularRefractionBackwardScatter(-ray.direction);
    if (!s) return -1;
    turned += std::acos(std::clamp(double(glm::dot(ray.direction, s->direction)), -1.0, 1.0));
    ray = {hit.point.rayOrigin(s->direction), s->direction, INFINITE};
  }
  return mirrors > 0 ? degrees(turned) : degrees(std::acos(double(glm::dot(before, ray.direction))));
}

std::unique_ptr<Scene> glassBallUnderWhiteSky(int size, double fieldOfView) {
  return sceneFrom(view(size, "0 0 4  0 0 0  0 1 0", fieldOfView) + R"(
LightSource "infinite" "rgb L" [ 1 1 1 ]
Material "dielectric" "spectrum eta" "glass-F11"
Shape "sphere"
)");
}

} // namespace

TEST(Dispersion, ColoursOfWavelengthsAddUpToWhite) {
  constexpr int N = 100000;
  Rgbd sum(0);
  for (int i = 0; i < N; ++i)
    sum += Rgbd(wavelengthColour(sampleWavelength((static_cast<float>(i) + 0.5f) / N))) / double(N);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], 1, 1e-3);
  // Red has long wavelengths, blue short ones.
  const Rgb red = wavelengthColour(620), green = wavelengthColour(540), blue = wavelengthColour(450);
  EXPECT_GT(red.r, 5 * red.b);
  EXPECT_GT(green.g, 2 * std::max(green.r, green.b));
  EXPECT_GT(blue.b, 5 * std::max(blue.r, blue.g));
}

TEST(Dispersion, IndicesOfGlasses) {
  // Schott's data sheets at the lines F, d and C, and water at 20 °C.
  const DispersiveIndex bk7(*indexOfNamedGlass("glass-BK7")), flint(*indexOfNamedGlass("glass-F11"));
  EXPECT_NEAR(bk7.at(486.13f), 1.52238, 2e-5);
  EXPECT_NEAR(bk7.at(587.56f), 1.51680, 2e-5);
  EXPECT_NEAR(bk7.at(656.27f), 1.51432, 2e-5);
  EXPECT_NEAR(flint.at(587.56f), 1.78472, 2e-5);
  EXPECT_NEAR(DispersiveIndex(*indexOfNamedGlass("water")).at(587.56f), 1.3334, 1e-4);
  const DispersiveIndex cauchy(cauchyIndex(1.5168, 64.17));
  EXPECT_NEAR(cauchy.at(587.56f), 1.5168, 1e-6);
  EXPECT_NEAR((double(cauchy.at(587.56f)) - 1) / double(cauchy.at(486.13f) - cauchy.at(656.27f)), 64.17, 0.1);
  EXPECT_TRUE(DispersiveIndex({{400, 700}, {1.5, 1.5}}).isConstant());
}

/** At the angle of minimum deviation δ of a prism of angle A, n sin(A/2) = sin((A + δ)/2). */
TEST(Dispersion, PrismTurnsLightByItsIndex) {
  const auto scene = sceneFrom(view(4, "0 0 9  0 0 0  0 1 0", 30) + R"(
Material "dielectric" "spectrum eta" "glass-F11"
Shape "trianglemesh" "integer indices" [0 1 2 3 5 4 0 3 4 0 4 1 1 4 5 1 5 2 2 5 3 2 3 0]
  "point3 P" [-1 0 1  1 0 1  0 1.7320508 1  -1 0 -1  1 0 -1  0 1.7320508 -1]
)");
  for (const float wavelength : {420.0f, 550.0f, 680.0f}) {
    double least = 180;
    for (int i = 0; i < 2000; ++i) {
      const float angle = static_cast<float>(i) / 2000 * PI / 2;
      const Vec3f direction(std::cos(angle), std::sin(angle), 0), target(-0.5f, 0.8660254f, 0.1f);
      const double d = deviation(*scene, {target - direction * 5.0f, direction, INFINITE}, wavelength, 0);
      if (d > 0) least = std::min(least, d);
    }
    const double n = double(DispersiveIndex(*indexOfNamedGlass("glass-F11")).at(wavelength));
    EXPECT_NEAR(least, degrees(2 * std::asin(n / 2)) - 60, 0.01) << wavelength;
  }
}

TEST(Dispersion, RainbowsOfADropStandAt42And51Degrees) {
  const auto scene = sceneFrom(view(4, "0 0 9  0 0 0  0 1 0", 30) +
                               "Material \"dielectric\" \"spectrum eta\" \"water\"\nShape \"sphere\"\n");
  const auto bow = [&](int mirrors, float wavelength) {
    double least = 1e9;
    for (int i = 1; i < 4000; ++i) {
      const double d = deviation(*scene, {{-3, static_cast<float>(i) / 4000, 0}, {1, 0, 0}, INFINITE},
                                 wavelength, mirrors);
      if (d > 0) least = std::min(least, d);
    }
    return mirrors == 1 ? 180 - least : least - 180;
  };
  EXPECT_NEAR(bow(1, 650), 42, 0.5);
  EXPECT_NEAR(bow(2, 650), 51, 0.5);
  // Red is outside in the primary rainbow and inside in the secondary one.
  EXPECT_NEAR(bow(1, 650) - bow(1, 400), 1.9, 0.3);
  EXPECT_NEAR(bow(2, 400) - bow(2, 650), 3.3, 0.5);
}

/** In white surroundings glass without absorption is invisible in every colour. */
TEST(Dispersion, WhiteLightThroughGlassStaysWhiteAsAWhole) {
  const ThreadPool pool;
  const auto scene = glassBallUnderWhiteSky(8, 18);
  const auto check = [&](const char* integrator, int samplesPerPixel, double bound) {
    const bool oneMap = integrator == std::string("photonmap"); // no surface can store photons
    const Rendered r =
        renderScene(*scene, integrator, oneMap ? "\"integer passes\" 1" : "", samples(samplesPerPixel));
    Rgbd sum(0);
    for (size_t p = 0; p < r.pixels(); ++p) sum += Rgbd(r.value(p)) / double(r.pixels());
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], 1, (SANITIZED ? 8 : 1) * bound) << integrator;
  };
  check("path", 16384, 0.005); // bound of four standard errors
  for (const char* integrator : {"simplepath", "photonmap", "whitted", "bdpt", "vcm"})
    check(integrator, 256, 0.04);
}

/** The wavelengths of a pixel's samples are stratified over the spectrum. */
TEST(Dispersion, WavelengthsOfAPixelAreStratified) {
  constexpr int N = 64, COLOURS = 10000;
  const ThreadPool pool;
  const auto scene = glassBallUnderWhiteSky(16, 8);
  double independent = 0; // squared error for N wavelengths, sum of the three colours
  for (int i = 0; i < COLOURS; ++i) {
    const Rgb e = wavelengthColour(sampleWavelength((static_cast<float>(i) + 0.5f) / COLOURS)) - Rgb(1);
    independent += double(e.r * e.r + e.g * e.g + e.b * e.b) / COLOURS / N;
  }
  const Rendered r = renderScene(*scene, "path", "", N);
  double error = 0;
  for (size_t p = 0; p < r.pixels(); ++p) {
    const Rgb e = r.value(p) - Rgb(1);
    error += double(e.r * e.r + e.g * e.g + e.b * e.b) / double(r.pixels());
  }
  EXPECT_LT(error, 0.5 * independent);
}

/** Camera paths and photons agree on dispersion: in a prism on the camera's side, and in caustics. */
TEST(Dispersion, EyePathsAndPhotonsAgree) {
  const ThreadPool pool;
  const auto scene = sceneFrom(view(24, "0 -2.5 1.6  0 .3 .2  0 0 1", 45) + R"(
Material "diffuse" "rgb reflectance" [ .7 .7 .7 ]
Shape "trianglemesh" "integer indices" [ 0 1 2  0 2 3 ] "point3 P" [ -2 -2 0  2 -2 0  2 2 0  -2 2 0 ]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [ 9 9 9 ]
Translate .9 0 2
Shape "sphere" "float radius" .4
AttributeEnd
Material "dielectric" "spectrum eta" "glass-F11"
Translate 0 0 .5
Shape "sphere" "float radius" .4
)");
  const PathClasses classes({{"caustic", "LS+DE"}, {"through", "LDS+E"}, {"lamps", "LS+E"}});
  const BatchMeans truth = classMeans(*scene, {"path", ""}, classes, samples(128), 12);
  for (const Way& way :
       {Way{"simplepath", ""},
        Way{"photonmap", "\"integer passes\" 1 \"integer photons\" " + std::to_string(samples(100000))},
        Way{"lightpath", ""}}) {
    const BatchMeans means = classMeans(*scene, way, classes, samples(48), 12);
    for (size_t i = 0; i < (way.integrator == "lightpath" ? 3u : 9u); ++i) {
      const double error = std::hypot(means.standardError(i), truth.standardError(i));
      EXPECT_NEAR(means.mean(i), truth.mean(i), 5 * error + 0.02 * std::abs(truth.mean(i)))
          << way.integrator << " " << classes.classes()[i / 3].name << " colour " << i % 3;
      EXPECT_LT(error, (SANITIZED ? 0.6 : 0.2) * truth.mean(i)) << way.integrator << " " << i;
    }
  }
}

TEST(Dispersion, OnlyWhereItIsAskedFor) {
  const auto lobes = [](const std::string& parameters) {
    return sceneFrom(view(4, "0 0 4  0 0 0  0 1 0", 30) + "Material \"dielectric\" " + parameters +
                     "\nShape \"sphere\"\n")
               ->contents()
               .lobes &
           DISPERSIVE;
  };
  EXPECT_EQ(lobes("\"float eta\" 1.5"), 0);
  EXPECT_EQ(lobes("\"spectrum eta\" \"glass-BK7\" \"bool dispersion\" false"), 0);
  EXPECT_EQ(lobes("\"spectrum eta\" [ 400 1.5 700 1.5 ]"), 0);
  EXPECT_NE(lobes("\"spectrum eta\" [ 400 1.6 700 1.5 ]"), 0);
  EXPECT_NE(lobes("\"spectrum eta\" \"glass-BK7\""), 0);
  EXPECT_NE(lobes("\"float eta\" 1.6 \"float abbe\" 30"), 0);
}
