/** @file
 * Transient renders: layers of the film by the optical length of paths. The layers add up to the picture,
 * frames of a light pulse have closed forms, and all estimators agree frame by frame.
 */
#include "classRendering.h"

namespace recurse {
namespace {

using namespace recurse::testing;

/** Layers of a film of one class: the picture, light before all frames, the frames, light after all
 * frames. */
constexpr size_t BEFORE = 1, FIRST_FRAME = 2;

PathClasses framed(const TransientFrames& frames, const std::string& paths = "all") {
  PathClasses classes({{paths, paths}});
  classes.addFrames(frames);
  return classes;
}

/** Largest difference between the picture and the sum of its other layers, relative to the brightest
 * value. */
double excess(const Rendered& r) {
  double brightest = 0, largest = 0;
  for (size_t p = 0; p < r.pixels(); ++p)
    for (int c = 0; c < 3; ++c) {
      double sum = 0;
      for (size_t layer = BEFORE; layer < r.film.layerCount(); ++layer) sum += double(r.value(p, layer)[c]);
      brightest = std::max(brightest, double(r.value(p)[c]));
      largest = std::max(largest, std::abs(sum - double(r.value(p)[c])));
    }
  return largest / brightest;
}

constexpr int SIZE = 24;
constexpr double PIXEL = 4.0 / SIZE; ///< width of a pixel on the floor

const std::string FLOOR = "Material \"diffuse\" \"rgb reflectance\" [ .5 .5 .5 ]\n"
                          "Shape \"bilinearmesh\" \"point3 P\" [ -9 -9 0  9 -9 0  -9 9 0  9 9 0 ]\n";
const std::string LAMP = "LightSource \"point\" \"rgb I\" [ 10 10 10 ] \"point3 from\" [ 0 0 1 ]\n";
const std::string SLAB = "Material \"dielectric\" \"float eta\" 1.5\nShape \"box\" \"point3 p1\" [ -9 -9 2 ] "
                         "\"point3 p2\" [ 9 9 3 ]\n";
constexpr double SLAB_DELAY = .5;            ///< (n - 1) times the thickness
constexpr double SLAB_TRANSMITS = .96 * .96; ///< (1 - ((n - 1)/(n + 1))²)², without internal reflections
constexpr double CAMERA_HEIGHT = 5;

/** Parallel vertical rays that start at the camera's height. */
std::string fromAbove(const std::string& world) {
  return view(SIZE, SIZE, "0 0 5  0 0 0  0 1 0",
              "Camera \"orthographic\" \"float screenwindow\" [ -2 2 -2 2 ]") +
         world;
}

double fromLamp(double x, double y) { return std::sqrt(1 + x * x + y * y); }
/** Radiance of a floor of albedo .5 under LAMP. */
double underLamp(double x, double y) { return .5 * 10 / M_PI / std::pow(fromLamp(x, y), 3); }

/** Arrival and radiance of a pulse at a point of the floor. */
struct Pulse {
  double (*length)(double x, double y);
  double (*radiance)(double x, double y);
};

/** Expects that each pixel has the light of the pulse, to within `tolerance`, and all of it in the frames of
 * the lengths within the pixel. */
void expectPulse(const Rendered& r, const TransientFrames& frames, const Pulse& pulse, double tolerance) {
  constexpr int POINTS = 5; // points along the side of a pixel, including the corners
  size_t clear = 0;
  for (size_t p = 0; p < r.pixels(); ++p) {
    size_t least = SIZE_MAX, most = 0;
    double radiance = 0;
    for (int i = 0; i < POINTS * POINTS; ++i) {
      const double x = (double(p % SIZE) + double(i % POINTS) / (POINTS - 1)) * PIXEL - 2;
      const double y = 2 - (double(p / SIZE) + double(i / POINTS) / (POINTS - 1)) * PIXEL;
      const size_t layer = frames.layerOf(float(pulse.length(x, y)));
      least = std::min(least, layer), most = std::max(most, layer);
      radiance += pulse.radiance(x, y) / (POINTS * POINTS);
    }
    ASSERT_NEAR(r.luminanceAt(p) / radiance, 1, tolerance) << "pixel " << p;
    double inside = 0;
    for (size_t layer = least; layer <= most; ++layer) inside += r.luminanceAt(p, BEFORE + layer);
    ASSERT_NEAR(inside / r.luminanceAt(p), 1, 1e-4) << "pixel " << p << ": light at a wrong time";
    clear += least == most;
  }
  EXPECT_GT(clear, r.pixels() / 4) << "pixels within one frame";
}

/** Expects a pulse on the floor, seen from above, by each of the ways. */
void expectPulse(const std::string& world, const std::string& paths, const TransientFrames& frames,
                 const Pulse& pulse, const std::vector<std::pair<Way, double>>& ways) {
  const auto scene = sceneFrom(fromAbove(world));
  // A quarter of the samples has twice the error.
  constexpr int SAMPLES = SANITIZED ? 16 : 64;
  constexpr double SCALE = SANITIZED ? 2 : 1;
  for (const auto& [way, tolerance] : ways) {
    SCOPED_TRACE(way.integrator);
    expectPulse(renderClasses(*scene, way, framed(frames, paths), SAMPLES, 1), frames, pulse,
                SCALE * tolerance);
  }
}

/** Expects that the means of the frames agree with the first way. */
void expectSameFrames(const std::string& world, const TransientFrames& frames, const std::vector<Way>& ways) {
  constexpr int SEEDS = SANITIZED ? 4 : 8, SAMPLES = SANITIZED ? 1 : 3;
  constexpr int TRUTH_SAMPLES = 16; // the standard error does not include rare paths that no sample finds
  constexpr double SURE = 5;        // standard errors
  // Bias of photons by their blur, relative to the frame and to the picture. The standard errors of the
  // sanitizers' few samples are uncertain.
  constexpr double BIAS = SANITIZED ? 0.6 : 0.01, EARLIER = 0.001;
  const auto scene = sceneFrom(world);
  const PathClasses classes = framed(frames);
  const BatchMeans truth = classMeans(*scene, ways[0], classes, TRUTH_SAMPLES, SEEDS);
  size_t lit = 0;
  for (size_t layer = BEFORE; layer < classes.layerCount(); ++layer)
    lit += truth.mean(3 * layer + 1) > 0.01 * truth.mean(1);
  EXPECT_GE(lit, 4u) << "frames with light";
  for (size_t i = 1; i < ways.size(); ++i) {
    const BatchMeans means = classMeans(*scene, ways[i], classes, SAMPLES, SEEDS);
    for (size_t layer = 0; layer < classes.layerCount(); ++layer) {
      const size_t green = 3 * layer + 1;
      const double error = std::hypot(truth.standardError(green), means.standardError(green));
      EXPECT_NEAR(means.mean(green), truth.mean(green),
                  SURE * error + BIAS * truth.mean(green) + EARLIER * truth.mean(1))
          << ways[i].integrator << " " << ways[i].parameters << ", " << classes.classes()[layer].name;
    }
  }
}

const std::string MANY = SANITIZED ? "\"integer photons\" 2000" : "\"integer photons\" 20000";
const Way PHOTONS = {"photonmap", MANY};
const Way PULSE_PHOTONS = {"photonmap", "\"integer photons\" 1000"}; ///< the pulse itself is direct light
const Way FEW_PHOTONS = {"photonmap", "\"integer photons\" 2000"};
const Way FOG_PHOTONS = {"photonmap", "\"integer photons\" 5000"};
const Way CAUSTICS = {"photonmap", "\"bool causticsonly\" true " + MANY};

} // namespace

TEST(Transient, FramesAreHalfOpenIntervals) {
  const TransientFrames frames(2, 4, 4);
  EXPECT_EQ(frames.layerCount(), 6u);
  EXPECT_EQ(frames.layerOf(1.999f), 0u);
  EXPECT_EQ(frames.layerOf(2), 1u);
  EXPECT_EQ(frames.layerOf(2.5f), 2u);
  EXPECT_EQ(frames.layerOf(3.999f), 4u);
  EXPECT_EQ(frames.layerOf(4), 5u);
  EXPECT_EQ(frames.layerOf(INFINITE), 5u);
  EXPECT_EQ(frames.layerName(0) + frames.layerName(4) + frames.layerName(5), "beforeframe-0003after");
  EXPECT_EQ(TransientFrames().layerCount(), 0u);
}

TEST(Transient, TextHasTheLengthsAsGiven) { EXPECT_EQ(TransientFrames(0.1, 0.7, 3).text(), "0.1:0.7:3"); }

TEST(Transient, LayersAddUpToThePictureOfTheSameSamples) {
  const auto scene = sceneFrom(glassAndMirrorBox(16));
  const PathClasses classes = framed({6, 12, 70}); // more layers than bits of a LayerMask
  const std::vector<Way> ways = {{"path", ""},     {"simplepath", ""},
                                 PHOTONS,          {"photonmap", MANY + " \"string direct\" \"photons\""},
                                 CAUSTICS,         {"simplephotonmap", MANY},
                                 {"bdpt", ""},     {"vcm", ""},
                                 {"lightpath", ""}};
  for (const Way& way : ways) {
    SCOPED_TRACE(way.integrator + " " + way.parameters);
    const Rendered transient = renderClasses(*scene, way, classes, 4, 1);
    const Rendered still = renderClasses(*scene, way, PathClasses(), 4, 1);
    EXPECT_LT(excess(transient), 1e-5);
    for (size_t p = 0; p < still.pixels(); ++p)
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(double(transient.value(p)[c]), double(still.value(p)[c]),
                    1e-4 * double(still.value(p)[c]))
            << "pixel " << p;
    EXPECT_GT(transient.mean(BEFORE), 0);
    EXPECT_GT(transient.mean(classes.layerCount() - 1), 0) << "after the last frame";
  }
}

TEST(Transient, SumsOfMediaAddUpAsWell) {
  const std::string fog = "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ .01 .01 "
                          ".01 ] \"rgb sigma_s\" [ .2 .2 .2 ]\nMediumInterface \"\" \"fog\"\n";
  const auto scene = sceneFrom(fog + fromAbove("MediumInterface \"fog\" \"fog\"\n" + LAMP + FLOOR));
  const PathClasses classes = framed({5, 9, 8});
  for (const Way& way :
       std::vector<Way>{{"path", ""},
                        FEW_PHOTONS,
                        {"photonmap", FEW_PHOTONS.parameters + " \"string volumephotons\" \"beams\""}}) {
    SCOPED_TRACE(way.integrator + " " + way.parameters);
    const Rendered transient = renderClasses(*scene, way, classes, 2, 1);
    const Rendered still = renderClasses(*scene, way, PathClasses(), 2, 1);
    EXPECT_LT(excess(transient), 1e-5);
    EXPECT_NEAR(transient.mean() / still.mean(), 1, 1e-4);
  }
}

TEST(Transient, PulseOfAPointLightIsAnExpandingRing) {
  // Splats have noise in single pixels.
  expectPulse(LAMP + FLOOR, "all", {6, 8, 8},
              {[](double x, double y) { return CAMERA_HEIGHT + fromLamp(x, y); }, underLamp},
              {{{"path", ""}, .01},
               {{"simplepath", ""}, .01},
               {PULSE_PHOTONS, .01},
               {{"bdpt", ""}, .2},
               {{"vcm", ""}, .2}});
}

TEST(Transient, PhotonsAreSeenWhenTheirWaveFrontPasses) {
  // The kernel covers several frames, but each photon counts when its light reaches the pixel.
  const TransientFrames frames(6, 8, 8);
  const auto scene = sceneFrom(fromAbove(LAMP + FLOOR));
  const Way wide = {"simplephotonmap",
                    "\"integer photons\" 100000 \"integer gatherphotons\" 100000 \"float radius\" .4"};
  const Rendered r = renderClasses(*scene, wide, framed(frames), 4, 1);
  double right = 0;
  for (size_t p = 0; p < r.pixels(); ++p) {
    const double x = (double(p % SIZE) + .5) * PIXEL - 2, y = 2 - (double(p / SIZE) + .5) * PIXEL;
    right += r.luminanceAt(p, BEFORE + frames.layerOf(float(CAMERA_HEIGHT + fromLamp(x, y))));
  }
  EXPECT_GT(right / (r.mean() * double(r.pixels())), 0.75) << "the rest is in pixels on borders";
}

TEST(Transient, AMirrorSendsTheWholeWay) {
  // From the camera down to the mirror at height 0, up to the ceiling, which a lamp at a distance of 1
  // lights.
  expectPulse("LightSource \"point\" \"rgb I\" [ 10 10 10 ] \"point3 from\" [ 0 0 6 ]\n"
              "Material \"conductor\" \"rgb reflectance\" [ 1 1 1 ]\n"
              "Shape \"bilinearmesh\" \"point3 P\" [ -9 -9 0  9 -9 0  -9 9 0  9 9 0 ]\n"
              "Translate 0 0 7\n" +
                  FLOOR,
              "LDSE", {13, 15, 8},
              {[](double x, double y) { return CAMERA_HEIGHT + 7 + fromLamp(x, y); }, underLamp},
              {{{"path", ""}, .01}, {PULSE_PHOTONS, .01}, {{"bdpt", ""}, .01}, {{"vcm", ""}, .01}});
}

TEST(Transient, AGlassSlabDelaysTheCamerasSideByItsIndex) {
  expectPulse(LAMP + FLOOR + SLAB, "LDSSE", {6.5, 8.5, 8},
              {[](double x, double y) { return CAMERA_HEIGHT + SLAB_DELAY + fromLamp(x, y); },
               [](double x, double y) { return SLAB_TRANSMITS * underLamp(x, y); }},
              {{{"path", ""}, .1}, {PULSE_PHOTONS, .1}, {{"bdpt", ""}, .1}, {{"vcm", ""}, .1}});
}

TEST(Transient, AGlassSlabDelaysPhotonsFromFarByItsIndex) {
  // Vertical parallel light from the tangent plane of the scene's bounding sphere arrives everywhere at the
  // same time.
  const auto scene = sceneFrom(fromAbove(
      "LightSource \"distant\" \"point3 from\" [ 0 0 1 ] \"point3 to\" [ 0 0 0 ]\n" + FLOOR + SLAB));
  const double length =
      double(scene->bounds().radius + scene->bounds().center.z) + SLAB_DELAY + CAMERA_HEIGHT + SLAB_DELAY;
  // Relative to the scene's origin, the floor is below its height in the file.
  const double floor = -scene->origin().z;
  const TransientFrames frames(length - floor - .15, length - floor + .15, 3);
  for (const Way& way :
       std::vector<Way>{{"photonmap", "\"integer photons\" 100000"},
                        {"photonmap", "\"bool causticsonly\" true \"integer photons\" 100000"},
                        {"simplephotonmap", "\"integer photons\" 400000"},
                        {"vcm", "\"integer photons\" 20000 \"float radius\" .5"}}) {
    SCOPED_TRACE(way.integrator + way.parameters);
    const Rendered r = renderClasses(*scene, way, framed(frames, "LSSDSSE"), SANITIZED ? 2 : 8, 1);
    EXPECT_NEAR(r.mean() / (square(SLAB_TRANSMITS) * .5 / M_PI), 1, 0.1);
    EXPECT_NEAR(r.mean(FIRST_FRAME + 1) / r.mean(), 1, 1e-4) << "all in the middle frame";
  }
}

TEST(Transient, ObliqueLightFromFarSweepsOverTheFloor) {
  // Light from (0, .6, .8) arrives later for smaller y.
  const std::string world =
      "LightSource \"distant\" \"point3 from\" [ 0 .6 .8 ] \"point3 to\" [ 0 0 0 ]\n" + FLOOR;
  const auto scene = sceneFrom(fromAbove(world));
  const Vec3d centre = Vec3d(scene->bounds().center) + scene->origin();
  static double atOrigin = 0;
  atOrigin = double(scene->bounds().radius) + glm::dot(centre, Vec3d(0, .6, .8)) + CAMERA_HEIGHT;
  expectPulse(
      world, "all", {atOrigin - 1.2, atOrigin + 1.2, 8},
      {[](double, double y) { return atOrigin - .6 * y; }, [](double, double) { return .5 * .8 / M_PI; }},
      {{{"path", ""}, .01}, {PULSE_PHOTONS, .01}, {{"bdpt", ""}, .3}, {{"vcm", ""}, .3}});
}

TEST(Transient, LightIsSlowInWater) {
  // Lamp, floor and camera are in a box of water.
  for (const std::string priority : {"", "\"integer priority\" 1"})
    expectPulse(LAMP + FLOOR + "Material \"dielectric\" \"float eta\" 1.25 " + priority +
                    "\n"
                    "Shape \"box\" \"point3 p1\" [ -10 -10 -1 ] \"point3 p2\" [ 10 10 6 ]\n",
                "LDE", {7.5, 10, 8},
                {[](double x, double y) { return 1.25 * (CAMERA_HEIGHT + fromLamp(x, y)); }, underLamp},
                {{{"path", ""}, .01}, {PULSE_PHOTONS, .01}, {{"bdpt", ""}, .2}, {{"vcm", ""}, .2}});
}

TEST(Transient, EstimatorsAgreeOnGlassAndMirrorFrameByFrame) {
  // Path tracing finds caustics so rarely that its standard error is not reliable.
  expectSameFrames(glassAndMirrorBox(12, 0.6), {5, 14, 9}, {{"bdpt", ""}, {"vcm", ""}, PHOTONS, CAUSTICS});
}

TEST(Transient, EstimatorsAgreeOnCausticsOfAPointFrameByFrame) {
  // Only photons find these caustics, in a separate map.
  expectSameFrames(fromAbove(LAMP + FLOOR +
                             "Shape \"bilinearmesh\" \"point3 P\" [ -9 2 -9  9 2 -9  -9 2 9  9 2 9 ]\n"
                             "Material \"dielectric\" \"float eta\" 1.5\nTranslate .8 0 .45\n"
                             "Shape \"sphere\" \"float radius\" .4\n"),
                   {5, 11, 12}, {{"bdpt", ""}, {"vcm", ""}, PHOTONS, CAUSTICS});
}

TEST(Transient, EstimatorsAgreeBehindRoughGlassUnderASkyFrameByFrame) {
  // Connections, shadow rays and photons pass the rough surfaces of a slab.
  const std::string world = "LightSource \"infinite\" \"rgb L\" [ 1 1 1 ]\n" + LAMP + FLOOR +
                            "Material \"dielectric\" \"float eta\" 2 \"float roughness\" .5\n"
                            "Shape \"box\" \"point3 p1\" [ -3 -3 2 ] \"point3 p2\" [ 3 3 3 ]\n";
  const auto scene = sceneFrom(fromAbove(world));
  const double first = double(scene->bounds().radius) + 2;
  expectSameFrames(fromAbove(world), {first, first + 8, 16},
                   {{"path", ""}, {"bdpt", ""}, {"vcm", ""}, PHOTONS});
}

TEST(Transient, EstimatorsAgreeInFogFrameByFrame) {
  const std::string world = "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ .05 "
                            ".05 .05 ] \"rgb sigma_s\" "
                            "[ .3 .3 .3 ]\nMediumInterface \"\" \"fog\"\n" +
                            fromAbove("MediumInterface \"fog\" \"fog\"\n" + LAMP + FLOOR);
  expectSameFrames(world, {4, 12, 8},
                   {{"path", ""},
                    FOG_PHOTONS,
                    {"photonmap", FOG_PHOTONS.parameters + " \"string volumephotons\" \"beams\""}});
}

} // namespace recurse
