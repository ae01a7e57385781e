/** @file
 * Motion against closed forms, and against pictures of single times.
 */
#include "rendering.h"

using namespace recurse;
using namespace recurse::testing;

namespace {

std::string settings(const std::string& camera, int size) {
  const std::string n = std::to_string(size);
  return "Film \"rgb\" \"integer xresolution\" " + n + " \"integer yresolution\" " + n +
         "\nPixelFilter \"box\"\n" + camera + "\n";
}

/** View along the z axis of [-1, 1]², y up. */
const char* const FROM_ABOVE =
    "Scale -1 1 1 LookAt 0 0 5  0 0 0  0 1 0 Camera \"orthographic\" \"float screenwindow\" [-1 1 -1 1]";

/** Emitter that turns by a quarter: the half plane x > 0, as large as the view. */
std::string turningHalf(const std::string& start, const std::string& end) {
  return "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n"
         "ActiveTransform StartTime " +
         start + " ActiveTransform EndTime " + end +
         " ActiveTransform All\n"
         "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [0 -2 0 2 -2 0 2 2 0 0 2 "
         "0]\n";
}

double greatestDifference(const Rendered& a, const Rendered& b) {
  double greatest = 0;
  for (size_t i = 0; i < a.pixels(); ++i)
    greatest = std::max(greatest, double(std::abs(luminance(a.value(i)) - luminance(b.value(i)))));
  return greatest;
}

} // namespace

TEST(Motion, ATurningHalfPlaneBlursInProportionToTheAngle) {
  // A point is covered while the axis of the half plane is less than a right angle from its direction.
  constexpr int SIZE = 8, SAMPLES = 256;
  for (const char* integrator : {"path", "photonmap"})
    for (const double scale : {1.0, 3.0}) {
      const std::string grown = " Scale " + std::to_string(scale) + " 1 1";
      const Rendered picture = renderText(
          settings(FROM_ABOVE, SIZE) + "WorldBegin\n" +
              turningHalf("Rotate 10 0 0 1" + grown, "Rotate 100 0 0 1 Scale 1 1 1"),
          integrator,
          std::string(integrator) == "path" ? "" : "\"integer photons\" 10 \"integer passes\" 256", SAMPLES);
      for (int y = 0; y < SIZE; ++y)
        for (int x = 0; x < SIZE; ++x) {
          double covered = 0;
          constexpr int GRID = 16;
          for (int k = 0; k < GRID * GRID; ++k) {
            const double px = (x + (k % GRID + 0.5) / GRID) / SIZE * 2 - 1;
            const double py = 1 - (y + (k / GRID + 0.5) / GRID) / SIZE * 2;
            const double angle = std::remainder(std::atan2(py, px) * 180 / M_PI - 55, 360);
            covered += std::clamp((135 - std::abs(angle)) / 90, 0.0, 1.0) / (GRID * GRID);
          }
          EXPECT_NEAR(double(picture.value(size_t(y) * SIZE + size_t(x)).g), covered, 0.06)
              << integrator << " " << x << " " << y;
        }
    }
}

TEST(Motion, TheShutterIsOpenForAPartOfTheMotion) {
  // The shutter is open from a third of the motion to its end, in the times of TransformTimes; the picture
  // has the exposure.
  const std::string camera =
      std::string(FROM_ABOVE) + " \"float shutteropen\" 4 \"float shutterclose\" 6 TransformTimes 3 6";
  const auto scene = sceneFrom(settings(camera, 4) + "WorldBegin\n" + turningHalf("", "Translate 3 0 0"));
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->film().imagingRatio, 2);
  EXPECT_TRUE(scene->moves());
  EXPECT_NEAR(scene->camera().timeAt(0), 1 / 3.0, 1e-6);
  EXPECT_EQ(scene->camera().timeAt(1), 1);
  // The shape has left the picture before the shutter opens.
  EXPECT_EQ(renderScene(*scene, "path", "", 16).mean(), 0);
}

