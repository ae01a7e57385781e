/** @file
 * 2. Grazing light and grazing views; a ground sphere of radius 1e6 under objects of size 1; a sphere of
 * radius 1e-4 seen from a distance of 1e4.
 */
#include "hardCase.h"

namespace recurse::hard {

namespace {

constexpr double DEGREE = M_PI / 180;

/** A plane of albedo 1/2. */
std::string plane(double half) {
  const std::string h = number(half);
  return diffuse(0.5) + "Shape \"bilinearmesh\" \"point3 P\" [ -" + h + " -" + h + " 0  " + h + " -" + h +
         " 0  -" + h + " " + h + " 0  " + h + " " + h + " 0 ]\n";
}

/** Parallel light of irradiance 1 / cos at `degrees` from the normal: L = ρ / π. */
void light(const Report& report, double degrees) {
  const double cosine = std::cos(degrees * DEGREE), sine = std::sin(degrees * DEGREE);
  const std::string scene = view(8, 8, "0 0 1  0 0 0  0 1 0", perspective(30)) + "Rotate 30 1 .3 0\n" +
                            // The camera looks at the centre of the tilted plane.
                            "LightSource \"distant\" \"point3 from\" [ " + number(sine) + " 0 " +
                            number(cosine) +
                            " ] \"point3 to\" [ 0 0 0 ] \"rgb L\" [ 1 1 1 ] \"float scale\" " +
                            number(1 / cosine) + "\n" + plane(1);
  Budget budget;
  budget.tolerance = 2e-3;
  // Very few photons would hit the plane.
  budget.only = [](const Way& w) { return !w.directPhotons; };
  checkMean(report, "light at " + shown("%g", degrees) + " degrees", scene, 0.5 / M_PI, budget);
  // Photons in a beam: ∫ L dA = ρ Φ / π for any search radius. The picture foreshortens the plane by cos 30°.
  // Even the narrowest cone reaches beyond the horizon at the second angle; the photons that miss the plane,
  // whose end the light sees at a 21st of its elevation, are in a segment of the cone's disc.
  const double elevation = 90 - degrees, cone = std::max(elevation / 5, 1e-3);
  const double cut = std::min(1.0, elevation * (1 - 1.0 / 21) / cone);
  const double missed = (std::acos(cut) - cut * std::sqrt(1 - cut * cut)) / M_PI;
  Budget beam;
  beam.photons = 1e4;
  beam.photonSamples = 32;
  beam.photonParameters = "\"float radius\" 2";
  beam.only = [](const Way& w) { return w.directPhotons; };
  checkMean(report, "beam at " + shown("%g", degrees) + " degrees, energy",
            view(64, 64, "0 0 20  0 0 0  0 1 0", orthographic(20)) + "Rotate 30 1 .3 0\n" + plane(20) +
                "LightSource \"spot\" \"float power\" 3 \"point3 from\" [ " + number(sine) + " 0 " +
                number(cosine) + " ] \"point3 to\" [ 0 0 0 ] \"float coneangle\" " + number(cone) +
                " \"float conedeltaangle\" 0\n",
            0.5 * 3 / M_PI * (1 - missed) * std::sqrt(0.75) / 1600, beam);
}

/** A plane under uniform light, seen by a pinhole camera from a distance of 10 at `degrees` from its
 * normal. */
void seen(const Report& report, double degrees, double fov, double half) {
  const double cosine = std::cos(degrees * DEGREE), sine = std::sin(degrees * DEGREE);
  const std::string scene =
      view(8, 8, number(10 * sine) + " 0 " + number(10 * cosine) + "  0 0 0  0 0 1", perspective(fov)) +
      "LightSource \"distant\" \"point3 from\" [ 0 .1 1 ] \"point3 to\" [ 0 0 0 ] \"rgb L\" "
      "[ 1 1 1 ]\n" +
      plane(half);
  Budget budget;
  budget.photonTolerance = 0.03;
  checkMean(report, "seen at " + shown("%g", degrees) + " degrees", scene, 0.5 / M_PI / std::sqrt(1.01),
            budget);
}

constexpr const char* PLANET =
    "AttributeBegin\nTranslate 0 -1000000 0\nShape \"sphere\" \"float radius\" 1000000\n"
    "AttributeEnd\n";

void planet(const Report& report) {
  Budget budget;
  budget.tolerance = 2e-3;
  // For the photons the whole picture is a single point of the planet.
  budget.photons = 1e6;
  budget.photonParameters = "\"integer gatherphotons\" 2000";
  budget.photonTolerance = 0.01 + photonNoise(2000);
  // A convex body in uniform light has no shadows: L = ρ L everywhere.
  for (const std::string eye : {"0 1 4", "0 .01 4", "0 100 4000"})
    checkMean(report, "even light, eye at " + eye,
              view(8, 8, eye + "  0 0 0  0 1 0", perspective(.05)) + constantLight(1) + diffuse(0.5) + PLANET,
              0.5, budget);
  // A black ball of radius 1 with its centre 2 above the ground occludes (1/2)² of the sky's irradiance under
  // it.
  Budget sharp = budget;
  sharp.samples = 256;
  sharp.photonSamples = 256;
  // Photons of the sky are distributed over the whole planet: they cannot resolve the shadow of an object of
  // size 1.
  sharp.only = [](const Way& w) { return !w.directPhotons; };
  checkMean(report, "sky hidden by a ball of radius 1",
            view(8, 8, "0 .5 5  0 0 0  0 1 0", perspective(.1)) + constantLight(1) + diffuse(0.5) + PLANET +
                diffuse(0) + "Translate 0 2 0\nShape \"sphere\"\n",
            0.5 * 0.75, sharp);
  checkMean(report, "point light at a height of 2",
            view(8, 8, "0 .5 5  0 0 0  0 1 0", perspective(.1)) +
                "LightSource \"point\" \"point3 from\" [ 0 2 0 ] \"rgb I\" [ 4 4 4 ]\n" + diffuse(0.5) +
                PLANET,
            0.5 / M_PI, budget);
}

/** A lamp of radius 1e-4: the picture's mean is L times the fraction of the picture that it covers. */
void farAway(const Report& report, const std::string& detail, const std::string& camera,
             const Vec3d& direction, double halfWidth) {
  const Vec3d eye = glm::normalize(direction) * 1e4;
  const std::string scene =
      view(4, 4, number(eye.x) + " " + number(eye.y) + " " + number(eye.z) + "  0 0 0  0 1 0", camera) +
      "AreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ]\n" + diffuse(0) +
      "Shape \"sphere\" \"float radius\" 1e-4\n";
  Budget budget;
  budget.samples = budget.photonSamples = 4096;
  budget.photons = 1000;
  budget.tolerance = 5e-3;
  budget.photonTolerance = budget.tolerance;
  checkMean(report, detail, scene, M_PI * 1e-8 / (4 * halfWidth * halfWidth), budget);
}

/** The lamp through a pinhole: a few pixels in the middle of a picture of thousands. */
void farAwayPinhole(const Report& report, const std::string& detail, const std::string& eye) {
  const double half = 1e4 * std::tan(0.0005 * DEGREE); // half width of the window at the sphere
  const int size = 4096;
  const double pixel = 2 * half / size;
  const std::string scene = "Film \"rgb\" \"integer xresolution\" 4096 \"integer yresolution\" 4096 "
                            "\"integer pixelbounds\" [ 2040 2056 "
                            "2040 2056 ]\nPixelFilter \"box\"\nLookAt " +
                            eye + "  0 0 0  0 1 0\n" + perspective(0.001) +
                            "\nWorldBegin\nAreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ]\n" + diffuse(0) +
                            "Shape \"sphere\" \"float radius\" 1e-4\n";
  Budget budget;
  budget.samples = budget.photonSamples = 256;
  budget.photons = 1000;
  budget.tolerance = budget.photonTolerance = 0.02;
  budget.only = [](const Way&) {
    return true;
  }; // the excluded ways trace light paths for all 16.8M pixels of the film
  checkMean(report, detail, scene, M_PI * 1e-8 / (256 * pixel * pixel), budget);
}

} // namespace

void addGrazingCases(HardCases& cases) {
  cases.push_back({2, "grazing light", false, [](const Report& r) {
                     light(r, 89.9);
                     light(r, 89.999);
                   }});
  cases.push_back({2, "grazing view", false, [](const Report& r) {
                     seen(r, 89.9, 0.1, 20);
                     seen(r, 89.999, 0.001, 20);
                   }});
  cases.push_back({2, "ground sphere of radius 1e6", false, planet});
  cases.push_back({2, "sphere of radius 1e-4 seen from 1e4", false, [](const Report& r) {
                     farAway(r, "parallel projection along an axis", orthographic(2e-4), {0, 0, 1}, 2e-4);
                     farAwayPinhole(r, "pinhole along an axis", "0 0 10000");
                     farAwayPinhole(r, "pinhole across the axes", "6000 4800 6400");
                   }});
}

} // namespace recurse::hard
