/** @file
 * Integrators against closed forms, against each other, and against the independent reference pictures.
 */
#include "kernelTesting.h"
#include "rendering.h"

#include <filesystem>
#include <random>
#include <sstream>

#include "recurse/core/image/image.h"
#include "recurse/pathclasses/pathExpression.h"
#include "transport/density/gather.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

/** The inside of an emitting sphere, seen from its centre. */
std::string furnace(const std::string& material, double emitted) {
  return view(32, "0 0 0  0 0 1  0 1 0", 140) + material +
         "\nReverseOrientation\nAreaLightSource \"diffuse\" \"rgb L\" [" + number(emitted) + " " +
         number(emitted) + " " + number(emitted) + "]\nShape \"sphere\" \"float radius\" 1\n";
}

constexpr const char* PHOTONS = SANITIZED ? "50000" : "200000";

/** Whether paths from both ends are connected. */
bool connects(const Way& way) { return integratorFrom(way.integrator, way.parameters)->splats(); }

/** Number of samples: photons and connections leave little noise to camera paths. */
int furnaceSamples(const Way& way) { return samples(readsPhotons(way) || connects(way) ? 4 : 128); }

/** A floor of reflectance 0.5 that fills the view, with its light somewhere above. */
std::string floorUnder(const std::string& light) {
  return view(8, "0 0 1  0 0 0  0 1 0", 12) +
         "Material \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\n"
         "Shape \"trianglemesh\" \"point3 P\" [-.6 -.6 0  .6 -.6 0  .6 .6 0  -.6 .6 0] \"integer indices\" "
         "[0 1 2 0 "
         "2 3]\n" +
         light;
}

} // namespace

TEST(Furnace, EveryIntegratorAndDiffuseAlbedo) {
  size_t scenes = 0;
  for (const double albedo : {0.1, 0.5, 0.9}) {
    const auto scene = sceneFrom(furnace("Material \"diffuse\" \"rgb reflectance\" [" + number(albedo) + " " +
                                             number(albedo) + " " + number(albedo) + "]",
                                         1 - albedo));
    for (const Way& way : dealt(albedo == 0.5 ? allWays(PHOTONS) : quickWays(PHOTONS), scenes++)) {
      const Rendered r = renderScene(*scene, way.integrator, way.parameters, furnaceSamples(way));
      EXPECT_NEAR(r.mean(), 1, (SANITIZED ? 0.02 : 0.005) + (connects(way) ? 4 * r.standardError() : 0))
          << way.integrator << " " << way.parameters << " albedo " << albedo << " error "
          << r.standardError();
    }
  }
}

TEST(Furnace, MirrorsAndMixes) {
  // Every reflection of a ray from the centre is at normal incidence, where a conductor's reflectance is the
  // parameter.
  struct Case {
    std::string material;
    double albedo;
  };
  const std::vector<Case> cases = {
      {"Material \"conductor\" \"rgb reflectance\" [.1 .1 .1]", 0.1},
      {"Material \"conductor\" \"rgb reflectance\" [.9 .9 .9]", 0.9},
      {"MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [.2 .2 .2]\n"
       "MakeNamedMaterial \"b\" \"string type\" \"diffuse\" \"rgb reflectance\" [.8 .8 .8]\n"
       "Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" .25",
       0.35},
      // A conductor with reflectance 0.9999 at normal incidence reflects at least this fraction at every
      // angle.
      {"MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\n"
       "MakeNamedMaterial \"b\" \"string type\" \"conductor\" \"rgb reflectance\" [.9999 .9999 .9999]\n"
       "Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" .4",
       0.7}};
  size_t scenes = 0;
  for (const Case& c : cases) {
    const auto scene = sceneFrom(furnace(c.material, 1 - c.albedo));
    for (const Way& way : dealt(quickWays(PHOTONS), scenes++)) {
      const Rendered r = renderScene(*scene, way.integrator, way.parameters, furnaceSamples(way));
      EXPECT_NEAR(r.mean(), 1, (SANITIZED ? 0.015 : 0.004) + 3 * r.standardError())
          << way.integrator << " " << way.parameters << "\n"
          << c.material;
    }
  }
}

