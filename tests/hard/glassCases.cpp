/** @file
 * 4. Refractive indices near 1 and far from it, the critical angle, thin slabs, many shells, camera and lamp
 * inside of glass.
 */
#include "hardCase.h"

namespace recurse::hard {

namespace {

/** Fresnel reflectance of unpolarised light in long double; eta is the index of the far side over the index
 * of the near side. */
long double reflectance(long double sine, long double cosine, long double eta) {
  const long double s = sine / eta;
  if (s >= 1) return 1;
  const long double c = std::sqrt((1 - s) * (1 + s));
  const long double across = (cosine - eta * c) / (cosine + eta * c),
                    along = (eta * cosine - c) / (eta * cosine + c);
  return (across * across + along * along) / 2;
}

Budget clear() {
  Budget b;
  b.samples = b.photonSamples = 256;
  b.photons = 1000;
  b.tolerance = b.photonTolerance = 1e-3;
  return b;
}

void indices(const Report& report) {
  // In uniform light objects without absorption are invisible.
  for (const double eta : {1.0, 1 + 1e-6, 1 - 1e-6, 10.0, 0.1}) {
    const std::string name = "eta " + shown("%.7g", eta);
    checkMean(report, name + ", ball in even light",
              view(16, 16, "0 0 3  0 0 0  0 1 0", perspective(45)) + constantLight(1) + glass(eta) +
                  "Shape \"sphere\"\n",
              1, clear());
    // A lamp through both faces of a slab: T = (1 - R) / (1 + R), the sum of all internal reflections. Below
    // the critical angle, which is 0.1 rad for the last index.
    const double angle = eta < 0.5 ? 0.05 : 0.5;
    const long double a = static_cast<long double>(angle);
    const long double r = reflectance(std::sin(a), std::cos(a), static_cast<long double>(eta));
    const auto t = static_cast<double>((1 - r) / (1 + r));
    const std::string slab =
        "Shape \"bilinearmesh\" \"point3 P\" [ -60 -60 0  60 -60 0  -60 60 0  60 60 0 ]\n"
        "ReverseOrientation\n"
        "Shape \"bilinearmesh\" \"point3 P\" [ -60 -60 -.1  60 -60 -.1  -60 60 -.1  60 60 -.1 ]\n";
    const std::string lamp =
        "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ]\n" + diffuse(0) +
        "Shape \"bilinearmesh\" \"point3 P\" [ -60 -60 -1  60 -60 -1  -60 60 -1  60 60 -1 ]\n"
        "AttributeEnd\n";
    const auto eye = [](double tilt) {
      return number(std::sin(tilt)) + " 0 " + number(std::cos(tilt)) + "  0 0 0  0 1 0";
    };
    const std::string rest = lamp + glass(eta) + slab;
    checkMean(report, name + ", slab", view(4, 4, eye(angle), orthographic(0.1)) + rest, t, clear());
    if (eta > 0.5) continue;
    const auto scene = sceneFrom(view(4, 4, eye(0.5), orthographic(0.1)) + rest);
    for (const Way& way : allWays(1000)) {
      const Rendered r2 = renderScene(*scene, way, clear());
      report.atMost(name + ", slab beyond the critical angle", way.label, "radiance", r2.mean(), 0,
                    r2.unsound());
    }
  }
}

/** View from inside of glass of index 1.5 towards its flat surface, with uniform light on both sides. */
void critical(const Report& report) {
  const long double eta = 1.5L;
  const long double angle = std::asin(1 / eta);
  for (const double off : {-1e-2, -1e-4, -1e-6, 0.0, 1e-6, 1e-4, 1e-2}) {
    const long double a = angle + static_cast<long double>(off);
    const long double r = reflectance(std::sin(a), std::cos(a), 1 / eta);
    // Radiance that enters the glass is multiplied by the square of the index.
    const auto expected = static_cast<double>(r + (1 - r) * eta * eta);
    Budget budget = clear();
    budget.samples = budget.photonSamples = 64;
    // The direction has an error of 1e-7: just below the critical angle transmission increases like a square
    // root.
    budget.tolerance = budget.photonTolerance = std::abs(off) <= 1e-6 ? 0.02 : 1e-3;
    const std::string eye =
        number(double(std::sin(a))) + " 0 " + number(-double(std::cos(a))) + "  0 0 0  0 1 0";
    checkMean(report, "critical angle " + (off == 0 ? std::string("itself") : shown("%+g", off)),
              view(4, 4, eye, orthographic(0.01)) + constantLight(1) + glass(1.5) +
                  "Shape \"bilinearmesh\" \"point3 P\" [ -9 -9 0  9 -9 0  -9 9 0  9 9 0 ]\n",
              expected, budget);
  }
}

/** A square of side 2 at height z as `pieces` x `pieces` pairs of triangles. */
std::string meshedSquare(double z, int pieces) {
  std::string points, indices;
  for (int j = 0; j <= pieces; ++j)
    for (int i = 0; i <= pieces; ++i) {
      points += number(2.0 * i / pieces - 1) + " " + number(2.0 * j / pieces - 1) + " " + number(z) + "  ";
      if (i == pieces || j == pieces) continue;
      const int a = j * (pieces + 1) + i, b = a + 1, c = a + pieces + 1, d = c + 1;
      for (const int vertex : {a, b, d, a, d, c}) indices += std::to_string(vertex) + " ";
    }
  return "Shape \"trianglemesh\" \"integer indices\" [ " + indices + "] \"point3 P\" [ " + points + "]\n";
}

/** Two faces in front of a lamp; `tilted`: at an angle to the axes. */
void slab(const Report& report, double thickness, double degrees, bool tilted, const std::string& faces,
          const std::string& more = "") {
  const long double a = static_cast<long double>(degrees) * M_PIl / 180;
  const long double r = reflectance(std::sin(a), std::cos(a), 1.5L);
  const std::string tilt = tilted ? "Rotate 33 .3 1 .2\n" : "";
  const std::string lamp = "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ]\n" + diffuse(0) +
                           "Translate 0 0 -.5\nShape \"disk\" \"float radius\" 6\nAttributeEnd\n";
  // The camera is tilted as well, so that its angle to the slab is the same.
  const std::string eye =
      number(double(std::sin(a))) + " 0 " + number(double(std::cos(a))) + "  0 0 0  0 1 0";
  const std::string head = view(8, 8, eye, orthographic(0.1));
  const size_t lookAt = head.find("LookAt");
  // Camera space from world space: the tilt is reversed first.
  const std::string camera =
      head.substr(lookAt, head.find('\n', lookAt) - lookAt) + (tilted ? "\nRotate -33 .3 1 .2" : "");
  const std::string turned = head.substr(0, lookAt) + camera + head.substr(head.find('\n', lookAt));
  checkMean(report,
            "slab " + shown("%g", thickness) + " thick at " + shown("%g", degrees) + " degrees" +
                (tilted ? ", tilted" : "") + more,
            turned + tilt + lamp + glass(1.5) + faces, static_cast<double>((1 - r) / (1 + r)), clear());
}

void thinSlab(const Report& report) {
  const std::string upper =
      "Shape \"bilinearmesh\" \"point3 P\" [ -1 -1 0  1 -1 0  -1 1 0  1 1 0 ]\nReverseOrientation\n";
  for (const double thickness : {1e-3, 1e-5, 1e-6})
    for (const double degrees : {0.0, 60.0})
      for (const bool tilted : {false, true})
        slab(report, thickness, degrees, tilted, upper + meshedSquare(-thickness, 1));
  for (const double degrees : {0.0, 60.0})
    slab(report, 1e-6, degrees, true, meshedSquare(0, 64) + "ReverseOrientation\n" + meshedSquare(-1e-6, 64),
         ", in small triangles");
}

/** Concentric shells of glass: at normal incidence n faces transmit (1 - R) / (1 + (n - 1) R). */
void shells(const Report& report) {
  constexpr int COUNT = SANITIZED ? 10 : 50; // paths have one event per shell, and each branch is traced
  std::string text;
  for (int i = 0; i < COUNT; ++i) {
    const double outer = 1 + 0.02 * i;
    text += "Shape \"sphere\" \"float radius\" " + number(outer + 0.01) +
            "\nAttributeBegin\nReverseOrientation\nShape \"sphere\" \"float radius\" " + number(outer) +
            "\nAttributeEnd\n";
  }
  const double r = 0.04, n = 2 * COUNT;
  Budget budget = clear();
  budget.samples = 64;
  budget.photonSamples = 32; // both branches are traced at each face
  checkMean(report, "even light",
            view(4, 4, "0 0 6  0 0 0  0 1 0", perspective(36)) + constantLight(1) + glass(1.5) + text, 1,
            budget);
  checkMean(report, "even light, eye in the middle",
            view(4, 4, "0 0 0  0 0 1  0 1 0", perspective(90)) + constantLight(1) + glass(1.5) + text, 1,
            budget);
  checkMean(report, "lamp in the middle",
            view(4, 4, "0 0 6  0 0 0  0 1 0", orthographic(1e-3)) + "AttributeBegin\n" + diffuse(0) +
                "AreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ]\nShape \"sphere\" \"float radius\" .9\n"
                "AttributeEnd\n" +
                glass(1.5) + text,
            (1 - r) / (1 + (n - 1) * r), budget);
}

void inside(const Report& report) {
  // Uniform light seen from inside: radiance over the square of the index is constant.
  checkMean(report, "eye in the middle of a glass ball",
            view(16, 16, "0 0 0  0 0 1  0 1 0", perspective(100)) + constantLight(1) + glass(1.5) +
                "Shape \"sphere\"\n",
            2.25, clear());
  // From 0.9 of the radius, light arrives along rays that hit the surface below the critical angle, 0.9 sin a
  // < 1/1.5; other rays have no light, because their walks never leave the ball.
  checkMean(report, "eye near the surface, outwards",
            view(8, 8, "0 0 .9  0 0 2  0 1 0", orthographic(0.3)) + constantLight(1) + glass(1.5) +
                "Shape \"sphere\"\n",
            2.25, clear());
  {
    // Near the surface every walk along it has total reflection.
    const auto scene = sceneFrom(view(4, 4, "0 0 .9  1 0 .9  0 1 0", orthographic(1e-3)) + constantLight(1) +
                                 glass(1.5) + "Shape \"sphere\"\n");
    for (const Way& way : allWays(1000)) {
      const Rendered r = renderScene(*scene, way, clear());
      report.atMost("eye near the surface, caught by total reflection", way.label, "radiance", r.mean(), 0,
                    r.unsound());
    }
  }
  // A black lamp of radius c at the centre of a ball of radius a, seen from outside at a distance b of the
  // ray from the centre: (1 - R) L / eta² for b < eta c; internal reflections return to the lamp.
  const double eta = 1.5, a = 0.5, c = 0.2, d = 1, lamp = 3;
  const std::string ball = "AttributeBegin\n" + diffuse(0) +
                           "AreaLightSource \"diffuse\" \"rgb L\" [ 3 3 3 ]\n" +
                           "Shape \"sphere\" \"float radius\" .2\nAttributeEnd\nAttributeBegin\n" +
                           glass(eta) + "Shape \"sphere\" \"float radius\" .5\nAttributeEnd\n";
  checkMean(report, "lamp inside a glass ball, seen",
            view(4, 4, "0 0 2  0 0 0  0 1 0", orthographic(1e-3)) + ball, 0.96 * lamp / (eta * eta), clear());
  double irradiance = 0;
  constexpr int STEPS = 100000;
  const double widest = std::asin(eta * c / d);
  for (int i = 0; i < STEPS; ++i) {
    const double theta = (i + 0.5) / STEPS * widest, b = d * std::sin(theta);
    const auto r = static_cast<double>(reflectance(
        static_cast<long double>(b / a), static_cast<long double>(std::sqrt(1 - b * b / a / a)), 1.5L));
    irradiance +=
        2 * M_PI * (1 - r) * lamp / (eta * eta) * std::cos(theta) * std::sin(theta) * widest / STEPS;
  }
  Budget wall;
  wall.samples = 1024;
  wall.photonSamples = 16;
  wall.photons = 4e5;
  wall.tolerance = 5e-3;
  wall.photonTolerance = 0.01 + photonNoise(1000);
  wall.photonParameters = "\"float radius\" .1";
  const std::string floor =
      diffuse(0.5) + "Shape \"bilinearmesh\" \"point3 P\" [ -1 -1 -1  1 -1 -1  -1 1 -1  1 1 -1 ]\n";
  const std::string below = view(8, 8, "1 0 -.5  0 0 -1  0 0 1", orthographic(0.02));
  checkMean(report, "lamp inside a glass ball, its light on a floor", below + floor + ball,
            0.5 / M_PI * irradiance, wall, true);
  // A point light at the centre: every ray leaves in its first direction, after any number of reflections,
  // and no light is lost.
  checkMean(report, "point light inside a glass ball",
            below + floor + "LightSource \"point\" \"rgb I\" [ 2 2 2 ]\n" + glass(eta) +
                "Shape \"sphere\" \"float radius\" .5\n",
            0.5 / M_PI * 2, wall, true);
}

} // namespace

void addGlassCases(HardCases& cases) {
  cases.push_back({4, "refractive index", false, indices});
  cases.push_back({4, "total reflection", false, critical});
  cases.push_back({4, "thin slab", false, thinSlab});
  cases.push_back({4, "50 shells of glass", false, shells});
  cases.push_back({4, "inside glass", false, inside});
}

} // namespace recurse::hard