TEST(Motion, AMovingCameraSeesWhatMovesTheOtherWay) {
  const std::string plate =
      "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n"
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [-.5 -.4 0 .6 -.3 0 0 .7 0]\n";
  const auto moved = [](const std::string& by) {
    return "ActiveTransform EndTime " + by + " ActiveTransform All\n";
  };
  const std::string motions[][2] = {{"Translate -.5 .2 0", "Translate .5 -.2 0"},
                                    {"Rotate 40 0 0 1", "Rotate -40 0 0 1"}};
  const std::string place = "Scale -1 1 1 LookAt 0 0 2 0 0 0 0 1 0\n";
  for (const char* name : {"Camera \"orthographic\"", "Camera \"perspective\" \"float fov\" 60"})
    for (const auto& [there, back] : motions) {
      const Rendered world =
          renderText(settings(place + name, 8) + "WorldBegin\n" + moved(there) + plate, "path", "", 1024);
      const Rendered eye =
          renderText(settings(place + moved(there) + name, 8) + "WorldBegin\n" + plate, "path", "", 1024);
      EXPECT_GT(world.mean(), 0.05);
      EXPECT_LT(greatestDifference(world, eye), 0.06) << name << " " << there;
      const Rendered wrong =
          renderText(settings(place + moved(back) + name, 8) + "WorldBegin\n" + plate, "path", "", 256);
      EXPECT_GT(greatestDifference(world, wrong), 0.1) << name << " " << there;
    }
}

namespace {

/** A floor under a lamp that moves, turns and grows; if `at` is not negative, the lamp at this time without
 * motion. */
std::string underMovingLamp(double at, const std::string& shape) {
  const auto moment = [](double t) {
    return "Translate " + std::to_string(-1 + 2 * t) + " 0 " + std::to_string(1 + t) + " Scale " +
           std::to_string(1 + t) + " " + std::to_string(1 + t) + " " + std::to_string(1 - t / 2);
  };
  return settings(FROM_ABOVE, 4) +
         "WorldBegin Material \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\n"
         "Shape \"disk\" \"float radius\" 3\n"
         "AreaLightSource \"diffuse\" \"rgb L\" [300 300 300] Material \"diffuse\" \"rgb reflectance\" [0 0 "
         "0]\n" +
         (at >= 0 ? moment(at)
                  : "ActiveTransform StartTime " + moment(0) + " ActiveTransform EndTime " + moment(1) +
                        " ActiveTransform All") +
         "\nTranslate 0 0 8\n" + shape + "\n";
}

} // namespace

TEST(Motion, ALampThatMovesLightsAsTheMeanOfItsMoments) {
  // The lamp is above the camera, so that only its light is visible.
  size_t scenes = 1;
  for (const char* shape : {"Shape \"sphere\" \"float radius\" .3",
                            "ReverseOrientation Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] "
                            "\"point3 P\" [-.3 -.3 0 .3 -.3 0 .3 .3 0 -.3 .3 0]"}) {
    constexpr int MOMENTS = 16;
    std::vector<double> expected(16, 0.0);
    for (int i = 0; i < MOMENTS; ++i) {
      const Rendered moment = renderText(underMovingLamp((i + 0.5) / MOMENTS, shape), "path", "", 128);
      for (size_t p = 0; p < expected.size(); ++p) expected[p] += double(moment.value(p).g) / MOMENTS;
    }
    const int passes = SANITIZED ? 64 : 256;
    const std::string photons = "\"integer photons\" 10000 \"integer passes\" " + std::to_string(passes);
    const std::vector<Way> ways = {
        {"path", ""}, {"photonmap", photons}, {"photonmap", photons + " \"string direct\" \"photons\""}};
    for (const Way& way : dealt(ways, scenes++)) {
      const Rendered moving = renderText(underMovingLamp(-1, shape), way.integrator, way.parameters,
                                         way.integrator == "path" ? 1024 : passes);
      double mean = 0;
      for (size_t p = 0; p < expected.size(); ++p) {
        EXPECT_NEAR(double(moving.value(p).g), expected[p], 0.12 * expected[p])
            << shape << " " << way.integrator << " " << way.parameters << ", pixel " << p;
        mean += expected[p] / double(expected.size());
      }
      EXPECT_GT(mean, 0.01);
      EXPECT_NEAR(moving.mean(), mean, 0.02 * mean)
          << shape << " " << way.integrator << " " << way.parameters;
    }
  }
}