TEST(Furnace, GlassInUniformLightIsInvisible) {
  size_t scenes = 0;
  for (const char* material : {"\"dielectric\" \"float eta\" 1.5", "\"dielectric\" \"float eta\" .7",
                               "\"dielectric\" \"float eta\" 1", "\"thindielectric\" \"float eta\" 1.8",
                               "\"dielectric\" \"float eta\" 2.4"}) {
    const auto scene = sceneFrom(view(16, "0 0 3  0 0 0  0 1 0", 45) +
                                 "LightSource \"infinite\" \"rgb L\" [1 1 1]\nMaterial " + material +
                                 "\nShape \"sphere\" \"float radius\" 1");
    for (const Way& way : dealt(allWays("1000"), scenes++)) {
      const Rendered r = renderScene(*scene, way.integrator, way.parameters, samples(64));
      EXPECT_NEAR(r.mean(), 1, 0.005) << way.integrator << " " << material;
    }
  }
}

TEST(DirectLight, IrradianceInClosedForm) {
  struct Case {
    std::string light;
    double irradiance; ///< irradiance at the origin
  };
  const double disk = 0.3, height = 1.5; // E = π L r² / (r² + h²) under the centre of a parallel disc
  const std::vector<Case> cases = {
      {"LightSource \"point\" \"point3 from\" [0 0 2] \"rgb I\" [8 8 8]", 8.0 / 4},
      {"LightSource \"point\" \"point3 from\" [0 0 2] \"float power\" 100", 100 / (4 * M_PI) / 4},
      {"LightSource \"spot\" \"point3 from\" [0 0 2] \"point3 to\" [0 0 0] \"rgb I\" [8 8 8] \"float "
       "coneangle\" "
       "40",
       8.0 / 4},
      {"LightSource \"distant\" \"point3 from\" [0 1 1] \"point3 to\" [0 0 0] \"rgb L\" [3 3 3]",
       3 * std::sqrt(0.5)},
      {"LightSource \"infinite\" \"rgb L\" [2 2 2]", 2 * M_PI},
      {"AreaLightSource \"diffuse\" \"rgb L\" [5 5 5]\nTranslate 0 0 1.5\nReverseOrientation Shape \"disk\" "
       "\"float radius\" .3",
       M_PI * 5 * disk * disk / (disk * disk + height * height)},
      {"AreaLightSource \"diffuse\" \"float power\" 7 \"bool twosided\" true\nTranslate 0 0 1.5\nShape "
       "\"disk\" \"float radius\" .3",
       7 / (2 * M_PI * M_PI * disk * disk) * M_PI * disk * disk / (disk * disk + height * height)},
      {"AreaLightSource \"diffuse\" \"rgb L\" [5 5 5]\nTranslate 0 0 1.5\nShape \"sphere\" \"float radius\" "
       ".3",
       M_PI * 5 * disk * disk / (height * height)},
      // Under the centre of a parallel disc with radiance L cosⁿ: 2π L / (n + 2) (1 - (h² / (r² + h²))^(n/2 +
      // 1))
      {"AreaLightSource \"diffuse\" \"rgb L\" [5 5 5] \"float exponent\" 4\nTranslate 0 0 3\n"
       "ReverseOrientation Shape \"disk\" \"float radius\" .6",
       2 * M_PI * 5 / 6 * (1 - std::pow(9 / 9.36, 3))}};
  size_t scenes = 0;
  for (const Case& c : cases) {
    const auto scene = sceneFrom(floorUnder("Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n" + c.light));
    for (const Way& way : dealt(quickWays(SANITIZED ? "100000" : "200000"), scenes++)) {
      // The disc of the photon search must be inside of the region of uniform light.
      const std::string more = readsPhotons(way) ? " \"float radius\" .1" : "";
      const Rendered r = renderScene(*scene, way.integrator, way.parameters + more, samples(64));
      const double expected = 0.5 * c.irradiance / M_PI;
      EXPECT_NEAR(r.mean(), expected, (readsPhotons(way) ? 0.05 : 0.01) * expected)
          << way.integrator << " " << way.parameters << "\n"
          << c.light;
    }
  }
}

TEST(Gather, UniformIrradianceIsEstimatedWithoutBias) {
  // Photons at random points of a plane, with flux for an irradiance of 3, over many maps.
  const double irradiance = 3, side = 2;
  const int photons = 2000, maps = SANITIZED ? 100 : 400;
  Diagnostics diagnostics;
  class NoTextures final : public TextureLookup {
    TexturedRgb rgb(const Parameters& p, const std::string& n) const override {
      return {Rgb(p.spectrum(n)), nullptr};
    }
    TexturedRgb real(const Parameters&, const std::string&) const override { return {}; }
  } textures;
  const auto material =
      plugIns().materials.make(parseParameterText("diffuse", ""), MaterialContext{textures, {}}, diagnostics);
  SurfacePoint point{};
  point.geometricNormal = point.shadingNormal = {0, 0, 1};
  BsdfArena arena;
  const ScatteringPoint scattering(*material->bsdfAt(point, arena), point);
  const PathClasses classes;
  const double expected = 0.5 * irradiance / M_PI;
  for (const Kernel kernel : ALL_KERNELS)
    for (const auto& [nearest, radius] :
         std::vector<std::pair<int, float>>{{0, 0.2f}, {50, INFINITE}, {8, INFINITE}}) {
      std::vector<double> estimates;
      for (int m = 0; m < maps; ++m) {
        std::mt19937_64 random(static_cast<uint64_t>(m));
        std::uniform_real_distribution<float> place(float(-side / 2), float(side / 2));
        std::vector<Photon> list(static_cast<size_t>(photons));
        for (Photon& p : list) {
          p.position = {place(random), place(random), 0};
          p.direction = packDirection(glm::normalize(Vec3f(place(random), place(random), 1)));
          p.normal = packDirection({0, 0, 1});
          p.power = Rgb(static_cast<float>(irradiance * side * side / photons));
        }
        PhotonMap map;
        map.build(list);
        TransportCounts counts;
        PathRadiance out(classes, counts);
        GatherSettings settings;
        settings.kernel = kernel;
        settings.nearest = nearest;
        settings.radius = radius;
        gather(map, settings, scattering, point, {0, 0, 1}, 0, Rgb(1),
               classes.step(classes.cameraStart(), PathEvent::D), out);
        estimates.push_back(double(out.total().r));
      }
      const Mean mean(estimates);
      EXPECT_NEAR(mean.value, expected, 4 * mean.error) << kernelName(kernel) << " nearest " << nearest;
      EXPECT_LT(mean.error, 0.06 * expected);
    }
}

TEST(Gather, FewOfManyPhotonsAreUnbiased) {
  const auto scene = sceneFrom(R"(
    Camera "perspective"
    WorldBegin
    Material "coateddiffuse" "rgb reflectance" [ .5 .5 .5 ] "float roughness" .3
    Shape "disk" "float radius" 4)");
  Hit hit;
  ASSERT_TRUE(scene->intersect({Vec3f(0, 0, 1), Vec3f(0, 0, -1), INFINITE}, hit));
  std::mt19937 random(1);
  std::uniform_real_distribution<float> coordinate(-.1f, .1f), slope(-1, 1);
  std::vector<Photon> photons(200);
  for (Photon& p : photons) {
    p.position = {coordinate(random), coordinate(random), 0};
    p.normal = packDirection({0, 0, 1});
    p.direction = packDirection(glm::normalize(Vec3f(slope(random), slope(random), 1)));
    p.power = Rgb(std::exp(3 * slope(random)));
  }
  PhotonMap map;
  map.build(photons);
  const PathClasses all;
  BsdfArena arena;
  const ScatteringPoint scattering(*hit.material->bsdfAt(hit.point, arena), hit.point);
  ASSERT_FALSE(scattering.lobes() & LAMBERTIAN);
  GatherSettings settings;
  settings.radius = .2f;
  TransportCounts counts;
  const auto gathered = [&](const Sampler* sampler) {
    PathRadiance out(all, counts);
    gather(map, settings, scattering, hit.point, glm::normalize(Vec3f(.5f, 0, 1)), 0, Rgb(1),
           all.step(all.cameraStart(), PathEvent::D), out, nullptr, sampler);
    return double(out.total().r);
  };
  const double exact = gathered(nullptr);
  EXPECT_EQ(counts.photonsScattered, photons.size());
  constexpr int TRIALS = 4000;
  double sum = 0, squares = 0;
  for (uint32_t i = 0; i < TRIALS; ++i) {
    counts = {};
    const Sampler sampler(1, i, 0);
    const double estimate = gathered(&sampler);
    sum += estimate / TRIALS;
    squares += estimate * estimate / TRIALS;
    ASSERT_LT(counts.photonsScattered, photons.size() / 4);
  }
  const double variance = squares - sum * sum;
  EXPECT_GT(variance, 0);
  EXPECT_NEAR(sum, exact, 4 * std::sqrt(variance / TRIALS));
}