TEST(Motion, InstancesAndTheirShapesMoveTogether) {
  // An object moves along x and one of its parts along y, which makes a diagonal. The second part does not
  // move in the object.
  const std::string part =
      "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] Material \"diffuse\" \"rgb reflectance\" [0 0 0] "
      "Shape \"disk\" \"float radius\" .1\n";
  const auto lamp = [&](const char* move) {
    return std::string("AttributeBegin ActiveTransform EndTime Translate ") + move + " ActiveTransform All " +
           part + "AttributeEnd\n";
  };
  const std::string camera = settings(FROM_ABOVE, 16) + "WorldBegin\n";
  const Rendered plain =
      renderText(camera + lamp("1 1 0") + "Translate -.5 0 0 " + lamp("1 0 0"), "path", "", 256);
  const Rendered instanced =
      renderText(camera + "ObjectBegin \"o\"\n" + lamp("0 1 0") + "Translate -.5 0 0 " + part +
                     "ObjectEnd\nActiveTransform EndTime Translate 1 0 0 ActiveTransform All\n"
                     "ObjectInstance \"o\"\n",
                 "path", "", 256);
  EXPECT_GT(plain.mean(), 0.01);
  EXPECT_LT(greatestDifference(plain, instanced), 0.05);
}

TEST(Motion, MovingGlassLosesNoLight) {
  // Clear glass in uniform light is invisible, in spite of rounding of positions on its moving surfaces.
  const std::string scene =
      view(16, "0 -4 1  0 0 0  0 0 1", 40) +
      "LightSource \"infinite\" \"rgb L\" [1 1 1]\n"
      "ActiveTransform EndTime Rotate 150 1 2 3 Translate .2 .3 -.1 ActiveTransform All\n"
      "Material \"dielectric\"\n" +
      "Scale 1 .7 1.2 Shape \"sphere\"\n";
  const Rendered picture = renderText(scene, "path", "", 64);
  for (size_t i = 0; i < picture.pixels(); ++i) EXPECT_NEAR(picture.value(i).g, 1, 2e-3f) << i;
}

TEST(Motion, LampsThatShineAheadTurnWithTheirShapes) {
  // Radiance of an emitted ray in a new direction, against the radiance of a camera ray at the same point.
  std::string text = underMovingLamp(-1, "Shape \"sphere\" \"float radius\" .3");
  const std::string lamp = "AreaLightSource \"diffuse\"";
  text.replace(text.find(lamp), lamp.size(), lamp + " \"float exponent\" 3");
  const auto scene = sceneFrom(text);
  const auto& light = dynamic_cast<const AreaLight&>(scene->lights()[0]);
  for (uint32_t i = 0; i < 200; ++i) {
    Sampler sampler(1, 8, i);
    const float time = sampler.next1D();
    const auto le = light.sampleLe({sampler.next1D(), sampler.next2D(), sampler.next2D(), time});
    ASSERT_TRUE(le);
    const Vec3f direction = Frame(le->normal).toWorld(cosineHemisphere(sampler.next2D()));
    SurfacePoint point;
    point.position = le->origin;
    point.geometricNormal = point.shadingNormal = le->normal;
    point.time = time;
    const Rgb expected = light.radiance(point, direction), told = light.radianceTowards(*le, direction);
    EXPECT_NEAR(told.g, expected.g, 2e-3f * expected.g + 1e-5f);
  }
}

TEST(Motion, AreaLightsOfMovingShapesKnowTheirDensities) {
  // Densities of samples against pdfLe() for the same ray, and flux against the radiance.
  const auto scene = sceneFrom(underMovingLamp(-1, "Shape \"sphere\" \"float radius\" .3"));
  const Light& light = scene->lights()[0];
  for (uint32_t i = 0; i < 200; ++i) {
    Sampler sampler(1, 8, i);
    const float time = sampler.next1D();
    const auto le = light.sampleLe({sampler.next1D(), sampler.next2D(), sampler.next2D(), time});
    ASSERT_TRUE(le);
    const LePdf pdf = light.pdfLe(*le);
    EXPECT_NEAR(pdf.position, le->pdfPosition, 1e-3f * pdf.position);
    EXPECT_NEAR(pdf.direction, le->pdfDirection, 1e-2f * pdf.direction + 1e-4f);
    const float cosine = glm::dot(le->normal, le->direction);
    EXPECT_NEAR(le->flux.g, 300 * cosine / (le->pdfPosition * le->pdfDirection), 1e-2f * le->flux.g);
    Hit hit;
    // Emitted light starts on the lamp where rays hit it at that time.
    EXPECT_FALSE(scene->intersect({le->origin, le->direction, 1e-3f, time}, hit));
    const Vec3f above = le->origin + le->normal * 1e-3f;
    ASSERT_TRUE(scene->intersect({above, -le->normal, 1e-2f, time}, hit));
    EXPECT_NEAR(hit.t, 1e-3f, 5e-5f);
    EXPECT_GT(glm::dot(hit.point.geometricNormal, le->normal), 0.9999f);
  }
}