TEST(Integrators, AgreeOnGlassAndMirror) {
  const auto scene = sceneFrom(glassAndMirrorBox(32));
  const Rendered truth = renderScene(*scene, "path", "", samples(1024));
  for (const Way& way : dealt(allWays(SANITIZED ? "100000" : "400000"), 0)) {
    if (way.integrator == "path") continue;
    const Rendered r = renderScene(*scene, way.integrator, way.parameters,
                                   16); // 16 for sanitizers too, because of the noise at the lamp's edges
    const double error = std::hypot(truth.standardError(), readsPhotons(way) ? 0 : r.standardError());
    EXPECT_NEAR(r.mean(), truth.mean(), 4 * error + 0.02 * truth.mean()) << way.integrator << way.parameters;
  }
}

TEST(Integrators, AgreeOnALampThatShinesAhead) {
  // The lamp illuminates the glass ball and the floor under it much more than the walls.
  std::string text = glassAndMirrorBox(32);
  const std::string radiance = "\"rgb L\" [ 25 25 25 ]";
  text.replace(text.find(radiance), radiance.size(), "\"rgb L\" [ 90 90 90 ] \"float exponent\" 6");
  const auto scene = sceneFrom(text);
  const Rendered truth = renderScene(*scene, "path", "", samples(1024));
  for (const Way& way : dealt(allWays(SANITIZED ? "100000" : "400000"), 1)) {
    if (way.integrator == "path") continue;
    const Rendered r = renderScene(*scene, way.integrator, way.parameters, 16);
    const double error = std::hypot(truth.standardError(), readsPhotons(way) ? 0 : r.standardError());
    EXPECT_NEAR(r.mean(), truth.mean(), 4 * error + 0.02 * truth.mean()) << way.integrator << way.parameters;
  }
}

TEST(Integrators, FinalGathersShareIrradiance) {
  const auto scene = sceneFrom(glassAndMirrorBox(32));
  for (const char* passes : {"1", "4"}) {
    const std::string parameters =
        "\"integer photons\" 50000 \"integer finalgather\" 16 \"integer passes\" " + std::string(passes) +
        " \"bool shareirradiance\" ";
    const Rendered own = renderScene(*scene, "photonmap", parameters + "false", 4);
    const Rendered shared = renderScene(*scene, "photonmap", parameters + "true", 4);
    // Photons and rays are the same; only the points at which irradiance is estimated differ.
    EXPECT_NEAR(shared.mean(), own.mean(), 0.005 * own.mean());
    EXPECT_NE(shared.mean(), own.mean());
    EXPECT_LT(3 * shared.statistics.counts.gathers, 2 * own.statistics.counts.gathers);
  }
}

TEST(Integrators, SameBitsForAnyNumberOfThreads) {
  const auto scene = sceneFrom(glassAndMirrorBox(SANITIZED ? 16 : 32));
  const std::string photons = std::to_string(samples(20000));
  std::vector<Way> ways = allWays(photons);
  ways.push_back({"path", "\"integer lightsamples\" 3"});
  ways.push_back({"photonmap", "\"integer passes\" 1 \"integer photons\" " + photons +
                                   " \"string photonindex\" \"flann\""});
  for (const Way& way : dealt(ways, 1)) {
    const Rendered one = renderScene(*scene, way.integrator, way.parameters, 3, 7, 1);
    for (const int threads : {2, 3}) {
      const Rendered several = renderScene(*scene, way.integrator, way.parameters, 3, 7, threads);
      for (size_t i = 0; i < one.pixels(); ++i)
        ASSERT_EQ(one.value(i), several.value(i)) << way.integrator << way.parameters << " pixel " << i;
      EXPECT_EQ(one.statistics.counts.rays, several.statistics.counts.rays);
    }
    const Rendered other = renderScene(*scene, way.integrator, way.parameters, 3, 8, 1);
    EXPECT_NE(one.mean(), other.mean());
  }
}

TEST(Integrators, CropIsAPartOfTheSamePicture) {
  const auto whole = sceneFrom(glassAndMirrorBox(32));
  std::string text = glassAndMirrorBox(32);
  text.insert(text.find("\nPixelFilter"), " \"integer pixelbounds\" [ 8 20 4 30 ]");
  const auto part = sceneFrom(text);
  for (const Way& way : dealt(allWays("1000"), 2)) {
    const Rendered a = renderScene(*whole, way.integrator, way.parameters, 2),
                   b = renderScene(*part, way.integrator, way.parameters, 2);
    ASSERT_EQ(b.pixels(), 12u * 26u);
    for (int y = 4; y < 30; ++y)
      for (int x = 8; x < 20; ++x)
        ASSERT_EQ(a.value(size_t(y * 32 + x)), b.value(size_t((y - 4) * 12 + (x - 8))))
            << way.integrator << " " << way.parameters << " pixel " << x << ", " << y;
  }
}

TEST(Integrators, DepthLimitCutsAndSaysHowMuch) {
  const auto scene = sceneFrom(furnace("Material \"diffuse\" \"rgb reflectance\" [.5 .5 .5]", 0.5));
  // LE + LDE + ... up to n events: 0.5 (1 + 0.5 + ... + 0.5ⁿ).
  for (int n = 0; n < 4; ++n) {
    const Rendered r = renderScene(*scene, "path", "\"integer maxdepth\" " + std::to_string(n), samples(8));
    EXPECT_NEAR(r.mean(), 1 - std::pow(0.5, n + 1), 0.01);
    EXPECT_GT(r.statistics.counts.truncatedThroughput, 0);
  }
  EXPECT_EQ(renderScene(*scene, "path", "", 1).statistics.counts.truncatedThroughput, 0);
  // Lost weight counts camera paths only: neither the flux of photons nor the flux of light subpaths is part
  // of the sum.
  for (const char* integrator : {"photonmap", "lightpath", "bdpt", "vcm"}) {
    const Rendered r = renderScene(*scene, integrator, "\"integer maxdepth\" 1", 1);
    EXPECT_LE(r.statistics.counts.truncatedThroughput, double(r.statistics.samples)) << integrator;
  }
}

TEST(Integrators, LightBetweenPerfectMirrorsEnds) {
  // Two parallel mirrors that reflect almost all light: walks are long, and end.
  const std::string text =
      view(4, "0 0 0  0 0 1  0 1 0", 20) +
      "Material \"conductor\" \"rgb reflectance\" [1 1 1]\nTranslate 0 0 1\nShape \"disk\" \"float radius\" "
      "100\n"
      "Translate 0 0 -2\nShape \"disk\" \"float radius\" 100\nLightSource \"infinite\" \"rgb L\" [1 1 1]";
  for (const Way& way : allWays("1000"))
    EXPECT_GE(renderText(text, way.integrator, way.parameters, 4).mean(), 0);
}

TEST(Integrators, EmptyAndDarkScenes) {
  for (const Way& way : allWays("100")) {
    EXPECT_EQ(renderText(view(4, "0 0 3  0 0 0  0 1 0", 40), way.integrator, way.parameters, 2).mean(), 0);
    EXPECT_EQ(
        renderText(view(4, "0 0 4  0 0 0  0 1 0", 40) + "Shape \"sphere\"", way.integrator, way.parameters, 2)
            .mean(),
        0); // without lights there is nothing to learn
    EXPECT_EQ(renderText(floorUnder(""), way.integrator, way.parameters, 2).mean(), 0);
    EXPECT_EQ(renderText(floorUnder("LightSource \"point\" \"rgb I\" [0 0 0] \"point3 from\" [0 0 1]"),
                         way.integrator, way.parameters, 2)
                  .mean(),
              0);
  }
}

TEST(Integrators, WarnOfFewPhotonsWhereTheyAreWanted) {
  const auto scene = sceneFrom(floorUnder("LightSource \"point\" \"rgb I\" [1 1 1] \"point3 from\" [0 0 1]"));
  const auto warns = [&](const std::string& paths) {
    const auto integrator = integratorFrom("photonmap", "");
    const PathClasses classes(std::vector<PathClass>{{"one", paths}});
    Film film(scene->film().crop, 1);
    RenderSettings settings;
    settings.samplesPerPixel = 1;
    const std::atomic<bool> stop{false};
    for (const std::string& w :
         render(*scene, *integrator, classes, settings, film, stop, nullptr, nullptr).warnings)
      if (w.find("no photon was stored: surfaces receive direct light only") != std::string::npos)
        return true;
    return false;
  };
  EXPECT_TRUE(warns("all")); // there is nothing to hit after the floor
  EXPECT_FALSE(warns("LDE"));
}

TEST(Integrators, InstancesLookLikeCopies) {
  const std::string shape = "Shape \"sphere\" \"float radius\" .3\nShape \"trianglemesh\" \"point3 P\" [-.5 "
                            "-.6 0 .5 -.6 0 0 -.4 .2] \"integer indices\" [0 1 2]\n";
  const std::string head =
      view(24, "0 0 3  0 0 0  0 1 0", 50) +
      "LightSource \"infinite\" \"rgb L\" [1 1 1]\nMaterial \"diffuse\" \"rgb reflectance\" [.6 .6 .6]\n";
  const std::string a = "Translate .5 0 0 Rotate 30 0 1 0 Scale 1 1.5 .5\n",
                    b = "Translate -.5 .2 0 Scale .8 .8 -.8\n";
  const auto lamp =
      std::string("AttributeBegin Translate 0 .8 0 AreaLightSource \"diffuse\" \"rgb L\" [9 9 9] "
                  "Shape \"sphere\" \"float radius\" .1 AttributeEnd\n");
  const Rendered copies = renderText(head + "AttributeBegin " + a + shape + lamp +
                                         "AttributeEnd AttributeBegin " + b + shape + lamp + "AttributeEnd",
                                     "path", "", samples(256));
  const Rendered instances = renderText(
      head + "ObjectBegin \"o\" " + shape + lamp + "ObjectEnd\nAttributeBegin " + a +
          "ObjectInstance \"o\" AttributeEnd AttributeBegin " + b + "ObjectInstance \"o\" AttributeEnd",
      "path", "", samples(256));
  EXPECT_NEAR(copies.mean(), instances.mean(),
              4 * std::hypot(copies.standardError(), instances.standardError()));
  size_t alike = 0;
  for (size_t i = 0; i < copies.pixels(); ++i)
    if (std::abs(luminance(copies.value(i)) - luminance(instances.value(i))) <
        0.15f * luminance(copies.value(i)) + 0.01f)
      ++alike;
  EXPECT_GT(double(alike), 0.97 * double(copies.pixels()));
}

TEST(Integrators, DomainsAreDisjointAndCoverSurfacePaths) {
  for (const auto& entry : plugIns().integrators.entries()) {
    const auto integrator = integratorFrom(entry.name, "");
    const std::string claims = integrator->claims();
    const DomainReport report = checkDomains(integrator->domains(), claims.empty() ? "surface" : claims);
    EXPECT_TRUE(report.sound()) << entry.name << "\n" << report.text();
  }
}

/** Independent reference pictures, if they exist: means only, with few samples. */
TEST(References, MeansAgree) {
  namespace fs = std::filesystem;
  const char* environment = std::getenv("RECURSE_SHARED");
  const fs::path folder =
      (environment ? fs::path(environment) : fs::path(RECURSE_SOURCE_DIR) / ".." / "shared") / "reference";
  if (!fs::exists(folder)) GTEST_SKIP() << "no reference pictures in " << folder;
  if (SANITIZED) GTEST_SKIP() << "takes too long with sanitizers";
  struct Case {
    const char* name;
    int pathSamples; ///< 0: too noisy for a path tracer in a test
  };
  for (const Case& c : {Case{"cornell", 4}, Case{"cornell-glass", 16}, Case{"hexroom-grey", 8},
                        Case{"sds", 0}, Case{"ajar", 0}}) {
    Diagnostics diagnostics;
    const SceneDescription description =
        loadScene((folder / (std::string(c.name) + ".pbrt")).string(), diagnostics);
    const auto scene = buildScene(description, {}, diagnostics);
    ASSERT_TRUE(scene) << diagnostics.format();
    const Image reference = readImage((folder / (std::string(c.name) + ".exr")).string());
    double mean = 0;
    for (int y = 0; y < reference.height; ++y)
      for (int x = 0; x < reference.width; ++x) mean += double(luminance(reference.rgb(x, y)));
    mean /= double(reference.width) * reference.height;
    if (c.pathSamples > 0) {
      const Rendered r = renderScene(*scene, "path", "", c.pathSamples);
      EXPECT_NEAR(r.mean(), mean, 0.01 * mean + 4 * r.standardError()) << c.name << " path";
    }
    // Few photons of a map may pass a door, which all pixels share: only the variance between independent
    // maps measures this error.
    constexpr int MAPS = 5;
    double sum = 0, squares = 0;
    for (int seed = 1; seed <= MAPS; ++seed) {
      const Rendered r = renderScene(*scene, "photonmap", "\"integer passes\" 1 \"integer photons\" 1000000",
                                     1, uint64_t(seed));
      sum += r.mean();
      squares += r.mean() * r.mean();
    }
    const double ofMaps = sum / MAPS;
    const double standardError = std::sqrt(std::max(0.0, squares / MAPS - ofMaps * ofMaps) / (MAPS - 1));
    EXPECT_LT(standardError, 0.02 * mean) << c.name << ": says nothing";
    EXPECT_NEAR(ofMaps, mean, 0.01 * mean + 4 * standardError) << c.name << " photonmap";
  }
}
